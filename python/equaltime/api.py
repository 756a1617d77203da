"""The function `render`, which renders a scene and returns a `Result`."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from equaltime.cluster import open_cluster
from equaltime.errors import EffectError, RenderError, StrategyError
from equaltime.images.exposure import AUTO, Exposure, checked_exposure
from equaltime.quoting import left_out
from equaltime.quoting.fixed_count import fixed_count
from equaltime.quoting.observer import Observer, QuoteWatch, overrides
from equaltime.quoting.pilot import Pilot
from equaltime.rendering.black_picture import warn_if_black
from equaltime.rendering.budget import Limits, StopRule
from equaltime.rendering.job import DEFAULT_SPP, Backend, Job, Traps, as_scene, check_arguments
from equaltime.rendering.output_files import check_replaceable, check_spares
from equaltime.rendering.result import Result
from equaltime.rendering.saved import Render, as_checkpoint
from equaltime.rendering.session import Checkpoints, Session, run
from equaltime.rendering.tev import Viewer
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["render"]

_LEFT_FOR_BIAS = 0.5
"""Largest bias from left-out effects, as a fraction of the error asked for; the noise may then be 87 % of it."""
_CROSS_CHECK_ALONE = "the embreex backend accepts no strategy and no limit except spp: give only spp and seed"


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
    checkpoint_exposure: Exposure = AUTO,
    overwrite: bool = False,
    without: Sequence[str] = (),
    within: float | None = None,
    stop: StopRule = "look",
    show: Viewer | None = None,
    traps: Traps = "ignore",
    backend: Backend = "core",
    cluster: Any = None,
) -> Result:
    """Render a scene until a number of samples, a time or an error is reached.

    The pixels depend on the scene, the strategy, the seed, the sample counts and the build of equaltime. They do not
    depend on ``threads``. They depend on ``time`` only through the sample counts.

    Parameters
    ----------
    scene
        A loaded scene, the path of a scene file, or nested dictionaries with Mitsuba's names (`load_dict`).
    spp
        Samples per pixel. With ``adaptive``, sample counts follow the noise, and their mean differs from ``spp`` by a
        few per cent. Without ``spp``, ``time`` and ``error``, the scene's own sample count is taken, or else 64. One
        sample alone gives no standard error. If several of the three limits are given, the first one reached ends the
        render.
    time
        Seconds from the first sample of this run to the final film. If the limit falls within a pass, the pass is not
        completed: some pixels then have fewer samples, or none. Outputs that the scene asks for beside the image take
        additional time, which ``stats.phases["outputs"]`` holds in seconds.
    strategy
        The methods by which paths are sampled: a `Strategy`, or text such as ``best`` or ``mis,sampler=sobol``, as
        `Strategy.parse` reads it.
    observer
        An `Observer`. Its methods are called for progress, quotes (predictions of time and error), ended passes, and
        checkpoints that could not be written.
    seed
        Seed of all random numbers, 0 … 2^64 - 1. Renders with different seeds are independent.
    threads
        Number of worker threads; 0 is one for each processor.
    backend
        ``core``, or ``embreex``: a second, slow renderer in float64 that checks the first (``spp`` and ``seed`` only).
    error
        Relative error to reach: 0.02 is 2 %. The argument ``stop`` chooses the rule that ends the render.
    resume
        A result, or a file that `Result.save` wrote. The render continues it, and gets the same bits as a render that
        was never stopped.
    checkpoint, checkpoint_every, checkpoint_exposure
        EXR file in which the render so far is saved, the seconds between two savings, and the exposure of the previews
        beside it, in stops or ``auto``. The interval grows if saving would take more than half of the time.
    overwrite
        Let ``checkpoint`` replace files of other programs, and renders of other scenes (`Result.save`).
    without
        Names of effects to leave out; an effect is a feature of the scene or of its light, see `equaltime.effects`. The
        image is then biased, and is labelled as biased. A pilot (a short render) measures the bias, and the image's
        error includes that bias.
    within
        Lets a pilot choose effects to leave out, whose relative bias together stays within this number, such as 0.01.
        The longest paths may be among these effects. If ``error`` is given, the bias also stays within half of it.
    cluster
        Processes that take the samples: ``local:N`` for N processes on this machine, the address of a scheduler of Dask
        such as ``tcp://node1:8786``, a ``distributed.Client``, a cluster of Dask such as ``SLURMCluster``, or a
        ``concurrent.futures.Executor``. The image has the bits of a render in this process (`equaltime.cluster`). With
        ``checkpoint``, samples that a process has finished are kept beside that file until the file contains them.
    show
        A viewer that receives the image after passes, at most a few times a second, and at the end.
    traps
        Treatment of floating-point faults outside Embree. ``ignore`` does not look for faults. ``check`` names the
        first sample that causes a fault. ``stop`` ends the process at the fault with SIGFPE, for a debugger. The choice
        changes the time, but no bit of the image.
    stop
        Rule by which ``error`` ends the render. ``look`` ends it when the upper limit of the image's own error,
        examined between passes, has reached ``error`` (`equaltime.rendering.budget`). Images that lack rare bright
        paths reach ``error`` sooner, so the images that this rule ends are too dark on average. ``fixed`` lets a pilot
        with separate samples choose the sample count beforehand (`equaltime.quoting.fixed_count`). The image gets that
        count whatever it shows, and is unbiased. The pilot's seconds are a phase of their own, and count towards
        ``time``. A resumed render keeps the count that was chosen for the same error.

    Returns
    -------
    Result
        The render. After Ctrl-C in the main thread: the finished samples, with ``stopped_by == "interrupt"`` and
        without the outputs beside the image.

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    EffectError
        If an effect does not exist or cannot be left out, or if the bias is larger than the error asked for.
    ImageError
        If ``resume`` cannot be read or belongs to another render, or ``checkpoint`` cannot be written or replaced.
    NonFiniteSample
        If a sample is NaN or infinite. Raised after the sample's pass, with the result so far.
    BrightImage
        If a pixel is larger than float32 can hold. Raised with the result so far.
    FaultySample
        If a sample caused a floating-point fault, with ``traps="check"``. Raised after the sample's pass, with the
        result so far.
    RenderError
        If there is not enough memory; if ``error`` is the only limit and the image is a single pixel, whose error
        cannot be estimated; or if a pilot meets too little light to choose a sample count.
    ValueError
        If an argument is out of range, or has the wrong type.

    Warns
    -----
    EqualtimeWarning
        If the picture is black everywhere and its error is 0, or if the camera is inside a closed surface.

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
    if cluster is not None and traps == "stop":
        raise ValueError("traps='stop' ends this process, but a cluster takes the samples elsewhere: omit one of them")
    exposure = checked_exposure(checkpoint_exposure)
    chosen = Strategy.of(strategy)
    loaded = as_scene(scene)
    limits = Limits(spp if spp or time or error else loaded.spp or DEFAULT_SPP, time, error)
    if backend == "embreex":
        others = any(x is not None for x in (resume, checkpoint, within, show, cluster))
        if others or without or threads or traps != "ignore":
            raise StrategyError(_CROSS_CHECK_ALONE)
        return warn_if_black(_cross_checked(loaded, limits, chosen, seed), loaded, stacklevel=2)
    if checkpoint is not None:
        check_spares(_files_of(checkpoint), loaded.files, "the scene is made of this file")
    resumed = None if resume is None else as_checkpoint(resume)
    if show is not None:
        show.connect()  # before any clock runs: it may have to be waited for
    job = Job(scene=loaded, strategy=chosen, limits=limits, seed=seed, threads=threads, traps=traps, resumed=resumed)
    begin = clock.perf_counter()
    left = _left_out(job, tuple(without), within)
    phases = {} if left is None else {"pilot": clock.perf_counter() - begin}
    if left is not None:
        job = left.job(job)
        if observer is not None:
            observer.decided(left.why)
    saving = None
    if checkpoint is not None:
        if not overwrite:
            source = None if loaded.source is None else os.path.abspath(loaded.source)
            check_replaceable(_files_of(checkpoint), source, job.scene.digest, "overwrite=True")
        unsaved = None if observer is None else observer.unsaved
        saving = Checkpoints(Path(checkpoint), checkpoint_every, exposure, unsaved)
    with open_cluster(cluster, checkpoint) as opened:
        result = _watched(replace(job, cluster=opened), loaded, stop, observer, show, saving)
    result = replace(result, stats=replace(result.stats, phases={**result.stats.phases, **phases}))
    return warn_if_black(result, loaded, stacklevel=2)


def _files_of(checkpoint: str | os.PathLike[str]) -> tuple[Path, Path]:
    return Path(checkpoint), Path(checkpoint).with_suffix(".png")


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
            quote = fixed.quote
            observer.quoted(replace(quote, error=quote.error.with_bias(job.bias), bias=job.bias))
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
        raise EffectError("give either effects to leave out, or the largest bias within which to choose them, not both")
    if job.limits.error is not None:
        within = min(within, _LEFT_FOR_BIAS * job.limits.error)
    return left_out.choose(job.scene, job.strategy, within, job.seed, job.threads)


def _cross_checked(scene: Scene, limits: Limits, strategy: Strategy, seed: int) -> Result:
    """Render with `equaltime.crosscheck`, which has one strategy, its own, and no clock."""
    if scene.transparent:
        raise RenderError("the embreex backend makes no alpha: omit transparent")
    if limits != Limits(spp=limits.spp) or limits.spp is None or strategy != Strategy():
        raise StrategyError(_CROSS_CHECK_ALONE)
    try:
        from equaltime.crosscheck.tracer import render_result  # here, since not everyone has embreex
    except ImportError as error:
        if error.name != "embreex":
            raise
        raise RenderError(str(error)) from error
    return render_result(scene, limits.spp, seed)
