"""Ways to write one picture: the same colours, in other formats, orders, windows and types."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import OpenEXR
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from ..unit.scene.picture_files import FILE_ORIENTATIONS, hdr, written

Array = NDArray[Any]
LOSSLESS: Final = {
    "none": OpenEXR.NO_COMPRESSION,
    "rle": OpenEXR.RLE_COMPRESSION,
    "zips": OpenEXR.ZIPS_COMPRESSION,
    "zip": OpenEXR.ZIP_COMPRESSION,
    "piz": OpenEXR.PIZ_COMPRESSION,
}
AXES: Final = {
    **{1: "-Y {h} +X {w}", 2: "-Y {h} -X {w}", 3: "+Y {h} -X {w}", 4: "+Y {h} +X {w}"},
    **{5: "+X {w} -Y {h}", 6: "-X {w} -Y {h}", 7: "-X {w} +Y {h}", 8: "+X {w} +Y {h}"},
}
"""Words of a Radiance file for each orientation of Exif."""


def bordered() -> st.SearchStrategy[NDArray[np.float32]]:
    """Return pictures (H, W, 3) of multiples of 1/256 in [0, 1), which all types hold; some have black borders."""
    sizes = st.tuples(st.integers(1, 6), st.integers(1, 6), st.integers(0, 2), st.integers(0, 2), st.integers(0, 2**16))
    return sizes.map(_bordered)


def _bordered(size: tuple[int, int, int, int, int]) -> NDArray[np.float32]:
    height, width, above, left, seed = size
    inside = np.random.default_rng(seed).integers(1, 256, (height, width, 3)).astype(np.float32) / 256
    return np.pad(inside, ((above, above), (left, left), (0, 0)))


@dataclass(frozen=True)
class Rewrite:
    """One way to write a picture whose loaded colours must be the same to the bit."""

    write: Callable[[Path, NDArray[np.float32]], Path]
    name: str

    def __repr__(self) -> str:
        return self.name


def _exr(draw: st.DrawFn) -> Rewrite:
    turn, layer = draw(st.integers(1, 8)), draw(st.sampled_from(["", "beauty.", "a.b."]))
    compression, kinds = draw(st.sampled_from(sorted(LOSSLESS))), draw(st.lists(st.booleans(), min_size=3, max_size=3))
    order, crop = draw(st.permutations("RGB")), draw(st.booleans())
    opaque = draw(st.booleans()) and not crop  # outside of the data window nothing is opaque
    overscan, words = draw(st.integers(0, 2)), draw(st.booleans())

    def write(folder: Path, pixels: NDArray[np.float32]) -> Path:
        stored = FILE_ORIENTATIONS[turn](pixels)
        seen = stored.any(axis=2)
        height, width = seen.shape
        top, left, bottom, right = 0, 0, height, width
        if crop and seen.any():
            rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
            top, left, bottom, right = rows[0], columns[0], rows[-1] + 1, columns[-1] + 1
        elif overscan:
            stored = np.pad(stored, ((overscan, overscan), (overscan, overscan), (0, 0)), constant_values=0.5)
            top, left, bottom, right = -overscan, -overscan, height + overscan, width + overscan
        data = stored if overscan and not crop else stored[top:bottom, left:right]
        if crop and not seen.any():
            data = stored
        planes = {
            layer + name: np.ascontiguousarray(data[..., "RGB".index(name)], np.float16 if half else np.float32)
            for name, half in zip(order, kinds, strict=True)
        }
        if opaque:
            planes[layer + "A"] = np.ones(data.shape[:2], np.float32)
        header: dict[str, Any] = {"compression": LOSSLESS[compression], "type": OpenEXR.scanlineimage}
        header["dataWindow"] = (np.array([left, top], np.int32), np.array([right - 1, bottom - 1], np.int32))
        header["displayWindow"] = (np.array([0, 0], np.int32), np.array([width - 1, height - 1], np.int32))
        header |= {"Orientation": turn} if turn != 1 else {}
        header |= {"comments": "not of the picture"} if words else {}
        OpenEXR.File(header, planes).write(str(folder / "a.exr"))
        return folder / "a.exr"

    crops = f"crop={crop} overscan={overscan}"
    return Rewrite(write, f"exr({compression} {layer}{''.join(order)} half={kinds} turn={turn} A={opaque} {crops})")


def _tiled(draw: st.DrawFn) -> Rewrite:
    tile, half = draw(st.sampled_from([0, 16, 32])), draw(st.booleans())

    def write(folder: Path, pixels: NDArray[np.float32]) -> Path:
        return written(folder / "a.exr", pixels.astype(np.float16) if half else pixels, tile=tile)

    return Rewrite(write, f"exr(tile={tile} half={half})")


def _tiff(draw: st.DrawFn) -> Rewrite:
    turn, tile = draw(st.integers(1, 8)), draw(st.sampled_from([0, 16]))
    compression = draw(st.sampled_from(["none", "lzw", "zip"]))
    planes, kind = draw(st.sampled_from(["contig", "separate"])), draw(st.sampled_from([np.float32, np.float64]))

    def write(folder: Path, pixels: NDArray[np.float32]) -> Path:
        stored = FILE_ORIENTATIONS[turn](pixels)
        stored = stored.astype(np.float32 if tile or len(stored) == 1 else kind)  # such float64 is refused
        more = {"compression": compression, "planarconfig": planes, "Orientation": turn}
        return written(folder / "a.tif", stored, tile=tile, **more)

    return Rewrite(write, f"tiff({compression} {planes} tile={tile} turn={turn} {kind.__name__})")


def _pfm(draw: st.DrawFn) -> Rewrite:
    little = draw(st.booleans())

    def write(folder: Path, pixels: NDArray[np.float32]) -> Path:
        height, width, _ = pixels.shape
        header = f"PF\n{width} {height}\n{-1.0 if little else 1.0}\n".encode()
        (folder / "a.pfm").write_bytes(header + pixels[::-1].astype("<f4" if little else ">f4").tobytes())
        return folder / "a.pfm"

    return Rewrite(write, f"pfm(little={little})")


@st.composite
def floats(draw: st.DrawFn) -> Rewrite:
    """Return a way to write linear colours."""
    return draw(st.sampled_from([_exr, _exr, _exr, _tiled, _tiff, _pfm]))(draw)


@st.composite
def bytes_(draw: st.DrawFn) -> Rewrite:
    """Return a way to write bytes encoded as sRGB, which are the fractions times 256."""
    kind = draw(st.sampled_from(["png", "tif", "bmp", "tga", "ppm", "webp", "gif"]))
    turn = draw(st.integers(1, 8)) if kind in ("png", "tif", "webp") else 1
    opaque = draw(st.booleans()) and kind in ("png", "tif", "tga", "webp")
    palette = draw(st.booleans()) and kind == "png"

    def write(folder: Path, pixels: NDArray[np.float32]) -> Path:
        stored = np.ascontiguousarray(FILE_ORIENTATIONS[turn](pixels) * 256, np.uint8)
        image = Image.fromarray(np.dstack([stored, np.full(stored.shape[:2], 255, np.uint8)]) if opaque else stored)
        if (palette or kind == "gif") and not opaque:
            image = _palette(stored)
        more: dict[str, Any] = {"lossless": True, "exact": True} if kind == "webp" else {}
        if turn != 1:
            exif = Image.Exif()
            exif[0x0112] = turn
            more |= {"tiffinfo": {0x0112: turn}} if kind == "tif" else {"exif": exif}
        image.save(folder / f"a.{kind}", **more)
        return folder / f"a.{kind}"

    return Rewrite(write, f"{kind}(turn={turn} A={opaque} palette={palette})")


def _palette(pixels: NDArray[np.uint8]) -> Image.Image:
    """Return an image of at most 256 colours, which small ones have, by their numbers."""
    colors, numbers = np.unique(pixels.reshape(-1, 3), axis=0, return_inverse=True)
    image = Image.fromarray(numbers.reshape(pixels.shape[:2]).astype(np.uint8), "P")
    image.putpalette(colors.astype(np.uint8).tobytes())
    return image


@st.composite
def radiance(draw: st.DrawFn) -> Rewrite:
    """Return a way to write a Radiance file, whose colours are multiples of 1/256 below 1 with one exponent."""
    turn, words = (
        draw(st.integers(1, 8)),
        draw(st.sampled_from([b"", b"SOFTWARE=a test\n# a comment\n", b"VIEW= -vp 0 0 1\n"])),
    )

    def write(folder: Path, pixels: NDArray[np.float32]) -> Path:
        stored = np.ascontiguousarray(FILE_ORIENTATIONS[turn](pixels) * 256, np.uint8)
        exponents = np.full((*stored.shape[:2], 1), 128, np.uint8)
        return hdr(folder / "a.hdr", np.dstack([stored, exponents]), AXES[turn], words)

    return Rewrite(write, f"hdr(turn={turn} {words!r})")
