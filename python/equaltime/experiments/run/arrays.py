"""Reads arrays from the folder of an experiment; an error names the damaged file and the remedy."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError

__all__ = ["read_array", "read_arrays"]

_RESTORE = "put a copy of the file there, or remove it to go on without it"


def read_array(path: Path, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return the numbers of an ``.npy`` file.

    Raises
    ------
    FileNotFoundError
        If the file is missing.
    ImageError
        If the file is damaged, or its array has another shape or a number that is not finite.
    """
    try:
        # memory-mapped, so that a damaged header cannot allocate more memory than the file's size
        found = np.load(path, mmap_mode="r", allow_pickle=False)
    except FileNotFoundError:
        raise
    except Exception as error:  # the type of NumPy's error depends on the damage
        raise ImageError(f"{path}: is damaged: {error}; {_RESTORE}") from error
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
        raise ImageError(f"{path}: is damaged: it holds no array of numbers; {_RESTORE}")
    if found.shape != shape:
        raise ImageError(f"{path}: is damaged: it has shape {found.shape}, not {shape}; {_RESTORE}")
    if not np.isfinite(found).all():
        raise ImageError(f"{path}: is damaged: it has numbers that are not finite; {_RESTORE}")
    return np.array(found)


def read_arrays(path: Path, names: Sequence[str]) -> tuple[NDArray[Any], ...]:
    """Return named arrays of an ``.npz`` file; raises `ImageError` if the file is damaged or an array is missing."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return tuple(file[name] for name in names)
    except Exception as error:  # zip, zlib and NumPy raise different errors for a damaged file
        raise ImageError(f"{path}: is damaged: {error}; {_RESTORE}") from error
