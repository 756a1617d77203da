"""`render`: from a scene to a result, by way of the rooms."""

from __future__ import annotations

import math
import os
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from equaltime.errors import EffectError, RenderError, StrategyError
from equaltime.film.error import Estimate
from equaltime.pricing import left_out
from equaltime.quoting.fixed_count import fixed_count
from equaltime.quoting.observer import Observer, QuoteWatch, overrides
from equaltime.quoting.pilot import Pilot
from equaltime.rendering.arguments import Backend, as_scene, check_arguments
from equaltime.rendering.black_picture import warn_if_black
from equaltime.rendering.budget import Limits, StopRule
from equaltime.rendering.job import Job, Traps
from equaltime.rendering.output_files import check_spares
from equaltime.rendering.result import Result
from equaltime.rendering.run import Checkpoints, run
from equaltime.rendering.saved import Render, as_checkpoint
from equaltime.rendering.session import Session
from equaltime.rendering.tev import Viewer
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["render"]

_DEFAULT_SPP = 64
_LEFT_FOR_BIAS = 0.5
"""Largest share of the ordered error that leaving effects out may make: the noise may then be 87 % of it."""
_CROSS_CHECK_ALONE = "the embreex backend has one strategy, its own, and no limit but spp: give spp and seed only"


def render(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    spp: int | None = None,
    time: float | None = None,
    error: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    observer: Observer | None = None,
    resume: Render | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_every: float = 60.0,
    without: Sequence[str] = (),
    within: float | None = None,
    stop: StopRule = "look",
    show: Viewer | None = None,
    traps: Traps = "ignore",
    backend: Backend = "core",
) -> Result:
    """Render a scene until a number of samples, a time or an error is reached.

    For one build, the pixels depend on the scene, the strategy, the seed and the sample counts: not on ``threads``, and
    on ``time`` only through the counts that were reached.

    Parameters
    ----------
    scene
        A loaded scene, the path of a scene file, or a dict in Mitsuba's words.
    spp
        Samples per pixel. If no limit is given: the scene's own sample count, or 64. One sample alone gives no
        standard error. If several limits are given, whichever comes first ends the render.
    time
        Seconds from the first sample (of this run, if it takes up another) to the final film. A limit that is shorter
        than a pass ends it part way: some pixels then have fewer samples, or none. Outputs that the scene asks for
        beside the image come on top; ``stats.phases["outputs"]`` says how long they took.
    strategy
        A `Strategy`, or text for `Strategy.parse`.
    observer
        An `Observer`: hears of progress, quotes, passes, and checkpoints that could not be written.
    seed
        Of all random numbers, 0 … 2^64 - 1. Renders with different seeds are independent.
    threads
        Worker threads; 0 is one for each processor.
    backend
        ``core``, or ``embreex`` for the slow float64 cross-check (``spp`` and ``seed`` only).
    error
        Relative error to reach (0.02 is 2 %), as ``stop`` says.
    resume
        A result, or a file that `Result.save` wrote: the render goes on from there, to the bits of one that did not
        stop.
    checkpoint, checkpoint_every
        File (EXR) where the render so far is saved, and how often, in seconds; less often where saving would take more
        than half of the time.
    without
        Effects to leave out, by name (`equaltime.effects`): the image is biased, says so, and its error has in it what
        that makes, which a pilot measures.
    within
        An error, such as 0.01: leave out what a pilot shows can be left out within it, and within half of ``error`` if
        that is given, also the longest paths.
    show
        A viewer that is shown the image after passes, a few times a second, and at the end.
    traps
        Look for floating-point faults, outside Embree: ``check`` names the first sample that raises one, ``stop`` ends
        the process there (SIGFPE), for a debugger. The bits are the same, the time is not.
    stop
        How ``error`` ends the render. ``look``: when the upper limit of the image's own error is there, looked at
        between passes as `equaltime.rendering.budget` says. Such a stop selects images without rare bright paths, which
        are too dark on average. ``fixed``: a pilot with samples of its own chooses the count beforehand
        (`equaltime.quoting.fixed_count`), and the image has that count whatever it shows, so that it is unbiased. The
        pilot takes a phase of its own, and its seconds count for ``time``. A render that is taken up keeps the count
        that was chosen for the same error.

    Returns
    -------
    Result
        After Ctrl-C (in the main thread) what was finished, with ``stopped_by == "interrupt"`` and without the outputs
        beside the image.

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    EffectError
        If an effect does not exist or cannot be left out, or what that makes is more than the error asked for.
    ImageError
        If ``resume`` cannot be read or belongs to another render, or ``checkpoint`` cannot be written.
    NonFiniteSample
        If a sample was NaN or infinite: after its pass, with the result so far.
    BrightImage
        If a pixel is more than float32 can hold: with the result so far.
    FaultySample
        The same for a sample that raised a floating-point fault, if these are looked for.
    RenderError
        If there is not enough memory; if only ``error`` is to end the render of a single pixel, which cannot be known;
        or if a pilot meets too little light to choose a count.
    ValueError
        If an argument is out of range, or of another type.

    Warns
    -----
    EqualtimeWarning
        If the picture is black everywhere and its error is 0, or the camera is inside a closed surface.

    Examples
    --------
    >>> result = et.render("scene.toml", spp=16)
    >>> result.spp, result.stopped_by
    (16.0, 'spp')
    >>> et.render("scene.toml", time=10.0, error=0.5).stopped_by  # whichever limit is met first
    'error'
    """
    check_arguments(
        spp,
        time,
        error,
        seed,
        threads,
        backend,
        within=within,
        without=without,
        checkpoint_every=checkpoint_every,
        stop=stop,
    )
    chosen = Strategy.of(strategy)
    loaded = as_scene(scene)
    limits = Limits(spp if spp or time or error else loaded.spp or _DEFAULT_SPP, time, error)
    if backend == "embreex":
        if any(x is not None for x in (resume, checkpoint, within, show)) or without or threads or traps != "ignore":
            raise StrategyError(_CROSS_CHECK_ALONE)
        return warn_if_black(_cross_checked(loaded, limits, chosen, seed), loaded, stacklevel=2)
    if checkpoint is not None:
        check_spares({Path(checkpoint), Path(checkpoint).with_suffix(".png")}, loaded.files, "the scene is made of it")
    resumed = None if resume is None else as_checkpoint(resume)
    if show is not None:
        show.connect()  # before any clock runs: it may have to be waited for
    job = Job(scene=loaded, strategy=chosen, limits=limits, seed=seed, threads=threads, traps=traps, resumed=resumed)
    begin = clock.perf_counter()
    left = _left_out(job, tuple(without), within)
    phases = {} if left is None else {"pilot": clock.perf_counter() - begin}
    if left is not None:
        job = _without(job, left)
        if observer is not None:
            observer.decided(left.why)
    saving = None
    if checkpoint is not None:
        saving = Checkpoints(Path(checkpoint), checkpoint_every, None if observer is None else observer.unsaved)
    result = _watched(job, loaded, stop, observer, show, saving)
    result = replace(result, stats=replace(result.stats, phases={**result.stats.phases, **phases}))
    return warn_if_black(result, loaded, stacklevel=2)


def _watched(
    job: Job,
    asking: Scene,
    stop: StopRule,
    observer: Observer | None,
    show: Viewer | None,
    saving: Checkpoints | None,
) -> Result:
    """Run a job, and let its observer and its viewer know."""
    progress = observer.progress if observer is not None and overrides(observer, "progress") else None
    asked = job.limits.error is not None or job.limits.seconds is not None
    hears = observer is not None and (overrides(observer, "quoted") or overrides(observer, "unquoted"))
    wants_quote = asked and hears
    if stop == "fixed":
        fixed = fixed_count(job, progress)
        job = replace(job, limits=fixed.limits(job.limits), stop=fixed.stop)
        if fixed.quote is not None and observer is not None:
            wants_quote = False
            observer.quoted(replace(fixed.quote, error=fixed.quote.error.with_bias(job.bias)))
    session = Session(job, progress)
    pass_ended, ended = list[Callable[[], object]](), list[Callable[[Result], object]]()
    if observer is not None and wants_quote:
        watch = QuoteWatch(Pilot(session, job.limits, probes=job.limits.error is not None), observer)
        pass_ended.append(watch.pass_ended)
        ended.append(lambda _: watch.ended())
    if observer is not None and overrides(observer, "pass_ended"):
        pass_ended.append(partial(observer.pass_ended, session.image))
    if show is not None:
        pass_ended.append(partial(_offer, show, session))
        ended.append(lambda result: show.show(result.image))
    return run(session, asking, saving, pass_ended, ended)


def _offer(viewer: Viewer, session: Session) -> None:
    if viewer.due:
        viewer.offer(session.image())


def _left_out(job: Job, without: tuple[str, ...], within: float | None) -> left_out.LeftOut | None:
    """Return the scene without effects, measured or chosen; None if nothing was to be left out."""
    if not without and within is None:
        return None
    if within is None:
        return left_out.measured(job.scene, job.strategy, without, job.seed, job.threads)
    if without:
        raise EffectError("give effects to leave out, or the error within which to choose them, not both")
    if job.limits.error is not None:
        within = min(within, _LEFT_FOR_BIAS * job.limits.error)
    return left_out.choose(job.scene, job.strategy, within, job.seed, job.threads)


def _without(job: Job, left: left_out.LeftOut) -> Job:
    """Return the job without the effects. Its noise may reach the ordered error less the bias."""
    return replace(
        job,
        scene=left.scene,
        strategy=left.strategy,
        limits=replace(job.limits, error=_rest(job.limits.error, left.bias)),
        without=left.names,
        bias=left.bias if left.names else None,
    )


def _rest(error: float | None, bias: Estimate) -> float | None:
    """Return the noise that makes the error asked for together with the bias."""
    if error is None:
        return None
    if bias.high >= error:
        raise EffectError(f"an error of {100.0 * error:.3g} % cannot be reached: what is left out makes {bias}")
    return math.sqrt(error**2 - bias.high**2)


def _cross_checked(scene: Scene, limits: Limits, strategy: Strategy, seed: int) -> Result:
    """Render with `equaltime.crosscheck`, which has one strategy, its own, and no clock."""
    if limits != Limits(spp=limits.spp) or limits.spp is None or strategy != Strategy():
        raise StrategyError(_CROSS_CHECK_ALONE)
    try:
        from equaltime.crosscheck.as_backend import render_result  # here, since not everyone has embreex
    except ImportError as error:
        if error.name != "embreex":
            raise
        raise RenderError(str(error)) from error
    return render_result(scene, limits.spp, seed)
