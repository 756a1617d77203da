"""Tails of squared errors, and whether two sets of renders have the same expectation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.cost.agreement import equality_test
from equaltime.cost.tails import block_errors, moment_index, tail_index

Array = NDArray[np.float64]


@pytest.mark.parametrize("index", [0.8, 1.5, 3.0])
def test_the_index_of_a_power_law_is_found(index: float) -> None:
    values = 1.0 + np.random.default_rng(5).pareto(index, 20_000)
    found = moment_index(values, 1000)
    assert found.index == pytest.approx(index, rel=0.2)
    assert found.least < found.index


def test_an_exponential_has_no_power_for_a_tail() -> None:
    assert moment_index(np.random.default_rng(5).standard_exponential(20_000), 1000).least > 4.0


def noisy_images(index: float | None, size: int = 64) -> Array:
    """Return 8 images of a picture with dark and noisy places; samples have a power tail, or none."""
    rng = np.random.default_rng(11)
    place = np.exp(rng.standard_normal((size, size, 1)))
    shape = (8, 16, size, size, 1)
    samples = rng.standard_normal(shape) if index is None else rng.pareto(index, shape)
    images: Array = 1.0 + 0.1 * place * samples.mean(axis=1) * np.ones(3)
    return images


def test_noise_that_differs_from_place_to_place_is_no_heavy_tail() -> None:
    assert tail_index(block_errors(noisy_images(None))).doubt == ""


@pytest.mark.parametrize("repeats", [5, 6])
def test_few_repeats_do_not_make_one(repeats: int) -> None:
    assert tail_index(block_errors(noisy_images(None, 128)[:repeats])).doubt == ""
    assert tail_index(block_errors(noisy_images(2.5, 128)[:repeats])).doubt != ""


def test_rare_samples_that_are_bounded_are_no_heavy_tail() -> None:
    """As of a small light that is found by chance: a pixel in ten has seen it in any one image."""
    found = np.random.default_rng(4).binomial(16, 0.007, (8, 64, 64, 1)) / 16.0
    assert tail_index(block_errors(0.1 + found * np.ones(3))).doubt == ""


def test_an_outlier_does_not_hide_behind_itself() -> None:
    images = 1.0 + 0.1 * np.random.default_rng(4).standard_normal((8, 64, 64, 3))
    hits = np.random.default_rng(5).random((8, 64, 64)) < 0.02
    images[hits] += 10.0 ** np.random.default_rng(6).uniform(1.0, 4.0, (int(hits.sum()), 1))
    assert tail_index(block_errors(images)).doubt


def test_errors_without_a_fourth_moment_are_seen() -> None:
    found = tail_index(block_errors(noisy_images(2.5)))
    assert found.index < 2.0
    assert "a few pixels carry much of the error" in found.doubt


def test_errors_without_a_variance_are_seen() -> None:
    assert "even the variance may be infinite" in tail_index(block_errors(noisy_images(1.3))).doubt


def test_of_a_few_pixels_or_repeats_nothing_is_said() -> None:
    images = noisy_images(2.5)
    for few in (images[:3], images[:, :8, :8]):
        found = tail_index(block_errors(few))
        assert math.isnan(found.index)
        assert found.doubt == ""


def test_images_without_noise_have_no_tail() -> None:
    assert tail_index(block_errors(np.ones((8, 64, 64, 3)))).doubt == ""


def test_equal_expectations_pass_and_a_small_bias_does_not() -> None:
    rng = np.random.default_rng(2)
    first, second = (1.0 + 0.1 * rng.standard_normal((8, 64, 64, 3)) for _ in range(2))
    assert equality_test(first, second) > 0.01
    assert equality_test(first, 1.005 * second) < 1e-6
