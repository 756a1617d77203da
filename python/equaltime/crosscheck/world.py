"""Ray intersection: embreex finds triangles, and float64 formulas give the hit points.

Each ray is also tested against every sphere and disk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from equaltime.crosscheck.patches import DiskPatch, SpherePatch, collect
from equaltime.crosscheck.vectors import Array, Index, Mask, dot, normalize
from equaltime.scene.assets import Assets
from equaltime.scene.model import SceneModel

__all__ = ["Hits", "World"]

NUDGE = 2.0**-18
"""Offset of a ray's start from its triangle for Embree, relative to the triangle's largest coordinate.

The offset is 64 times the rounding of float32. Surfaces nearer than that are missed; points and distances do not depend
on the offset."""
ATTEMPTS = 8
"""Largest number of searches for the first hit of a ray. If float64 shows that the ray misses the triangle that Embree
found, the search continues behind it."""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Nearest surface that each ray hits, one row per ray; for a ray without a hit, `patch` is -1 and `t` infinite."""

    t: Array
    """Distances (N,) from the rays' origins along unit directions."""
    patch: Index
    """Number of the patch (triangle, sphere or disk) that each ray hits (N,)."""
    point: Array
    """Hit points (N, 3)."""
    normal: Array
    """Unit geometric normals on the front side (N, 3)."""
    shading: Array
    """Unit shading normals on the front side (N, 3)."""
    tangent: Array
    """Directions in which the texture coordinate u grows (N, 3), of any length."""


class World:
    """All surfaces of a scene, ready for ray intersection. A patch is one triangle, sphere or disk.

    For each patch, ``shape`` holds the index of its shape, and ``primitive`` the index of the triangle in that shape.
    """

    def __init__(self, model: SceneModel, assets: Assets) -> None:
        self.triangles, self.spheres, self.disks = collect(model, assets)
        corners = self.triangles.corners
        self._middle = 0.5 * (corners.max(axis=(0, 1)) + corners.min(axis=(0, 1))) if len(corners) else np.zeros(3)
        corners = corners - self._middle
        self._nudge = NUDGE * np.abs(corners).max(axis=(1, 2), initial=0.0)
        self._embree = EmbreeScene()
        if len(corners):
            TriangleMesh(self._embree, corners.astype(np.float32))
        analytic: list[SpherePatch | DiskPatch] = [*self.spheres, *self.disks]
        shapes = np.array([patch.shape for patch in analytic], np.int64)
        self.shape: Index = np.append(self.triangles.shapes, shapes)
        self.primitive: Index = np.append(self.triangles.primitives, np.zeros_like(shapes))

    @property
    def first_sphere(self) -> int:
        """Number of the first patch that is a sphere.

        Patches are numbered from 0: all triangles first, then the spheres, then the disks.
        """
        return len(self.triangles.shapes)

    @property
    def first_disk(self) -> int:
        """Number of the first patch that is a disk.

        Patches are numbered from 0: all triangles first, then the spheres, then the disks.
        """
        return self.first_sphere + len(self.spheres)

    def intersect(self, origins: Array, directions: Array, start: Index) -> tuple[Array, Index]:
        """Return distance (N,) and patch number (N,) of each ray's first hit; infinity and -1 without a hit.

        A patch is a triangle, sphere or disk. Rays have `origins` and unit `directions`, (N, 3). `start` (N,) is the
        number of the patch that a ray leaves, or -1. A ray can hit its start patch again only on a sphere's far side.
        Rays need no tolerance to miss their own origin.
        """
        best, patch = self._nearest_triangle(origins, directions, start)
        for number, sphere in enumerate(self.spheres, self.first_sphere):
            _keep_nearest(best, patch, _meet_sphere(sphere, origins, directions, start == number), number)
        for number, disk in enumerate(self.disks, self.first_disk):
            t = np.where(start == number, np.inf, _meet_disk(disk, origins, directions))
            _keep_nearest(best, patch, t, number)
        return best, patch

    def hits(self, origins: Array, directions: Array, t: Array, patch: Index) -> Hits:
        """Return the hits of rays with their points, normals and tangents, for shading.

        Rays have `origins` and unit `directions`, (N, 3). ``t`` (N,) are the distances and ``patch`` (N,) the patch
        numbers that `intersect` returned for these rays.
        """
        there = patch >= 0
        point = origins + np.where(there, t, 0.0)[:, None] * directions
        normal, tangent = np.zeros_like(point), np.zeros_like(point)
        shading = normal.copy()
        flat = np.flatnonzero(there & (patch < self.first_sphere))
        triangle = patch[flat]
        normal[flat], tangent[flat] = self.triangles.normals[triangle], self.triangles.tangents[triangle]
        weights = self._weights(point[flat], triangle)
        shading[flat] = normalize(np.einsum("nk,nki->ni", weights, self.triangles.corner_normals[triangle]))
        for number, sphere in enumerate(self.spheres, self.first_sphere):
            on = np.flatnonzero(patch == number)
            outward = normalize(point[on] - sphere.center)
            point[on] = sphere.center + sphere.radius * outward
            normal[on] = shading[on] = sphere.front * outward
            tangent[on] = np.cross(sphere.axis, outward)
        for number, disk in enumerate(self.disks, self.first_disk):
            on = np.flatnonzero(patch == number)
            normal[on] = shading[on] = disk.normal
            tangent[on] = point[on] - disk.to_world[:3, 3]
        return Hits(t, patch, point, normal, shading, tangent)

    def _nearest_triangle(self, origins: Array, directions: Array, start: Index) -> tuple[Array, Index]:
        best, patch = np.full(len(origins), np.inf), np.full(len(origins), -1, np.int64)
        if not self.first_sphere:
            return best, patch
        on = np.flatnonzero((start >= 0) & (start < self.first_sphere))
        begin = origins - self._middle
        side = np.sign(dot(directions[on], self.triangles.normals[start[on]]))
        begin[on] += (side * self._nudge[start[on]])[:, None] * self.triangles.normals[start[on]]
        pending = np.arange(len(origins))
        for _ in range(ATTEMPTS):
            found = self._embree.run(
                begin[pending].astype(np.float32), directions[pending].astype(np.float32), output=True
            )
            met = found["primID"] >= 0
            pending, candidate, near = pending[met], found["primID"][met].astype(np.int64), found["tfar"][met]
            t = self._meet_plane(origins[pending], directions[pending], candidate)
            real = (t > 0.0) & np.isfinite(t) & (candidate != start[pending])
            best[pending[real]], patch[pending[real]] = t[real], candidate[real]
            pending, near = pending[~real], near[~real] + self._nudge[candidate[~real]]
            if not pending.size:
                break
            begin[pending] += near[:, None].astype(np.float64) * directions[pending]
        return best, patch

    def _meet_plane(self, origins: Array, directions: Array, triangle: Index) -> Array:
        normal = self.triangles.normals[triangle]
        with np.errstate(divide="ignore", invalid="ignore"):
            t: Array = dot(self.triangles.corners[triangle, 0] - origins, normal) / dot(directions, normal)
        return t

    def _weights(self, point: Array, triangle: Index) -> Array:
        """Return the barycentric coordinates (N, 3) of points, clamped to the triangle."""
        a, b, c = np.moveaxis(self.triangles.corners[triangle], 1, 0)
        normal = self.triangles.normals[triangle]
        parts = [dot(normal, np.cross(q - p, point - p)) for p, q in ((b, c), (c, a), (a, b))]
        weights = np.clip(np.stack(parts, axis=1), 0.0, None)
        inside: Array = weights / weights.sum(axis=1, keepdims=True)
        return inside


def _keep_nearest(best: Array, patch: Index, t: Array, number: int) -> None:
    nearer = t < best
    best[nearer], patch[nearer] = t[nearer], number


def _meet_sphere(sphere: SpherePatch, origins: Array, directions: Array, on_it: Mask) -> Array:
    """Return the distance at which rays hit a sphere first; for rays that start on the sphere, at which they leave it.

    With o from the centre, |o + t d| = r has the roots q and c/q, where c = |o|^2 - r^2, q = -b -+ sqrt(b^2 - c) and
    b = o.d. To avoid cancellation, the discriminant comes from the line's closest point, and c from a product.
    """
    o = origins - sphere.center
    b = dot(o, directions)
    closest = o - b[:, None] * directions
    discriminant = sphere.radius**2 - dot(closest, closest)
    distance = np.sqrt(dot(o, o))
    c = np.where(on_it, 0.0, (distance - sphere.radius) * (distance + sphere.radius))
    with np.errstate(divide="ignore", invalid="ignore"):
        q = -b - np.copysign(np.sqrt(np.maximum(discriminant, 0.0)), b)
        q = np.where(on_it, -2.0 * b, q)
        roots = np.stack([q, c / q])
    roots = np.where((roots > 0.0) & (discriminant > 0.0), roots, np.inf)
    nearest: Array = roots.min(axis=0)
    return nearest


def _meet_disk(disk: DiskPatch, origins: Array, directions: Array) -> Array:
    center = disk.to_world[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((center - origins) @ disk.normal) / (directions @ disk.normal)
        local = (origins + t[:, None] * directions - center) @ disk.from_world[:2, :3].T
    inside = (t > 0.0) & ((local**2).sum(axis=1) <= 1.0)
    met: Array = np.where(inside, t, np.inf)
    return met
