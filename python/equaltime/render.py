"""`render`: from a scene to a result."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from equaltime import _core
from equaltime.error_estimate import PixelStatistics, image_error, pixel_statistics, standard_error
from equaltime.errors import NonFiniteSample, Problem, RenderError, SceneError, StrategyError
from equaltime.images import Window
from equaltime.passes import Limits, ProgressCallback, run_passes
from equaltime.result import Origin, Result, Stats, StoppedBy
from equaltime.scene import Scene, load, load_dict
from equaltime.scene.model import MOST_SAMPLES
from equaltime.strategy import Strategy

__all__ = ["MOST_SECONDS", "MOST_THREADS", "Backend", "render"]

Backend = Literal["core", "embreex"]
MOST_THREADS = 4096
"""More than any machine has processors; some ten thousand end the process."""
MOST_SECONDS = 1e9
"""Thirty years: what a 64-bit count of nanoseconds holds, with room to spare."""
_DEFAULT_SPP = 64
_REPLICATES = 2
_BYTES_PER_MOMENTS = 56
_BYTES_PER_RESULT_PIXEL = 100


def render(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    spp: int | None = None,
    time: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: ProgressCallback | None = None,
    backend: Backend = "core",
) -> Result:
    """Render a scene until a number of samples or a time is reached.

    For one build, the pixels depend on the scene, the strategy, the seed and the sample counts: not on ``threads``, and
    on ``time`` only through the counts that were reached.

    Parameters
    ----------
    scene
        A loaded scene, the path of a scene file, or a dict in Mitsuba's words.
    spp
        Samples per pixel. If neither ``spp`` nor ``time`` is given: the scene's own sample count, or 64.
        One sample alone gives no standard error.
    time
        Seconds from the first sample to the final film. If ``spp`` is given too, whichever comes first ends the render.
        A limit that is shorter than a pass ends it part way: some pixels then have fewer samples, or none.
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

    Returns
    -------
    Result
        After Ctrl-C (in the main thread) what was finished, with ``stopped_by == "interrupt"``.

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    NonFiniteSample
        If a sample was NaN or infinite: after its pass, with the result so far.
    RenderError
        If there is not enough memory.
    ValueError
        If an argument is out of range.
    """
    _check_arguments(spp, time, seed, threads, backend)
    chosen = strategy if isinstance(strategy, Strategy) else Strategy.parse(strategy)
    loaded = _as_scene(scene)
    limits = Limits(spp if spp or time else loaded.spp or _DEFAULT_SPP, time)
    if backend == "embreex":
        return _render_cross_check(loaded, limits, chosen, seed)
    return _render_core(loaded, limits, chosen, seed, threads, progress)


def _check_arguments(spp: int | None, time: float | None, seed: int, threads: int, backend: str) -> None:
    if spp is not None and not 1 <= spp <= MOST_SAMPLES:
        raise ValueError(f"spp must be from 1 to {MOST_SAMPLES}, found {spp}")
    if time is not None and not 0.0 < time <= MOST_SECONDS:
        raise ValueError(f"time must be a positive number of seconds up to {MOST_SECONDS:g}, found {time}")
    if not 0 <= seed < 2**64:
        raise ValueError(f"seed must be from 0 to 2^64 - 1, found {seed}")
    if not 0 <= threads <= MOST_THREADS:
        raise ValueError(f"threads must be from 0 to {MOST_THREADS}, found {threads}")
    if backend not in get_args(Backend):
        raise ValueError(f"backend must be one of {', '.join(get_args(Backend))}, found {backend!r}")


def _as_scene(scene: Scene | str | os.PathLike[str] | Mapping[str, Any]) -> Scene:
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return load_dict(dict(scene))
    return load(Path(scene))


def _render_core(
    scene: Scene, limits: Limits, strategy: Strategy, seed: int, threads: int, progress: ProgressCallback | None
) -> Result:
    settings = _core.Settings(
        **strategy.model_dump(exclude={"truncate"}), truncate=strategy.truncate or 0, max_depth=scene.max_depth
    )
    _check_memory(scene)
    try:
        core = scene.core
        renderer = _core.Renderer(core, settings, seed=seed, threads=threads, replicates=_REPLICATES)
    except MemoryError as error:
        width, height = scene.size
        raise RenderError(f"not enough memory for the scene and a film of {width}x{height} pixels") from error
    height, width = core.film_shape
    begin = clock.perf_counter()
    stopped_by = run_passes(renderer, height * width, limits, progress)
    seconds = clock.perf_counter() - begin
    if stopped_by == "interrupt" and not renderer.counters["paths"]:
        raise KeyboardInterrupt
    while True:
        try:
            return _core_result(scene, core, renderer, strategy, seed, seconds, stopped_by)
        except KeyboardInterrupt:  # an impatient one more, or one too late: what is finished is finished
            stopped_by = "interrupt"


def _core_result(
    scene: Scene,
    core: _core.Scene,
    renderer: _core.Renderer,
    strategy: Strategy,
    seed: int,
    seconds: float,
    stopped_by: StoppedBy,
) -> Result:
    """Make the result of what `renderer` holds; raises `NonFiniteSample` with it if a sample was not a number."""
    counters = renderer.counters
    stats = Stats(
        phases={**scene.timings, "render": seconds},
        paths=counters["paths"],
        rays=counters["rays"],
        shadow_rays=counters["shadow_rays"],
        kernel=renderer.kernel,
        threads=renderer.threads,
        effects=tuple(name for name, used in core.effects().items() if used),
        build=_core.build_info(),
    )
    origin = _origin(scene, strategy.name, strategy.biased, seed, _REPLICATES, "core")
    result = _result(pixel_statistics(renderer.moments), stats, stopped_by, origin)
    if renderer.nonfinite:
        x, y, index = renderer.nonfinite[0]
        raise NonFiniteSample((x, y), index, seed, result)
    return result


def _check_memory(scene: Scene) -> None:
    """Refuse a film that this machine cannot hold: the system would rather end the process than say so."""
    _, _, width, height = scene.model.sensor.film.crop
    needed = width * height * (_REPLICATES * _BYTES_PER_MOMENTS + _BYTES_PER_RESULT_PIXEL)
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > present:
        message = f"an image of {width}x{height} pixels needs {needed / 1e9:.3g} GB of memory; "
        raise SceneError((Problem("", message + f"this machine has {present / 1e9:.3g} GB"),))


def _render_cross_check(scene: Scene, limits: Limits, strategy: Strategy, seed: int) -> Result:
    """Render with `equaltime.crosscheck`, which has one strategy, its own, and no clock."""
    if limits.spp is None or limits.seconds is not None or strategy != Strategy():
        raise StrategyError("the embreex backend has no time limit and one strategy, its own: give spp and seed only")
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
    return _result(pixels, stats, "spp", _origin(scene, "crosscheck", False, seed, limits.spp, "embreex"))


def _origin(scene: Scene, strategy: str, biased: bool, seed: int, replicates: int, backend: str) -> Origin:
    film = scene.model.sensor.film
    return Origin(
        scene=None if scene.source is None else str(scene.source),
        digest=scene.digest,
        window=Window(*film.crop[:2], *film.size),
        substitutions=tuple(map(str, scene.substitutions)),
        max_depth=scene.max_depth,
        strategy=strategy,
        biased=biased,
        seed=seed,
        replicates=replicates,
        backend=backend,
    )


def _result(pixels: PixelStatistics, stats: Stats, stopped_by: StoppedBy, origin: Origin) -> Result:
    begin = clock.perf_counter()
    errors = standard_error(pixels)
    error = image_error(pixels)
    phases = {**stats.phases, "estimate": clock.perf_counter() - begin}
    with np.errstate(over="ignore"):  # beyond 3e38 a float32 is infinite, and so it is shown
        image = pixels.mean.astype(np.float32)
    return Result(image, errors, pixels.samples, error, replace(stats, phases=phases), stopped_by, origin)
