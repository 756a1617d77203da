"""The protocol of agreement itself, on images of which the truth is known.

Seeds are fixed. The counts of false alarms are binomial: each test of them would fail for one seed in ten thousand.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime.statistics.agreement import (
    LEVEL,
    Agreement,
    BlockMeans,
    anderson_darling,
    block_means,
    compare,
    share,
    sidak,
)

Array = NDArray[np.float64]
SEEDS, ROWS, COLUMNS = 64, 16, 16


class Pair:
    """Two renderers of a made-up scene, with noise that differs from pixel to pixel and is shared by the channels."""

    def __init__(self, seed: int = 0) -> None:
        self.rng = np.random.default_rng(seed)
        self.truth = self.rng.uniform(0.5, 2.0, (ROWS, COLUMNS, 3))
        self.sigma = self.rng.uniform(0.02, 0.5, (2, ROWS, COLUMNS, 1))

    @property
    def standard_error(self) -> Array:
        """Of the difference of the two mean images (rows, columns, 1)."""
        error: Array = np.sqrt((self.sigma**2).sum(axis=0) / SEEDS)
        return error

    def images(self, renderer: int, bias: Array | float = 0.0, seeds: int = SEEDS) -> Iterator[Array]:
        for _ in range(seeds):
            grey = self.rng.standard_normal((ROWS, COLUMNS, 1))
            color = self.rng.standard_normal((ROWS, COLUMNS, 3))
            yield self.truth + bias + self.sigma[renderer] * (0.8 * grey + 0.6 * color)

    def compared(self, bias: Array | float = 0.0, block: int = 1) -> Agreement:
        """Compare the two, of which the first has a bias."""
        images = self.images(0, bias), self.images(1)
        return compare(*(BlockMeans.of_seeds(side, block) for side in images))


def test_equal_expectations_fail_as_often_as_stated() -> None:
    comparisons = [Pair(seed).compared() for seed in range(300)]
    for level in (0.1, 0.01):
        looks = {name: sum(c.looks[name] < level for c in comparisons) for name in comparisons[0].looks}
        most = stats.binom.isf(1e-5, len(comparisons), 1.15 * level)  # 1.15: see anderson_darling
        assert all(count <= most for count in looks.values()), looks
        assert sum(c.p < level for c in comparisons) <= most
    assert all(count > 0 for count in looks.values()), "safe, but not blind"


def test_skewed_noise_of_many_paths_gives_no_false_alarm() -> None:
    """A pixel's samples are far from normal; block means over 64 pixels and 16 samples of skewness 6 are near it."""
    rng = np.random.default_rng(1)
    p_values = []
    for _ in range(100):
        sides = [rng.gamma(64 * 16 / 9.0, 1.0, (SEEDS, 8, 8, 3)), rng.gamma(64 * 16, 1.0, (SEEDS, 8, 8, 3)) / 9.0]
        p_values.append(compare(*(BlockMeans.of_seeds(side, 1) for side in sides)).p)
    assert sum(p < 0.05 for p in p_values) <= stats.binom.isf(1e-4, 100, 0.05)


@pytest.mark.parametrize("sign", ["one", "random"])
def test_a_bias_below_a_standard_error_is_found_when_it_is_spread_wide(sign: str) -> None:
    for seed in range(10):
        pair = Pair(seed)
        if sign == "one":
            bias = 0.4 * pair.standard_error
        else:
            bias = 0.9 * pair.standard_error * pair.rng.choice([-1.0, 1.0], (ROWS, COLUMNS, 1))
        found = pair.compared(bias)
        assert found.p < share(LEVEL, 20)
        assert found.looks["worst"] > share(LEVEL, 20), "no single block shows it"


def test_a_mistake_in_one_block_is_found_and_its_place_is_told() -> None:
    pair = Pair(3)
    bias = np.zeros((ROWS, COLUMNS, 3))
    bias[5, 7, 1] = 8.0 * pair.standard_error[5, 7, 0]
    found = pair.compared(bias)
    assert found.p < share(LEVEL, 20)
    assert found.worst_block == (5, 7, 1)
    assert "block (5, 7), channel 1" in str(found)
    assert found.z[5, 7, 1] > 0, "the first image is the brighter one"


def test_seeds_that_are_no_seeds_are_found() -> None:
    """Renders that repeat the same numbers claim half of their true standard error."""
    pair = Pair(4)
    sides = [[image for image in pair.images(side, seeds=16) for _ in range(4)] for side in (0, 1)]
    assert compare(*(BlockMeans.of_seeds(side, 1) for side in sides)).p < share(LEVEL, 20)


def test_known_variances_and_seeds_can_be_compared() -> None:
    pair = Pair(5)
    mean = pair.truth + pair.sigma[0] / 8.0 * pair.rng.standard_normal((ROWS, COLUMNS, 3))
    known = BlockMeans.of_pixels(mean, np.broadcast_to(pair.sigma[0] ** 2 / 64.0, mean.shape), block=2)
    seeds = BlockMeans.of_seeds(pair.images(1), block=2)
    assert compare(known, seeds).p > LEVEL
    assert compare(BlockMeans(known.mean + 0.02, known.variance, math.inf), seeds).p < LEVEL


def test_what_has_no_noise_must_be_equal_but_for_rounding() -> None:
    pair = Pair(6)
    images = [list(pair.images(side)) for side in (0, 1)]
    for image in images[0] + images[1]:
        image[:4] = 17.0
    images[1] = [image * (1 + 5e-7) for image in images[1]]
    same = compare(*(BlockMeans.of_seeds(side, 2) for side in images))
    assert np.isnan(same.z[:2]).all()
    assert np.isfinite(same.z[2:]).all()
    assert same.p > LEVEL
    for image in images[1]:
        image[0:2, 0:2, 2] += 1e-3
    different = compare(*(BlockMeans.of_seeds(side, 2) for side in images))
    assert different.unequal == 1
    assert different.p == 0.0


def test_images_without_any_noise_are_compared_too() -> None:
    flat = np.ones((SEEDS, 4, 4, 3))
    assert compare(BlockMeans.of_seeds(flat, 2), BlockMeans.of_seeds(flat, 2)).p == 1.0
    differ = compare(BlockMeans.of_seeds(flat, 2), BlockMeans.of_seeds(2.0 * flat, 2))
    assert differ.p == 0.0
    assert "no noise" in str(differ)


def test_block_means_drop_what_is_left_over() -> None:
    image = np.arange(5 * 7 * 3, dtype=np.float64).reshape(5, 7, 3)
    means = block_means(image, 2, 2)
    assert means.shape == (2, 3, 3)
    np.testing.assert_allclose(means[1, 2, 0], image[2:4, 4:6, 0].mean())


@pytest.mark.parametrize("size", [12, 300])
def test_anderson_darling_fails_as_often_as_it_says(size: int) -> None:
    rng = np.random.default_rng(size)
    p_values = np.array([anderson_darling(rng.standard_normal(size)) for _ in range(4000)])
    for level in (0.1, 0.01):
        low, high = (stats.binom.ppf(q, 4000, f * level) for q, f in ((1e-5, 0.95), (1 - 1e-5, 1.25)))
        assert low <= (p_values < level).sum() <= high
    assert anderson_darling(1.5 * rng.standard_normal(500)) < 1e-6
    assert anderson_darling(rng.standard_normal(500) + 0.4) < 1e-6


def test_levels_are_shared_so_that_all_together_keep_them() -> None:
    assert sidak(share(LEVEL, 50), 50) == pytest.approx(LEVEL)
    assert sidak(1e-12, 1000) == pytest.approx(1e-9)
    assert sidak(1.0, 3) == 1.0
