"""Frames of an animated scene: their numbers, the times at which their shutter opens and closes, and their files.

Frame n begins n / fps seconds after the animation's time 0. The shutter opens at this time, and stays open for a share
of the frame's duration. A share of 0 makes a still; 0.5 is the 180-degree shutter of film cameras.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from equaltime.words import shortened

__all__ = ["MOST_FRAMES", "Frame", "frame_files", "frame_pattern", "parse_frames"]

MOST_FRAMES = 100_000
_LARGEST = 10**9
_RANGE = re.compile(r"(\d{1,10})(?:-(\d{1,10})(?::(\d{1,10}))?)?")


@dataclass(frozen=True)
class Frame:
    """One frame of an animation: its number, which with ``fps`` and ``blur`` gives the times of the shutter."""

    number: int
    fps: float = 24.0
    """Frames per second."""
    blur: float = 0.0
    """Share of the frame's duration for which the shutter is open, from 0 to 1; 0 makes a still."""

    @property
    def shutter(self) -> tuple[float, float]:
        """Times at which the shutter opens and closes, in seconds; equal for a still."""
        return self.number / self.fps, (self.number + self.blur) / self.fps


def parse_frames(text: str) -> tuple[int, ...]:
    """Return the frame numbers of ``text`` in ascending order: ``0-47``, ``0-47:2`` (steps of 2) or ``1,5,10-12``.

    Raises ValueError with a message for other text, and for more than `MOST_FRAMES` frames.
    """
    numbers: set[int] = set()
    for part in text.split(","):
        found = _RANGE.fullmatch(part.strip())
        if found is None:
            raise ValueError(f"expected frames such as 0-47, 0-47:2 or 1,5,10-12, found {shortened(text, 60)}")
        first, last, step = int(found[1]), int(found[2] or found[1]), int(found[3] or 1)
        if last < first or step == 0 or last > _LARGEST:
            raise ValueError(f"expected a first frame, a last one after it and a step of at least 1, found '{part}'")
        if (last - first) // step + len(numbers) >= MOST_FRAMES:
            raise ValueError(f"more than {MOST_FRAMES:,} frames: {shortened(text, 60)}")
        numbers.update(range(first, last + 1, step))
    return tuple(sorted(numbers))


def frame_files(output: Path, numbers: Sequence[int]) -> tuple[Path, ...]:
    """Return the file of each frame in ``numbers``: ``####`` in the name of ``output`` becomes the frame's number.

    The number has at least as many digits as there are ``#``. Without ``#`` it follows the name, with four digits:
    ``film.exr`` becomes ``film_0012.exr``. Raises ValueError if the name has several groups of ``#``.
    """
    name = output.name if "#" in output.name else f"{output.stem}_####{output.suffix}"
    before, *places = re.split("(#+)", name)
    if len(places) > 2:
        raise ValueError(f"the name of a frame's file has one group of #, found more in {output.name}")
    digits, after = places
    return tuple(output.with_name(f"{before}{number:0{len(digits)}d}{after}") for number in numbers)


def frame_pattern(name: str, number: int) -> str:
    """Return a file name with ``#`` from which `frame_files` makes the file name ``name`` for the frame ``number``.

    ``film_0012.exr`` becomes ``film_####.exr``. There is no such name if ``name`` lacks the number or already contains
    a ``#``. Then return a similar name, to which ``_####`` is added.
    """
    found = [] if "#" in name else re.finditer(rf"0*{number}(?!\d)", name)
    place = max(found, key=lambda match: (len(match[0]), match.start()), default=None)
    if place is not None:
        return f"{name[: place.start()]}{'#' * len(place[0])}{name[place.end() :]}"
    path = Path(name.replace("#", "_"))
    return f"{path.stem}_####{path.suffix}"
