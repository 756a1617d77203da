"""Files of a waving sheet, for tests of meshes that deform."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.export.files import write_ply

__all__ = ["FACES", "TIMES", "deformation", "sheet", "write"]

Array = NDArray[np.float64]

SIDE = 5
TIMES = (0.0, 0.25, 1.0)
_CORNERS = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
_A, _B, _C, _D = (c.ravel() for c in (_CORNERS[:-1, :-1], _CORNERS[:-1, 1:], _CORNERS[1:, 1:], _CORNERS[1:, :-1]))
FACES = np.concatenate([np.stack([_A, _B, _C], 1), np.stack([_A, _C, _D], 1)]).astype(np.uint32)


def sheet(time: float) -> tuple[Array, Array]:
    """Return vertices and normals (25, 3) at a time."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    phase = 4.0 * time
    z = 0.9 + 0.4 * np.sin(2 * x + phase) + 0.3 * time * y
    slope = np.stack([-0.8 * np.cos(2 * x + phase), np.full_like(x, -0.3 * time), np.ones_like(x)], axis=-1)
    points = np.stack([0.6 * x + 0.7 * time - 0.3, 0.6 * y, z], axis=-1)
    return points.reshape(-1, 3), (slope / np.linalg.norm(slope, axis=-1, keepdims=True)).reshape(-1, 3)


def write(folder: Path, *, normals: bool = True) -> None:
    """Write the sheet at each of the times: ``sheet-0.ply`` and so on."""
    for number, time in enumerate(TIMES):
        vertices, directions = sheet(time)
        write_ply(folder / f"sheet-{number}.ply", vertices, FACES, directions if normals else None, None, None)


def deformation(folder: Path, *numbers: int) -> dict[str, Any]:
    """Return what stands for a ``filename``: at each of the times the file of that number, or the time's own."""
    keys = zip(TIMES, numbers or range(len(TIMES)), strict=True)
    return {"animation": [{"time": time, "filename": str(folder / f"sheet-{k}.ply")} for time, k in keys]}
