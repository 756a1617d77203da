"""Two renders whose noise comes from few bright paths are not told to differ more often than p-values allow.

Renders are made up: a pixel is the mean of two halves, and its variance is the square of half their difference, pooled
over 7x7 pixels, as files of renders have it. Nearly all noise comes from few bright events.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime.film.sums import box_sum, neighbours
from equaltime.statistics.agreement import BlockMeans, compare, compare_pair

Floats = NDArray[np.float64]

PAIRS = 100
LEVEL = 0.01
MOST = int(stats.binom.isf(1e-4, PAIRS, LEVEL))
"""More rejections than this have a probability below 1e-4 if p-values are right."""
SIDE = 384
"""So large that its blocks of 128 pixels a side have the events that a test needs: smaller pictures allow none."""


Render = tuple[Floats, Floats]


def render(rng: np.random.Generator, bias: float = 0.0) -> Render:
    """Return a render and its pixels' variances: even noise, and bright events in one pixel of a hundred."""
    shape = (2, SIDE, SIDE, 1)
    halves = rng.normal(1.0 + bias, 0.02, shape) + 5.0 * rng.exponential(1.0, shape) * (rng.random(shape) < 0.005)
    square = np.square(halves[0] - halves[1]) / 4.0
    return halves.mean(axis=0), box_sum(square) / neighbours(SIDE, SIDE)


def pixels(result: et.Result) -> Render:
    """Return an image and its pixels' variances, as `compare` reads them from a file."""
    return result.image.astype(np.float64), np.square(result.standard_error.astype(np.float64))


def careful(first: Render, second: Render) -> float:
    found = compare_pair(first, second, 8, 49.0)
    assert found is not None
    return found.p


def careless(first: Render, second: Render) -> float:
    return compare(*(BlockMeans.of_pixels(*one, 8, 49.0) for one in (first, second))).p


def rejections(test: Callable[[Render, Render], float], bias: float = 0.0) -> int:
    rng = np.random.default_rng(20261126)
    return sum(test(render(rng), render(rng, bias)) < LEVEL for _ in range(PAIRS))


def test_equal_renders_are_not_told_to_differ() -> None:
    assert rejections(careful) <= MOST


def test_with_the_test_for_many_renders_they_would_be() -> None:
    assert rejections(careless) > 5 * MOST


@pytest.mark.parametrize(("strategy", "samples"), [("bsdf", 4), ("bsdf", 16), ("naive", 8)])
def test_unbiased_renders_whose_pixels_have_mostly_met_no_lamp_are_not_told_to_differ(
    strategy: str, samples: int
) -> None:
    """Of 24 pairs, at a level of 1e-3, three rejections have a probability of 2e-6; small blocks reject most pairs."""
    scene = et.load("cornell-box").with_(size=(96, 96))
    better = pixels(et.render(scene, spp=64, seed=99))
    pairs = [(pixels(et.render(scene, spp=samples, strategy=strategy, seed=seed)), better) for seed in range(24)]
    found = [compare_pair(*pair, 8, 49.0) for pair in pairs]
    assert sum(one is not None and one.p < 1e-3 for one in found) < 3
    if samples < 16:
        assert sum(careless(*pair) < 1e-3 for pair in pairs) > 12, "the twin"


def test_a_picture_that_lacks_long_paths_is_told_though_its_noise_is_uneven() -> None:
    scene = et.load("cornell-box").with_(size=(96, 96))
    whole, cut = (pixels(et.render(scene.with_(max_depth=depth), spp=64, seed=depth)) for depth in (8, 3))
    found = compare_pair(whole, cut, 8, 49.0)
    assert found is not None
    assert found.p < 1e-6


def test_noise_of_very_few_pixels_allows_no_test() -> None:
    scene = et.load("veach-mis").with_(size=(96, 64))
    first, second = (pixels(et.render(scene, spp=4, strategy="bsdf", seed=seed)) for seed in (1, 2))
    assert compare_pair(first, second, 8, 49.0) is None


def test_a_render_that_is_brighter_is_told() -> None:
    """By 3 % of its even light."""
    assert rejections(careful, bias=0.03) > 0.9 * PAIRS
