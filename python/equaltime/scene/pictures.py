"""Reads the pictures that a scene names, for textures and skies: the whole display window, upright, in linear sRGB.

The section "Pictures" of ``scenes/README.md`` says how each property of an image file is treated.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.images.reading import excess, opened, reason
from equaltime.scene.picture_account import PictureAccount
from equaltime.scene.picture_colors import (
    CIE_XYZ,
    NAMED,
    REC709,
    Choice,
    choose,
    linear_of_srgb,
    luminance_weights,
    rgb_of_luminance_chroma,
    to_srgb,
)
from equaltime.words import shortened

__all__ = ["Stored", "Texels", "largest", "read_picture", "read_stored", "upright"]

Array = NDArray[Any]

WINDOWED: Final = frozenset({"openexr", "rla"})
"""Formats with a display window (the rectangle of the image to show); other formats have no such window."""
MOST_SHOWN: Final = 1 << 27
"""Largest size in bytes of a display window that any file may declare, however small the file. Pixels outside its data
window take no space in the file."""
MOST_PARTS: Final = 64
"""Largest number of images, and of smaller copies, that are counted in a file; counting may decode them all."""
NEAR_SRGB: Final = (2.15, 2.45)
"""Range of powers that mean sRGB in practice: 2.2, which sRGB files declare, and 2.4, the power of its upper part."""
ALIASES: Final = {"linear": "lin", "scene_linear": "lin", "lin_srgb": "lin", "acescg": "lin_ap1"}
"""Colour-space names that earlier releases of OpenImageIO give."""
UNSAID: Final = frozenset({"", "rec709"})
"""OpenImageIO's words for formats that do not declare their colours, such as PPM and PFM."""


@dataclass(frozen=True, slots=True, eq=False)
class Texels:
    """The texels of one bitmap in memory, and the warnings about its file."""

    texels: Array
    """Values (H, W, 1 or 3) in uint8, float16 or float32."""
    srgb: bool
    """Whether uint8 texels are encoded as sRGB; other texels are linear."""
    told: tuple[str, ...] = ()
    """Warnings about content of the file that is not used, as text."""

    @property
    def linear(self) -> NDArray[np.float32]:
        """The colours (H, W, 3) in linear float32."""
        colors = self.texels
        if colors.dtype == np.uint8:
            colors = _decoded(colors, "srgb" if self.srgb else 1.0)
        return np.ascontiguousarray(np.broadcast_to(colors, (*colors.shape[:2], 3)), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Stored:
    """The pixels of a picture's display window as the file stores them, before any conversion of colours."""

    colors: Array
    """Colours (H, W, 1 or 3), multiplied by the opacity only if the file stores them so."""
    alpha: Array | None
    """Opacity (H, W, 1), or None."""
    choice: Choice
    kind: str
    """Storage of the colours: ``encoded``, ``signed`` (signed integers) or ``linear``."""
    account: PictureAccount


def read_stored(path: Path, kept: Container[str], check: Callable[[Any], object] = lambda spec: None) -> Stored:
    """Return the picture at `path` as the file stores it.

    OpenImageIO's number types in ``kept``, such as ``half``, stay as in the file. Other types become float32. ``check``
    is called with the file's OpenImageIO ``ImageSpec`` before pixels are read. Raises ImageError for a file that cannot
    be read, and ValueError for a file that declares too many pixels.
    """
    with opened(path, UnassociatedAlpha=1) as source:
        spec, file_format = source.spec(), str(source.format_name())
        check(spec)
        account, choice = PictureAccount(spec), choose(spec.channelnames)
        window = _window(spec, file_format, path, account)
        pixels = _pixels(source, spec, file_format, path, kept)
        _count_parts(source, account)
    names = spec.channelnames
    used = [names[channel] for channel in choice.channels]
    account.channels(*used)
    if not choice.named:
        account.note(f"no layer has R, G and B, or Y: {', '.join(used)} {'is' if len(used) == 1 else 'are'} taken")
    colors, alpha = _shown(pixels[..., list(choice.channels)], window), None
    if choice.alpha is not None:
        alpha = _shown(pixels[..., choice.alpha : choice.alpha + 1], window)
        account.channels(names[choice.alpha])
    return Stored(colors, alpha, choice, _kind(spec, file_format), account)


def read_picture(path: Path, raw: bool = False) -> Texels:
    """Return the texels of the picture at `path`; with `raw`, the file's numbers without colour conversion.

    Raises ValueError for a file that cannot be read, and for a texel that is not finite.
    """
    try:
        stored = read_stored(path, ("uint8", "half"))
    except ImageError as error:
        message = str(error).removeprefix(f"{path}: ")
        raise ValueError(f"{path}: cannot be read as an image: {message}") from error
    if stored.alpha is not None and (stored.alpha < largest(stored.alpha)).any():
        stored.account.note("its opacity is not used: a mask takes a texture of its own")
    colors = upright(stored.colors, _orientation(path, stored.account))
    try:
        found = _linear(colors, stored, raw)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    if found.texels.dtype != np.uint8 and not (finite := np.isfinite(found.texels)).all():
        y, x = np.argwhere(~finite.all(axis=2))[0]
        raise ValueError(f"{path}: pixel ({x}, {y}) is not finite: {found.texels[y, x].tolist()}")
    return found


def largest(pixels: Array) -> float:
    """Return the number that stands for 1.0 in `pixels`: the largest value of an integer type, or 1.0 for floats."""
    return float(np.iinfo(pixels.dtype).max) if np.issubdtype(pixels.dtype, np.integer) else 1.0


def _pixels(source: Any, spec: Any, file_format: str, path: Path, kept: Container[str]) -> Array:
    """Return all channels (H, W, C); types in ``kept`` stay as in the file, others become float32."""
    if wrong := excess(spec, path):
        raise ValueError(f"{path}: {wrong}")
    if str(spec.format) == "double" and file_format == "tiff" and (spec.tile_width or spec.height == 1):
        # release 3.2 silently returns wrong numbers
        raise ValueError(f"{path}: OpenImageIO misreads tiles and single rows of float64; write the file as float32")
    kind = str(spec.format) if str(spec.format) in kept and not _is_mixed(spec) else "float"
    given = source.read_image(0, 0, 0, spec.nchannels, kind)
    if given is None:
        raise ImageError(f"{path}: {reason(source, path)}")
    pixels = np.asarray(given).reshape(spec.height, spec.width, spec.nchannels)
    for channel in range(spec.nchannels):
        if file_format == "openexr" and str(spec.channelformat(channel)) == "uint":
            numbers = source.read_image(0, 0, channel, channel + 1, "uint")
            if numbers is None:
                raise ImageError(f"{path}: {reason(source, path)}")
            pixels[..., channel] = np.asarray(numbers).reshape(spec.height, spec.width)
    return pixels


def _is_mixed(spec: Any) -> bool:
    return len({str(spec.channelformat(channel)) for channel in range(spec.nchannels)}) > 1


def _kind(spec: Any, file_format: str) -> str:
    """Return how colours are stored; see `Stored`."""
    kind = str(spec.format)
    if kind in ("uint8", "uint16") or (kind == "uint" and file_format != "openexr"):
        return "encoded"
    return "signed" if kind in ("int8", "int16", "int") else "linear"


def _count_parts(source: Any, account: PictureAccount) -> None:
    """Report that parts and levels of a file after the first are not used."""
    levels = _counted(lambda number: source.seek_subimage(0, number))
    if levels > 1:
        account.note(f"{levels - 1} smaller copies of it are not used")
    parts = _counted(lambda number: source.seek_subimage(number, 0))
    if parts > 1:
        several = f"at least {parts}" if parts == MOST_PARTS else str(parts)
        account.note(f"the first of {several} images in the file is used")


def _counted(seek: Callable[[int], bool]) -> int:
    return next((number for number in range(1, MOST_PARTS) if not seek(number)), MOST_PARTS)


# -- where pixels are -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Window:
    """A data window in a display window, whose first pixel is (0, 0)."""

    x: int
    y: int
    width: int
    """The display window's width and height, in pixels."""
    height: int


def _window(spec: Any, file_format: str, path: Path, account: PictureAccount) -> _Window:
    """Return the position of a file's pixels; raises ValueError for a display window that is too large."""
    if file_format not in WINDOWED:
        if spec.x or spec.y:
            account.note("its offset on a page is not used")
        return _Window(0, 0, spec.width, spec.height)
    width, height = spec.full_width, spec.full_height
    if 4 * width * height * min(spec.nchannels, 3) > max(MOST_SHOWN, spec.image_bytes(True)):
        raise ValueError(f"{path}: a display window of {width}x{height} pixels around {spec.width}x{spec.height}")
    return _Window(spec.x - spec.full_x, spec.y - spec.full_y, width, height)


def _shown(pixels: Array, window: _Window) -> Array:
    """Return the pixels (H, W, C) of the display window; black outside the data window."""
    height, width, channels = pixels.shape
    if (window.x, window.y, window.width, window.height) == (0, 0, width, height):
        return np.ascontiguousarray(pixels)
    result = np.zeros((window.height, window.width, channels), pixels.dtype)
    left, right = max(window.x, 0), min(window.x + width, window.width)
    top, bottom = max(window.y, 0), min(window.y + height, window.height)
    if left < right and top < bottom:
        inside = pixels[top - window.y : bottom - window.y, left - window.x : right - window.x]
        result[top:bottom, left:right] = inside
    return result


def _orientation(path: Path, account: PictureAccount) -> int:
    """Return Exif's orientation number, from a Radiance header if there is one, and note that header's variables."""
    number = account.attribute("Orientation")
    if (aspect := account.attribute("PixelAspectRatio", 1.0)) is not None:
        account.note(f"pixels of aspect {aspect:g} are taken for squares: a picture spans u and v in [0, 1]")
    if (header := _radiance_header(path)) is not None:
        number, variables = header
        for name in ("hdr:exposure", "oiio:ColorSpace", "oiio:Gamma"):  # made by OpenImageIO from the variables
            account.attribute(name)
        for name, value in variables.items():
            account.note(f"{name}={value} in its header is not used")
    return number if isinstance(number, int) and 1 <= number <= 8 else 1


def upright(pixels: Array, orientation: int) -> Array:
    """Return pixels (H, W, ...) turned upright: row 0 at the top, column 0 at the left.

    `orientation` is Exif's number, from 1 to 8. It gives the sides on which row 0 and column 0 of the file belong: 1 is
    top and left, 2 top right, 3 bottom right, 4 bottom left, 5 left top, 6 right top, 7 right bottom, 8 left bottom.
    """
    if orientation >= 5:
        pixels = np.swapaxes(pixels, 0, 1)
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    return np.ascontiguousarray(pixels)


# -- colour spaces ----------------------------------------------------------------------------------------------------


def _linear(colors: Array, stored: Stored, raw: bool) -> Texels:
    """Return the colours in linear sRGB, or as bytes encoded as sRGB; with `raw`, unchanged."""
    account = stored.account
    curve, primaries = _color_space(stored.kind, raw, account)
    if stored.choice.kind == "luminance and chroma":
        colors = rgb_of_luminance_chroma(colors, luminance_weights(primaries))
    if stored.choice.kind == "XYZ":
        primaries = CIE_XYZ
    if raw:
        return Texels(colors, False, account.told())
    if stored.kind == "signed":
        account.note("whole numbers with a sign count as linear, from -1 to 1")
    matrix = to_srgb(primaries) if colors.shape[2] == 3 else None
    if colors.dtype == np.uint8 and matrix is None and curve in ("srgb", 1.0):
        return Texels(colors, curve == "srgb", account.told())
    if colors.dtype == np.uint8 or curve != 1.0:
        colors = _decoded(colors, curve)
    if matrix is not None:
        colors = (colors.astype(np.float64) @ matrix.T).astype(np.float32)
    return Texels(np.ascontiguousarray(colors), False, account.told())


def _color_space(kind: str, raw: bool, account: PictureAccount) -> tuple[float | str, Sequence[float]]:
    """Return the curve (``srgb`` or a power) and the primaries of the colours, as the file declares them."""
    curve: float | str = "srgb" if kind == "encoded" else 1.0
    primaries: Sequence[float] = REC709
    name, gamma = account.attribute("oiio:ColorSpace"), account.attribute("oiio:Gamma")
    said = name if isinstance(name, str) and name.lower() not in UNSAID else ""
    if said and (known := _named(said, gamma)) is not None:
        curve, primaries = known
    elif said and not raw:
        account.note(f"its colour space {name} is not known: {'sRGB' if curve == 'srgb' else 'linear'} is taken")
    given = account.attribute("chromaticities")
    if isinstance(given, tuple) and len(given) == 8:
        primaries = given
    _tell_conversions(raw, account)
    return curve, primaries


def _named(name: str, gamma: object) -> tuple[float | str, Sequence[float]] | None:
    """Return the curve and the primaries of a colour space by OpenImageIO's name, such as ``g22_rec709_scene``."""
    encoding, _, space = ALIASES.get(name.lower(), name.lower()).partition("_")
    primaries = NAMED.get(space.removesuffix("_scene").removesuffix("_display") or "rec709")
    if primaries is None:
        return None
    if encoding in ("lin", "srgb"):
        return (1.0 if encoding == "lin" else "srgb"), primaries
    if not encoding.startswith("g") or not isinstance(gamma, float) or not gamma > 0.0:
        return None
    return ("srgb" if NEAR_SRGB[0] <= gamma <= NEAR_SRGB[1] else gamma), primaries


def _tell_conversions(raw: bool, account: PictureAccount) -> None:
    """Note conversions that OpenImageIO makes by itself, and colour profiles other than sRGB."""
    for name in ("jpeg:ColorSpace", "tiff:ColorSpace"):
        if (space := account.attribute(name, "RGB", "YCbCr", "palette")) is not None:
            account.note(f"colours in {space} are turned into RGB without a profile")
    if (shape := account.attribute("textureformat", "Plain Texture", "LatLong Environment")) is not None:
        account.note(f"its layout, {shape}, is not used")
    profile = str(account.attribute("ICCProfile:profile_description") or "without a name")
    if account.attribute("ICCProfile") is not None and "srgb" not in profile.lower() and not raw:
        account.note(f"its profile of colours is not used: {shortened(profile, 60)}")


def _decoded(colors: Array, curve: float | str) -> NDArray[np.float32]:
    """Return encoded colours as linear float32."""
    values = colors.astype(np.float64) / (255.0 if colors.dtype == np.uint8 else 1.0)
    if not isinstance(curve, str):
        power: NDArray[np.float32] = np.copysign(np.abs(values) ** curve, values).astype(np.float32)
        return power
    return linear_of_srgb(values).astype(np.float32)


# -- headers of Radiance pictures --------------------------------------------------------------------------------------

# OpenImageIO 3.2 confuses two of the eight orientations (+X +Y and -X -Y) and reports few of the variables. The header,
# which is text, is therefore read here. See Ward, "File Formats", radsite.lbl.gov/radiance/refer.

MAGIC: Final = (b"#?RADIANCE", b"#?RGBE")
LONGEST: Final = 1 << 16
"""Largest size, in bytes, of the header of a Radiance picture (.hdr) that is read; real headers have a few hundred
bytes."""
ORIENTATIONS: Final = {
    **{"-Y +X": 1, "-Y -X": 2, "+Y -X": 3, "+Y +X": 4},
    **{"+X -Y": 5, "-X -Y": 6, "-X +Y": 7, "+X +Y": 8},
}
"""Exif's number of each orientation: direction from row to row, then direction within a row; y grows upwards."""
_VARIABLE: Final = re.compile(rb"(EXPOSURE|COLORCORR|PRIMARIES|PIXASPECT|GAMMA)=\s*(.*)")
_SIZE: Final = re.compile(rb"([-+][XY]) +\d+ +([-+][XY]) +\d+ *$")


def _radiance_header(path: Path) -> tuple[int, dict[str, str]] | None:
    """Return Exif's orientation number (1 to 8) and the variables in the header, as text by name.

    Return None if the file is not a Radiance picture. Only variables that change colours or the aspect of pixels are
    returned. The values of a variable that occurs several times are joined by commas, in order.
    """
    with path.open("rb") as file:
        begin = file.read(LONGEST)
    if not begin.startswith(MAGIC):
        return None
    variables: dict[str, str] = {}
    lines = iter(begin.split(b"\n"))
    for line in lines:
        if not line.strip():
            break
        if match := _VARIABLE.match(line):
            name, value = (part.decode("latin-1").strip() for part in match.groups())
            variables[name] = f"{variables[name]}, {value}" if name in variables else value
    size = _SIZE.match(next(lines, b"").rstrip(b"\r"))
    words = b"" if size is None else b" ".join(size.groups())
    return ORIENTATIONS.get(words.decode(), 1), variables
