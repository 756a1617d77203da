"""Image files, all through OpenImageIO.

A render is written as an EXR with float32 channels ``R``, ``G``, ``B`` first (the linear image), then
``stderr.R``, ``stderr.G``, ``stderr.B`` (standard error of each pixel) and ``samples`` (count); its provenance is JSON
in the attribute ``equaltime:record``. A second part, which viewers pass over, holds the moments of every pixel without
loss (`equaltime.moments`), so that the render can be taken up or merged. A part ``parts``, in merged renders alone,
holds sums over what was merged, from which the standard error is estimated (`equaltime.parts_of_merge`). Parts
``unseen`` and ``lamps``, where there is need of them, hold what samples may have missed (`equaltime.unseen`), and a
last one, ``aovs``, the outputs that the scene's integrator asks for beside the image. Files are written under a
temporary name in the same folder and renamed, so that a reader never sees half a file and a failure leaves alone what
was there.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from equaltime import moments as words
from equaltime.disk import replacing
from equaltime.errors import ImageError
from equaltime.image_files import complaint, excess, opened, read_part, reason, utf8

__all__ = [
    "SOFTWARE",
    "Part",
    "Picture",
    "Window",
    "check_writable",
    "read",
    "read_missed",
    "read_moments",
    "read_parts",
    "write",
    "write_render",
]

SOFTWARE = f"equaltime {version('equaltime')}"
CHANNELS = ("R", "G", "B", "stderr.R", "stderr.G", "stderr.B", "samples")
RECORD = "equaltime:record"
_SOFTWARE = ("Software", "generatedBy")
"""Attributes that name the writer of a file: the usual one, and Mitsuba's."""
_MOMENTS = "moments"
_PARTS = "parts"
_MISSED = {"unseen": ("R", "G", "B"), "lamps": ("R", "G", "B", "share")}
_AOVS = "aovs"


@dataclass(frozen=True)
class Window:
    """Where the pixels of a file lie in the full film, in pixels from its top left corner."""

    x: int
    y: int
    full_width: int
    full_height: int


@dataclass(frozen=True, eq=False)
class Picture:
    """What an image file holds."""

    channels: Mapping[str, NDArray[np.float32]]
    """Channel name → (H, W) float32."""
    window: Window
    record: Mapping[str, Any]
    """The provenance of a file written by equaltime; empty for others."""
    software: str = ""
    """What the file says wrote it."""

    @property
    def image(self) -> NDArray[np.float32]:
        """(H, W, 3) linear RGB; raises `ImageError` if the file has no channels of that name."""
        return self._rgb("")

    @property
    def standard_error(self) -> NDArray[np.float32] | None:
        """(H, W, 3) standard error of ``image``, or None if the file does not carry one."""
        return self._rgb("stderr.") if "stderr.R" in self.channels else None

    @property
    def samples(self) -> NDArray[np.int64] | None:
        """(H, W) sample counts, or None if the file does not carry them."""
        counts = self.channels.get("samples")
        return None if counts is None else counts.astype(np.int64)

    def _rgb(self, prefix: str) -> NDArray[np.float32]:
        names = [prefix + channel for channel in "RGB"]
        if missing := [name for name in names if name not in self.channels]:
            raise ImageError(f"the image has no channel {', '.join(missing)}; it has {', '.join(self.channels)}")
        return np.stack([self.channels[name] for name in names], axis=-1)


def read(path: str | os.PathLike[str]) -> Picture:
    """Read any image that OpenImageIO knows as float32 channels by name.

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
        record = _parse_record(spec.getattribute(RECORD), path)
        software = next((str(said) for name in _SOFTWARE if (said := spec.getattribute(name))), "")
    planes = pixels.reshape(spec.height, spec.width, spec.nchannels)
    channels = {name: planes[..., i] for i, name in enumerate(spec.channelnames)}
    return Picture(channels, Window(spec.x, spec.y, spec.full_width, spec.full_height), record, software)


def read_moments(path: str | os.PathLike[str]) -> NDArray[Any] | None:
    """Read the (R, H, W) moments of a file that `write_render` wrote, or None if it was written without.

    Raises
    ------
    ImageError
        If the file is missing, is no image, or is damaged.
    """
    found = read_part(path, _MOMENTS, "uint")
    if found is None:
        return None
    names = words.channel_names(len(found[0]) // words.WORDS)
    ordered = _ordered(*found, names)
    if ordered is None:
        raise ImageError(f"{path}: the part '{_MOMENTS}' has other channels than the moments of a film")
    return words.joined(ordered)


def read_parts(path: str | os.PathLike[str]) -> NDArray[Any] | None:
    """Read the (H, W) sums over the parts of a merged render, or None if the file has none; raises as `read_moments`.

    Files that were merged by equaltime 0.1.0 have none.
    """
    found = read_part(path, _PARTS, "uint")
    if found is None:
        return None
    ordered = _ordered(*found, words.part_channels())
    if ordered is None:
        raise ImageError(f"{path}: the part '{_PARTS}' has other channels than the sums over what was merged")
    return np.asarray(words.joined(ordered, words.PARTS)[0])


def _ordered(channels: Sequence[str], pixels: NDArray[Any], names: Sequence[str]) -> NDArray[Any] | None:
    """Return the pixels with their channels in the order of ``names``, which EXR does not keep; None if they differ."""
    place = {name: i for i, name in enumerate(channels)}
    return None if set(names) != set(place) else pixels[..., [place[name] for name in names]]


def read_missed(path: str | os.PathLike[str]) -> dict[str, NDArray[np.float32]]:
    """Read what samples may have missed, (H, W, C) by the name of the part; raises as `read_moments`."""
    missed = {}
    for part, wanted in _MISSED.items():
        found = read_part(path, part, "float")
        if found is None:
            continue
        channels, pixels = found
        if sorted(channels) != sorted(wanted):
            raise ImageError(f"{path}: the part '{part}' has other channels than {', '.join(wanted)}")
        missed[part] = np.asarray(pixels[..., [channels.index(name) for name in wanted]])
    return missed


def write_render(
    path: Path,
    image: NDArray[Any],
    standard_error: NDArray[Any],
    samples: NDArray[Any],
    record: Mapping[str, Any],
    window: Window,
    description: str = "",
    moments: NDArray[Any] | None = None,
    missed: Mapping[str, NDArray[Any]] | None = None,
    aovs: Mapping[str, NDArray[Any]] | None = None,
    parts: NDArray[Any] | None = None,
) -> None:
    """Write image, standard error (both (H, W, 3)) and sample counts (H, W) to an EXR file, whole or not at all.

    ``record`` must be JSON. Counts are exact up to 2^24; with the (R, H, W) ``moments`` they are exact there. ``parts``
    are the (H, W) sums over what was merged.

    Raises
    ------
    ImageError
        If the file cannot be written; what was there before is left alone.
    """
    layers = (image, standard_error, samples[..., None])
    pixels = np.concatenate([np.asarray(layer, np.float32) for layer in layers], axis=-1)
    attributes = {
        "compression": "zip",
        "oiio:ColorSpace": "lin_rec709",
        "Software": SOFTWARE,
        "ImageDescription": description,
        RECORD: json.dumps(record, allow_nan=False),
    }
    written = [Part(CHANNELS, pixels, attributes)]
    if moments is not None:
        raw = {"compression": "none", "oiio:subimagename": _MOMENTS}  # half of the words are noise
        written.append(Part(words.channel_names(len(moments)), words.split(moments), raw))
    if parts is not None:
        written.append(_named(_PARTS, words.part_channels(), words.split(parts[None], words.PARTS)))
    for name, planes in (missed or {}).items():
        written.append(_named(name, _MISSED[name], np.asarray(planes, np.float32)))
    if aovs:
        planes = np.stack([np.asarray(plane, np.float32) for plane in aovs.values()], axis=-1)
        written.append(_named(_AOVS, tuple(aovs), planes))
    write(path, "openexr", written, window)


def _named(name: str, channels: tuple[str, ...], pixels: NDArray[Any]) -> Part:
    return Part(channels, pixels, {"compression": "zip", "oiio:subimagename": name})


def write_exr(path: Path, image: NDArray[Any], description: str = "") -> None:
    """Write an image (H, W, 3) alone to an EXR file, whole or not at all; raises `ImageError`."""
    attributes = {"compression": "zip", "oiio:ColorSpace": "lin_rec709", "ImageDescription": description}
    write(path, "openexr", [Part(CHANNELS[:3], np.asarray(image, np.float32), attributes)])


@dataclass(frozen=True, eq=False)
class Part:
    """One image of a file: (H, W, C) pixels of type float32, uint32 or uint8, written as they are."""

    channels: tuple[str, ...]
    pixels: NDArray[Any]
    attributes: Mapping[str, str]

    def spec(self, window: Window | None) -> Any:
        """Return what OpenImageIO needs to know before it writes."""
        height, width, count = self.pixels.shape
        types = {"uint8": "uint8", "uint32": "uint", "float32": "float"}
        spec = oiio.ImageSpec(width, height, count, types[self.pixels.dtype.name])
        spec.channelnames = self.channels
        if window is not None:
            spec.x, spec.y = window.x, window.y
            spec.full_width, spec.full_height = window.full_width, window.full_height
        for name, value in self.attributes.items():
            spec.attribute(name, value)
        return spec


def write(path: Path, file_format: str, parts: Sequence[Part], window: Window | None = None) -> None:
    """Write the parts as they are, whole or not at all; raises `ImageError`."""
    specs = tuple(part.spec(window) for part in parts)
    output = oiio.ImageOutput.create(file_format)
    if output is None:
        raise ImageError(f"{path}: {complaint(oiio)}")
    try:
        with replacing(path) as temporary:
            done = output.open(str(temporary), specs if len(specs) > 1 else specs[0])
            for i, part in enumerate(parts):
                done = done and (i == 0 or output.open(str(temporary), specs[i], "AppendSubimage"))
                done = done and output.write_image(np.ascontiguousarray(part.pixels))
            # closing writes what is still buffered, so it can fail as well
            if not (output.close() and done):
                said = complaint(output) or "the file could not be completed"
                raise ImageError(f"{path}: cannot write: {said}")
    except OSError as error:
        raise ImageError(f"{path}: {error.strerror or error}") from error


def check_writable(path: Path, extensions: tuple[str, ...]) -> None:
    """Raise `ImageError` if ``path`` could not be written later: find it out before an hour of rendering."""
    if path.suffix.lower() not in extensions:
        found = f"extension '{path.suffix}'" if path.suffix else "no extension"
        raise ImageError(f"{path}: {found}; known are {', '.join(extensions)}")
    try:
        if path.is_dir():
            raise ImageError(f"{path}: is a folder")
        folder = Path(os.path.realpath(path)).parent if path.is_symlink() else path.parent
        if not folder.is_dir():
            raise ImageError(f"{path}: the folder {folder} does not exist")
    except OSError as error:  # such as a name that no file can have
        raise ImageError(f"{path}: {error.strerror or error}") from error
    utf8(folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ImageError(f"{path}: the folder {folder} cannot be written to")


def _parse_record(text: object, path: str | os.PathLike[str]) -> Mapping[str, Any]:
    if not isinstance(text, str):
        return {}
    try:
        record = json.loads(text)
    except (ValueError, RecursionError) as error:  # of numbers without end, or of nesting
        raise ImageError(f"{path}: the attribute {RECORD} is damaged: {error}") from error
    return record if isinstance(record, dict) else {}
