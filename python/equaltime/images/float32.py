"""Conversion of images to float32, as files hold them; the largest number in float32 is 3.4e38."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import BrightImage

__all__ = ["as_float32", "beyond_float32"]


def as_float32(image: NDArray[Any]) -> NDArray[np.float32]:
    """Return an image as float32; values beyond the range of float32 become infinite."""
    with np.errstate(over="ignore"):
        return image.astype(np.float32)


def beyond_float32(image: NDArray[Any], corner: tuple[int, int], where: str) -> BrightImage | None:
    """Return the error for the first pixel of an image (H, W, 3) that is not finite in float32; None if all are.

    Parameters
    ----------
    corner
        Position (x, y) of the image's first pixel in the whole film.
    where
        Name of the image, with which the error message begins; may be empty.
    """
    beyond = np.argwhere(~np.isfinite(as_float32(image)))
    if not len(beyond):
        return None
    y, x, channel = (int(number) for number in beyond[0])
    pixel = f"pixel {corner[0] + x},{corner[1] + y}"
    return BrightImage(f"{where}: {pixel}" if where else pixel, float(image[y, x, channel]))
