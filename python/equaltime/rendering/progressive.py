"""A render as an iterator of passes, to watch it, to change its target, or to stop it early.

::

    session = et.progressive(scene, error=0.02)
    for state in session:
        show(state.image, state.error)
        if enough(state):
            break                      # the result so far stays
    result = session.result            # the same bits as et.render up to there
    session.aim(error=0.01)            # go on
    for state in session: ...
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any

from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job, as_scene, check_arguments
from equaltime.rendering.result import Result
from equaltime.rendering.saved import Render, as_checkpoint
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["Progressive", "progressive"]


class Progressive:
    """A render whose passes the caller runs: iterating yields its `Result` so far at the end of every pass.

    `progressive` makes it from a ``session``, the render in the core. One thread at a time may iterate; `cancel` may be
    called from any thread.
    """

    def __init__(self, session: Session) -> None:
        self._session = session

    def __iter__(self) -> Iterator[Result]:
        for _ in self._session.passes:
            yield self._session.result("unfinished")

    @property
    def result(self) -> Result:
        """Result of the render so far.

        Its ``stopped_by`` is the reason why the last loop ended, or ``unfinished``.
        """
        return self._session.result(self._session.passes.stopped_by or "unfinished")

    @property
    def time_left(self) -> float | None:
        """Estimated seconds until the nearest limit is met, updated within passes; None if nothing is known yet."""
        return self._session.passes.time_left

    def cancel(self) -> None:
        """End the running loop within its pass; may be called from any thread.

        Finished work stays, and a new loop continues the render.
        """
        self._session.passes.cancel()

    def aim(self, spp: int | None = None, time: float | None = None, error: float | None = None) -> None:
        """Replace the limits from the next pass on; limits that are not given are removed.

        ``spp`` is samples per pixel, ``time`` seconds since the loop began, and ``error`` the relative error as a
        fraction.

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
    """Return a render whose passes the caller runs, by iterating over it.

    Without a limit, passes go on while the caller iterates. There are no callbacks and no checkpoints (use the yielded
    results and `Result.save`), and no feature of the scene can be left out.

    Parameters
    ----------
    scene
        A loaded scene, the path of a scene file, or a dict with Mitsuba's keys.
    spp, time, error
        Limits: samples per pixel, seconds since the loop began, relative error (0.02 is 2 %). The first limit that is
        met ends the loop.
    strategy
        A `Strategy`, or text for `Strategy.parse`.
    seed
        Seed of all random numbers, 0 … 2^64 - 1.
    threads
        Number of worker threads; 0 is one for each processor.
    resume
        A result, or a file that `Result.save` wrote, which the render continues.

    Raises
    ------
    SceneError, StrategyError, ImageError, RenderError, ValueError
        As `equaltime.render` does, at once. Also `SampleError` or `BrightImage`, with the result so far, from the loop
        or from `Progressive.result`.

    Examples
    --------
    >>> for state in et.progressive("scene.toml", spp=8):
    ...     print(state.spp)
    2.0
    4.0
    8.0
    """
    check_arguments(spp=spp, time=time, error=error, seed=seed, threads=threads)
    chosen = Strategy.of(strategy)
    resumed = None if resume is None else as_checkpoint(resume)
    limits = Limits(spp, time, error)
    job = Job(scene=as_scene(scene), strategy=chosen, limits=limits, seed=seed, threads=threads, resumed=resumed)
    return Progressive(Session(job))
