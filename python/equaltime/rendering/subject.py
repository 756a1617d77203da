"""What an experiment measures: anything that renders a scene to given sample counts and times itself."""

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
    """Where a run stands when every pixel has ``spp`` samples."""

    spp: int
    wall_s: float
    """Seconds since the first sample, without what is no rendering."""
    cpu_s: float
    """Seconds of all processors in that time."""
    image: NDArray[np.float32]
    """(H, W, 3): linear RGB radiance."""
    estimate: Estimate | None = None
    """What the render itself says its error is, if it does."""
    paths: int | None = None
    rays: int | None = None
    shadow_rays: int | None = None
    """So far; None if the renderer does not count them."""
    samples: NDArray[np.int64] | None = None
    """(H, W): samples of each pixel; None if all have ``spp``."""


class Subject(Protocol):
    """A strategy of some renderer, as an experiment sees it.

    A subject may have a method ``close``, called when it is not needed any more.
    """

    @property
    def label(self) -> str:
        """Its name in the experiment."""

    @property
    def name(self) -> str:
        """The strategy in full, in one line."""

    @property
    def renderer(self) -> RendererKind:
        """Who renders."""

    @property
    def biased(self) -> bool:
        """Whether it says of itself that it converges to something else than the scene's light transport."""

    def prepare(self, scene: Scene, threads: int) -> float:
        """Get ready to render ``scene`` on ``threads`` threads (0: one for each processor); return the seconds taken.

        What a renderer does once a process or a scene belongs here: loading, compiling, a first sample to warm up.
        """

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None) -> Iterator[Checkpoint]:
        """Render with random numbers of ``seed`` (31 bits), and yield a checkpoint at each count of ``ladder``.

        Counts are samples per pixel in all, rising. The next count is asked for after the last checkpoint was taken:
        the ladder may follow from the times. With ``seconds`` the run ends at the first checkpoint past it.
        """
