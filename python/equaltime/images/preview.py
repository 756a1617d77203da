"""Previews of linear images for viewing: sRGB with eight bits per channel, at exposure 0, clipped to [0, 1].

No exposure is fitted to the image, so two previews can be compared by eye.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.images import image_files as images
from equaltime.statistics.agreement import block_means

__all__ = ["SOURCE", "png_bytes", "reduced", "srgb_bytes", "write_png"]

SOURCE: Final = "equaltime:scene"
"""Name of the attribute in which a preview names the scene's file."""


def srgb_bytes(image: NDArray[Any]) -> NDArray[np.uint8]:
    """Return a linear RGB image (H, W, 3) as eight-bit sRGB, by the exact curve of IEC 61966-2-1."""
    linear = np.clip(image, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1.0 / 2.4) - 0.055)
    return np.asarray(np.round(255.0 * encoded), np.uint8)


def reduced(values: NDArray[Any], longest: int) -> NDArray[np.float64]:
    """Return the image ``values`` (H, W, …) reduced until no side exceeds ``longest`` pixels.

    Each new pixel is the mean of a block of pixels. Rows and columns at the end that fill no block are dropped. A
    small image is returned unchanged.
    """
    factor = math.ceil(max(values.shape[:2]) / longest)
    if factor == 1:
        return values
    height, width = values.shape[:2]
    return block_means(values, min(factor, height), min(factor, width))


def write_png(
    path: Path,
    image: NDArray[Any],
    description: str = "",
    scene: str | None = None,
    alpha: NDArray[Any] | None = None,
) -> None:
    """Write the preview of a linear image (H, W, 3) to a PNG file.

    ``description`` and ``scene`` (the path of the scene file) become attributes of the file. If ``alpha`` (H, W) is
    given, the image must already be multiplied by it (associated). The file gets alpha and unmultiplied colours, as PNG
    requires. A fully transparent pixel keeps its colour.

    Raises
    ------
    ImageError
        If the file cannot be written; an earlier file stays unchanged.
    """
    attributes: dict[str, Any] = {
        "oiio:ColorSpace": "sRGB",
        "Software": images.SOFTWARE,
        "ImageDescription": description,
    }
    if scene is not None:
        attributes[SOURCE] = scene
    channels: tuple[str, ...] = images.RGB
    pixels = srgb_bytes(image)
    if alpha is not None:
        weight = np.where(alpha > 0.0, alpha, 1.0)[..., None]
        opaque = np.round(255.0 * np.clip(alpha, 0.0, 1.0)).astype(np.uint8)
        channels, pixels = (*images.RGB, "A"), np.dstack([srgb_bytes(image / weight), opaque])
        attributes["oiio:UnassociatedAlpha"] = 1  # colours are already unmultiplied
    images.write(path, "png", [images.Layer(channels, pixels, attributes)])


def png_bytes(image: NDArray[Any]) -> bytes:
    """Return the preview of a linear image (H, W, 3) as the bytes of a PNG file."""
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / "preview.png"
        write_png(path, image)
        return path.read_bytes()
