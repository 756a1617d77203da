"""Reduction of large pictures to a size that fits a page."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["reduced"]

Floats = NDArray[np.float64]


def reduced(values: NDArray[Any], longest: int) -> Floats:
    """Average whole blocks of pixels of (H, W, …) until no side exceeds ``longest``; small images stay unchanged."""
    factor = math.ceil(max(values.shape[:2]) / longest)
    if factor == 1:
        return values
    down, across = (min(factor, size) for size in values.shape[:2])
    rows, columns = values.shape[0] // down, values.shape[1] // across
    blocks = values[: rows * down, : columns * across].reshape(rows, down, columns, across, *values.shape[2:])
    return np.asarray(blocks.mean(axis=(1, 3)))
