"""Array operations that the film's statistics share, most of them in C++: sums over neighbourhoods, and error terms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from equaltime._core import (
    MOST_PIXELS_A_SECOND_NET,
    box_sum,
    error_contributions,
    focused_light,
    join_replicates,
    lamps_in_sight,
    merge_moments,
    mirrored_lamps,
    nearest_mean,
    others_sum,
    sample_deviations,
    second_net_pixels,
    standard_errors,
    unshadowed,
)

__all__ = [
    "MOST_PIXELS_A_SECOND_NET",
    "RADIUS",
    "box_sum",
    "error_contributions",
    "error_floor",
    "focused_light",
    "join_replicates",
    "lamps_in_sight",
    "merge_moments",
    "mirrored_lamps",
    "nearest_mean",
    "neighbours",
    "others_count",
    "others_sum",
    "sample_deviations",
    "second_net_pixels",
    "standard_errors",
    "unshadowed",
    "window_around",
]

Floats = NDArray[np.float64]

RADIUS = 3
"""Distance in pixels from the centre of a neighbourhood to its outermost pixels: 3, so a neighbourhood is 7x7."""


def error_floor(mean: float) -> float:
    """Return (0.1 m)², the part of a squared error's denominator R² + (0.1 m)² that keeps dark pixels from dominating.

    R is the reference brightness of a pixel. ``mean`` is m, the mean of R over pixels and channels.
    """
    return (0.1 * mean) ** 2


def neighbours(height: int, width: int) -> Floats:
    """Return the number of pixels in each pixel's 7x7 neighbourhood, itself included: (``height``, ``width``, 1)."""
    return box_sum(np.ones((height, 1, 1))) * box_sum(np.ones((1, width, 1)))


def others_count(height: int, width: int) -> Floats:
    """Return the number of other pixels in each pixel's 7x7 neighbourhood: (``height``, ``width``, 1); at least 1."""
    return np.maximum(neighbours(height, width) - 1.0, 1.0)


def window_around(mask: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return slices (rows, columns) of the smallest window that holds all pixels set in a mask, with a margin.

    The margin holds the 7x7 neighbourhoods of these pixels, as far as they lie in the image. The mask is (H, W), and at
    least one pixel must be set.
    """
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return _around(rows), _around(columns)


def _around(where: NDArray[np.intp]) -> slice:
    return slice(max(int(where[0]) - RADIUS, 0), int(where[-1]) + RADIUS + 1)
