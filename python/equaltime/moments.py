"""Moments of a film as integers that an image file can hold without loss.

A film is a (R, H, W) structured array with the fields ``count``, ``mean`` (3) and ``m2`` (3), the core's own. EXR has
no float64, and narrowing one silently would end resuming with the same bits: every number is split into two uint32
channels, its low and its high word.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["DTYPE", "WORDS", "channel_names", "joined", "split"]

DTYPE = np.dtype([("count", "<u8"), ("mean", "<f8", (3,)), ("m2", "<f8", (3,))])
"""Of one pixel in one replicate: samples, their mean and the sum of their squared deviations from it, by channel."""
WORDS = DTYPE.itemsize // 4
"""uint32 channels for one replicate."""

_QUANTITIES = ("count", *(f"{moment}.{channel}" for moment in ("mean", "m2") for channel in "RGB"))


def channel_names(replicates: int) -> tuple[str, ...]:
    """Return the names of the channels of `split`, in order: ``r0.count.low``, ``r0.count.high``, and so on."""
    return tuple(f"r{r}.{name}.{word}" for r in range(replicates) for name in _QUANTITIES for word in ("low", "high"))


def split(moments: NDArray[Any]) -> NDArray[np.uint32]:
    """Return (R, H, W) moments as (H, W, R * WORDS) words, in the order of `channel_names`."""
    replicates, height, width = moments.shape
    flat = np.ascontiguousarray(moments.astype(DTYPE, copy=False)).view("<u4")
    words = flat.reshape(replicates, height, width, WORDS).transpose(1, 2, 0, 3)
    return np.ascontiguousarray(words).reshape(height, width, replicates * WORDS)


def joined(words: NDArray[np.uint32]) -> NDArray[Any]:
    """Return the moments that `split` made these words from."""
    height, width, channels = words.shape
    by_replicate = words.reshape(height, width, channels // WORDS, WORDS).transpose(2, 0, 1, 3)
    return np.ascontiguousarray(by_replicate, "<u4").view(DTYPE)[..., 0]
