"""The cross-check as a backend of `equaltime.render`: its image with an error bar, as a `Result`."""

from __future__ import annotations

import time as clock

import numpy as np

from equaltime.crosscheck.tracer import render
from equaltime.film.error import PixelStatistics
from equaltime.rendering.result import Result, Stats, make_result
from equaltime.rendering.session import origin_of
from equaltime.scene import Scene

__all__ = ["render_result"]


def render_result(scene: Scene, spp: int, seed: int) -> Result:
    """Render a scene by the cross-check with ``spp`` samples per pixel; return the image with its error bar."""
    begin = clock.perf_counter()
    mean, variance = render(scene, spp=spp, seed=seed)
    seconds = clock.perf_counter() - begin
    samples = np.full(mean.shape[:2], spp, np.int64)
    pixels = PixelStatistics(mean, variance, samples, degrees=float(max(spp - 1, 1)))
    stats = Stats(
        phases={**scene.timings, "render": seconds},
        paths=samples.size * spp,
        rays=0,
        shadow_rays=0,
        kernel="crosscheck",
        threads=1,
    )
    return make_result(pixels, stats, "spp", origin_of(scene, "crosscheck", False, seed, spp, "embreex"))
