"""Tails of squared errors, and whether two sets of renders have the same expectation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.images.metrics import MOST_RATIO, Reference, Tail, squared_errors, tail_of
from equaltime.statistics.agreement import equality_test, near_normal

Array = NDArray[np.float64]


def seen(images: Array, truth: Array | float = 1.0) -> Tail:
    return tail_of(squared_errors(images, exactly(np.broadcast_to(truth, images.shape[1:]))))


def exactly(truth: Array) -> Reference:
    return Reference(truth, np.zeros_like(truth))


def noisy_images(index: float | None, repeats: int = 8, size: int = 64) -> Array:
    """Return images of a picture with dark and noisy places; samples have a power tail, or none."""
    rng = np.random.default_rng(11)
    place = np.exp(0.3 * rng.standard_normal((size, size, 1)))
    shape = (repeats, 16, size, size, 1)
    samples = rng.standard_normal(shape) if index is None else rng.pareto(index, shape) - 1.0 / (index - 1.0)
    images: Array = 1.0 + 0.1 * place * samples.mean(axis=1) * np.ones(3)
    return images


def sparks(seed: int, rate: float) -> Array:
    """Return six images in which light is found by chance alone, `rate` times a pixel; its expectation is 1."""
    rng = np.random.default_rng(seed)
    images: Array = rng.poisson(rate, (6, 48, 48, 1)) / rate * np.ones(3)
    return images


@pytest.mark.parametrize("repeats", [3, 4, 8])
def test_noise_that_differs_from_place_to_place_is_no_heavy_tail(repeats: int) -> None:
    assert seen(noisy_images(None, repeats)).doubt == ""


@pytest.mark.parametrize("repeats", [3, 4, 8])
def test_samples_with_hardly_a_variance_are_seen(repeats: int) -> None:
    """Samples of index 2.2: squared errors have index 1.1."""
    doubt = seen(noisy_images(2.2, repeats)).doubt
    assert doubt.startswith("heavy tail: one pixel of one render makes ")
    assert "of the squared error (the limit is 1.5 %)" in doubt


def test_many_rare_samples_that_are_bounded_are_no_heavy_tail() -> None:
    """As of a small light that is found by chance: one pixel in twenty has seen it in any one image."""
    found = np.random.default_rng(4).binomial(16, 0.003, (5, 64, 64, 1)) / 16.0
    tail = seen(0.1 + found * np.ones(3), 0.103)
    assert tail.doubt == ""
    assert tail.ratio < MOST_RATIO


def test_a_handful_of_rare_samples_is_one() -> None:
    found = np.random.default_rng(4).binomial(16, 3e-5, (5, 64, 64, 1)) / 16.0
    assert 0 < np.count_nonzero(found) < 20
    assert seen(0.1 + found * np.ones(3), 0.1).doubt


def test_the_ratio_falls_as_one_over_the_root_of_what_happened() -> None:
    for count in (16, 400):
        errors = np.zeros((2, 10_000))
        errors[0, :count] = 7.0
        assert tail_of(errors).ratio == pytest.approx(1.0 / math.sqrt(2 * count))


def test_a_picture_whose_error_is_in_one_place_has_no_tail_of_that() -> None:
    errors = np.ones((6, 4096)) + 0.1 * np.random.default_rng(1).standard_normal((6, 4096))
    errors[:, 17] += 1e4
    assert tail_of(errors).doubt == ""


def test_what_was_not_seen_is_allowed_for_where_single_pixels_count() -> None:
    errors = np.square(np.random.default_rng(1).standard_normal((6, 9216)))
    assert tail_of(errors).unseen == 0.0
    errors[2, 5] += 0.01 * errors.sum()
    assert tail_of(errors).doubt == ""
    assert tail_of(errors).unseen == pytest.approx(0.2, rel=0.02)


def test_of_one_repeat_nothing_is_said_and_exact_images_have_no_tail() -> None:
    alone = seen(noisy_images(2.2, 1))
    assert math.isnan(alone.ratio)
    assert (alone.doubt, alone.unseen) == ("", 0.0)
    assert seen(np.ones((8, 64, 64, 3))) == Tail(0.0, 0.0)
    assert seen(np.full((8, 64, 64, 3), 2.0)).doubt == ""


def test_an_outlier_as_bright_as_numbers_go_is_seen() -> None:
    images = np.ones((4, 16, 16, 3))
    images[1, 3, 3] = 1e150
    assert seen(images).doubt


def test_equal_expectations_pass_and_a_small_bias_does_not() -> None:
    rng = np.random.default_rng(2)
    first, second = (1.0 + 0.1 * rng.standard_normal((8, 64, 64, 3)) for _ in range(2))
    assert equality_test(first, second) > 0.01
    assert equality_test(first, 1.005 * second) < 1e-6


def test_blocks_are_compared_where_they_hold_enough_rare_events_and_only_there() -> None:
    """A false alarm at 0.001 once in 1000 pairs: none is expected in 40. The rule's twin, small blocks, has many."""
    exact = 1.0 + 0.01 * np.random.default_rng(5).standard_normal((6, 48, 48, 3))
    pairs = [(sparks(seed, 0.01), exact) for seed in range(40)]
    assert not any(near_normal(*pair, 4) for pair in pairs)
    assert sum(equality_test(*pair, 4) < 0.001 for pair in pairs) > 5
    common = [(sparks(seed, 0.5), exact) for seed in range(40)]
    trusted = [pair for pair in common if near_normal(*pair, 12)]
    assert len(trusted) > 30
    assert not any(equality_test(*pair, 12) < 0.001 for pair in trusted)
    assert all(equality_test(1.2 * first, second, 12) < 0.001 for first, second in trusted)


def test_blocks_in_which_one_side_found_nothing_are_not_compared() -> None:
    first, second = (1.0 + 0.1 * np.random.default_rng(seed).standard_normal((6, 48, 48, 3)) for seed in (1, 2))
    assert near_normal(first, second, 8)
    first[:, :8, :8] = 0.0
    assert not near_normal(first, second, 8)
    assert near_normal(first, second, 12)
    assert near_normal(np.ones_like(first), second, 8)
