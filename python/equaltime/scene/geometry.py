"""The scene's surfaces in world space.

The core (the renderer in C++) is built from these surfaces, and `equaltime.crosscheck` traces them. Everything is
float64 in the scene's own units, placed and oriented as in Mitsuba 3:

- the front side of a rectangle or disk faces the direction to which the inverse transpose of ``to_world`` takes +z;
- a cube faces outwards, however it is mirrored;
- a mesh with normals in its file faces along these normals;
- a mesh without normals, or with ``face_normals``, faces according to the order of its vertices after placement, so
  that a mirrored mesh faces the other way;
- a mirrored sphere or cylinder is inside out;
- ``flip_normals`` swaps front and back of any shape.

Radiance leaves the front side only. A side whose BSDF is None absorbs all light.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import meshes, transforms
from equaltime.scene.assets import Assets
from equaltime.scene.core import Unsupported
from equaltime.scene.model import (
    Bsdf,
    Color,
    Cube,
    Cylinder,
    Deformation,
    Diffuse,
    Disk,
    Instance,
    MeshFile,
    Perspective,
    Plugin,
    Rectangle,
    SceneModel,
    Shape,
    Solid,
    Sphere,
    Texture,
    TexturePlugin,
    as_array,
    linear_scale,
    mirrors,
    poses,
)
from equaltime.scene.model.wrappers import sides
from equaltime.scene.motion import at_time, span

__all__ = [
    *("CylinderSurface", "DiskSurface", "MeshSurface", "QuadSurface", "SphereSurface"),
    *("Surface", "bounds", "seen_whole", "surface", "surfaces"),
]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """The BSDFs of a surface's front and back, and the radiance that its front emits.

    A BSDF of None absorbs all light.
    """

    front: Bsdf | None
    back: Bsdf | None
    radiance: Texture | Color | None
    """Radiance that the front side emits; None if it emits nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class MeshSurface:
    """A triangle mesh in world space. Seen from the front, the vertices of a face are counter-clockwise."""

    sides: Sides
    vertices: Array
    """Positions (N, 3)."""
    faces: NDArray[np.uint32]
    """Indices (M, 3) of vertices."""
    normals: Array | None = None
    """Shading normals (N, 3) on the front side; None for flat faces. A blend of two poses may have normals shorter than
    1."""
    uvs: Array | None = None
    """Texture coordinates (N, 2)."""
    attributes: Mapping[str, Array] = field(default_factory=dict)
    """Attributes by Mitsuba's names: ``vertex_...`` (N, 1 or 3), ``face_...`` (M, 1 or 3)."""

    def towards(self, other: MeshSurface, share: float) -> MeshSurface:
        """Return the linear blend of this mesh and `other`, two poses of one mesh; `share` in [0, 1] weights `other`.

        Positions and normals are blended. The normals are not scaled to length 1.
        """

        def mixed(a: Array, b: Array) -> Array:
            return (1.0 - share) * a + share * b

        normals = self.normals if other.normals is None or self.normals is None else mixed(self.normals, other.normals)
        return replace(self, vertices=mixed(self.vertices, other.vertices), normals=normals)


@dataclass(frozen=True, slots=True, eq=False)
class QuadSurface:
    """The square [-1, 1]^2 at z = 0, under `to_world` (4, 4). Its front faces +z, or -z with `flip_normals`."""

    sides: Sides
    to_world: Array
    flip_normals: bool

    def mesh(self) -> MeshSurface:
        """Return this square as a mesh of two triangles, with the same front side."""
        turned = mirrors(self.to_world) != self.flip_normals
        faces = meshes.flip(meshes.QUAD_FACES) if turned else meshes.QUAD_FACES
        return MeshSurface(self.sides, meshes.place(meshes.QUAD_VERTICES, self.to_world), faces)


@dataclass(frozen=True, slots=True, eq=False)
class DiskSurface:
    """The unit disk at z = 0, under `to_world` (4, 4). Its front faces +z, or -z with `flip_normals`."""

    sides: Sides
    to_world: Array
    flip_normals: bool


@dataclass(frozen=True, slots=True, eq=False)
class SphereSurface:
    """A sphere in world space. Its front is the outside, or the inside with `flip_normals`."""

    sides: Sides
    center: Array
    """Centre (3,)."""
    radius: float
    flip_normals: bool
    pole: Array
    """Unit vector (3,) along the axis of the azimuth."""
    meridian: Array
    """Unit vector (3,) in the direction of azimuth 0."""
    mirrored: bool
    """Whether azimuth runs clockwise about the pole."""


@dataclass(frozen=True, slots=True, eq=False)
class CylinderSurface:
    """A tube without caps in world space. Its front is the outside, or the inside with `flip_normals`."""

    sides: Sides
    base: Array
    """Centre (3,) of one end."""
    end: Array
    """Centre (3,) of the other end."""
    radius: float
    flip_normals: bool
    meridian: Array
    """Direction (3,) of azimuth 0."""
    mirrored: bool
    """Whether azimuth runs clockwise about the axis."""


Surface = MeshSurface | QuadSurface | DiskSurface | SphereSurface | CylinderSurface


def surfaces(model: SceneModel, assets: Assets) -> Iterator[Surface]:
    """Yield the surfaces of the model's shapes in world space, one for each shape, in order.

    Raises ValueError if a file cannot be used, and `Unsupported` for a shape that has no surface here.
    """
    return (surface(shape, assets) for shape in model.shapes)


def surface(shape: Plugin, assets: Assets) -> Surface:
    """Return the surface of `shape` in world space; an animated shape is at its first key.

    Raises ValueError if the shape's file cannot be used. Raises `Unsupported` for a shape that has no surface here,
    such as an instance.
    """
    if not isinstance(shape, Rectangle | Disk | Sphere | Cylinder | Cube | MeshFile):
        raise Unsupported(shape)
    both, to_world = _sides(shape), as_array(poses(shape.to_world)[0])
    if isinstance(shape, Rectangle):
        return QuadSurface(both, to_world, shape.flip_normals)
    if isinstance(shape, Disk):
        return DiskSurface(both, to_world, shape.flip_normals)
    if isinstance(shape, Sphere):
        return _sphere(shape, both, to_world)
    if isinstance(shape, Cylinder):
        return _cylinder(shape, both, to_world)
    if isinstance(shape, Cube):
        turned = mirrors(to_world) != shape.flip_normals
        faces = meshes.flip(meshes.CUBE_FACES) if turned else meshes.CUBE_FACES
        return MeshSurface(both, meshes.place(meshes.CUBE_VERTICES, to_world), faces, uvs=meshes.CUBE_UVS)
    return _posed(shape, both, to_world, assets)


def _sphere(shape: Sphere, sides: Sides, to_world: Array) -> SphereSurface:
    center = meshes.place(np.array([shape.center]), to_world)[0]
    scale = linear_scale(poses(shape.to_world)[0])
    axes = np.eye(3) if scale is None else to_world[:3, :3] / scale  # a stretched sphere has no defined rotation
    mirrored = mirrors(to_world)
    flipped = mirrored != shape.flip_normals
    return SphereSurface(sides, center, shape.world_radius, flipped, axes[:, 2], axes[:, 0], mirrored)


def _cylinder(shape: Cylinder, sides: Sides, to_world: Array) -> CylinderSurface:
    base, end = meshes.place(np.array([shape.p0, shape.p1]), to_world)
    axis = np.subtract(shape.p1, shape.p0)
    meridian, mirrored = to_world[:3, :3] @ transforms.perpendicular(axis / math.hypot(*axis)), mirrors(to_world)
    flipped = mirrored != shape.flip_normals
    return CylinderSurface(sides, base, end, shape.world_radius, flipped, meridian, mirrored)


def _posed(shape: MeshFile, sides: Sides, to_world: Array, assets: Assets) -> MeshSurface:
    """Return a mesh; a deforming mesh in its first pose, or in the pose where it is held."""
    if not isinstance(shape.filename, Deformation):
        return _mesh(shape, sides, to_world, assets)
    times, filenames, held = shape.filename.times, shape.filename.filenames, shape.filename.held
    before, share = span(times, times[0] if held is None else held)
    poses = (_mesh(shape.replace(filename=name), sides, to_world, assets) for name in filenames[before : before + 2])
    first = next(poses)
    return first if share == 0.0 else first.towards(next(poses), share)


def _mesh(shape: MeshFile, sides: Sides, to_world: Array, assets: Assets) -> MeshSurface:
    data = assets.mesh(shape)
    vertices, faces, normals = meshes.place(data.vertices, to_world), data.faces, None
    if data.normals is not None and not shape.face_normals:
        if mirrors(to_world):
            faces = meshes.flip(faces)
        normals = meshes.place_normals(data.normals, to_world)
        missing = ~normals.any(axis=1)
        if missing.any():
            normals[missing] = meshes.smooth_normals(vertices, faces)[missing]
    elif not shape.face_normals:
        normals = meshes.smooth_normals(vertices, faces)
    if shape.flip_normals:
        faces, normals = meshes.flip(faces), None if normals is None else -normals
    uvs = data.uvs
    if shape.flip_tex_coords and uvs is not None:
        uvs = np.column_stack([uvs[:, 0], 1.0 - uvs[:, 1]])
    return MeshSurface(sides, vertices, faces, normals, uvs, data.attributes)


def _sides(shape: Solid) -> Sides:
    """Return the BSDFs of the front and the back of `shape`, and its emission."""
    radiance = shape.emitter.radiance if shape.emitter is not None else None
    if radiance is not None and not isinstance(radiance, TexturePlugin) and not any(radiance):
        radiance = None
    bsdf = shape.bsdf
    if bsdf is None:
        grey = 0.5 if shape.emitter is None else 0.0
        bsdf = Diffuse(reflectance=(grey, grey, grey))
    return Sides(*sides(bsdf), radiance)


# -- the extent of a scene ---------------------------------------------------------------------------------------------

FOV: Final = 45.0
"""Field of view, in degrees, of the camera that `seen_whole` adds. Mitsuba 2 adds the same camera to a scene without
one."""


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
    """Return the scene with a perspective camera that looks along +z and sees the whole scene.

    Use it for a scene without a camera. The nearest side of the scene's bounding box fits into the view. The camera has
    no clipping planes, and its shutter opens and closes at time 0. Raises ValueError if a file cannot be used.
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
