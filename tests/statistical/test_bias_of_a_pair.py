"""Two renders whose noise comes from few bright paths are not told to differ more often than p-values allow.

Renders are made up: a pixel is the mean of two halves, and its variance is the square of half their difference, pooled
over 7x7 pixels, as files of renders have it. Nearly all noise comes from few bright events.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from equaltime.film.sums import box_sum, neighbours
from equaltime.statistics.agreement import BlockMeans, compare, compare_pair

Floats = NDArray[np.float64]

PAIRS = 100
LEVEL = 0.01
MOST = int(stats.binom.isf(1e-4, PAIRS, LEVEL))
"""More rejections than this have a probability below 1e-4 if p-values are right."""
SIDE = 192


Render = tuple[Floats, Floats]


def render(rng: np.random.Generator, bias: float = 0.0) -> Render:
    """Return a render and its pixels' variances: even noise, and bright events in one pixel of a hundred."""
    shape = (2, SIDE, SIDE, 1)
    halves = rng.normal(1.0 + bias, 0.02, shape) + 5.0 * rng.exponential(1.0, shape) * (rng.random(shape) < 0.005)
    square = np.square(halves[0] - halves[1]) / 4.0
    return halves.mean(axis=0), box_sum(square) / neighbours(SIDE, SIDE)


def careful(first: Render, second: Render) -> float:
    return compare_pair(first, second, 8, 49.0).p


def careless(first: Render, second: Render) -> float:
    return compare(*(BlockMeans.of_pixels(*one, 8, 49.0) for one in (first, second))).p


def rejections(test: Callable[[Render, Render], float], bias: float = 0.0) -> int:
    rng = np.random.default_rng(20261126)
    return sum(test(render(rng), render(rng, bias)) < LEVEL for _ in range(PAIRS))


def test_equal_renders_are_not_told_to_differ() -> None:
    assert rejections(careful) <= MOST


def test_with_the_test_for_many_renders_they_would_be() -> None:
    assert rejections(careless) > 5 * MOST


def test_a_render_that_is_brighter_is_told() -> None:
    """By 3 % of its even light."""
    assert rejections(careful, bias=0.03) > 0.9 * PAIRS
