"""Writes a figure for papers as PDF and PNG."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from equaltime.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["write_figure"]

_KINDS = {"pdf": {"CreationDate": None}, "png": {}}
"""File types and their metadata; without a date, so that equal figures give equal files."""


def write_figure(figure: Figure, folder: Path, name: str) -> tuple[str, ...]:
    """Write a figure into a folder, each file atomically; return the files as FOLDER/NAME.KIND."""
    folder.mkdir(parents=True, exist_ok=True)
    for kind, metadata in _KINDS.items():
        with replacing(folder / f"{name}.{kind}") as file:
            figure.savefig(file, format=kind, dpi=200, facecolor="white", metadata=metadata)
    return tuple(f"{folder.name}/{name}.{kind}" for kind in _KINDS)
