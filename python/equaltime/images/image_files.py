"""Reads image files of any program, and writes image files, through OpenImageIO.

Files are written under a temporary name in the same folder and then renamed. A reader therefore never sees half a file,
and a failure leaves an existing file unchanged. The layout of saved renders is in `equaltime.rendering.render_file`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.files import replacing
from equaltime.images.reading import complaint, excess, opened, reason, started, utf8

__all__ = [
    "PICTURES",
    "RENDERED",
    "RGB",
    "SOFTWARE",
    "Layer",
    "Picture",
    "Window",
    "check_writable",
    "escaped",
    "extension",
    "linear_rgb",
    "read",
    "read_attributes",
    "write",
    "write_exr",
]

SOFTWARE = f"equaltime {version('equaltime')}"
RGB = ("R", "G", "B")
RENDERED: Final = (".exr", ".png", ".jpg", ".jpeg")
"""Extensions of pictures that equaltime writes."""
PICTURES: Final = (*RENDERED, ".hdr", ".pfm", ".tif", ".tiff", ".webp", ".bmp", ".tga", ".ppm")
"""Common extensions of pictures, to tell them from scenes in messages."""
_SOFTWARE = ("Software", "generatedBy")
"""Attributes that name the program that wrote a file: the usual attribute, then Mitsuba's."""
_OURS = "equaltime:"
_TEXTS: Final = 1 << 17
"""Room for the texts of a picture, in bytes: its tag has at most 60,000."""
_REC709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
"""Chromaticities x, y of red, green, blue and white (ITU-R BT.709)."""


@dataclass(frozen=True)
class Window:
    """Position of an image in the full film: its first pixel (x, y) from the top left, and the film's size.

    All numbers are in pixels.
    """

    x: int
    y: int
    full_width: int
    full_height: int


@dataclass(frozen=True, eq=False)
class Picture:
    """Content of an image file, as `read` returns it: channels, position in the full film, and text attributes."""

    channels: Mapping[str, NDArray[np.float32]]
    """Channels (H, W) in float32, by name."""
    window: Window
    software: str = ""
    """Program that wrote the file, as the file states it; empty if the file does not."""
    attributes: Mapping[str, str] = field(default_factory=dict)
    """Text attributes whose names begin with ``equaltime:``, by full name."""
    record: Mapping[str, Any] = field(default_factory=dict)
    """Data on how equaltime rendered the image, as `equaltime.rendering.render_file` reads it; empty for other
    files."""

    @property
    def image(self) -> NDArray[np.float32]:
        """Linear image (H, W, 3) of the channels R, G and B; raises `ImageError` if one of the channels is missing."""
        return self._rgb("")

    @property
    def standard_error(self) -> NDArray[np.float32] | None:
        """Standard error (H, W, 3) of ``image``; None if the file has no channel ``stderr.R``."""
        return self._rgb("stderr.") if "stderr.R" in self.channels else None

    @property
    def samples(self) -> NDArray[np.int64] | None:
        """Number of samples of each pixel (H, W); None if the file has no channel ``samples``."""
        counts = self.channels.get("samples")
        return None if counts is None else counts.astype(np.int64)

    def _rgb(self, prefix: str) -> NDArray[np.float32]:
        names = [prefix + channel for channel in "RGB"]
        if missing := [name for name in names if name not in self.channels]:
            raise ImageError(f"the image has no channel {', '.join(missing)}; it has {', '.join(self.channels)}")
        return np.stack([self.channels[name] for name in names], axis=-1)


def read(path: str | os.PathLike[str]) -> Picture:
    """Return the content of the image file at ``path``: its first image, with all channels in float32.

    Raises
    ------
    ImageError
        If the file is missing, is no image, or is damaged.
    """
    with opened(path) as source:
        spec = source.spec()
        if wrong := excess(spec, path):
            raise ImageError(f"{path}: {wrong}")
        pixels = source.read_image("float")
        if pixels is None:
            raise ImageError(f"{path}: {reason(source, path)}")
        texts = _texts(spec)
    planes = pixels.reshape(spec.height, spec.width, spec.nchannels)
    channels = {name: planes[..., i] for i, name in enumerate(spec.channelnames)}
    software = next((texts[name] for name in _SOFTWARE if texts.get(name)), "")
    ours = {name: text for name, text in texts.items() if name.startswith(_OURS)}
    return Picture(channels, Window(spec.x, spec.y, spec.full_width, spec.full_height), software, ours)


def read_attributes(path: str | os.PathLike[str]) -> dict[str, str]:
    """Return the text attributes of the first image in the file at ``path``, by name.

    Raises `ImageError` if the file cannot be read.
    """
    with opened(path) as source:
        return _texts(source.spec())


def _texts(spec: Any) -> dict[str, str]:
    return {each.name: each.value for each in spec.extra_attribs if isinstance(each.value, str)}


def linear_rgb() -> dict[str, Any]:
    """Return the attributes by which an OpenImageIO file declares linear RGB with the primaries of Rec. 709."""
    return {"oiio:ColorSpace": "lin_rec709", "chromaticities": _REC709}


def write_exr(path: Path, image: NDArray[Any], description: str = "") -> None:
    """Write an image (H, W, 3) to an EXR file at ``path`` with the channels R, G and B.

    ``description`` becomes the attribute ``ImageDescription``. Raises `ImageError` on failure; an existing file then
    stays unchanged.
    """
    attributes = {"compression": "zip", **linear_rgb(), "ImageDescription": description}
    write(path, "openexr", [Layer(RGB, np.asarray(image, np.float32), attributes)])


def escaped(text: str) -> str:
    r"""Return ``text`` in a spelling that an image attribute can hold.

    Bytes of a file name that are not UTF-8 become escapes such as ``\udcff``.
    """
    return text.encode("utf-8", "backslashreplace").decode()


@dataclass(frozen=True, eq=False)
class Layer:
    """One image (subimage) of a file to write, with pixels (H, W, C) of type float32, uint32 or uint8."""

    channels: tuple[str, ...]
    pixels: NDArray[Any]
    attributes: dict[str, Any]
    """Attributes by name: strings, whole numbers, or tuples of floats."""
    kind: str = ""
    """OpenImageIO's name of the number type in the file; empty for the type of ``pixels``."""

    def spec(self, window: Window | None) -> Any:
        """Return the OpenImageIO ``ImageSpec`` of this image; ``window`` is its rectangle in the full film, if any."""
        height, width, count = self.pixels.shape
        types = {"uint8": "uint8", "uint32": "uint", "float32": "float"}
        spec = oiio.ImageSpec(width, height, count, self.kind or types[self.pixels.dtype.name])
        spec.channelnames = self.channels
        if window is not None:
            spec.x, spec.y = window.x, window.y
            spec.full_width, spec.full_height = window.full_width, window.full_height
        for name, value in self.attributes.items():
            if isinstance(value, str):
                spec.attribute(name, escaped(value))
            elif isinstance(value, int):
                spec.attribute(name, value)
            else:
                spec.attribute(name, f"float[{len(value)}]", value)
        return spec


def write(path: Path, file_format: str, parts: Sequence[Layer], window: Window | None = None) -> None:
    """Write one image file at ``path`` whose subimages are ``parts``, with their pixels unchanged.

    ``file_format`` is OpenImageIO's name, such as ``openexr``. ``window`` is the rectangle of the pixels in the full
    film. Raises `ImageError` on failure; an existing file then stays unchanged.
    """
    specs = tuple(part.spec(window) for part in parts)
    output = started(lambda: oiio.ImageOutput.create(file_format))
    if output is None:
        said = complaint(oiio) or "OpenImageIO does not start; memory or threads may be short"
        raise ImageError(f"{path}: cannot write: {said}")
    try:
        with replacing(path) as temporary:
            if file_format != "openexr":  # on a full disk libpng ends a file early in silence, libjpeg the process
                temporary.write_bytes(bytes(sum(part.pixels.nbytes for part in parts) + _TEXTS))
            done = output.open(str(temporary), specs if len(specs) > 1 else specs[0])
            for i, part in enumerate(parts):
                done = done and (i == 0 or output.open(str(temporary), specs[i], "AppendSubimage"))
                done = done and output.write_image(np.ascontiguousarray(part.pixels))
            # closing writes buffered data, so it can fail too
            if not (output.close() and done):
                said = complaint(output) or "the file could not be completed"
                said = _refusal(temporary) or said
                raise ImageError(f"{path}: cannot write: {said}")
    except OSError as error:
        raise ImageError(f"{path}: {error.strerror or error}") from error


def _refusal(file: Path) -> str:
    """Return why the system takes no more data at the end of ``file``, such as a full disk; empty if it takes more.

    OpenImageIO does not tell the reason.
    """
    try:
        with file.open("ab") as end:
            end.write(bytes(1 << 16))
    except OSError as error:
        return error.strerror or str(error)
    return ""


def extension(path: Path) -> str:
    """Return the extension of a file in lower case, such as ``.exr``, also of a kept copy such as ``NAME.exr~``."""
    return path.suffix.lower().removesuffix("~")


def check_writable(path: Path, extensions: tuple[str, ...]) -> None:
    """Raise `ImageError` if ``path`` cannot be written, or does not end in one of the ``extensions``.

    An extension has a dot and lower-case letters, such as ``.exr``. Call this before a render, so that a wrong path
    does not waste the time of the render.
    """
    if path.suffix.lower() not in extensions:
        if extension(path) in extensions:
            raise ImageError(f"{path}: is a kept copy, which is only read; copy it to a name without ~, and give that")
        found = f"extension '{path.suffix}'" if path.suffix else "no extension"
        raise ImageError(f"{path}: {found}; expected {', '.join(extensions)}")
    try:
        if path.is_dir():
            raise ImageError(f"{path}: is a folder")
        if path.exists() and not path.is_file():
            raise ImageError(f"{path}: is a pipe, a socket or a device, and no file")
        folder = Path(os.path.realpath(path)).parent if path.is_symlink() else path.parent
        if not folder.is_dir():
            raise ImageError(f"{path}: the folder {folder} does not exist")
    except OSError as error:  # such as an impossible name
        raise ImageError(f"{path}: {error.strerror or error}") from error
    utf8(folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ImageError(f"{path}: the folder {folder} cannot be written to")
