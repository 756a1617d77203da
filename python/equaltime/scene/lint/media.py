"""Checks for hazards of media: densities too large for single precision, and cameras inside a medium."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.compile_media import sees_media
from equaltime.scene.geometry import MeshSurface, SphereSurface
from equaltime.scene.lint.facts import Finding, first_places
from equaltime.scene.lint.parts import LintScene, Part
from equaltime.scene.model import Medium

__all__ = ["check_media"]

Array = NDArray[np.float64]

SHORTEST: Final = 1e-7
"""Shortest mean free path that is accepted, as a fraction of the scene's extent. The core has the same limit."""


def check_media(world: LintScene) -> Iterator[Finding]:
    """Yield findings for media that are too dense, and for a medium around the camera that the sensor does not name."""
    yield from _dense(world)
    yield from _around_camera(world)


def _dense(world: LintScene) -> Iterator[Finding]:
    """Find media whose mean free path is too short compared with the extent of the scene."""
    extent = _extent(world)
    if extent == 0.0 or not sees_media(world.scene.model.integrator):
        return
    media = {id(node): node for node in world.scene.model.nodes() if isinstance(node, Medium)}
    shares = {node: 1.0 / (densest * extent) for node in media.values() if (densest := _densest(node)) > 0.0}
    found = [node for node, share in shares.items() if share < SHORTEST]
    if found:
        least = min(shares[node] for node in found)
        yield Finding(
            "dense-media",
            "warning",
            f"media with a mean free path below {SHORTEST:.0e} of the scene's extent: {len(found)}; "
            f"the shortest: {least:.3g} of the scene",
            first_places(world.called(node) for node in found),
            len(found),
            "refuses them: single precision leaves shapes and lights many mean free paths from where they are",
            "lower sigma_t or scale (a body many mean free paths thick looks the same), leave out what is far away, or "
            "give the shape an opaque BSDF",
        )


def _densest(medium: Medium) -> float:
    return max(medium.scale * sigma for sigma in medium.sigma_t)


def _extent(world: LintScene) -> float:
    """Return the longest side of the scene's bounds; 0 if it has instances, or if meshes were skipped."""
    if not world.parts or world.skipped or any(part.grouped for part in world.parts):
        return 0.0
    corners = np.array([part.bounds for part in world.parts])
    return float((corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0)).max())


def _around_camera(world: LintScene) -> Iterator[Finding]:
    """Find shapes with an interior medium that contain the camera, while the sensor names no medium."""
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
