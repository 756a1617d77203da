"""Tools that all image readers share: open files, check declared sizes, and report OpenImageIO's messages."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from equaltime.errors import ImageError

__all__ = ["complaint", "excess", "opened", "read_part", "reason", "started"]

MOST_INFLATED: Final = 1032
"""Largest compression factor of zlib; other image formats reach about the same factor."""
ALWAYS: Final = 1 << 22
"""Size of pixels, in bytes, that a file of any size may declare."""


def excess(spec: Any, path: str | os.PathLike[str]) -> str | None:
    """Return an error message if an image file declares more pixels than a file of its size can hold, else None.

    ``path`` is the file, and ``spec`` is its OpenImageIO ``ImageSpec``. Call this before memory is allocated for the
    pixels.
    """
    declared, size = spec.image_bytes(True), os.path.getsize(path)
    if declared <= max(ALWAYS, MOST_INFLATED * size):
        return None
    pixels = f"{spec.width}x{spec.height} pixels of {spec.nchannels} channels"
    return f"{pixels} are declared, more than a file of {size} bytes can hold"


def complaint(speaker: Any) -> str:
    """Return the last error message of ``speaker``, which is the module OpenImageIO or one of its objects.

    The message is on one line, without repetitions. Bytes in it that are not UTF-8 are replaced by a placeholder.
    """
    try:
        message: str = speaker.geterror()
    except UnicodeDecodeError as error:
        message = error.object.decode("utf-8", "replace")
    return "; ".join(dict.fromkeys(line.strip() for line in message.splitlines() if line.strip()))


def utf8(path: str | os.PathLike[str]) -> str:
    """Return ``path`` as text for OpenImageIO; raises `ImageError` if the path is not UTF-8."""
    name = os.fspath(path)
    try:
        name.encode()
    except UnicodeEncodeError as error:
        raise ImageError(f"{path}: OpenImageIO cannot open it, since its name is not UTF-8") from error
    return name


def started(make: Callable[[], Any]) -> Any:
    """Call ``make``, a function that creates an OpenImageIO object, and return the object; None if it fails.

    A failure without an error message is tried once more. OpenImageIO's first use fails silently if the system gives it
    no threads.
    """
    made = make()
    return make() if made is None and not _complains() else made


def _complains() -> bool:
    try:
        return bool(oiio.geterror(False))
    except UnicodeDecodeError:  # the message quotes a file
        return True


@contextmanager
def opened(path: str | os.PathLike[str], **wishes: int) -> Iterator[Any]:
    """Yield an OpenImageIO ``ImageInput``, the open reader of the image file at ``path``, and close it after the block.

    ``wishes`` are OpenImageIO's options for reading, by name without the prefix ``oiio:``, such as
    ``UnassociatedAlpha=1``. Raises `ImageError` for an unreadable file.
    """
    config = oiio.ImageSpec()
    for name, value in wishes.items():
        config.attribute(f"oiio:{name}", value)
    source = started(lambda: oiio.ImageInput.open(utf8(path), config))
    if source is None:
        raise ImageError(f"{path}: {reason(oiio, path)}")
    try:
        yield source
    except UnicodeDecodeError as error:  # the name of a channel, or an attribute
        raise ImageError(f"{path}: holds text that is not UTF-8") from error
    finally:
        source.close()


def read_part(path: str | os.PathLike[str], name: str, kind: str) -> tuple[list[str], NDArray[Any]] | None:
    """Return the channel names and the pixels (H, W, C) of the subimage called ``name`` in the EXR file at ``path``.

    Returns None if the file has no such subimage after the first one. ``kind`` is OpenImageIO's name of the wanted
    number type, such as ``float``.
    """
    with opened(path) as source:
        number = 1
        while source.seek_subimage(number, 0):
            spec = source.spec()
            if spec.getattribute("oiio:subimagename") != name:
                number += 1
                continue
            if wrong := excess(spec, path):
                raise ImageError(f"{path}: {wrong}")
            pixels = source.read_image(number, 0, 0, spec.nchannels, kind)
            if pixels is None:
                raise ImageError(f"{path}: {reason(source, path)}")
            return list(spec.channelnames), pixels.reshape(spec.height, spec.width, spec.nchannels)
    return None


def reason(speaker: Any, path: str | os.PathLike[str]) -> str:
    """Return a short text that says why the file at ``path`` cannot be read.

    The text is "no such file" for a missing file, and else the last error message of ``speaker``, which is the module
    OpenImageIO or its reader of the file.
    """
    said = complaint(speaker)  # or OpenImageIO prints the message when the process ends
    if not Path(path).exists():
        return "no such file"
    return said or "not an image that can be read"
