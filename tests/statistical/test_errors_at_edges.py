"""Whether stated errors hold where pixels are noisy and an edge is near.

A pixel's noise is measured by a reference brightness, which is a local mean where the pixel is noisy. Before black
ground the mean must not have the ground in it, and in the dark it must not have the light in it. An interval of 95 %
holds in fewer than 88 of 100 renders by chance once in 300 times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.film import error
from equaltime.film.error import PixelStatistics, image_error, pixel_statistics
from equaltime.rendering.core import make_renderer

from ..unit.film.plain_parts import plain_parts, whole_means

Floats = NDArray[np.float64]

PLATE = Path(__file__).parents[2] / "scenes" / "experiments" / "plate.toml"
SEEDS, LEAST_INSIDE = 100, 88


def plate() -> et.Scene:
    """Return a rough plate before black ground, and its highlight of a lamp."""
    return et.load(PLATE, alpha=0.25, radius=1, radiance=7.6)


def ball() -> et.Scene:
    """Return a ball before black ground that a lamp lights from the side: few samples find it where it sets."""
    look = {"origin": [0, 1, 4], "target": [0, 0.5, 0], "up": [0, 1, 0]}
    film = {"type": "hdrfilm", "width": 40, "height": 40, "rfilter": {"type": "box"}}
    lamp = {"type": "sphere", "center": [-1.2, 3, 1.5], "radius": 1.0, "emitter": {"type": "area", "radiance": 5}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "sensor": {"type": "perspective", "fov": 40, "to_world": [{"look_at": look}], "film": film},
            "ball": {"type": "sphere", "center": [0, 0.7, 0], "radius": 0.7, "bsdf": {"type": "diffuse"}},
            "lamp": lamp,
        }
    )


@cache
def truth(scene: Callable[[], et.Scene]) -> tuple[Floats, Floats]:
    """Return the mean of two long renders, and the square of its noise."""
    pair = [et.render(scene(), spp=8192, strategy="mis", seed=seed).image.astype(np.float64) for seed in (1, 2)]
    return (pair[0] + pair[1]) / 2, np.square(pair[0] - pair[1]) / 4


@cache
def runs(scene: Callable[[], et.Scene], spp: int) -> tuple[list[PixelStatistics], float]:
    """Return the statistics of each seed's pixels, and the true error of such renders."""
    loaded, strategy = scene(), et.Strategy.parse("bsdf")
    true, noise = truth(scene)
    denominator = np.square(true) + (0.1 * true.mean()) ** 2
    found, squares = [], []
    for seed in range(SEEDS):
        renderer = make_renderer(loaded, strategy, 500 + seed, 1)
        renderer.advance(spp)
        found.append(pixel_statistics(renderer.moments))
        squares.append(((np.square(found[-1].mean - true) - noise) / denominator).mean())
    return found, math.sqrt(float(np.mean(squares)))


def inside(scene: Callable[[], et.Scene], spp: int) -> int:
    """Return how many renders have the true error in the interval that they state."""
    found, true = runs(scene, spp)
    intervals = [image_error(pixels) for pixels in found]
    return sum(each.low <= true <= each.high for each in intervals)


CASES = [(plate, 4), (plate, 16), (plate, 64), (ball, 16), (ball, 64), (ball, 96)]


@pytest.mark.parametrize(("scene", "spp"), CASES)
def test_intervals_hold_the_error_beside_edges(scene: Callable[[], et.Scene], spp: int) -> None:
    assert inside(scene, spp) >= LEAST_INSIDE


@pytest.mark.parametrize(("scene", "spp"), [(plate, 16), (ball, 96)])
def test_local_means_that_reach_across_edges_would_be_seen(
    scene: Callable[[], et.Scene], spp: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def whole(mean: Floats, variance: Floats, samples: Any, floor: float, least: Floats | None) -> Any:
        return plain_parts(mean, variance, samples, floor, 0.0 if least is None else least, means=whole_means)

    monkeypatch.setattr(error, "error_contributions", whole)
    assert inside(scene, spp) < LEAST_INSIDE
