"""The surfaces of a scene as patches: a patch is one triangle, sphere or disk, and knows the index of its shape.

Patches are numbered from 0: all triangles first, then the spheres, then the disks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equaltime.crosscheck.vectors import Array, Index, normalize, perpendicular
from equaltime.scene import geometry
from equaltime.scene.assets import Assets
from equaltime.scene.geometry import CylinderSurface, DiskSurface, MeshSurface, QuadSurface, SphereSurface
from equaltime.scene.model import Cube, SceneModel, Shape, as_array, poses

__all__ = ["DiskPatch", "SpherePatch", "TrianglePatch", "collect"]

CUBE_TANGENTS = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Axes along which the texture coordinate u of Mitsuba's cube changes: for the faces at x = ±1, at y = 1 and at z =
±1."""
CUBE_TANGENT_BELOW_Y = np.array([0.0, 0.0, 1.0])
"""Axis along which the texture coordinate u of Mitsuba's cube changes on the face at y = -1."""


@dataclass(frozen=True, slots=True, eq=False)
class TrianglePatch:
    """All T triangles of the scene, with corners counter-clockwise as seen from the front."""

    corners: Array
    """Positions of the three corners of each triangle (T, 3, 3)."""
    corner_normals: Array
    """Unit shading normals at the corners (T, 3, 3); geometric normals if the mesh has none."""
    normals: Array
    """Unit geometric normals on the front side (T, 3)."""
    areas: Array
    """Areas of the triangles (T,)."""
    tangents: Array
    """Directions in which the texture coordinate u grows (T, 3), of any length."""
    shapes: Index
    """Index of the shape that each triangle belongs to (T,)."""
    primitives: Index
    """Index of each triangle in its shape (T,)."""


@dataclass(frozen=True, slots=True, eq=False)
class SpherePatch:
    """A sphere of the scene; `axis` is the world direction of local +z.

    `front` is 1 if the front side is outside, else -1.
    """

    shape: int
    center: Array
    radius: float
    front: float
    axis: Array


@dataclass(frozen=True, slots=True, eq=False)
class DiskPatch:
    """A disk of the scene: the unit disk in the plane z = 0, transformed by `to_world`.

    `normal` is the unit normal on the front side.
    """

    shape: int
    to_world: Array
    from_world: Array
    normal: Array


def collect(model: SceneModel, assets: Assets) -> tuple[TrianglePatch, list[SpherePatch], list[DiskPatch]]:
    """Return the triangles, spheres and disks of all shapes of a scene, to be intersected with rays.

    Triangles without area are left out.
    """
    meshes: list[TrianglePatch] = []
    spheres: list[SpherePatch] = []
    disks: list[DiskPatch] = []
    for index, (shape, surface) in enumerate(zip(model.shapes, geometry.surfaces(model, assets), strict=True)):
        if isinstance(surface, SphereSurface):
            front = -1.0 if surface.flip_normals else 1.0
            axis = normalize(as_array(poses(shape.to_world)[0])[:3, 2])
            spheres.append(SpherePatch(index, surface.center, surface.radius, front, axis))
        elif isinstance(surface, DiskSurface):
            disks.append(_disk(index, surface))
        elif not isinstance(surface, CylinderSurface):  # `check` refuses cylinders
            meshes.append(_triangles(index, shape, surface))
    return _joined(meshes), spheres, disks


def _joined(meshes: list[TrianglePatch]) -> TrianglePatch:
    """Return the triangles of all meshes, in order."""
    if not meshes:
        rows, numbers = np.zeros((0, 3)), np.zeros(0, np.int64)
        return TrianglePatch(np.zeros((0, 3, 3)), np.zeros((0, 3, 3)), rows, np.zeros(0), rows, numbers, numbers)
    return TrianglePatch(
        *(np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in TrianglePatch.__slots__)
    )


def _disk(index: int, surface: DiskSurface) -> DiskPatch:
    linear = surface.to_world[:3, :3]
    mirrored = np.linalg.det(linear) < 0.0
    normal = normalize(np.cross(linear[:, 0], linear[:, 1]))
    front = -1.0 if mirrored != surface.flip_normals else 1.0
    return DiskPatch(index, surface.to_world, np.linalg.inv(surface.to_world).astype(np.float64), front * normal)


def _triangles(index: int, shape: Shape, surface: MeshSurface | QuadSurface) -> TrianglePatch:
    mesh = surface.mesh() if isinstance(surface, QuadSurface) else surface
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.sqrt((across**2).sum(axis=1))
    kept = np.flatnonzero(twice > 0.0)
    corners, normals = corners[kept], across[kept] / twice[kept, None]
    smooth = None if mesh.normals is None else mesh.normals[mesh.faces[kept]]
    corner_normals = np.repeat(normals[:, None], 3, axis=1) if smooth is None else smooth
    if isinstance(surface, QuadSurface):
        tangents = np.tile(surface.to_world[:3, 0], (len(kept), 1))
    elif isinstance(shape, Cube):
        tangents = _cube_tangents(as_array(poses(shape.to_world)[0]), corners)
    else:
        tangents = _uv_tangents(corners, None if mesh.uvs is None else mesh.uvs[mesh.faces[kept]], normals)
    shapes = np.full(len(kept), index, np.int64)
    return TrianglePatch(corners, corner_normals, normals, 0.5 * twice[kept], tangents, shapes, kept.astype(np.int64))


def _cube_tangents(to_world: Array, corners: Array) -> Array:
    center = corners.mean(axis=1) - to_world[:3, 3]
    local = center @ np.linalg.inv(to_world[:3, :3]).T  # 1 or -1 along the face's axis, a third at most elsewhere
    axis = np.abs(local).argmax(axis=1)
    tangents = CUBE_TANGENTS[axis]
    tangents[(axis == 1) & (local[:, 1] < 0.0)] = CUBE_TANGENT_BELOW_Y
    along: Array = tangents @ to_world[:3, :3].T
    return along


def _uv_tangents(corners: Array, uvs: Array | None, normals: Array) -> Array:
    """Return the direction of dp/du (T, 3), from p = p0 + u dp_du + v dp_dv on each triangle.

    Without texture coordinates, u and v are barycentric.
    """
    if uvs is None:
        return corners[:, 1] - corners[:, 0]
    edges, steps = corners[:, 1:] - corners[:, :1], uvs[:, 1:] - uvs[:, :1]
    determinant = steps[:, 0, 0] * steps[:, 1, 1] - steps[:, 0, 1] * steps[:, 1, 0]
    tangents = (edges[:, 0] * steps[:, 1, 1:] - edges[:, 1] * steps[:, 0, 1:]) * np.sign(determinant)[:, None]
    useless = determinant == 0.0
    tangents[useless] = perpendicular(normals[useless])
    return tangents
