"""The bounds of surfaces, a camera that sees the whole scene, and the size of nested data.

Mitsuba 2 gave such scenes the same camera; Mitsuba 3.9 reads them, but does not render them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.assets import Assets
from equaltime.scene.geometry import CylinderSurface, DiskSurface, MeshSurface, QuadSurface, Surface, surface
from equaltime.scene.model import Instance, Perspective, SceneModel, Shape, as_array, poses
from equaltime.scene.motion import at_time
from equaltime.scene.tree import FREE_ENTRIES, MAX_DEPTH, USES_OF_EACH

__all__ = ["Extent", "bounds", "seen_whole"]

Container = Mapping[str, object] | Sequence[object]


class Extent:
    """Counts the entries of dictionaries and lists: once for each reading, and once for each distinct container."""

    def __init__(self) -> None:
        self._known: dict[int, Container] = {}  # keeps the containers alive, so that no id is reused
        self._own = self._read = 0

    def take(self, table: Container) -> bool:
        """Count one dictionary or list; tell whether the entries read are still within the limit for sharing."""
        size = 1 + len(table)
        if id(table) not in self._known:
            self._known[id(table)] = table
            self._own += size
        self._read += size
        return self._read <= FREE_ENTRIES + USES_OF_EACH * self._own

    @property
    def complaint(self) -> str:
        """The error for a scene whose limit was exceeded."""
        most = FREE_ENTRIES + USES_OF_EACH * self._own
        return f"its dictionaries and lists are used again and again; the limit for this scene is {most} entries"

    def check(self, table: Container, depth: int) -> None:
        """Count one list at nesting level `depth`; raises ValueError if the depth or the entries exceed their limit."""
        if depth >= MAX_DEPTH:
            raise ValueError(f"lists are nested more than {MAX_DEPTH} deep")
        if not self.take(table):
            raise ValueError(self.complaint)


Array = NDArray[np.float64]

FOV: Final = 45.0


def bounds(of: Surface) -> Array:
    """Return the lower and the upper corner (2, 3) of a box around a surface."""
    if isinstance(of, QuadSurface):
        of = of.mesh()
    if isinstance(of, MeshSurface):
        return np.array([of.vertices.min(axis=0), of.vertices.max(axis=0)])
    if isinstance(of, DiskSurface):
        reach, center = np.linalg.norm(of.to_world[:3, :2], axis=1), of.to_world[:3, 3]
        return np.array([center - reach, center + reach])
    if isinstance(of, CylinderSurface):
        ends = np.array([of.base, of.end])
        return np.array([ends.min(axis=0) - of.radius, ends.max(axis=0) + of.radius])
    return np.array([of.center - of.radius, of.center + of.radius])


def seen_whole(model: SceneModel, assets: Assets) -> SceneModel:
    """Return the scene with a camera in front of it that looks along +z, with the nearest side of its bounds in view.

    The camera has no clipping planes, which would cut nothing there; its shutter opens and closes at time 0. Raises
    ValueError if a file cannot be used.
    """
    corners = np.concatenate([_corners(shape, assets) for shape in at_time(model, 0.0).shapes])
    low, high = corners.min(axis=0), corners.max(axis=0)
    distance = float((high - low).max()) / (2.0 * math.tan(math.radians(FOV) / 2.0))
    x, y, _ = (0.5 * low + 0.5 * high).tolist()
    to_world = transforms.translate((x, y, float(low[2]) - distance))
    return model.replace(sensor=Perspective().replace(fov=FOV, to_world=to_world))


def _corners(shape: Shape, assets: Assets) -> Array:
    """Return the corners (N, 3) of boxes around a shape at rest; for an instance, of the box around its group."""
    if not isinstance(shape, Instance):
        return bounds(surface(shape, assets))
    to_world = as_array(poses(shape.to_world)[0])
    parts = np.concatenate([bounds(surface(part, assets)) for part in shape.shapegroup.shapes])
    return np.array(list(_box(parts))) @ to_world[:3, :3].T + to_world[:3, 3]


def _box(points: Array) -> Iterator[tuple[float, ...]]:
    """Iterate over the corners of the box around some points."""
    return product(*zip(points.min(axis=0).tolist(), points.max(axis=0).tolist(), strict=True))
