"""Makes small picture files for tests, and reads them as textures and skies."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene.pictures import Texels, read_picture

Array = NDArray[Any]
KINDS = {"float16": "half", "float32": "float", "float64": "double", "uint32": "uint"}
"""OpenImageIO's names of types."""
FILE_ORIENTATIONS = {
    1: lambda p: p,
    2: lambda p: p[:, ::-1],
    3: lambda p: p[::-1, ::-1],
    4: lambda p: p[::-1],
    5: lambda p: p.transpose(1, 0, 2),
    6: lambda p: np.rot90(p, 1),  # anticlockwise: a viewer turns it clockwise
    7: lambda p: p[::-1, ::-1].transpose(1, 0, 2),
    8: lambda p: np.rot90(p, -1),
}
"""Functions from pixels as they are seen to those in the file, by Exif's number."""


def colors(height: int = 4, width: int = 6, channels: int = 3, seed: int = 1) -> NDArray[np.float32]:
    """Return numbers in [0, 1) that half precision has too."""
    return np.random.default_rng(seed).integers(0, 1024, (height, width, channels)).astype(np.float32) / 1024


def written(path: Path, pixels: Array, names: str = "", *, data: tuple[int, int] = (0, 0), **more: Any) -> Path:
    """Write pixels (H, W, C) by OpenImageIO and return the path.

    ``names`` are those of the channels, ``data`` is where the pixels begin; ``display`` is the size of the display
    window, ``tile`` that of tiles; what else there is are attributes, with ``__`` for a colon.
    """
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, KINDS.get(pixels.dtype.name, pixels.dtype.name))
    spec.attribute("oiio:UnassociatedAlpha", 1)
    if names:
        spec.channelnames = tuple(names.split())
    spec.x, spec.y = data
    spec.full_width, spec.full_height = more.pop("display", (width, height))
    spec.tile_width = spec.tile_height = more.pop("tile", 0)
    for name, value in more.items():
        spec.attribute(name.replace("__", ":"), value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(pixels)), output.geterror()
    output.close()
    return path


def hdr(path: Path, pixels: Array, axes: str = "-Y {h} +X {w}", header: bytes = b"") -> Path:
    """Write a Radiance picture of uncompressed pixels (H, W, 4 bytes) as they stand in the file."""
    rows, columns, _ = pixels.shape
    size = axes.format(h=rows if axes[1] == "Y" else columns, w=columns if axes[1] == "Y" else rows)
    text = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + header + b"\n" + size.encode() + b"\n"
    path.write_bytes(text + np.ascontiguousarray(pixels, np.uint8).tobytes())
    return path


def png_with(path: Path, kind: bytes, data: bytes) -> Path:
    """Put a chunk behind the header of a PNG file, in place."""
    content = path.read_bytes()
    made = struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(content[:33] + made + content[33:])
    return path


def texels(path: Path, raw: bool = False) -> Texels:
    return read_picture(path, raw)


def numbers(path: Path, raw: bool = False) -> NDArray[np.float32]:
    """Return the linear colours (H, W, 3) of a texture."""
    return read_picture(path, raw).linear


def scene(path: Path, use: str = "texture") -> et.Scene:
    """Return a scene before whose camera a ball stands under a sky that is the picture, or a wall that has it."""
    sensor = {"type": "perspective", "to_world": np.diag([-1.0, 1.0, -1.0, 1.0])}  # it looks along -z
    behind = np.eye(4)
    behind[2, 3] = -3.0
    bsdf = {"type": "diffuse", "reflectance": {"type": "bitmap", "filename": str(path)}}
    wall = {"type": "rectangle", "to_world": behind, "bsdf": bsdf}
    sky = {"type": "envmap", "filename": str(path)}
    parts = {"ball": {"type": "sphere", "center": [0, 0, -4]}, "sky": sky}
    return et.load_dict(
        {"type": "scene", "sensor": sensor} | (parts if use == "sky" else {"wall": wall, "sky": {"type": "constant"}})
    )


def srgb_decoded(values: Array) -> Array:
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
