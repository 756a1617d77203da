"""What any reader of image files does: open them, doubt what they declare, and say what OpenImageIO says of them."""

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
"""By what factor zlib can compress at most, which is about what any format of images reaches."""
ALWAYS: Final = 1 << 22
"""Bytes of pixels that any file may declare."""


def excess(spec: Any, path: str | os.PathLike[str]) -> str | None:
    """Say that the file declares more pixels than it can hold, if it does: no memory is taken for them then."""
    declared, size = spec.image_bytes(True), os.path.getsize(path)
    if declared <= max(ALWAYS, MOST_INFLATED * size):
        return None
    pixels = f"{spec.width}x{spec.height} pixels of {spec.nchannels} channels"
    return f"{pixels} are declared, more than a file of {size} bytes can hold"


def complaint(speaker: Any) -> str:
    """Return in one line what OpenImageIO, or a part of it, says last: it repeats itself, in several lines.

    It quotes files as they are, which may not be text.
    """
    try:
        message: str = speaker.geterror()
    except UnicodeDecodeError as error:
        message = error.object.decode("utf-8", "replace")
    return "; ".join(dict.fromkeys(line.strip() for line in message.splitlines() if line.strip()))


def utf8(path: str | os.PathLike[str]) -> str:
    """Return the path in the only letters that OpenImageIO reads; raises `ImageError` if it has others."""
    name = os.fspath(path)
    try:
        name.encode()
    except UnicodeEncodeError as error:
        raise ImageError(f"{path}: OpenImageIO cannot open it, since its name is not UTF-8") from error
    return name


def started(make: Callable[[], Any]) -> Any:
    """Return what OpenImageIO makes; its first use fails without a word where it may have no threads, and only that."""
    made = make()
    return make() if made is None and not _complains() else made


def _complains() -> bool:
    try:
        return bool(oiio.geterror(False))
    except UnicodeDecodeError:  # it quotes a file
        return True


@contextmanager
def opened(path: str | os.PathLike[str], **wishes: int) -> Iterator[Any]:
    """Give OpenImageIO's reader of a file, and close it; raises `ImageError` if there is none.

    ``wishes`` are hints that its readers know, without the ``oiio:`` before them.
    """
    config = oiio.ImageSpec()
    for name, value in wishes.items():
        config.attribute(f"oiio:{name}", value)
    source = started(lambda: oiio.ImageInput.open(utf8(path), config))
    if source is None:
        raise ImageError(f"{path}: {reason(oiio, path)}")
    try:
        yield source
    except UnicodeDecodeError as error:  # a name of a channel, or an attribute
        raise ImageError(f"{path}: holds text that is not UTF-8") from error
    finally:
        source.close()


def read_part(path: str | os.PathLike[str], name: str, kind: str) -> tuple[list[str], NDArray[Any]] | None:
    """Read the channels' names and the pixels (H, W, C) of a part after the first, None if there is none so named."""
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
    """Choose the clearest words for a file that OpenImageIO would not read."""
    said = complaint(speaker)  # what is not asked for, OpenImageIO prints when the process ends
    if not Path(path).exists():
        return "no such file"
    return said or "not an image that can be read"
