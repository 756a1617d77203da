"""Grounds of a scene's own: flat shapes below all else, and far wider."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.assets import Assets
from equaltime.scene.geometry import DiskSurface, MeshSurface, QuadSurface, surface
from equaltime.scene.model import Disk, MeshFile, Plugin, Rectangle, SceneModel
from equaltime.scene.motion import still
from equaltime.scene.studio import are_grounds

__all__ = ["own_grounds"]


def own_grounds(model: SceneModel, assets: Assets) -> list[Plugin]:
    """Return the grounds of a scene: its rectangles, disks and meshes that are flat, below all else and far wider.

    Shapes that emit light, instances and shapes with an unreadable file are left out.
    """
    shapes, parts = list[Plugin](), list[NDArray[np.float64]]()
    for shape in still(model).shapes:
        if not isinstance(shape, Rectangle | Disk | MeshFile) or shape.emitter is not None:
            continue
        try:
            points = _points(shape, assets)
        except ValueError:  # reported when the scene is built
            continue
        if len(points):
            shapes.append(shape)
            parts.append(points)
    return [shape for shape, ground in zip(shapes, are_grounds(parts), strict=True) if ground]


def _points(shape: Rectangle | Disk | MeshFile, assets: Assets) -> NDArray[np.float64]:
    """Return points (N, 3) of a shape, in world space, whose bounding box is that of the shape or contains it."""
    found = surface(shape, assets)
    if isinstance(found, MeshSurface):
        return found.vertices
    assert isinstance(found, QuadSurface | DiskSurface)
    corners = np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    points: NDArray[np.float64] = corners @ found.to_world[:3, :3].T + found.to_world[:3, 3]
    return points
