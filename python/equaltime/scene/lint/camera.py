"""Checks for hazards of the camera's position."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.compile_media import sees_media
from equaltime.scene.geometry import MeshSurface, SphereSurface
from equaltime.scene.lint.facts import Finding, first_places
from equaltime.scene.lint.parts import LintScene, Part

__all__ = ["check_camera"]

Array = NDArray[np.float64]


def check_camera(world: LintScene) -> Iterator[Finding]:
    """Yield a finding if shapes with an interior medium contain the camera, but the sensor names no medium."""
    model = world.scene.model
    if model.sensor.medium is not None or not sees_media(model.integrator):
        return
    filled = [part for part in world.parts if part.shape.interior is not None and _holds(part, world.camera)]
    if filled:
        yield Finding(
            "camera-in-medium",
            "note",
            f"shapes with a medium in them that the camera stands in, and whose medium it does not name: {len(filled)}",
            first_places(part.name for part in filled),
            len(filled),
            "begins paths in the medium; Mitsuba begins them in vacuum, and its image is another",
            "name the medium in the sensor: then all begin in it",
        )


def _holds(part: Part, point: Array) -> bool:
    """Tell whether a point is inside a sphere or a mesh."""
    if part.grouped:  # its coordinates are in the group's own space
        return False
    if isinstance(part.surface, SphereSurface):
        return bool(np.linalg.norm(point - part.surface.center) < part.surface.radius)
    return isinstance(part.surface, MeshSurface) and abs(_winding(part.surface, point)) > 0.5


def _winding(mesh: MeshSurface, point: Array) -> float:
    """Return the winding number of a mesh about a point: its signed solid angle divided by 4 pi.

    The solid angles are computed triangle by triangle, as by van Oosterom & Strackee (1983).
    """
    corners = mesh.vertices[mesh.faces] - point
    a, b, c = np.moveaxis(corners, 1, 0)
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    around = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2(volume, around).sum() / (2.0 * np.pi))
