"""The error bars, against brute force and against simulated renders whose truth is known.

Simulations have fixed seeds; a z-test here rejects beyond 4.4 standard errors (false alarms: 1e-5 each).
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.film.error import (
    PixelStatistics,
    error_parts,
    image_error,
    pixel_statistics,
    standard_error,
)
from equaltime.film.moments import DTYPE
from equaltime.statistics.intervals import Interval

Z_LIMIT = 4.4

Floats = NDArray[np.float64]


def replicates(means: Floats, counts: Any) -> NDArray[Any]:
    moments = np.zeros(means.shape[:3], DTYPE)
    moments["mean"], moments["count"] = means, counts
    return moments


def simulate(truth: Floats, spp: int, noise: float, seed: int, count: int = 2) -> NDArray[Any]:
    """Render ``truth`` with relative Gaussian noise of each sample, shared by the channels."""
    rng = np.random.default_rng(seed)
    scatter = rng.standard_normal((count, *truth.shape[:2], 1)) * noise / math.sqrt(spp / count)
    return replicates(truth * (1.0 + scatter), spp // count)


def picture(height: int, width: int) -> Floats:
    y, x = np.mgrid[:height, :width] / max(height, width)
    edge = 0.05 + 0.4 * (x > 0.5) * (y > 0.4)
    return np.stack([0.3 + 0.2 * np.sin(9.0 * x), 0.2 + 0.3 * y, edge], axis=-1)


def neighbourhood_means(values: Floats) -> Floats:
    """Brute force: the mean over the 7x7 neighbourhood that lies in the image."""
    result = np.empty_like(values)
    for y in range(values.shape[0]):
        for x in range(values.shape[1]):
            block = values[max(0, y - 3) : y + 4, max(0, x - 3) : x + 4]
            result[y, x] = block.mean(axis=(0, 1))
    return result


def test_the_image_is_the_count_weighted_mean_of_the_replicates() -> None:
    means = np.array([1.0, 4.0])[:, None, None, None] * np.ones(3)
    pixels = pixel_statistics(replicates(means, np.array([2, 1])[:, None, None]))
    np.testing.assert_allclose(pixels.mean, 2.0)
    assert pixels.samples.item() == 3


def test_equal_counts_give_the_plain_variance_of_the_mean() -> None:
    means = np.random.default_rng(1).normal(size=(5, 4, 6, 3))
    pixels = pixel_statistics(replicates(means, 8))
    np.testing.assert_allclose(pixels.variance, means.var(axis=0, ddof=1) / 5, rtol=1e-12)


def simulated_bias(formula: Callable[[NDArray[Any]], Floats]) -> float:
    """Return z of a variance estimate at counts 2 and 1, where the true variance of the mean is 1/3."""
    counts = np.array([2, 1])[:, None, None]
    rng = np.random.default_rng(5)
    means = rng.standard_normal((2, 200, 200, 3)) / np.sqrt(counts)[..., None]
    variance = formula(replicates(means, counts))
    return float((variance.mean() - 1.0 / 3.0) / (variance.std() / math.sqrt(variance.size)))


def test_the_variance_is_unbiased_for_unequal_counts() -> None:
    assert abs(simulated_bias(lambda moments: pixel_statistics(moments).variance)) < Z_LIMIT


def test_the_formula_for_equal_counts_would_be_seen_to_be_biased() -> None:
    assert abs(simulated_bias(lambda moments: moments["mean"].var(axis=0, ddof=1) / 2)) > Z_LIMIT


def test_the_standard_error_pools_the_neighbourhood_that_lies_in_the_image() -> None:
    pixels = pixel_statistics(simulate(picture(9, 12), 8, 1.0, seed=2))
    np.testing.assert_allclose(standard_error(pixels), np.sqrt(neighbourhood_means(pixels.variance)), rtol=1e-6)


def test_the_standard_error_follows_each_pixel_s_own_count() -> None:
    moments = simulate(np.ones((20, 20, 3)), 8, 1.0, seed=3)
    moments["count"][:, 10:] *= 4
    errors = standard_error(pixel_statistics(moments))
    np.testing.assert_allclose(errors[9] / errors[10], 2.0, rtol=0.2)


def test_a_bright_pixel_does_not_spoil_the_standard_error_of_dark_ones_beyond_its_neighbourhood() -> None:
    moments = simulate(picture(20, 20), 8, 1.0, seed=4)
    alone = standard_error(pixel_statistics(moments))
    moments["mean"][0, 5, 5] = 1e30
    beside = standard_error(pixel_statistics(moments))
    np.testing.assert_array_equal(beside[9:], alone[9:])
    np.testing.assert_array_equal(beside[:, 9:], alone[:, 9:])


def test_nothing_is_known_after_one_sample() -> None:
    pixels = pixel_statistics(replicates(np.ones((2, 4, 4, 3)), np.array([1, 0])[:, None, None]))
    found = image_error(pixels)
    assert math.isnan(found.value)
    assert (found.low, found.high) == (0.0, math.inf)
    assert np.isinf(standard_error(pixels)).all()
    assert str(image_error(pixels)) == "unknown"


def test_a_pixel_without_samples_is_black_with_an_unknown_error() -> None:
    moments = simulate(np.ones((10, 10, 3)), 8, 0.1, seed=6)
    moments[:, 4, 4] = 0
    pixels = pixel_statistics(moments)
    errors = standard_error(pixels)
    assert (pixels.mean[4, 4] == 0.0).all()
    assert np.isinf(errors[4, 4]).all()
    assert np.isfinite(np.delete(errors.reshape(100, 3), 44, axis=0)).all()
    assert not image_error(pixels).known


def test_the_image_error_is_the_definition() -> None:
    # flat and of little noise: all references are nearly 1
    pixels = pixel_statistics(simulate(np.ones((16, 11, 3)), 8, 0.01, seed=7))
    expected = np.mean(pixels.variance / (1.0 + 0.1**2))
    assert image_error(pixels).value == pytest.approx(math.sqrt(expected), rel=0.002)


def test_the_references_order_the_error() -> None:
    """The pixel with its noise is the brightest, then comes the mean of both, then the pixel left out."""
    pixels = pixel_statistics(simulate(picture(40, 40), 8, 2.0, seed=7))
    parts = error_parts(pixels, float(pixels.mean.mean()))
    assert parts.lenient.mean() < parts.value.mean() < parts.cautious.mean()


def test_a_pixel_that_has_met_a_rare_bright_path_does_not_excuse_itself() -> None:
    """One replicate of some pixels is ten times too bright; the truth is 1 everywhere."""
    moments = simulate(np.ones((40, 40, 3)), 8, 0.1, seed=7)
    moments["mean"][0, ::8, ::8] = 10.0
    pixels = pixel_statistics(moments)
    true = math.sqrt(np.mean(pixels.variance / (1.0 + 0.1**2)))
    error = image_error(pixels)
    assert 0.6 * true < error.value < error.high
    assert error.high > true
    itself = math.sqrt(np.mean(pixels.variance / (pixels.mean**2 + (0.1 * pixels.mean.mean()) ** 2)))
    assert itself < 0.3 * true, "the twin: the pixel as its own reference"


def test_between_edges_the_reference_is_the_pixel_once_noise_is_low() -> None:
    truth = np.where(np.arange(40)[:, None] // 3 % 2, 1.0, 0.05) * np.ones((40, 40, 3))
    pixels = pixel_statistics(simulate(truth, 8, 1e-3, seed=7))

    def error(reference: Floats) -> float:
        return math.sqrt(np.mean(pixels.variance / (reference**2 + (0.1 * truth.mean()) ** 2)))

    assert image_error(pixels).value == pytest.approx(error(truth), rel=0.01)
    # the plain local mean is far off
    assert abs(error(neighbourhood_means(truth)) / error(truth) - 1.0) > 0.1


def test_a_black_image_has_no_upper_limit() -> None:
    assert image_error(pixel_statistics(replicates(np.zeros((2, 8, 8, 3)), 4))) == Interval(0.0, 0.0, math.inf)


def test_an_image_without_noise_has_no_error() -> None:
    assert image_error(pixel_statistics(replicates(np.ones((2, 8, 8, 3)), 4))) == Interval(0.0, 0.0, 0.0)


def test_a_single_pixel_is_estimated_without_limits() -> None:
    error = image_error(pixel_statistics(simulate(np.ones((1, 1, 3)), 8, 0.5, seed=8)))
    assert error.known
    assert (error.low, error.high) == (0.0, math.inf)


def test_a_few_pixels_give_a_wide_interval() -> None:
    error = image_error(pixel_statistics(simulate(np.ones((2, 4, 3)), 8, 0.5, seed=8)))
    assert 2.0 < error.high / error.low < 20.0


@pytest.mark.parametrize("power", [-40, 40])
def test_scaling_the_light_by_a_power_of_two_changes_no_bit_of_the_error(power: int) -> None:
    moments = simulate(picture(16, 16), 8, 0.5, seed=9)
    before = image_error(pixel_statistics(moments))
    moments["mean"] *= 2.0**power
    assert image_error(pixel_statistics(moments)) == before


def realised_error(image: Floats, truth: Floats) -> float:
    weight = truth**2 + (0.1 * truth.mean()) ** 2
    return math.sqrt(float(np.mean((image - truth) ** 2 / weight)))


def covered(side: int, spp: int, count: int, noise: float, shrink: float = 1.0) -> int:
    """Count, of 200 simulated renders, the intervals that hold the realised error."""
    truth = picture(side, side)
    hits = 0
    for seed in range(200):
        pixels = pixel_statistics(simulate(truth, spp, noise, seed, count))
        error, real = image_error(pixels), realised_error(pixels.mean, truth)
        factor = (error.high / error.value) ** shrink
        hits += error.value / factor <= real <= error.value * factor
    return hits


@pytest.mark.parametrize(("side", "count"), [(24, 2), (64, 2), (64, 4)])
def test_the_interval_holds_the_realised_error_in_95_of_100_renders(side: int, count: int) -> None:
    # fewer than 178 of 200 happen by chance once in 3000 times at 95 %
    assert 178 <= covered(side, 64, count, 0.5) <= 200


def test_an_interval_of_less_than_half_the_width_would_be_seen_to_be_too_narrow() -> None:
    assert covered(24, 64, 2, 0.5, shrink=0.4) < 178


def test_contributions_of_a_few_bright_pixels_widen_the_interval() -> None:
    moments = simulate(np.ones((64, 64, 3)), 8, 0.1, seed=10)
    even = image_error(pixel_statistics(moments))
    moments["mean"][0, ::20, ::20] += 50.0
    spotted = image_error(pixel_statistics(moments))
    assert spotted.high / spotted.value > 1.5 > 1.1 > even.high / even.value


def test_many_degrees_of_freedom_are_accepted() -> None:
    truth = picture(32, 32)
    variance = (0.1 * truth) ** 2
    pixels = PixelStatistics(truth, variance, np.full((32, 32), 64), degrees=63.0)
    assert image_error(pixels).value == pytest.approx(realised_error(truth * 1.1, truth), rel=0.05)


def test_a_limit_beyond_all_numbers_is_unknown() -> None:
    """Eight pixels, of which one makes a third of the error, at the strictest level of a look."""
    variance = np.ones((1, 8, 3))
    variance[0, 0] = 4.0
    pixels = PixelStatistics(np.ones((1, 8, 3)), variance, np.full((1, 8), 4), 1.0)
    assert image_error(pixels, level=0.95).high < 100.0
    assert image_error(pixels, level=1.0 - 2e-9).high == math.inf
