"""An image against a reference of as many samples: how often the interval holds the true error.

The picture has what is hard: a lamp with noisy edges beside dark pixels, and noise of rare bright events. Seeds are
fixed. Of N intervals that hold the truth with probability 0.95, fewer than `least(N)` do with probability 0.001.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime.film.sums import box_sum, neighbours
from equaltime.images.metrics import Reference, measure
from equaltime.rendering.noisy_reference import Difference, Noise, log_ratio
from equaltime.statistics.intervals import Interval

Array = NDArray[np.float64]
Means = tuple[Array, Array]

SIDE, PAIRS = 32, 200
LAMP = np.zeros((SIDE, SIDE, 1), bool)
LAMP[4:9, 10:16] = True
EDGE = LAMP & ~np.roll(LAMP, (1, 1), (0, 1))
TRUTH = np.where(LAMP, 20.0, np.linspace(0.05, 0.4, SIDE)[:, None, None]) * np.array([1.0, 0.8, 0.6])
FLOOR = np.square(TRUTH) + (0.1 * TRUTH.mean()) ** 2


def least(count: int) -> int:
    return int(stats.binom.ppf(0.001, count, 0.95))


def replicates(rng: np.random.Generator, samples: int) -> Means:
    """Return the means of two replicates: sums of so many events each, of which there are few outside the lamp."""
    shape = 0.5 * samples * np.where(LAMP, 1.0, 0.5)
    first, second = (TRUTH * np.where(LAMP & ~EDGE, 1.0, rng.gamma(shape) / shape) for _ in range(2))
    return first, second


def cases(samples: int) -> Iterator[tuple[Array, Means]]:
    """Return images of 16 samples a pixel, and the replicates of a reference of so many."""
    for seed in range(PAIRS):
        rng = np.random.default_rng([samples, seed])
        yield 0.5 * sum(replicates(rng, 16)), replicates(rng, samples)


def true_square(image: Array) -> float:
    return float((np.square(image - TRUTH) / FLOOR).mean())


def mean_and_variance(means: Means) -> Means:
    return 0.5 * (means[0] + means[1]), 0.25 * np.square(means[0] - means[1])


def pooled(variance: Array) -> Array:
    return box_sum(variance) / neighbours(SIDE, SIDE)


def by_pixels(image: Array, means: Means) -> Interval:
    mean, variance = mean_and_variance(means)
    return Difference.of(image, mean, Noise(variance, pooled=False)).measured


def by_neighbourhoods(image: Array, means: Means) -> Interval:
    mean, variance = mean_and_variance(means)
    return Difference.of(image, mean, Noise(pooled(variance), pooled=True)).measured


def by_pooled_errors(image: Array, means: Means) -> Interval:
    """Return the error with the noise of 7x7 pixels over the denominator of one."""
    mean, variance = mean_and_variance(means)
    return measure(image, Reference(mean, pooled(variance)), ["relmse"])["relmse"]


def held(method: Callable[[Array, Means], Interval], samples: int) -> int:
    hits = 0
    for image, means in cases(samples):
        found = method(image, means)
        hits += found.low <= true_square(image) <= found.high
    return hits


@pytest.mark.parametrize("samples", [16, 64, 256, 1024])
@pytest.mark.parametrize("method", [by_pixels, by_neighbourhoods])
def test_the_interval_holds_the_error_whatever_the_samples_of_the_reference(
    method: Callable[[Array, Means], Interval], samples: int
) -> None:
    assert held(method, samples) >= least(PAIRS)


@pytest.mark.parametrize("samples", [16, 64])
def test_pooled_noise_over_each_pixel_s_own_denominator_does_not(samples: int) -> None:
    assert held(by_pooled_errors, samples) < least(PAIRS)


def test_no_error_is_negative_and_a_good_reference_leaves_none_unknown() -> None:
    for samples in (16, 1024):
        found = [by_pixels(*case) for case in cases(samples)]
        assert all(one.value > 0.0 for one in found if one.known)
    assert all(one.known for one in found)


def test_an_interval_of_a_third_of_the_width_would_be_noticed() -> None:
    def narrow(image: Array, means: Means) -> Interval:
        found = by_pixels(image, means)
        return Interval(found.value, *(found.value + (end - found.value) / 3.0 for end in (found.low, found.high)))

    assert held(narrow, 16) < least(PAIRS)


def test_the_ratio_of_two_errors_holds_that_of_the_pair() -> None:
    hits, wrong = 0, 0
    for seed in range(PAIRS):
        rng = np.random.default_rng([7, seed])
        first, second = (0.5 * sum(replicates(rng, samples)) for samples in (16, 64))
        reference, variance = mean_and_variance(replicates(rng, 256))
        truth = np.log(true_square(first) / true_square(second))
        log, half = log_ratio(
            *(Difference.of(image, reference, Noise(variance, pooled=False)) for image in (first, second))
        )
        plain = [measure(i, Reference(reference, 0.0 * variance), ["relmse"])["relmse"].value for i in (first, second)]
        hits += abs(log - truth) <= half
        wrong += abs(np.log(plain[0] / plain[1]) - truth) <= half  # the noise of the reference left in
    assert hits >= least(PAIRS) > wrong
