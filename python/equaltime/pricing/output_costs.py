"""Cost of the outputs beside the image: the share of each in the time of the image and all outputs together.

Outputs are made after the render, by separate paths (`equaltime.rendering.outputs`). So a share holds for a render with
this number of samples a pixel: first hits cost the same for any number, rays take at most 16 samples, and bounces cost
about as much as the image.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import perf_counter

import numpy as np

from equaltime.rendering.core_subject import CoreSubject
from equaltime.rendering.outputs import asked_for, outputs
from equaltime.scene import Scene
from equaltime.statistics.intervals import Interval, ratio_interval
from equaltime.strategy import Strategy

__all__ = ["ALL", "measure_outputs"]

ALL = "all"


def measure_outputs(
    scene: Scene,
    strategy: Strategy,
    repeats: int,
    samples: int,
    seed: int = 0,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
) -> Mapping[str, Interval]:
    """Return the share of the time that each output beside the image takes, by ``name:kind`` (``distance:depth``).

    The key `ALL` has the share of all outputs made together. Shares refer to the time of the image with all outputs.
    The result is empty if the scene asks for no outputs.

    Each of ``repeats`` repeats makes the image, each output by itself, and all outputs together, by ``strategy`` with
    ``samples`` per pixel. The first repeat has the seed ``seed``, and each repeat takes the next one. Every second
    repeat goes in reverse order, so that a drifting machine affects all alike. ``threads`` is the number of threads; 0
    is one for each processor. ``progress`` is called with the finished fraction. Raises `NonFiniteSample` if a sample
    is NaN or infinite.
    """
    asked = asked_for(scene)
    if not asked:
        return {}
    subject = CoreSubject("", strategy)
    subject.prepare(scene, threads)

    def image(seed: int) -> float:
        (end,) = subject.run(seed, (samples,))
        return end.wall_s

    def beside(chosen: tuple[tuple[str, str], ...]) -> Callable[[int], float]:
        def seconds(seed: int) -> float:
            begin = perf_counter()
            outputs(scene, scene, strategy, seed, threads, samples, 1.0, chosen)
            return perf_counter() - begin

        return seconds

    single = {f"{name}:{what}".lstrip(":"): beside(((name, what),)) for name, what in asked}
    cases = {"": image, **single, ALL: beside(asked)}
    found: dict[str, list[float]] = {name: [] for name in cases}
    for repeat in range(repeats):
        for name in list(cases) if repeat % 2 == 0 else list(cases)[::-1]:
            found[name].append(cases[name](seed + repeat))
        if progress is not None:
            progress((repeat + 1) / repeats)
    times = {name: np.array(seconds) for name, seconds in found.items()}
    whole = times[""] + times[ALL]
    return {name: ratio_interval(times[name], whole) for name in (*single, ALL)}
