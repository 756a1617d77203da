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
    """Unit (a window with its samples between two counts) that an earlier process of this render finished and saved."""

    @property
    def window(self) -> Window:
        """Window of the unit."""

    @property
    def begin(self) -> int:
        """Samples per pixel, on average, before the unit."""

    @property
    def end(self) -> int:
        """Samples per pixel, on average, after the unit."""

    def read(self) -> Rendered | None:
        """Return what was rendered; None if it cannot be read."""


class Team(Protocol):
    """Processes that render units."""

    @property
    def size(self) -> int:
        """Number of units that are rendered at once, at least 1."""

    def begin(self) -> None:
        """Prepare for a pass: look for processes that have joined or left since the last one."""

    def submit(self, unit: Unit) -> Future[Rendered]:
        """Return a future of the rendered unit."""

    def check(self) -> bool:
        """Tell whether units that wait must be submitted again, because all processes that knew them have ended.

        Called while units are waited for. Raises RenderError if no process is left.
        """

    def failure(self, error: Exception) -> RenderError:
        """Return an error for the user from what the engine raised when a unit could not be rendered."""

    def keep(self, unit: Unit, rendered: Rendered) -> None:
        """Keep a rendered unit in a safe place, if there is one."""

    def kept(self, recipe: Recipe) -> Sequence[KeptUnit]:
        """Return the units of a render that were kept."""

    def saved(self) -> None:
        """Forget all kept units, since the film that has them was saved."""


class Cluster(Protocol):
    """Processes that form a team for any scene."""

    def team(self, scene: Scene) -> Team:
        """Return a team whose processes have the scene.

        Raises RenderError if no process can render it to the bits of this one.
        """
