"""Arrays in the folder of an experiment: read whole, or refused with the name of the file and what to do."""

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
        If there is no such file.
    ImageError
        If it is damaged, of another shape, or has a number that is not finite.
    """
    try:
        # mapped: a damaged header cannot ask for more memory than the file has
        found = np.load(path, mmap_mode="r", allow_pickle=False)
    except FileNotFoundError:
        raise
    except Exception as error:  # what NumPy raises for a damaged file depends on the damage
        raise ImageError(f"{path}: is damaged: {error}; {_RESTORE}") from error
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
        raise ImageError(f"{path}: is damaged: it holds no array of numbers; {_RESTORE}")
    if found.shape != shape:
        raise ImageError(f"{path}: is damaged: it has shape {found.shape}, not {shape}; {_RESTORE}")
    if not np.isfinite(found).all():
        raise ImageError(f"{path}: is damaged: it has numbers that are not finite; {_RESTORE}")
    return np.array(found)


def read_arrays(path: Path, names: Sequence[str]) -> tuple[NDArray[Any], ...]:
    """Return named arrays of an ``.npz`` file; raises `ImageError` if it is damaged or lacks one."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return tuple(file[name] for name in names)
    except Exception as error:  # zip, zlib and NumPy each have errors of their own for a damaged file
        raise ImageError(f"{path}: is damaged: {error}; {_RESTORE}") from error
