"""Moments (count, mean, deviation) of a film's pixels: their array types, and how files store them without loss.

EXR has no float64, and its compression gains nothing on numbers whose last digits are noise. So an array (L, H, W) of a
NumPy type is stored byte by byte: byte k of all numbers of a layer is a channel. A uint32 word holds four pixels, so
the channel has ceil(W / 4) words in a row. Such channels compress well: the high bytes of neighbours are alike, and the
low bytes of whole numbers are zero.

The means of a film are close to the image, which is in the file anyway. So a mean is stored as the count of float64
numbers between the mean and its prediction from the image. The prediction is nearly exact for the last replicate that
has samples, as the image is the mean of all replicates. The moments of a film with one sample per pixel therefore take
almost no space beside the image.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "DTYPE",
    "MOST",
    "PARTS",
    "channel_names",
    "deviations",
    "nonfinite",
    "packed",
    "packed_moments",
    "packed_shape",
    "sample_variance",
    "squared_deviations",
    "stored",
    "unpacked",
    "unpacked_moments",
]

DTYPE: Final = np.dtype([("mean", "<f8", (3,)), ("count", "<u4"), ("deviation", "<u4", (3,))])
"""Moments of one pixel in one replicate (group of its samples): the mean of the samples, their number, and the root
mean square of their deviations from the mean (over n, not n - 1), by channel. A deviation is the upper half of a
float64 (`deviations`). A film of the core is an array (R, H, W) of this type, with R replicates."""
MOST: Final = 2**32 - 1
"""Largest number of samples of a pixel in one replicate (group of its samples): the limit of uint32."""
PARTS: Final = np.dtype(
    [
        *((name, "<u8") for name in ("parts", "uneven", "squares")),
        *((name, "<f8", (3,)) for name in ("within", "between")),
    ]
)
"""Sums over the merged renders (parts) that have samples in a pixel. ``parts`` counts these renders, and ``uneven``
counts those whose two groups of samples (replicates) have unequal counts. Let render k have n samples with mean I_k and
variance V, and let I be the merged mean. Then ``squares``, ``within`` and ``between`` are the sums of ``n²``, ``n² V``
and ``n (I_k - I)²``. `equaltime.film.parts_of_merge` has the formulas."""


_ROWS: Final = 64
"""Rows of an image that are packed at once, which bounds the memory."""
_WORD: Final = 4
"""Pixels, of a byte each, in a word."""


def deviations(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return the standard deviation of one sample in each element of ``moments``, with divisor n and not n - 1.

    ``moments`` is an array of type `DTYPE` and any shape (...); the result has shape (..., 3), for R, G and B.
    """
    return np.asarray((moments["deviation"].astype(np.uint64) << np.uint64(32)).view(np.float64))


def stored(deviation: NDArray[np.float64]) -> NDArray[np.uint32]:
    """Return standard deviations, an array ``deviation`` of any shape, in the form in which `DTYPE` stores them.

    The form is the upper half of each float64: 32 bits, with 21 significant bits.
    """
    bits = np.ascontiguousarray(deviation, np.float64).view(np.uint64)
    return ((bits + np.uint64(2**31)) >> np.uint64(32)).astype(np.uint32)


def squared_deviations(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return the sum of squared deviations of samples from their mean, for each element of ``moments``.

    ``moments`` is an array of type `DTYPE` and any shape (...); the result has shape (..., 3), for R, G and B.
    """
    return np.asarray(moments["count"][..., None] * np.square(deviations(moments)))


def sample_variance(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return the variance of one sample of each pixel, (H, W, 3), from the moments (R, H, W) of R replicates.

    A replicate is a group of a pixel's samples. Squared deviations from the means of the replicates are pooled, with n
    - R degrees of freedom for n samples. The variance is infinite where n is at most R.
    """
    freedom = moments["count"].astype(np.int64).sum(axis=0) - (moments["count"] > 0).sum(axis=0)
    sums = squared_deviations(moments).sum(axis=0)
    pooled = np.divide(sums, freedom[..., None], out=np.full_like(sums, np.inf), where=freedom[..., None] > 0)
    return np.asarray(pooled)


def nonfinite(moments: NDArray[Any]) -> tuple[int, int] | None:
    """Return the first pixel (x, y) whose mean or deviation is NaN or infinite; None if all numbers are finite.

    ``moments`` (R, H, W) is an array of type `DTYPE`.
    """
    finite = np.isfinite(moments["mean"]).all(axis=(0, 3)) & np.isfinite(deviations(moments)).all(axis=(0, 3))
    if finite.all():
        return None
    y, x = np.argwhere(~finite)[0]
    return int(x), int(y)


def channel_names(dtype: np.dtype[Any], layers: int) -> tuple[str, ...]:
    """Return the names of the file channels in which `packed` stores ``layers`` arrays of type ``dtype``, in order.

    A channel holds one byte of one number: ``r0.mean.R.0`` is the lowest byte of the mean of red in layer 0.
    """
    return tuple(f"r{layer}.{name}" for layer in range(layers) for name in _bytes_of(dtype))


def _bytes_of(dtype: np.dtype[Any]) -> list[str]:
    names = []
    for field in dtype.names or ():
        of = dtype[field]
        for number in [f"{field}.{c}" for c in "RGB"] if of.shape else [field]:
            names += [f"{number}.{byte}" for byte in range(of.base.itemsize)]
    return names


def packed_shape(height: int, width: int) -> tuple[int, int]:
    """Return (rows, columns) of the uint32 image in which `packed` stores an image of this height and width in pixels.

    A word holds four bytes, one of each of four neighbouring pixels, so that a row has ceil(width / 4) columns.
    """
    return height, -(-width // _WORD)


def packed(numbers: NDArray[Any]) -> NDArray[np.uint32]:
    """Return an array (L, H, W) of a NumPy type as an image of uint32 words for EXR files, (H, ceil(W / 4), C).

    EXR has no float64. A channel holds one byte of one of the L numbers, and a word holds that byte of four
    neighbouring pixels. `channel_names` lists the C channels.
    """
    layers, height, width = numbers.shape
    size = numbers.dtype.itemsize
    flat = np.ascontiguousarray(numbers).view(np.uint8).reshape(layers, height, width, size)
    planes = np.zeros((*packed_shape(height, width), layers * size, _WORD), np.uint8)
    by_channel = flat.transpose(1, 2, 0, 3).reshape(height, width, layers * size)
    for place in range(_WORD):
        of = by_channel[:, place::_WORD]
        planes[:, : of.shape[1], :, place] = of
    return planes.view("<u4")[..., 0]


def unpacked(words: NDArray[np.uint32], width: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return the array (L, H, W) of type ``dtype`` from the words (H, ceil(W / 4), C) that `packed` returned.

    ``width`` is W, the width of the array in pixels.
    """
    height, columns, channels = words.shape
    layers = channels // dtype.itemsize
    planes = np.ascontiguousarray(words, "<u4").view(np.uint8).reshape(height, columns, channels, _WORD)
    flat = np.empty((height, columns * _WORD, channels), np.uint8)
    for place in range(_WORD):
        flat[:, place::_WORD] = planes[..., place]
    by_layer = flat[:, :width].reshape(height, width, layers, dtype.itemsize).transpose(2, 0, 1, 3)
    return np.ascontiguousarray(by_layer).view(dtype)[..., 0]


def packed_moments(moments: NDArray[Any], image: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return the moments (R, H, W) of a film as an image of uint32 words for EXR files, (H, ceil(W / 4), C).

    The means are stored as differences from a prediction, which compress well. ``image`` (H, W, 3) is the image in the
    same file, from which the means are predicted. `unpacked_moments` reads the words.
    """
    height, width = image.shape[:2]
    words = np.empty((*packed_shape(height, width), len(moments) * DTYPE.itemsize), np.uint32)
    for row in range(0, height, _ROWS):
        rows = slice(row, row + _ROWS)
        part = moments[:, rows].astype(DTYPE)
        apart = _ordered(part["mean"]) - _ordered(_foretold(part, image[rows]))
        part["mean"] = _unsigned(apart).view(np.float64)
        words[rows] = packed(part)
    return words


def unpacked_moments(words: NDArray[np.uint32], image: NDArray[np.float32]) -> NDArray[Any]:
    """Return the moments (R, H, W) of a film, of type `DTYPE`, from the words that `packed_moments` returned.

    ``image`` (H, W, 3) must be the image that was given to `packed_moments`.
    """
    height, width = image.shape[:2]
    moments = np.empty((words.shape[-1] // DTYPE.itemsize, height, width), DTYPE)
    for row in range(0, height, _ROWS):
        rows = slice(row, row + _ROWS)
        part = unpacked(words[rows], width, DTYPE)
        apart = _signed(np.ascontiguousarray(part["mean"]).view(np.uint64))
        for replicate in range(len(part)):  # the last is predicted from those before
            foretold = _foretold(part, image[rows], replicate)
            part["mean"][replicate] = _floats(_ordered(foretold) + apart[replicate])
        moments[:, rows] = part
    return moments


def _foretold(moments: NDArray[Any], image: NDArray[np.float32], replicate: int | None = None) -> NDArray[np.float64]:
    """Predict the means (R, H, W, 3) from the image, or the mean of one replicate; the last also needs those before."""
    with np.errstate(all="ignore"):
        first = _finite(image.astype(np.float64))
        if replicate is not None and replicate < len(moments) - 1:
            return first
        counts = moments["count"].astype(np.float64)[..., None]
        rest = counts.sum(axis=0) * first
        for count, mean in zip(counts[:-1], moments["mean"][:-1], strict=True):
            rest -= count * mean
        last = _finite(rest / counts[-1])
    return last if replicate is not None else np.stack([*[first] * (len(moments) - 1), last])


def _finite(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the numbers, with 0 for those that are not finite, as where there are no samples."""
    return np.where(np.isfinite(numbers), numbers, 0.0)


def _ordered(numbers: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the rank of each float64 among all float64: neighbours differ by 1."""
    bits = np.ascontiguousarray(numbers).view(np.int64)
    return bits ^ ((bits >> 63) & np.int64(2**63 - 1))


def _floats(order: NDArray[np.int64]) -> NDArray[np.float64]:
    return (order ^ ((order >> 63) & np.int64(2**63 - 1))).view(np.float64)


def _unsigned(numbers: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return unsigned numbers in which small values of either sign have only low bytes."""
    return ((numbers << 1) ^ (numbers >> 63)).view(np.uint64)


def _signed(numbers: NDArray[np.uint64]) -> NDArray[np.int64]:
    half = (numbers >> np.uint64(1)).view(np.int64)
    return half ^ -((numbers & np.uint64(1)).view(np.int64))
