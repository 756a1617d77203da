"""Sums over neighbourhoods against the plain definition."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.film.sums import RADIUS, box_sum, nearest_mean, neighbours, others_count, others_sum

Floats = NDArray[np.float64]


def by_definition(image: Floats, middle: bool) -> Floats:
    height, width, _ = image.shape
    sums = np.zeros_like(image)
    for y in range(height):
        for x in range(width):
            around = image[max(y - RADIUS, 0) : y + RADIUS + 1, max(x - RADIUS, 0) : x + RADIUS + 1]
            sums[y, x] = around.sum(axis=(0, 1)) - (0.0 if middle else image[y, x])
    return sums


@pytest.mark.parametrize("shape", [(1, 1, 3), (2, 9, 1), (13, 4, 3), (8, 8, 2)])
@pytest.mark.parametrize(("sum_of", "middle"), [(box_sum, True), (others_sum, False)])
def test_sums_are_those_of_the_definition(
    shape: tuple[int, int, int], sum_of: Callable[[Floats], Floats], middle: bool
) -> None:
    image = np.random.default_rng(1).random(shape)
    assert np.allclose(sum_of(image), by_definition(image, middle), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("shape", [(1, 1, 3), (2, 9, 1), (13, 4, 3), (8, 8, 2)])
def test_means_of_the_nearest_are_those_of_the_definition(shape: tuple[int, int, int]) -> None:
    image = np.random.default_rng(4).random(shape)
    height, width, _ = shape
    sums, weights = np.zeros_like(image), np.zeros((height, width, 1))
    for y, x in np.ndindex(height, width):
        for row, column in np.ndindex(height, width):
            apart = max(abs(row - y), abs(column - x))
            weight = np.exp(-0.5 * ((row - y) ** 2 + (column - x) ** 2) / 0.8**2) if 0 < apart <= 2 else 0.0
            sums[y, x] += weight * image[row, column]
            weights[y, x] += weight
    assert np.allclose(nearest_mean(image), sums / np.maximum(weights, 1e-300), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("value", [0.0, 1e300, np.inf, np.nan])
@pytest.mark.parametrize(("function", "reach", "itself"), [(box_sum, RADIUS, True), (nearest_mean, 2, False)])
def test_a_pixel_is_felt_in_its_neighbourhood_alone(
    function: Callable[[Floats], Floats], reach: int, itself: bool, value: float
) -> None:
    """Of a mean of the nearest not a bit is of the pixel itself, nor of a sum of the others."""
    image = np.random.default_rng(2).random((20, 20, 1))
    spotted = image.copy()
    spotted[9, 10] = value
    near = np.zeros(image.shape, np.bool_)
    near[9 - reach : 10 + reach, 10 - reach : 11 + reach] = True
    near[9, 10] = itself
    assert ((function(spotted) != function(image)) == near).all()
    assert others_sum(spotted)[9, 10] == others_sum(image)[9, 10]


def test_an_image_seen_through_a_slice_is_summed_like_its_copy() -> None:
    image = np.random.default_rng(3).random((30, 40, 6))
    assert (box_sum(image[3:20:2, ::-1, 1:4]) == box_sum(image[3:20:2, ::-1, 1:4].copy())).all()


def test_counts_of_neighbours_are_sums_of_ones() -> None:
    ones = np.ones((9, 12, 1))
    assert (neighbours(9, 12) == by_definition(ones, True)).all()
    assert (others_count(9, 12) == by_definition(ones, False)).all()
