"""Moments (count, mean, deviation) in files of format 1, of equaltime 0.1.0, which can still be resumed and merged.

Each 8-byte number is stored as two uint32 channels, its low and its high word. The sums of squared deviations are
float64. Image, errors and counts are channels of the first subimage: R, G, B, stderr.R, stderr.G, stderr.B, samples.
"""

from __future__ import annotations

import os
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.film.moments import DTYPE, MOST, PARTS, stored
from equaltime.images.reading import read_part

__all__ = ["read_moments", "read_parts"]

_MOMENTS: Final = np.dtype([("count", "<u8"), ("mean", "<f8", (3,)), ("m2", "<f8", (3,))])


def read_moments(path: str | os.PathLike[str]) -> NDArray[Any] | None:
    """Return the moments (count, mean, deviation) in a file; None if there are none.

    The result is an array (R, H, W) of the type `equaltime.film.moments.DTYPE`, for R replicates (parts of each pixel's
    samples). Means are exact, and standard deviations are rounded. Raises `ImageError` for a damaged file.
    """
    found = _read(path, "moments", _MOMENTS)
    if found is None:
        return None
    if int(found["count"].max(initial=0)) > MOST:
        raise ImageError(f"{path}: is damaged: a pixel has more than {MOST} samples")
    moments = np.zeros(found.shape, DTYPE)
    moments["mean"], moments["count"] = found["mean"], found["count"]
    with np.errstate(all="ignore"):  # a damaged file may hold anything: `SavedRender.read` checks the numbers
        moments["deviation"] = stored(np.sqrt(found["m2"] / np.maximum(found["count"], 1)[..., None]))
    return moments


def read_parts(path: str | os.PathLike[str]) -> NDArray[Any] | None:
    """Return the sums over the renders that were merged into a file, (H, W); None if it was not merged.

    The variance of each pixel follows from these sums. The array has the type `equaltime.film.moments.PARTS`. Raises
    `ImageError` for a damaged file.
    """
    found = _read(path, "parts", PARTS)
    return None if found is None else np.asarray(found[0])


def _read(path: str | os.PathLike[str], name: str, dtype: np.dtype[Any]) -> NDArray[Any] | None:
    found = read_part(path, name, "uint")
    if found is None:
        return None
    channels, pixels = found
    layers = len(channels) // (dtype.itemsize // 4)
    prefixes = [f"r{layer}." for layer in range(layers)] if name == "moments" else [""]
    wanted = [f"{prefix}{word}" for prefix in prefixes for word in _words(dtype)]
    place = {channel: i for i, channel in enumerate(channels)}
    if {*wanted} != {*place}:
        raise ImageError(f"{path}: the part '{name}' has other channels than those of format 1")
    height, width = pixels.shape[:2]
    words = pixels[..., [place[channel] for channel in wanted]].reshape(height, width, len(prefixes), -1)
    return np.ascontiguousarray(words.transpose(2, 0, 1, 3), "<u4").view(dtype)[..., 0]


def _words(dtype: np.dtype[Any]) -> list[str]:
    shapes = ((name, dtype[name].shape) for name in dtype.names or ())
    numbers = (number for name, shape in shapes for number in ([f"{name}.{c}" for c in "RGB"] if shape else [name]))
    return [f"{number}.{word}" for number in numbers for word in ("low", "high")]
