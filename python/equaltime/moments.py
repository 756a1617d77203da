"""Moments of a film as integers that an image file can hold without loss.

A film is a (R, H, W) structured array with the fields ``count``, ``mean`` (3) and ``m2`` (3), the core's own. EXR has
no float64, and narrowing one silently would end resuming with the same bits: every number is split into two uint32
channels, its low and its high word. The sums over the parts of a merged render (`equaltime.parts_of_merge`) are stored
in the same way.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["DTYPE", "PARTS", "WORDS", "channel_names", "joined", "part_channels", "split"]

DTYPE = np.dtype([("count", "<u8"), ("mean", "<f8", (3,)), ("m2", "<f8", (3,))])
"""Of one pixel in one replicate: samples, their mean and the sum of their squared deviations from it, by channel."""
PARTS = np.dtype(
    [
        *((name, "<u8") for name in ("parts", "uneven", "squares")),
        *((name, "<f8", (3,)) for name in ("within", "between")),
    ]
)
"""Sums over the parts that have samples in a pixel: their number; that of parts whose replicates have unequal counts;
``n²``, ``n² V`` and ``n (I_k - I)²`` (`equaltime.parts_of_merge`)."""
WORDS = DTYPE.itemsize // 4
"""uint32 channels for one replicate."""


def channel_names(replicates: int) -> tuple[str, ...]:
    """Return the names of the channels of `split`, in order: ``r0.count.low``, ``r0.count.high``, and so on."""
    return tuple(f"r{r}.{word}" for r in range(replicates) for word in _words(DTYPE))


def part_channels() -> tuple[str, ...]:
    """Return the names of the channels of `split` for one layer of the type `PARTS`, in order."""
    return _words(PARTS)


def _words(dtype: np.dtype[Any]) -> tuple[str, ...]:
    shapes = ((name, dtype[name].shape) for name in dtype.names or ())
    numbers = (number for name, shape in shapes for number in ([f"{name}.{c}" for c in "RGB"] if shape else [name]))
    return tuple(f"{number}.{word}" for number in numbers for word in ("low", "high"))


def split(layers: NDArray[Any], dtype: np.dtype[Any] = DTYPE) -> NDArray[np.uint32]:
    """Return (L, H, W) numbers of the type `DTYPE` or `PARTS` as (H, W, L * words), in the order of their channels."""
    count, height, width = layers.shape
    size = dtype.itemsize // 4
    flat = np.ascontiguousarray(layers.astype(dtype, copy=False)).view("<u4")
    words = flat.reshape(count, height, width, size).transpose(1, 2, 0, 3)
    return np.ascontiguousarray(words).reshape(height, width, count * size)


def joined(words: NDArray[np.uint32], dtype: np.dtype[Any] = DTYPE) -> NDArray[Any]:
    """Return the numbers that `split` made these words from."""
    height, width, channels = words.shape
    size = dtype.itemsize // 4
    by_layer = words.reshape(height, width, channels // size, size).transpose(2, 0, 1, 3)
    return np.ascontiguousarray(by_layer, "<u4").view(dtype)[..., 0]
