"""Checks for coarsely rounded vertices.

Coarse vertices occur in shapes too far from the camera, and in meshes written too far from their own origin.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from equaltime.scene.lint.facts import Finding, first_places
from equaltime.scene.lint.parts import LintScene, Part
from equaltime.scene.model import MeshFile

__all__ = ["check_extent"]

STEPS: Final = 1000.0
"""Width of a shape below which its rounding is visible, in single-precision rounding steps of its vertices."""


def check_extent(world: LintScene) -> Iterator[Finding]:
    """Yield findings for meshes whose vertices are too coarse for the size of the mesh.

    Vertices are coarse if rounding to single precision, in the core or in the mesh's file, leaves few distinct
    positions.
    """
    found = {part: steps for part in world.meshes if (steps := _steps(part)) < STEPS}
    if found:
        yield Finding(
            "coarse-shapes",
            "warning",
            f"shapes whose vertices round to few places, so small are they for their distance from the camera: "
            f"{len(found)}; places across the coarsest: {min(found.values()):.3g}",
            first_places(part.name for part in sorted(found, key=found.__getitem__)),
            len(found),
            "rounds vertices to single precision around the camera: there it is finest, and coarse far away",
            "leave out what is too far to be seen, or move the camera nearer",
        )
    written = [part for part in world.parts if isinstance(part.shape, MeshFile) and _was_rounded(part, world)]
    if written:
        yield Finding(
            "coarse-files",
            "warning",
            f"meshes written in single precision far from their origin, so that they have few places: {len(written)}",
            first_places(part.name for part in written),
            len(written),
            "reads all that the file says, which is no more",
            "write the mesh around its own middle, with to_world to move it, or in double precision",
        )


def _steps(part: Part) -> float:
    """Return the width of a shape in rounding steps of its vertices."""
    assert part.origin is not None
    farthest = float(np.abs(part.bounds - part.origin).max())
    return part.extent / float(np.spacing(np.float32(farthest))) if 0.0 < farthest < 3e38 else np.inf


def _was_rounded(part: Part, world: LintScene) -> bool:
    """Tell whether all vertices of the file are single-precision numbers, and coarse for the mesh's size."""
    assert isinstance(part.shape, MeshFile)
    vertices = world.scene.assets.mesh(part.shape).vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    farthest = float(np.abs([low, high]).max())
    if not 0.0 < farthest < 3e38 or float((high - low).max()) / float(np.spacing(np.float32(farthest))) >= STEPS:
        return False
    return bool((vertices == vertices.astype(np.float32)).all())
