"""Images of glTF files, decoded by OpenImageIO from a file beside the document, a data URI or a buffer view."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.images.reading import excess
from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.picture_channels import rgb_of_luminance_chroma
from equaltime.scene.pictures import Stored, largest, read_stored
from equaltime.scene.primaries import REC709, luminance_weights

__all__ = ["decode"]

SUFFIXES: Final = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg", b"RIFF": ".webp"}
MOST_PIXELS: Final = 1 << 28
IGNORED: Final = (
    *("oiio:ColorSpace", "oiio:Gamma", "chromaticities", "ICCProfile", "ICCProfile:profile_description"),
    "PixelAspectRatio",
)
"""Image attributes that readers must ignore, as the specification says: materials define the encoding of textures."""
Check = Callable[[int], object]


def decode(document: Document, index: int, check: Check) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Return the pixels of image `index`, and notes on features of the image file that are not used.

    The pixels (H, W, 4) are uint8, uint16 or float32, with opacity not premultiplied. `check` is called with the number
    of pixels before they are read, and may raise `Malformed`. Raises `Malformed` if the image cannot be read.
    """
    image, place = document.gltf.images[index], f"images[{index}]"
    if image.bufferView is not None:
        return _from_bytes(bytes(document.view(image.bufferView)), place, check)
    if image.uri is None:
        raise Malformed((place, "needs a 'uri' or a 'bufferView'"))
    if image.uri.startswith("data:"):
        return _from_bytes(document.resource(image.uri, f"{place}.uri"), place, check)
    try:
        path = document.locate(document.relative(image.uri, f"{place}.uri"))
    except Malformed:
        raise
    except ValueError as error:
        raise Malformed((f"{place}.uri", str(error))) from error
    return _from_file(path, place, check)


def _from_bytes(content: bytes, place: str, check: Check) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Decode bytes through a private file, because OpenImageIO's Python module reads files only."""
    suffix = next((suffix for magic, suffix in SUFFIXES.items() if content.startswith(magic)), None)
    if suffix is None:
        raise Malformed((place, "is no PNG, JPEG or WebP image"))
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / f"image{suffix}"
        path.write_bytes(content)
        return _from_file(path, place, check)


def _from_file(path: Path, place: str, check: Check) -> tuple[NDArray[Any], tuple[str, ...]]:
    def checked(spec: Any) -> None:
        if spec.width * spec.height > MOST_PIXELS:
            raise Malformed((place, f"{spec.width}x{spec.height} pixels; the limit is {MOST_PIXELS} in all"))
        if wrong := excess(spec, path):
            raise Malformed((place, wrong))
        check(spec.width * spec.height)

    try:
        stored = read_stored(path, ("uint8", "uint16"), checked)
    except ImageError as error:
        message = str(error).removeprefix(f"{path}: ").replace(str(path), path.name)  # the path may be a private file
        raise Malformed((place, f"cannot be read as an image: {message}")) from error
    for name in IGNORED:
        stored.account.attribute(name)
    if (number := stored.account.attribute("Orientation", 1)) is not None:
        stored.account.note(f"its orientation {number} is not used: images of glTF are as they are stored")
    return _rgba(stored), tuple(f"{place}: {told}" for told in stored.account.told())


def _rgba(stored: Stored) -> NDArray[Any]:
    """Return grey, grey with opacity, RGB or RGBA as RGBA."""
    colors, alpha = stored.colors, stored.alpha
    if stored.choice.kind == "luminance and chroma":
        colors = rgb_of_luminance_chroma(colors, luminance_weights(REC709))
    height, width, channels = colors.shape
    color = colors if channels == 3 else np.repeat(colors, 3, axis=2)
    if alpha is None:
        alpha = np.full((height, width, 1), largest(colors), colors.dtype)
    return np.concatenate([color, alpha], axis=2)
