"""What any reader of image files asks: whether to believe what a file declares, and what OpenImageIO says of it."""

from __future__ import annotations

import os
from typing import Any, Final

__all__ = ["complaint", "excess"]

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
