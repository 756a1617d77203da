"""`render`: from a scene to a result."""

from __future__ import annotations

import math
import os
import time as clock
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from equaltime.arguments import Backend, as_scene, check_arguments
from equaltime.black_picture import warn_if_black
from equaltime.budget import Limits
from equaltime.checkpoint import Checkpoint
from equaltime.error_estimate import Estimate, PixelStatistics
from equaltime.errors import EffectError, ImageError, RenderError, StrategyError
from equaltime.first_hits import asked_for
from equaltime.fixed_count import fixed_count
from equaltime.output_files import check_spares
from equaltime.outputs import outputs
from equaltime.pilot import Pilot, Quote
from equaltime.progress import ProgressCallback
from equaltime.result import Result, Stats, make_result
from equaltime.scene import Scene
from equaltime.session import Session, Traps, origin_of
from equaltime.stopping import StopRule
from equaltime.strategy import Strategy
from equaltime.tev import Viewer

if TYPE_CHECKING:
    from equaltime.effects.pilot import LeftOut

__all__ = ["render"]

T = TypeVar("T")

_DEFAULT_SPP = 64
_LEFT_FOR_BIAS = 0.5
"""Of the error asked for, what leaving effects out may make at most: the noise may be 87 % of it then."""
_CROSS_CHECK_ALONE = "the embreex backend has one strategy, its own, and no limit but spp: give spp and seed only"


def render(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    spp: int | None = None,
    time: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: ProgressCallback | None = None,
    backend: Backend = "core",
    *,
    error: float | None = None,
    resume: str | os.PathLike[str] | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_every: float = 60.0,
    unsaved: Callable[[str], object] | None = None,
    quoted: Callable[[Quote], object] | None = None,
    unquoted: Callable[[str], object] | None = None,
    without: Sequence[str] = (),
    within: float | None = None,
    decided: Callable[[Sequence[str]], object] | None = None,
    show: Viewer | None = None,
    traps: Traps = "ignore",
    stop: StopRule = "look",
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
    seed
        Of all random numbers, 0 … 2^64 - 1. Renders with different seeds are independent.
    threads
        Worker threads; 0 is one for each processor.
    progress
        Called with a `Progress` about ten times a second. It may raise `KeyboardInterrupt` to stop.
    backend
        ``core``, or ``embreex`` for the slow float64 cross-check (``spp`` and ``seed`` only).
    error
        Relative error to reach (0.02 is 2 %), as ``stop`` says.
    resume
        A file that `Result.save` wrote: the render goes on from there, to the same bits as if it had not stopped.
    checkpoint
        Where to save what is done so far (EXR), every ``checkpoint_every`` seconds, within a pass too; less often where
        saving would take more than half of the time.
    unsaved
        Called with why, where a checkpoint could not be written, once until one has been again; the render goes on.
    quoted
        Called once, within 8 samples a pixel or a twentieth of the work, but not of more than ten seconds, with what
        the error or the time asked for will cost or bring. For an error some pixels, 4096 at most, are rendered to the
        end beforehand (`equaltime.probe`), which takes at most 3 % of the work, or 4 samples a pixel if that is more;
        they are none of the image's.
    unquoted
        Called once instead, if an error or a time was asked for and there can be no quote, with why, in words.
    without
        Effects to leave out, by name (`equaltime.effects`): the image is biased, says so, and its error has in it what
        that makes, which a pilot measures.
    within
        An error, such as 0.01: leave out what a pilot shows can be left out within it, and within half of ``error`` if
        that is given, also the longest paths.
    decided
        Called once, before the first sample, with what was left out or kept and why, in words.
    show
        A viewer that is shown the image after passes, a few times a second, and at the end.
    traps
        Look for floating-point faults, outside Embree: ``check`` names the first sample that raises one, ``stop`` ends
        the process there (SIGFPE), for a debugger. The bits are the same, the time is not.
    stop
        How ``error`` ends the render. ``look``: when the upper limit of the image's own error is there, looked at
        between passes as `equaltime.budget` says. Such a stop selects images without rare bright paths, which are too
        dark on average. ``fixed``: a pilot with samples of its own chooses the count beforehand
        (`equaltime.fixed_count`), and the image has that count whatever it shows, so that it is unbiased. The pilot
        takes a phase of its own, and its seconds count for ``time``. A render that is taken up keeps the count that was
        chosen for the same error.

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
    chosen = strategy if isinstance(strategy, Strategy) else Strategy.parse(strategy)
    loaded = as_scene(scene)
    limits = Limits(spp if spp or time or error else loaded.spp or _DEFAULT_SPP, time, error)
    if backend == "embreex":
        if any(x is not None for x in (resume, checkpoint, within, show)) or without or threads or traps != "ignore":
            raise StrategyError(_CROSS_CHECK_ALONE)
        return warn_if_black(_render_cross_check(loaded, limits, chosen, seed), loaded, stacklevel=2)
    if checkpoint is not None:
        check_spares({Path(checkpoint), Path(checkpoint).with_suffix(".png")}, loaded.files, "the scene is made of it")
    resumed = None if resume is None else Checkpoint.read(resume)
    if show is not None:
        show.connect()  # before any clock runs: it may have to be waited for
    begin = clock.perf_counter()
    if within is not None and error is not None:
        within = min(within, _LEFT_FOR_BIAS * error)
    left = _left_out(loaded, chosen, tuple(without), within, seed, threads)
    piloting = {} if left is None else {"pilot": clock.perf_counter() - begin}
    rendered, by = (loaded, chosen) if left is None else (left.scene, left.strategy)
    names, bias = () if left is None else left.names, None
    if left is not None:
        limits = replace(limits, error=_rest(error, left.bias))
        if decided is not None:
            decided(left.why)
        bias = left.bias if left.names else None
    fixed = None
    if stop == "fixed":
        fixed = fixed_count(rendered, by, limits, seed, threads, progress, resumed)
        limits = fixed.limits(limits)
    rule = None if fixed is None else fixed.stop
    session = Session(rendered, by, seed, threads, limits, progress, resumed, names, bias, traps, rule)
    watchers: list[Callable[[Session], object]] = []
    watch = None
    if fixed is not None and fixed.quote is not None:
        if quoted is not None:
            quoted(replace(fixed.quote, error=fixed.quote.error.with_bias(bias)))
    elif (quoted or unquoted) and (error or time):
        watch = _Watch(Pilot(session, limits, probes=limits.error is not None), quoted, unquoted)
        watchers.append(watch)
    if show is not None:
        watchers.append(partial(_show, show))

    def pass_ended(session: Session) -> None:
        for watcher in watchers:
            watcher(session)

    result = session.run(None if checkpoint is None else Path(checkpoint), checkpoint_every, pass_ended, unsaved)
    result = replace(result, stats=replace(result.stats, phases={**result.stats.phases, **piloting}))
    try:
        if watch is not None:
            watch.ended()
        if show is not None:
            show.show(result.image)
        result = _with_outputs(result, loaded, rendered, by, seed, threads, checkpoint)
        return warn_if_black(result, loaded, stacklevel=2)
    except KeyboardInterrupt:  # the image is finished
        return replace(result, stopped_by="interrupt")


def _with_outputs(
    result: Result,
    scene: Scene,
    rendered: Scene,
    strategy: Strategy,
    seed: int,
    threads: int,
    checkpoint: str | os.PathLike[str] | None,
) -> Result:
    """Add the outputs that the scene asks for; not after Ctrl-C, since they may take as long as the image."""
    if result.stopped_by == "interrupt" or not asked_for(scene):
        return result
    if checkpoint is not None:  # outputs may take as much memory as the image, too
        with suppress(ImageError):
            result.save(checkpoint)
    begin, worked = clock.perf_counter(), result.stats.seconds * result.stats.threads
    samples = max(1, round(float(result.samples.mean())))
    try:
        aovs = outputs(scene, rendered, strategy, seed, threads, samples, worked)
    except MemoryError as problem:
        where = "" if checkpoint is None else f"; the image is in {checkpoint}"
        raise RenderError(f"not enough memory for the outputs beside the image{where}") from problem
    phases = {**result.stats.phases, "outputs": clock.perf_counter() - begin}
    return replace(result, aovs=aovs, stats=replace(result.stats, phases=phases))


def _left_out(
    scene: Scene, strategy: Strategy, without: tuple[str, ...], within: float | None, seed: int, threads: int
) -> LeftOut | None:
    """Return what is left out of the scene, if anything was asked for."""
    if not without and within is None:
        return None
    from equaltime.effects import pilot  # here, since it measures by what measures renders

    if within is None:
        return pilot.measured(scene, strategy, without, seed, threads)
    if without:
        raise EffectError("give effects to leave out, or the error within which to choose them, not both")
    return pilot.choose(scene, strategy, within, seed, threads)


def _rest(error: float | None, bias: Estimate) -> float | None:
    """Return the noise that makes the error asked for together with the bias."""
    if error is None:
        return None
    if bias.high >= error:
        raise EffectError(f"an error of {100.0 * error:.3g} % cannot be reached: what is left out makes {bias}")
    return math.sqrt(error**2 - bias.high**2)


class _Watch:
    """Gives the quote as soon as there is one, or says why there is none."""

    def __init__(
        self,
        pilot: Pilot,
        quoted: Callable[[Quote], object] | None,
        unquoted: Callable[[str], object] | None,
    ) -> None:
        self._pilot, self._quoted, self._unquoted, self._done = pilot, quoted, unquoted, False

    def __call__(self, _: Session) -> None:
        if self._done:
            return
        try:
            found = self._pilot.pass_ended()
        except RenderError as problem:
            self._give(self._unquoted, str(problem))
            return
        if found is not None:
            self._give(self._quoted, found)

    def ended(self) -> None:
        """Say that the render is over, so that there will be no quote any more."""
        if not self._done:
            self._give(self._unquoted, "the render ended before a pilot could tell anything")

    def _give(self, heard: Callable[[T], object] | None, what: T) -> None:
        self._done = True
        if heard is not None:
            heard(what)


def _show(viewer: Viewer, session: Session) -> None:
    if viewer.due:
        viewer.offer(session.image())


def _render_cross_check(scene: Scene, limits: Limits, strategy: Strategy, seed: int) -> Result:
    """Render with `equaltime.crosscheck`, which has one strategy, its own, and no clock."""
    if limits != Limits(spp=limits.spp) or limits.spp is None or strategy != Strategy():
        raise StrategyError(_CROSS_CHECK_ALONE)
    begin = clock.perf_counter()
    try:
        from equaltime import crosscheck  # here, since not everyone has embreex

        mean, variance = crosscheck.render(scene, spp=limits.spp, seed=seed)
    except ImportError as error:
        if error.name != "embreex":
            raise
        raise RenderError(str(error)) from error
    seconds = clock.perf_counter() - begin
    samples = np.full(mean.shape[:2], limits.spp, np.int64)
    pixels = PixelStatistics(mean, variance, samples, degrees=float(max(limits.spp - 1, 1)))
    stats = Stats(
        phases={**scene.timings, "render": seconds},
        paths=samples.size * limits.spp,
        rays=0,
        shadow_rays=0,
        kernel="crosscheck",
        threads=1,
    )
    return make_result(pixels, stats, "spp", origin_of(scene, "crosscheck", False, seed, limits.spp, "embreex"))
