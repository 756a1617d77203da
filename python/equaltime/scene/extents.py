"""Bounding boxes of surfaces, a camera that sees the whole scene, and limits on the size of nested data.

Mitsuba 2 added the same camera to a scene without a camera. Mitsuba 3.9 reads such a scene, but does not render it.
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
    """Counter of the entries in nested dictionaries and lists, with a limit.

    A container that occurs several times counts each time it is read. The limit grows with the entries in distinct
    containers.
    """

    def __init__(self) -> None:
        self._known: dict[int, Container] = {}  # keeps the containers alive, so that no id is reused
        self._own = self._read = 0

    def take(self, table: Container) -> bool:
        """Count the entries of one dictionary or list. Return True if all counted entries are within the limit."""
        size = 1 + len(table)
        if id(table) not in self._known:
            self._known[id(table)] = table
            self._own += size
        self._read += size
        return self._read <= FREE_ENTRIES + USES_OF_EACH * self._own

    @property
    def complaint(self) -> str:
        """Error message for a scene whose entries exceed the limit, with the limit's value."""
        most = FREE_ENTRIES + USES_OF_EACH * self._own
        return f"its dictionaries and lists are used again and again; the limit for this scene is {most} entries"

    def check(self, table: Container, depth: int) -> None:
        """Count the entries of a list or dictionary at nesting level `depth`.

        Raises ValueError if the level reaches `MAX_DEPTH`, or if the entries exceed the limit.
        """
        if depth >= MAX_DEPTH:
            raise ValueError(f"lists are nested more than {MAX_DEPTH} deep")
        if not self.take(table):
            raise ValueError(self.complaint)


Array = NDArray[np.float64]

FOV: Final = 45.0


def bounds(of: Surface) -> Array:
    """Return a box around the surface `of` in world space: an array (2, 3) of its lower and its upper corner."""
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
    """Return the scene with a new perspective camera that looks along +z and sees the whole scene.

    The nearest side of the scene's bounding box fits into the view. The camera has no clipping planes, and its shutter
    opens and closes at time 0. Raises ValueError if a file cannot be used.
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
