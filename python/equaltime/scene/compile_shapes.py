"""Hands shapes to the core, the renderer in C++, with the BSDFs and the emission of both sides."""

from __future__ import annotations

import numpy as np

from equaltime.scene.assets import Assets
from equaltime.scene.compile_bsdfs import BsdfCompiler, Textures
from equaltime.scene.compile_media import Media
from equaltime.scene.core import SceneBuilder, Unsupported
from equaltime.scene.deforming import steps
from equaltime.scene.geometry import CylinderSurface, DiskSurface, MeshSurface, QuadSurface, Surface
from equaltime.scene.model import (
    Animation,
    Bitmap,
    Checkerboard,
    Color,
    Cylinder,
    Instance,
    MeshAttribute,
    Shape,
    ShapeGroup,
    Solid,
    Sphere,
    as_array,
    mirrors,
    without_shear,
)
from equaltime.scene.model.wrappers import turns

__all__ = ["Shapes"]

WHITE: Color = (1.0, 1.0, 1.0)


class Shapes:
    """Adds shapes to the core's scene builder, with their BSDFs, media and emitters; a group is added once."""

    def __init__(
        self, builder: SceneBuilder, assets: Assets, materials: BsdfCompiler, textures: Textures, media: Media
    ) -> None:
        self._builder = builder
        self._assets = assets
        self._materials = materials
        self._textures = textures
        self._media = media
        self._groups: dict[ShapeGroup, int] = {}

    def add(self, shape: Shape) -> None:
        """Add `shape` to the core's scene; raises ValueError if the shape or its file cannot be used."""
        placement = shape.to_world
        if isinstance(placement, Animation):
            self._moving(shape, placement)
        elif isinstance(shape, Instance):
            self._builder.add_instance(self._group(shape.shapegroup), as_array(placement))
        else:
            self._solid(shape)

    def _moving(self, shape: Shape, animation: Animation) -> None:
        """Add an animated shape as an instance: of its group, or of a new group for it alone. Times are in shutters."""
        matrices = np.array(animation.matrices)
        if isinstance(shape, Instance):
            self._builder.add_moving_instance(self._group(shape.shapegroup), animation.times, matrices)
            return
        if isinstance(shape, Sphere | Cylinder):
            matrices = np.array([without_shear(matrix, _middle(shape)) for matrix in animation.matrices])
        # Mirroring may turn a shape inside out, so it happens in the shape's own space; the motion does not mirror.
        own = np.diag([1.0, 1.0, -1.0 if mirrors(matrices[0]) else 1.0, 1.0])
        first = self._solid(shape.replace(to_world=own))
        self._builder.add_moving_instance(self._builder.add_group(first), animation.times, matrices @ own)

    def _group(self, group: ShapeGroup) -> int:
        if group not in self._groups:
            first, *_ = [self._solid(shape) for shape in group.shapes]
            self._groups[group] = self._builder.add_group(first)
        return self._groups[group]

    def _solid(self, shape: Solid) -> int:
        """Add a surface and return its number in the core."""
        placed, *later = steps(shape, self._assets)
        turned = shape.bsdf is not None and turns(shape.bsdf)
        front = self._materials.index(placed.sides.front)
        same = placed.sides.back is placed.sides.front and not turned
        back = front if same else self._materials.index(placed.sides.back, turned)
        radiance = placed.sides.radiance
        if isinstance(radiance, Bitmap | Checkerboard | MeshAttribute):
            index = _add_surface(self._builder, placed, front, back, WHITE)
            self._builder.bind_radiance(index, self._textures.index(radiance))
        else:
            index = _add_surface(self._builder, placed, front, back, radiance)
        attributes = placed.attributes if isinstance(placed, MeshSurface) else {}
        self._textures.hand_over(index, attributes, shape.nodes())
        self._media.bound(shape, index)
        if later:
            self._deform(shape, index, later)
        return index

    def _deform(self, shape: Solid, index: int, later: list[Surface]) -> None:
        """Add the later poses of a mesh, at evenly spaced times."""
        if shape.emitter is not None and later[0].sides.radiance is not None:
            raise Unsupported(shape.emitter, "a mesh that deforms cannot emit")
        poses = [pose for pose in later if isinstance(pose, MeshSurface)]
        normals = None if poses[0].normals is None else np.array([pose.normals for pose in poses])
        self._builder.deform_mesh(index, np.array([pose.vertices for pose in poses]), normals)


def _middle(shape: Sphere | Cylinder) -> list[float]:
    """Return the centre of symmetry of a shape, in its own space."""
    ends = (shape.center, shape.center) if isinstance(shape, Sphere) else (shape.p0, shape.p1)
    return [0.5 * (a + b) for a, b in zip(*ends, strict=True)]


def _add_surface(
    builder: SceneBuilder, placed: Surface, front: int | None, back: int | None, radiance: Color | None
) -> int:
    if isinstance(placed, MeshSurface):
        return builder.add_mesh(
            placed.vertices, placed.faces, placed.normals, placed.uvs, front=front, back=back, radiance=radiance
        )
    flipped = placed.flip_normals
    if isinstance(placed, QuadSurface):
        return builder.add_rectangle(placed.to_world, flip_normals=flipped, front=front, back=back, radiance=radiance)
    if isinstance(placed, DiskSurface):
        return builder.add_disk(placed.to_world, flip_normals=flipped, front=front, back=back, radiance=radiance)
    if isinstance(placed, CylinderSurface):
        ends = placed.base.tolist(), placed.end.tolist()
        return builder.add_cylinder(
            *ends,
            placed.radius,
            flip_normals=flipped,
            front=front,
            back=back,
            radiance=radiance,
            meridian=placed.meridian.tolist(),
            mirrored=placed.mirrored,
        )
    return builder.add_sphere(
        placed.center.tolist(),
        placed.radius,
        flip_normals=flipped,
        front=front,
        back=back,
        radiance=radiance,
        pole=placed.pole.tolist(),
        meridian=placed.meridian.tolist(),
        mirrored=placed.mirrored,
    )
