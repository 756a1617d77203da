"""Subjects of experiments: anything that renders a scene to given sample counts and measures its own time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import Estimate
from equaltime.scene import Scene

__all__ = ["Checkpoint", "RendererKind", "Subject"]

RendererKind = Literal["core", "mitsuba", "command"]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """State of a run when every pixel has ``spp`` samples."""

    spp: int
    wall_s: float
    """Seconds of rendering since the first sample, without other work."""
    cpu_s: float
    """Seconds of all processors in that time."""
    image: NDArray[np.float32]
    """(H, W, 3): linear RGB radiance."""
    estimate: Estimate | None = None
    """Error that the renderer itself states; None if it states none."""
    paths: int | None = None
    rays: int | None = None
    shadow_rays: int | None = None
    """Counts so far of paths, rays and shadow rays; None if the renderer does not count them."""
    samples: NDArray[np.int64] | None = None
    """(H, W): samples of each pixel; None if all have ``spp``."""


class Subject(Protocol):
    """A strategy of some renderer, as an experiment sees it.

    A subject may have a method ``close``, which is called when the subject is no longer needed.
    """

    @property
    def label(self) -> str:
        """Name of the subject in the experiment."""

    @property
    def name(self) -> str:
        """The strategy in full, in one line."""

    @property
    def renderer(self) -> RendererKind:
        """Kind of the renderer."""

    @property
    def biased(self) -> bool:
        """Whether, by its own account, the strategy converges to something else than the scene's light transport."""

    def prepare(self, scene: Scene, threads: int) -> float:
        """Get ready to render ``scene`` on ``threads`` threads (0: one for each processor); return the seconds taken.

        Work that a renderer does once per process or scene belongs here: loading, compiling, a first sample to warm up.
        """

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None) -> Iterator[Checkpoint]:
        """Render with random numbers of ``seed`` (31 bits), and yield a checkpoint at each count of ``ladder``.

        Counts are total samples per pixel, rising. The next count is asked for after the last checkpoint was taken, so
        the ladder may depend on the times. With ``seconds`` the run ends at the first checkpoint past them.
        """
