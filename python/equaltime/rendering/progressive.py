"""A render as an iterator of passes, for whoever wants to look on, to change the target, or to stop when it is enough.

::

    session = et.progressive(scene, error=0.02)
    for state in session:
        show(state.image, state.error)
        if enough(state):
            break                      # what is done stays
    result = session.result            # the same bits as et.render up to there
    session.aim(error=0.01)            # go on
    for state in session: ...
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any

from equaltime.rendering.arguments import as_scene, check_arguments
from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job
from equaltime.rendering.result import Result
from equaltime.rendering.saved import Render, as_checkpoint
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["Progressive", "progressive"]


class Progressive:
    """A render that is going on; iterating gives its `Result` so far at the end of every pass.

    One thread at a time may iterate; `cancel` may be called from any.
    """

    def __init__(self, session: Session) -> None:
        self._session = session

    def __iter__(self) -> Iterator[Result]:
        for _ in self._session.passes:
            yield self._session.result("unfinished")

    @property
    def result(self) -> Result:
        """What is done so far; its `stopped_by` says which limit was met, or ``unfinished``."""
        return self._session.result(self._session.passes.stopped_by or "unfinished")

    @property
    def time_left(self) -> float | None:
        """Estimated seconds of rendering to the nearest limit, right again within a pass after the load has changed."""
        return self._session.passes.time_left

    def cancel(self) -> None:
        """End the loop that runs, within a pass; from any thread. What is done stays, and another loop goes on."""
        self._session.passes.cancel()

    def aim(self, spp: int | None = None, time: float | None = None, error: float | None = None) -> None:
        """Change when to stop, from the next pass on; ``time`` counts from the start of the loop that goes on.

        Raises
        ------
        ValueError
            If no limit is given, or one is out of range.
        """
        check_arguments(spp=spp, time=time, error=error)
        if spp is None and time is None and error is None:
            raise ValueError("give spp, time or error: a render needs an end")
        self._session.passes.limits = Limits(spp, time, error)


def progressive(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    spp: int | None = None,
    time: float | None = None,
    error: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    resume: Render | None = None,
) -> Progressive:
    """Begin a render whose passes the caller runs.

    Every argument is as `equaltime.render` takes it, but that without a limit the passes go on for as long as they are
    iterated. What that tells on the way, or saves, the caller can see of every pass, and `Result.save`; it alone leaves
    effects out.

    Raises
    ------
    SceneError, StrategyError, ImageError, RenderError, ValueError
        As `equaltime.render` does, at once; and `SampleError` or `BrightImage` from the loop, or from
        `Progressive.result`, with the result so far.
    """
    check_arguments(spp=spp, time=time, error=error, seed=seed, threads=threads)
    chosen = Strategy.of(strategy)
    resumed = None if resume is None else as_checkpoint(resume)
    limits = Limits(spp, time, error)
    job = Job(scene=as_scene(scene), strategy=chosen, limits=limits, seed=seed, threads=threads, resumed=resumed)
    return Progressive(Session(job))
