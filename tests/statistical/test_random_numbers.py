"""The numbers behind all decisions: uniform, unrelated across slots, pixels, seeds and replicates, and well spread.

Seeds are fixed. All p-values of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime._core import parts

from .chi2 import LEVEL, chi_square, share, sidak

Array = NDArray[np.float64]
KINDS = ["independent", "stratified", "sobol", "lattice"]
EACH = share(LEVEL, len(KINDS) * (3 + 5))
BOUND = stats.norm.isf(share(LEVEL, 3 * len(KINDS)) / 2)


def numbers(kind: str, seed: int, pixel: int, count: int, slot: int, replicates: int = 1) -> Array:
    """Return the pairs (count, 2) of the first samples."""
    drawn: Array = parts.sample_numbers(kind, seed, pixel, count, slot, replicates)
    return drawn


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_multiples_of_the_smallest_step_below_one(kind: str) -> None:
    steps = numbers(kind, 1, 2, 1 << 16, 3) * 2.0**24
    assert (steps == np.floor(steps)).all()
    assert steps.min() >= 0
    assert steps.max() < 2.0**24


SETS: dict[str, Callable[[str], Array]] = {
    "samples": lambda kind: numbers(kind, 1, 7, 1 << 16, 11),
    "pixels": lambda kind: np.concatenate([numbers(kind, 1, p, 1, 11) for p in range(1 << 16)]),
    "seeds": lambda kind: np.concatenate([numbers(kind, s, 7, 4, 11)[3:] for s in range(1 << 16)]),
}


def uniform_p(pairs: Array) -> float:
    counts = np.histogram2d(*pairs.T, bins=16, range=[[0, 1], [0, 1]])[0]
    return chi_square(counts, np.full(counts.shape, len(pairs) / counts.size))


@pytest.mark.parametrize("over", SETS)
@pytest.mark.parametrize("kind", KINDS)
def test_pairs_are_uniform(kind: str, over: str) -> None:
    assert uniform_p(SETS[over](kind)) > EACH


def test_pairs_tilted_by_ten_percent_are_rejected() -> None:
    pairs = SETS["pixels"]("independent")
    pairs[:, 0] += 0.1 * pairs[:, 0] * (1 - pairs[:, 0])
    assert uniform_p(pairs) < EACH


# Two sets of numbers that should have nothing to do with one another: n samples each, in a thousand pixels.

COUNT, PIXELS = 64, 1024
OTHER: dict[str, Callable[[str, int], Array]] = {
    "next slot": lambda kind, p: numbers(kind, 1, p, COUNT, 12),
    "same decision a bounce on": lambda kind, p: numbers(kind, 1, p, COUNT, 27),
    "next pixel": lambda kind, p: numbers(kind, 1, p + 1, COUNT, 11),
    "pixel below": lambda kind, p: numbers(kind, 1, p + 256, COUNT, 11),
    "next seed": lambda kind, p: numbers(kind, 2, p, COUNT, 11),
}


def correlation_p(first: list[Array], second: list[Array]) -> float:
    """Return the p-value of all four correlations between two pairs being 0, by t-tests over the pixels."""
    products = np.stack([(a - 0.5).T @ (b - 0.5) for a, b in zip(first, second, strict=True)])
    p = stats.ttest_1samp(products.reshape(len(products), 4), 0.0).pvalue
    return sidak(float(p.min()), 4)


# The lattices of two pixels are the same points with other shifts, and their Sobol' points are the same with other
# scrambles. A pair of pixels may agree by much, or disagree, as these have it; only the mean over pixels is 0. So a
# correlation between pixels has to be larger to be seen.
@pytest.mark.parametrize("other", OTHER)
@pytest.mark.parametrize("kind", KINDS)
def test_numbers_of_different_decisions_are_not_correlated(kind: str, other: str) -> None:
    first = [numbers(kind, 1, p, COUNT, 11) for p in range(0, 512 * PIXELS, 512)]
    second = [OTHER[other](kind, p) for p in range(0, 512 * PIXELS, 512)]
    assert correlation_p(first, second) > EACH
    part = 0.15 if kind in ("lattice", "sobol") and other in ("next pixel", "pixel below", "next seed") else 0.03
    mixed = [(1 - part) * b + part * a for a, b in zip(first, second, strict=True)]
    assert correlation_p(first, mixed) < EACH, "the twin: a correlation of 3 or 15 %"


@pytest.mark.parametrize("kind", KINDS)
def test_replicates_are_not_correlated(kind: str) -> None:
    both = [numbers(kind, 1, p, 2 * COUNT, 11, 2) for p in range(PIXELS)]
    assert correlation_p([b[0::2] for b in both], [b[1::2] for b in both]) > LEVEL


def is_net(pairs: Array) -> bool:
    """Return whether 2^m points put one into every elementary interval of area 2^-m."""
    m = (len(pairs) - 1).bit_length()
    for k in range(m + 1):
        columns, rows = (pairs * [1 << k, 1 << (m - k)]).astype(int).T
        if len(set((columns << (m - k)) + rows)) != len(pairs):
            return False
    return True


PIXEL, PADDED = 0, 8 + 16 * 8 + 3
"""The slots of the pixel's place, and of a direction at the first vertex whose numbers are padded."""


@pytest.mark.parametrize("replicates", [1, 2, 3])
@pytest.mark.parametrize(("slot", "m"), [(PIXEL, 1), (PIXEL, 4), (PIXEL, 7), (PIXEL, 10), (PADDED, 4), (PADDED, 10)])
def test_sobol_numbers_of_each_replicate_are_a_net_in_base_two(slot: int, m: int, replicates: int) -> None:
    n = 1 << m
    for pixel in range(20):
        drawn = numbers("sobol", 5, pixel, 3 * n * replicates, slot, replicates)
        for replicate in range(replicates):
            own = drawn[replicate::replicates]
            assert all(is_net(own[block : block + n]) for block in (0, n, 2 * n))


def test_independent_numbers_and_shifted_nets_are_none() -> None:
    """The twin."""
    assert not is_net(numbers("independent", 5, 0, 128, 0))
    assert not is_net(numbers("sobol", 5, 0, 192, 0)[32:160])


def in_strata(pairs: Array) -> bool:
    """Return whether 4^k points put one into every cell of 2^k by 2^k."""
    side = math.isqrt(len(pairs))
    return len({tuple(cell) for cell in (pairs * side).astype(int).tolist()}) == len(pairs) == side**2


@pytest.mark.parametrize("replicates", [1, 2, 3])
@pytest.mark.parametrize("k", [1, 2, 4])
def test_stratified_numbers_of_each_replicate_take_a_stratum_each(k: int, replicates: int) -> None:
    n = 4**k
    for pixel in range(20):
        for slot in (0, 9, 27):
            drawn = numbers("stratified", 5, pixel, 3 * n * replicates, slot, replicates)
            for replicate in range(replicates):
                own = drawn[replicate::replicates]
                assert all(in_strata(own[block : block + n]) for block in (0, n, 2 * n))


def test_independent_numbers_and_those_from_the_middle_of_sixteen_do_not() -> None:
    """The twin. In half of the pixels, or fewer, two parts of sixteen complete each other."""
    assert not in_strata(numbers("independent", 5, 0, 16, 0))
    assert not all(in_strata(numbers("stratified", 5, pixel, 18, 0)[2:]) for pixel in range(20))


def scatter(kind: str, count: int, seed: int) -> float:
    """Return the variance of the mean of `count` samples, over pixels."""
    integrand = SMOOTH["two dimensions"][0]
    return float(np.var([integrand(numbers(kind, seed, p, count, 11)).mean() for p in range(4000)]))


@pytest.mark.parametrize("count", [4, 16, 64])
def test_strata_leave_the_variance_within_them_alone(count: int) -> None:
    """As the integrals over the cells have it, which are exact to 1e-5; a χ²-test at 0.1 %."""
    u = (np.arange(512) + 0.5) / 512
    side = math.isqrt(count)
    values = SMOOTH["two dimensions"][0](np.stack(np.meshgrid(u, u, indexing="ij"), axis=-1).reshape(-1, 2))
    cells = values.reshape(side, 512 // side, side, 512 // side).transpose(0, 2, 1, 3).reshape(count, -1)
    expected = float(cells.var(axis=1).mean()) / count
    low, high = stats.chi2.ppf([0.0005, 0.9995], 3999) / 3999
    assert low < scatter("stratified", count, 9) / expected < high
    assert scatter("independent", count, 9) / expected > high, "the twin: no strata"


@pytest.mark.parametrize("count", [1, 3, 6, 20, 50])
def test_strata_do_no_harm_at_any_number_of_samples(count: int) -> None:
    """A one-sided F-test at 0.1 %; as a twin, numbers that come in equal pairs."""
    high = stats.f.ppf(0.999, 3999, 3999)
    assert scatter("stratified", count, 9) / scatter("independent", count, 9) < high
    assert scatter("independent", (count + 1) // 2, 10) / scatter("independent", 2 * count, 9) > high


def error_slope(kind: str, integrand: Callable[[Array], Array], exact: float, replicates: int = 1) -> float:
    """Return d log(error) / d log(samples) of the mean over 16 to 1024 samples of a replicate."""
    sizes = 2 ** np.arange(4, 11)
    runs = [numbers(kind, s, 3, 1024 * replicates, 11, replicates)[::replicates] for s in range(200)]
    values = np.stack([integrand(r) for r in runs])
    errors = [np.sqrt(((values[:, :n].mean(axis=1) - exact) ** 2).mean()) for n in sizes]
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


SMOOTH: dict[str, tuple[Callable[[Array], Array], float]] = {
    "one dimension": (lambda u: np.exp(u[:, 1]), np.e - 1),
    "two dimensions": (lambda u: np.sin(np.pi * u[:, 0]) * np.exp(u[:, 1]), 2 / np.pi * (np.e - 1)),
}


@pytest.mark.parametrize("replicates", [1, 2])
@pytest.mark.parametrize("name", SMOOTH)
def test_sobol_errors_of_smooth_integrals_fall_faster_than_samples_grow(name: str, replicates: int) -> None:
    assert error_slope("sobol", *SMOOTH[name], replicates) < -1.2
    assert -0.6 < error_slope("independent", *SMOOTH[name], replicates) < -0.4, "the twin"


@pytest.mark.parametrize("count", [3, 4, 7])
@pytest.mark.parametrize("kind", KINDS)
def test_means_over_pixels_are_unbiased(kind: str, count: int) -> None:
    """Over scrambles, any number of samples of a smooth integrand has its exact mean: z-tests at 0.1 %, and twins."""
    integrand, exact = SMOOTH["two dimensions"]
    means = np.array([integrand(numbers(kind, 9, p, count, 11)).mean() for p in range(10_000)])
    error = means.std() / np.sqrt(len(means))
    assert abs(means.mean() - exact) < BOUND * error
    assert abs(means.mean() * 1.03 - exact) > BOUND * error
