"""Images of glTF files, decoded by OpenImageIO from a file beside the document, a data URI or a buffer view."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from equaltime.image_files import complaint, excess
from equaltime.scene.gltf.document import Document, Malformed

__all__ = ["decode"]

SUFFIXES: Final = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg", b"RIFF": ".webp"}
MOST_PIXELS: Final = 1 << 28
Check = Callable[[int], object]


def decode(document: Document, index: int, check: Check) -> NDArray[Any]:
    """Return the pixels (H, W, 4) of an image, not multiplied by its opacity: uint8, uint16 or float32, as it has them.

    Raises `Malformed`, as ``check`` may that is told their number before they are read.
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


def _from_bytes(content: bytes, place: str, check: Check) -> NDArray[Any]:
    """Decode what is in memory: OpenImageIO's Python module reads files only, so that it goes through a private one."""
    suffix = next((suffix for magic, suffix in SUFFIXES.items() if content.startswith(magic)), None)
    if suffix is None:
        raise Malformed((place, "is no PNG, JPEG or WebP image"))
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / f"image{suffix}"
        path.write_bytes(content)
        return _from_file(path, place, check)


def _from_file(path: Path, place: str, check: Check) -> NDArray[Any]:
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    if source is None:
        raise Malformed((place, f"cannot be read as an image: {_reason(oiio, path)}"))
    try:
        spec = source.spec()
        if spec.width * spec.height > MOST_PIXELS:
            raise Malformed((place, f"{spec.width}x{spec.height} pixels; the limit is {MOST_PIXELS} in all"))
        if wrong := excess(spec, path):
            raise Malformed((place, wrong))
        check(spec.width * spec.height)
        pixels = source.read_image(str(spec.format) if str(spec.format) in ("uint8", "uint16") else "float")
        if pixels is None:
            raise Malformed((place, f"cannot be read as an image: {_reason(source, path)}"))
    finally:
        source.close()
    return _rgba(np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels))


def _reason(speaker: Any, path: Path) -> str:
    """Return OpenImageIO's words without the name of a private file."""
    return complaint(speaker).replace(str(path), path.name) or "unknown format"


def _rgba(pixels: NDArray[Any]) -> NDArray[Any]:
    """Return grey, grey with opacity, RGB or RGBA as RGBA."""
    channels = pixels.shape[2]
    largest = np.iinfo(pixels.dtype).max if np.issubdtype(pixels.dtype, np.integer) else 1
    opaque = np.full((*pixels.shape[:2], 1), largest, pixels.dtype)
    if channels >= 4:
        return np.ascontiguousarray(pixels[..., :4])
    color = pixels if channels == 3 else np.repeat(pixels[..., :1], 3, axis=2)
    return np.concatenate([color, pixels[..., 1:2] if channels == 2 else opaque], axis=2)
