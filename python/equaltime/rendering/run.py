"""Run of a job: its passes, its checkpoints (saves on the way), and the outputs beside the image."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from equaltime.errors import ImageError, RenderError
from equaltime.rendering.outputs import asked_for, outputs
from equaltime.rendering.result import Result
from equaltime.rendering.session import Session
from equaltime.scene import Scene

__all__ = ["Checkpoints", "run"]


@dataclass(frozen=True)
class Checkpoints:
    """Path of the checkpoints (saves on the way), the interval between them, and a callback for failed saves."""

    path: Path
    every: float = 60.0
    """Seconds between checkpoints; longer if saving would take more than half of the time."""
    unsaved: Callable[[str], object] | None = None
    """Called with the reason when a checkpoint cannot be written; again only after one was written."""


def run(
    session: Session,
    asking: Scene,
    checkpoints: Checkpoints | None = None,
    pass_ended: Sequence[Callable[[], object]] = (),
    ended: Sequence[Callable[[Result], object]] = (),
) -> Result:
    """Run a session to its end, and return its result with the outputs that the scene ``asking`` asks for.

    Parameters
    ----------
    asking
        The user's scene. In the session's scene, effects may have been left out.
    pass_ended
        Called after each pass.
    ended
        Called with the finished image, before the outputs are made.

    Raises
    ------
    RenderError
        If there is not enough memory for the outputs.
    KeyboardInterrupt, SampleError, BrightImage
        As `Session.run` does.
    """

    def each(_: Session) -> None:
        for hear in pass_ended:
            hear()

    if checkpoints is None:
        result = session.run(pass_ended=each)
    else:
        result = session.run(checkpoints.path, checkpoints.every, each, checkpoints.unsaved)
    try:
        for hear in ended:
            hear(result)
        return _with_outputs(result, session, asking, None if checkpoints is None else checkpoints.path)
    except KeyboardInterrupt:  # the image is finished
        return replace(result, stopped_by="interrupt")


def _with_outputs(result: Result, session: Session, asking: Scene, checkpoint: Path | None) -> Result:
    """Add the outputs, except after Ctrl-C, since they may take as long as the image."""
    if result.stopped_by == "interrupt" or not asked_for(asking):
        return result
    if checkpoint is not None:  # outputs may also take as much memory as the image
        with suppress(ImageError):
            result.save(checkpoint)
    job, begin, worked = session.job, clock.perf_counter(), result.stats.seconds * result.stats.threads
    samples = max(1, round(float(result.samples.mean())))
    try:
        aovs = outputs(asking, job.scene, job.strategy, job.seed, job.threads, samples, worked)
    except MemoryError as problem:
        where = "" if checkpoint is None else f"; the image is in {checkpoint}"
        raise RenderError(f"not enough memory for the outputs beside the image{where}") from problem
    phases = {**result.stats.phases, "outputs": clock.perf_counter() - begin}
    return replace(result, aovs=aovs, stats=replace(result.stats, phases=phases))
