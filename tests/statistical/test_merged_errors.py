"""Merged renders state the variance that they have: real renders of Sobol's points, in parts of even and odd counts.

The stated variance of every pixel is held against the scatter of merged images over groups of seeds, both relative to
the picture. Seeds are fixed; a z-test over the groups rejects beyond 4 standard errors (false alarms: 6e-5 each). The
twin joins the replicates of all parts, and knows nothing of the parts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache, reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.parts_of_merge import MergedFilm

SCENE = Path(__file__).parents[2] / "scenes" / "experiments" / "ball.toml"
GROUPS = 60
Z_LIMIT = 4.0


@cache
def films(counts: tuple[int, ...]) -> tuple[MergedFilm, ...]:
    """Return merged films of parts with so many samples a pixel, one a group."""
    scene = et.load(SCENE).with_(size=(16, 16))

    def part(seed: int, spp: int) -> NDArray[Any]:
        moments = et.render(scene, spp=spp, seed=seed, threads=1).moments
        assert moments is not None
        return moments

    return tuple(
        reduce(MergedFilm.joined, (MergedFilm.of(part(100 * group + k, spp)) for k, spp in enumerate(counts)))
        for group in range(GROUPS)
    )


def excess(found: Sequence[PixelStatistics]) -> float:
    """Return z of the stated variance less that of the images over the groups, relative to the picture."""
    images = np.array([pixels.mean for pixels in found])
    mean = images.mean(axis=0)
    denominator = np.square(mean) + (0.1 * mean.mean()) ** 2
    stated = np.array([(pixels.variance / denominator).mean() for pixels in found])
    real = (np.square(images - mean) / denominator).mean(axis=(1, 2, 3)) * len(found) / (len(found) - 1)
    apart = stated - real
    return float(apart.mean() / (apart.std(ddof=1) / math.sqrt(len(found))))


@pytest.mark.parametrize("counts", [(3, 3, 3, 3), (1,) * 8, (2,) * 8, (14, 2)], ids=str)
def test_the_stated_variance_is_that_of_the_image(counts: tuple[int, ...]) -> None:
    assert abs(excess([film.statistics() for film in films(counts)])) < Z_LIMIT


def test_that_of_joined_replicates_would_be_seen_to_be_too_large_for_odd_parts() -> None:
    assert excess([pixel_statistics(film.moments) for film in films((3, 3, 3, 3))]) > Z_LIMIT
