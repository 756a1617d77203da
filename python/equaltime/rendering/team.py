"""Team: processes that render units for one render, wherever they run, as `equaltime.rendering.spread` needs them."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Protocol

from equaltime.errors import RenderError
from equaltime.rendering.units import Recipe, Rendered, Unit, Window
from equaltime.scene import Scene

__all__ = ["Cluster", "KeptUnit", "Team"]


class KeptUnit(Protocol):
    """Unit that an earlier process of this render finished and saved, so that it need not be rendered again.

    A unit is a window of the film with its samples between two counts.
    """

    @property
    def window(self) -> Window:
        """Window of the film, in pixels: x0, y0, x1, y1, without column x1 and row y1."""

    @property
    def begin(self) -> int:
        """Samples per pixel, on average, before the samples of this unit."""

    @property
    def end(self) -> int:
        """Samples per pixel, on average, after the samples of this unit."""

    def read(self) -> Rendered | None:
        """Return the pixels with the samples of this unit, from its file; None if they cannot be read."""


class Team(Protocol):
    """Interface to processes that render units (windows of the film, between two sample counts) of one render."""

    @property
    def size(self) -> int:
        """Number of units (windows of the film with some samples) that are rendered at once, at least 1."""

    def begin(self) -> None:
        """Prepare for a pass: find processes that have joined or left since the last pass."""

    def submit(self, unit: Unit) -> Future[Rendered]:
        """Let a process render ``unit``, a window of the film with some samples; return a future of the result."""

    def check(self) -> bool:
        """Tell whether waiting units must be submitted again, because all processes that had received them have ended.

        A unit is a window of the film with some samples. The method is called while units are waited for. Raises
        RenderError if no process is left.
        """

    def failure(self, error: Exception) -> RenderError:
        """Return an error for the user, made from ``error``, which the process pool or Dask raised for a unit."""

    def keep(self, unit: Unit, rendered: Rendered) -> None:
        """Save a rendered unit (window of the film, some samples), if there is a folder for that.

        So a crash before the next save of the whole render does not lose the unit.
        """

    def kept(self, recipe: Recipe) -> Sequence[KeptUnit]:
        """Return the units (windows of the film with some samples) that an unfinished run of the same render saved.

        ``recipe`` identifies the render.
        """

    def saved(self) -> None:
        """Delete all saved units (windows of the film), since a file of the whole render now contains their samples."""


class Cluster(Protocol):
    """Interface to processes that can render any scene, as ``Job.cluster``: `team` gives them one scene."""

    def team(self, scene: Scene) -> Team:
        """Return a team of the processes, each of which has loaded the scene.

        Raises RenderError if no process gives the same bits as this one.
        """
