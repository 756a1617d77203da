"""The variance that second nets tell is that of real images: of a lattice's points, one net a pixel.

The stated variance of every pixel is held against the scatter of images over seeds, both relative to the picture. Seeds
are fixed; a z-test over the seeds rejects beyond 4 standard errors (false alarms: 6e-5 each). The twin takes replicates
for independent, which they are not in one net.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.second_nets import statistics_so_far
from equaltime.rendering.core import make_renderer
from equaltime.strategy import Strategy

SCENES = Path(__file__).parents[2] / "scenes"
COUNTS = (8, 24, 64)
SEEDS, SIDE = 48, 40
Z_LIMIT = 4.0
Pair = tuple[PixelStatistics, PixelStatistics]


@cache
def renders(name: str) -> list[list[Pair]]:
    """Return what is known by second nets and by replicates alone, by seed and count."""
    scene = et.load(SCENES / name).with_(size=(SIDE, SIDE), max_depth=5)
    found = []
    for seed in range(SEEDS):
        renderer = make_renderer(scene, Strategy(sampler="lattice"), seed, 0, nets=1, second_net=2)
        pairs = []
        for count in COUNTS:
            renderer.advance(count)
            pairs.append((statistics_so_far(renderer), pixel_statistics(renderer.moments)))
        found.append(pairs)
    return found


def excess(name: str, count: int, which: Callable[[Pair], PixelStatistics]) -> float:
    """Return z of the stated variance less that of the images over the seeds, relative to the picture."""
    found = [which(pairs[COUNTS.index(count)]) for pairs in renders(name)]
    images = np.array([pixels.mean for pixels in found])
    mean = images.mean(axis=0)
    denominator = np.square(mean) + (0.1 * mean.mean()) ** 2
    stated = np.array([(pixels.variance / denominator).mean() for pixels in found])
    real = (np.square(images - mean) / denominator).mean(axis=(1, 2, 3)) * SEEDS / (SEEDS - 1)
    apart = stated - real
    return float(apart.mean() / (apart.std(ddof=1) / math.sqrt(SEEDS)))


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", ["cornell-box.toml", "experiments/ball.toml", "experiments/opening.toml"])
def test_the_stated_variance_is_that_of_the_image(name: str, count: int) -> None:
    assert abs(excess(name, count, lambda pair: pair[0])) < Z_LIMIT


@pytest.mark.parametrize("count", COUNTS)
def test_that_of_the_replicates_of_one_net_would_be_seen_to_be_wrong(count: int) -> None:
    assert abs(excess("cornell-box.toml", count, lambda pair: pair[1])) > Z_LIMIT
