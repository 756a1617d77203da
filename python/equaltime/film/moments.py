"""Array types for moments (count, mean, deviation) of a film's pixels, and for sums over the parts of a merged film."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["DTYPE", "MOST", "PARTS", "deviations", "nonfinite", "squared_deviations", "stored"]

DTYPE: Final = np.dtype([("mean", "<f8", (3,)), ("count", "<u4"), ("deviation", "<u4", (3,))])
"""One pixel in one replicate: the mean of its samples, their number, and the root mean square of their deviations from
the mean (over n, not n - 1), by channel. A deviation is the upper half of a float64 (`deviations`). A film of the core
is a (R, H, W) array of this type."""
MOST: Final = 2**32 - 1
"""Most samples of a pixel in one replicate."""
PARTS: Final = np.dtype(
    [
        *((name, "<u8") for name in ("parts", "uneven", "squares")),
        *((name, "<f8", (3,)) for name in ("within", "between")),
    ]
)
"""Sums over the parts that have samples in a pixel: the number of parts; the number of parts whose replicates have
unequal counts; ``n²``, ``n² V`` and ``n (I_k - I)²`` (`equaltime.film.parts_of_merge`)."""


def deviations(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return the standard deviations of samples, (..., 3), from moments of shape (...); divisor n, not n - 1."""
    return np.asarray((moments["deviation"].astype(np.uint64) << np.uint64(32)).view(np.float64))


def stored(deviation: NDArray[np.float64]) -> NDArray[np.uint32]:
    """Return standard deviations as moments store them: the upper half of each float64, with 21 significant bits."""
    bits = np.ascontiguousarray(deviation, np.float64).view(np.uint64)
    return ((bits + np.uint64(2**31)) >> np.uint64(32)).astype(np.uint32)


def squared_deviations(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return the sums of squared deviations of samples from their mean, (..., 3), from moments of shape (...)."""
    return np.asarray(moments["count"][..., None] * np.square(deviations(moments)))


def nonfinite(moments: NDArray[Any]) -> tuple[int, int] | None:
    """Return the first pixel (x, y) whose (R, H, W) moments hold NaN or infinity; None if all numbers are finite."""
    finite = np.isfinite(moments["mean"]).all(axis=(0, 3)) & np.isfinite(deviations(moments)).all(axis=(0, 3))
    if finite.all():
        return None
    y, x = np.argwhere(~finite)[0]
    return int(x), int(y)
