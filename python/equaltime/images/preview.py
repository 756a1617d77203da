"""Previews of linear images for viewing: sRGB with eight bits per channel, clipped to [0, 1], as PNG or JPEG.

The exposure is given in stops and written in the file's description (`equaltime.images.exposure`). A JPEG has no alpha:
it shows the image over a background, black by default.
"""

from __future__ import annotations

import hashlib
import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.images import image_files as images
from equaltime.images.exposure import exposure_in_words
from equaltime.images.reading import complaint, excess, opened
from equaltime.statistics.agreement import block_means

__all__ = [
    "EXTENSIONS",
    "JPEG_QUALITY",
    "REPEAT",
    "SOURCE",
    "is_edited",
    "png_bytes",
    "reduced",
    "srgb_bytes",
    "write",
    "write_grey",
]

SOURCE: Final = "equaltime:scene"
"""Name of the attribute in which a preview names the scene's file."""
REPEAT: Final = "equaltime:repeat"
"""Name of the attribute in which a preview has what repeats its render, as JSON data."""
_PIXELS: Final = "equaltime:pixels"
"""Name of the attribute in which a PNG has the fingerprint of its pixels."""
_TELLING: Final = frozenset({"Software", "ImageDescription", SOURCE, REPEAT, _PIXELS})
"""Names of the attributes that tell of the render, and not of how to show the pixels."""
_LONGEST: Final = 60_000
"""Largest length of this attribute, in bytes: a comment of a JPEG has at most 65,533."""
_FORMATS: Final = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg"}
EXTENSIONS: Final = tuple(_FORMATS)
"""Extensions of files that `write` can write."""
JPEG_QUALITY: Final = 95
"""Quality of a JPEG, in [1, 100], if no other is asked for: the loss is hard to see."""
_JPEG: Final[dict[str, Any]] = {"jpeg:subsampling": "4:4:4", "jpeg:com_attributes": 1}
"""Attributes of a JPEG: colours in full resolution, and all texts kept as comments."""


def srgb_bytes(image: NDArray[Any], stops: float = 0.0) -> NDArray[np.uint8]:
    """Return a linear RGB image (H, W, 3) as eight-bit sRGB, by the exact curve of IEC 61966-2-1.

    The image is first multiplied by 2 to the power ``stops``.
    """
    exposed = image.astype(np.float64) * 2.0**stops if stops else image
    linear = np.clip(exposed, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1.0 / 2.4) - 0.055)
    return np.asarray(np.round(255.0 * encoded), np.uint8)


def reduced(values: NDArray[Any], longest: int) -> NDArray[np.float64]:
    """Return the image ``values`` (H, W, …) reduced in size until no side exceeds ``longest`` pixels.

    Each new pixel is the mean of a block of pixels. Rows and columns at the end that fill no block are dropped. A small
    image is returned unchanged.
    """
    factor = math.ceil(max(values.shape[:2]) / longest)
    if factor == 1:
        return values
    height, width = values.shape[:2]
    return block_means(values, min(factor, height), min(factor, width))


def write(
    path: Path,
    image: NDArray[Any],
    description: str = "",
    scene: str | None = None,
    alpha: NDArray[Any] | None = None,
    stops: float = 0.0,
    repeat: str = "",
    background: Sequence[float] | None = None,
    metadata: bool = True,
    quality: int = JPEG_QUALITY,
) -> None:
    """Write the preview of a linear image (H, W, 3) to a file whose extension is one of `EXTENSIONS`.

    ``description``, ``scene`` (the path of the scene file) and ``repeat`` (JSON data that repeat the render, left out
    if empty or above 60,000 bytes) become attributes of the file. ``stops`` is the exposure;
    if it is not 0, the description tells it. If ``alpha`` (H, W) is given, the image must already be multiplied by it
    (associated). A PNG gets alpha and unmultiplied colours, as PNG requires; a fully transparent pixel keeps its
    colour. A JPEG gets no alpha. ``background`` is a linear RGB colour behind the image, which the exposure does not
    change. With a background, a PNG gets no alpha either. Without ``metadata`` the file tells only its colour space.
    ``quality`` is the quality of a JPEG, in [1, 100].

    Raises
    ------
    ImageError
        If the file cannot be written; an earlier file stays unchanged.
    """
    file_format = _FORMATS[path.suffix.lower()]
    shown = exposure_in_words(stops)
    attributes = _attributes("; ".join(filter(None, [description, shown and f"shown {shown}"])), scene)
    if repeat and len(images.escaped(repeat)) <= _LONGEST:
        attributes[REPEAT] = repeat
    channels: tuple[str, ...] = images.RGB
    if file_format == "jpeg":
        attributes |= {**_JPEG, "compression": f"jpeg:{quality}"}
    if alpha is not None and background is not None:
        pixels = srgb_bytes(image * 2.0**stops + (1.0 - alpha)[..., None] * np.asarray(background))
    elif alpha is None or file_format == "jpeg":
        pixels = srgb_bytes(image, stops)
    else:
        weight = np.where(alpha > 0.0, alpha, 1.0)[..., None]
        opaque = np.round(255.0 * np.clip(alpha, 0.0, 1.0)).astype(np.uint8)
        channels, pixels = (*images.RGB, "A"), np.dstack([srgb_bytes(image / weight, stops), opaque])
        attributes["oiio:UnassociatedAlpha"] = 1  # colours are already unmultiplied
    if file_format == "png":
        attributes[_PIXELS] = _fingerprint(pixels)
    if not metadata:
        attributes = {name: value for name, value in attributes.items() if name not in _TELLING}
    images.write(path, file_format, [images.Layer(channels, pixels, attributes)])


def is_edited(path: Path, attributes: Mapping[str, str]) -> bool:
    """Tell whether the preview at ``path`` has other pixels than `write` gave it.

    ``attributes`` are the file's texts. Only a PNG of this version or later can tell: a JPEG does not keep pixels
    exactly. Raises `ImageError` if the file cannot be read.
    """
    if (written := attributes.get(_PIXELS)) is None:
        return False
    with opened(path, UnassociatedAlpha=1) as source:
        pixels = None if excess(source.spec(), path) else source.read_image("uint8")
        complaint(source)  # or OpenImageIO prints it when the process ends
        return pixels is None or _fingerprint(pixels) != written


def _fingerprint(pixels: NDArray[np.uint8]) -> str:
    return hashlib.sha256(pixels.tobytes()).hexdigest()[:16]


def write_grey(path: Path, grey: NDArray[np.uint8], description: str = "", scene: str | None = None) -> None:
    """Write bytes (H, W) as a grey PNG file; 0 is black, 255 white.

    ``description`` and ``scene`` (the path of the scene file) become attributes of the file.

    Raises
    ------
    ImageError
        If the file cannot be written; an earlier file stays unchanged.
    """
    images.write(path, "png", [images.Layer(("Y",), grey[..., None], _attributes(description, scene))])


def _attributes(description: str, scene: str | None) -> dict[str, Any]:
    source = {} if scene is None else {SOURCE: scene}
    return {
        "oiio:ColorSpace": "sRGB",
        "Software": images.SOFTWARE,
        "ImageDescription": description,
        **source,
    }


def png_bytes(image: NDArray[Any], alpha: NDArray[Any] | None = None, stops: float = 0.0) -> bytes:
    """Return the preview of a linear image (H, W, 3) as the bytes of a PNG file.

    ``stops`` is the exposure, positive for brighter. If ``alpha`` (H, W) is given, the image must already be multiplied
    by it; the PNG gets alpha and unmultiplied colours.
    """
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / "preview.png"
        write(path, image, alpha=alpha, stops=stops)
        return path.read_bytes()
