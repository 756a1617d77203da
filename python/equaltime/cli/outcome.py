"""What every command that makes an image must not write over."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from equaltime.errors import ImageError

__all__ = ["check_spares"]


def check_spares(places: Iterable[Path], files: Iterable[Path], why: str) -> None:
    """Raise `ImageError` for an output that would take the place of one of the files, by whatever name."""
    there = [file for file in files if os.path.exists(file)]
    for place in filter(Path.exists, places):
        if any(place.samefile(file) for file in there):
            raise ImageError(f"{place}: {why}; write to another")
