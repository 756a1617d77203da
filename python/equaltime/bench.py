"""Measures how fast scenes render, and compares a render's time with the time for tracing its rays alone.

The *limit ratio* is the time that Embree alone needs to trace the rays of a render, divided by the time of the render.
A ratio of 1 would mean that the renderer does nothing but trace rays. Each repeat times a render and the replay of the
render's rays. Repeats visit all scenes and thread counts in turn, so that a slow change of the machine's speed affects
all alike.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from equaltime import _core
from equaltime.machine import machine, worker_threads
from equaltime.rendering.core import MOMENTS_BYTES, check_memory, core_settings
from equaltime.scene import Scene
from equaltime.statistics.intervals import Interval, median_interval
from equaltime.strategy import Strategy

__all__ = ["Benchmark", "Measurement", "measure"]

_PILOT_SAMPLES = 2
# Seconds that a repeat takes, about, if its number of samples is not given.
_REPEAT_SECONDS = 0.5
_MOST_SAMPLES = 256
_FILMS = 2
"""Number of films in memory at once: the render's and its replay's."""


@dataclass(frozen=True)
class Measurement:
    """Measured speed of one scene with one number of threads.

    An interval holds the median over repeats and its 95 % limits.
    """

    name: str
    """Path of the scene's file as it was given, or ``scene N`` for the N-th of the scenes if it was made in memory."""
    threads: int
    paths_per_s: Interval
    rays_per_s: Interval
    """Rays per second, shadow rays included."""
    limit_ratio: Interval
    """Seconds that Embree alone needs to trace the render's rays, divided by the seconds of the render; 1 is the best.
    """
    scaling: Interval
    """Paths per second, divided by the paths per second with the first number of threads in the same repeat."""
    repeats: int
    samples: int
    """Samples per pixel in each repeat."""
    rays_per_path: float
    """Mean number of rays of a path, shadow rays included."""
    kernel: str
    """Name of the compiled path tracer that was chosen for the scene."""
    strategy: str
    size: tuple[int, int]
    """Width and height of the rendered image in pixels."""
    max_depth: int
    triangles: int
    memory_bytes: int
    """Bytes of memory that the scene takes in the core, without the image."""
    seconds: Mapping[str, float] = field(hash=False)
    """Seconds of two phases: ``load`` reads the files, ``build`` makes the core's scene."""

    def as_dict(self) -> dict[str, Any]:
        """Return the measurement as JSON data, by field name.

        A field that is an interval becomes its value, the median. The dict ``intervals`` holds [low, high] by the same
        names.
        """
        spreads = {name: value for name, value in vars(self).items() if isinstance(value, Interval)}
        facts = {name: value for name, value in vars(self).items() if name not in spreads}
        return {
            **facts,
            "size": list(self.size),
            "seconds": dict(self.seconds),
            **{name: value.value for name, value in spreads.items()},
            "intervals": {name: [value.low, value.high] for name, value in spreads.items()},
        }


@dataclass(frozen=True)
class Benchmark:
    """Result of `measure`: speeds of scenes, with the machine and the build of equaltime that were measured."""

    scenes: tuple[Measurement, ...]
    machine: Mapping[str, Any] = field(hash=False)
    build: Mapping[str, Any] = field(hash=False)


@dataclass(frozen=True)
class _Case:
    """A scene on a number of threads, and what its repeats gave."""

    name: str
    scene: Scene
    settings: _core.Settings
    threads: int
    samples: int
    results: list[Mapping[str, Any]] = field(default_factory=list, hash=False)

    def repeat(self, number: int) -> None:
        """Time a render and the replay of its rays; which comes first alternates."""
        self.results.append(
            _core.measure_limit(
                self.scene.core,
                self.settings,
                seed=number,
                threads=self.threads,
                samples=self.samples,
                pairs=1,
                replay_first=number % 2 == 1,
            )
        )

    @property
    def pairs(self) -> list[Mapping[str, Any]]:
        return [result["pairs"][0] for result in self.results]

    @property
    def rates(self) -> list[float]:
        return [pair["paths"] / pair["render_seconds"] for pair in self.pairs]


def measure(
    scenes: Sequence[Scene],
    *,
    threads: Sequence[int] = (0,),
    repeats: int = 9,
    spp: int | None = None,
    strategy: Strategy | str = "best",
    progress: Callable[[float], object] | None = None,
) -> Benchmark:
    """Render every scene with every number of threads, and return the measured speeds.

    Parameters
    ----------
    scenes
        Loaded scenes.
    threads
        Numbers of worker threads; 0 is one for each processor. `Measurement.scaling` refers to the first.
    repeats
        Number of repeats for every scene and number of threads.
    spp
        Samples per pixel in each repeat. The default takes about half a second on the first number of threads, with at
        most 256 samples per pixel.
    strategy
        A `Strategy`, or text for `Strategy.parse`.
    progress
        Function that is called after every measurement with the fraction of the work that is done, in [0, 1].

    Raises
    ------
    SceneError, StrategyError
        If a scene cannot be built, or the strategy cannot be read.
    ValueError
        If an argument is out of range.
    """
    if not scenes or not threads or min(threads) < 0 or repeats < 1 or (spp is not None and spp < 1):
        raise ValueError("give scenes, numbers of threads of at least 0, and repeats and spp of at least 1")
    chosen = Strategy.of(strategy)
    cases = [
        case
        for number, scene in enumerate(scenes, 1)
        for case in _cases(str(scene.source or f"scene {number}"), scene, chosen, threads, spp)
    ]
    for repeat in range(repeats):
        # there and back, so that a steady drift favours none
        for position, case in enumerate(cases if repeat % 2 == 0 else cases[::-1], 1):
            case.repeat(repeat)
            if progress is not None:
                progress((repeat + position / len(cases)) / repeats)
    bases = [cases[position - position % len(threads)] for position in range(len(cases))]
    summaries = (_summary(case, base, chosen) for case, base in zip(cases, bases, strict=True))
    return Benchmark(tuple(summaries), machine(), _core.build_info())


def _cases(name: str, scene: Scene, strategy: Strategy, threads: Sequence[int], spp: int | None) -> list[_Case]:
    """Build the scene and choose how many samples a repeat takes, the same for all numbers of threads."""
    check_memory(scene, _FILMS * MOMENTS_BYTES)
    settings, threads = core_settings(scene, strategy), [worker_threads(count) for count in threads]
    if spp is None:
        pilot = _core.measure_limit(scene.core, settings, threads=threads[0], samples=_PILOT_SAMPLES, pairs=1)
        per_sample = pilot["pairs"][0]["render_seconds"] / _PILOT_SAMPLES
        spp = min(max(round(_REPEAT_SECONDS / per_sample), 1), _MOST_SAMPLES)
    return [_Case(name, scene, settings, count, spp) for count in threads]


def _summary(case: _Case, base: _Case, strategy: Strategy) -> Measurement:
    core, rates, last = case.scene.core, case.rates, case.results[-1]
    rays_of_path = [(pair["rays"] + pair["shadow_rays"]) / pair["paths"] for pair in case.pairs]
    height, width = core.film_shape
    return Measurement(
        name=case.name,
        threads=last["threads"],
        paths_per_s=median_interval(rates),
        rays_per_s=median_interval([rate * rays for rate, rays in zip(rates, rays_of_path, strict=True)]),
        limit_ratio=median_interval([pair["replay_seconds"] / pair["render_seconds"] for pair in case.pairs]),
        scaling=median_interval([rate / base_rate for rate, base_rate in zip(rates, base.rates, strict=True)]),
        repeats=len(case.pairs),
        samples=case.samples,
        rays_per_path=statistics.fmean(rays_of_path),
        kernel=last["kernel"],
        strategy=strategy.name,
        size=(width, height),
        max_depth=case.scene.max_depth,
        triangles=core.triangles,
        memory_bytes=core.memory_bytes,
        seconds=case.scene.timings,
    )
