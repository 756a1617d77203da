"""Shapes: meshes from files, analytic shapes and instances, with their materials and emitters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, NonNegativeFloat, NonNegativeInt, PositiveFloat, model_validator

from equaltime.scene.model.animation import Animation, MeshName, Placement, poses
from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.bsdfs import RoughConductor, RoughDielectric
from equaltime.scene.model.emitters import Area
from equaltime.scene.model.media import Medium
from equaltime.scene.model.principled import Principled
from equaltime.scene.model.textures import TexturePlugin
from equaltime.scene.model.values import IDENTITY, Vec3, linear_scale, scale_across
from equaltime.scene.model.wrappers import Bsdf

__all__ = [
    *("Cube", "Cylinder", "Disk", "Gltf", "Instance", "MeshFile", "Obj", "Ply", "Rectangle"),
    *("Serialized", "Shape", "ShapeGroup", "ShapePlugin", "Solid", "Sphere"),
]


class ShapePlugin(Plugin):
    """Base of the shapes."""

    kind: ClassVar[Kind] = "shape"
    hints: ClassVar[frozenset[str]] = frozenset({"silhouette_sampling_weight"})

    to_world: Placement = IDENTITY
    """Placement of the shape; an animation, an extension to Mitsuba, moves the shape while the shutter is open."""
    silhouette_sampling_weight: NonNegativeFloat = 1.0
    """A hint for derivatives in Mitsuba, not used."""


class Solid(ShapePlugin):
    """Base of the shapes with a surface of their own: all but instances."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf", "emitter": "emitter"}

    flip_normals: bool = False
    """Turn the front side, which reflects and emits, to the other side."""
    bsdf: Bsdf | None = None
    """Material; by default diffuse with reflectance 0.5, or 0 if the shape emits, as in Mitsuba."""
    emitter: Area | None = None
    interior: Medium | None = None
    """Medium behind the front side."""
    exterior: Medium | None = None
    """Medium before the front side."""
    priority: Annotated[int, Field(ge=-(2**31), lt=2**31)] | None = None
    """Rank among overlapping closed shapes: the highest fills the overlap, of equals the last. An extension to
    Mitsuba."""


class Faceted(Solid):
    """Base of the shapes whose faces are flat."""

    face_normals: bool = False
    """Has no effect: the faces are flat either way."""

    hints: ClassVar[frozenset[str]] = frozenset({"face_normals", "silhouette_sampling_weight"})


class Rectangle(Faceted):
    """The square [-1, 1]^2 in the plane z = 0, facing +z."""

    type: Literal["rectangle"] = "rectangle"


class Disk(Solid):
    """The unit disk in the plane z = 0, facing +z."""

    type: Literal["disk"] = "disk"


class Cube(Faceted):
    """The cube [-1, 1]^3, facing outwards."""

    type: Literal["cube"] = "cube"


class Sphere(Solid):
    """A sphere, facing outwards; a reflection in ``to_world`` turns it inside out, as in Mitsuba."""

    type: Literal["sphere"] = "sphere"
    center: Vec3 = (0.0, 0.0, 0.0)
    radius: PositiveFloat = 1.0

    @model_validator(mode="after")
    def _stays_a_sphere(self) -> Self:
        if self.is_stretched and isinstance(self.to_world, Animation):
            raise ValueError("to_world of a sphere that moves must scale all directions alike, without shear")
        if self.is_stretched and any(map(_minds_azimuth, self.nodes())):
            rule = "must scale all directions alike, without shear"
            raise ValueError(f"to_world of a sphere with textures or anisotropy {rule}")
        return self

    @property
    def is_stretched(self) -> bool:
        """Whether ``to_world`` would make the sphere another shape; see `world_radius`."""
        return any(linear_scale(matrix) is None for matrix in poses(self.to_world))

    @property
    def world_radius(self) -> float:
        """Radius in world space at the first key; for a stretched sphere the radius along x, as in Mitsuba."""
        matrix = poses(self.to_world)[0]
        return self.radius * (linear_scale(matrix) or math.hypot(*(row[0] for row in matrix[:3])))


def _minds_azimuth(node: Plugin) -> bool:
    """Tell whether a node depends on the azimuth, which Mitsuba does not know for a stretched sphere."""
    if isinstance(node, Principled):
        return node.anisotropic != 0.0
    alphas = node.alphas if isinstance(node, RoughConductor | RoughDielectric) else (0.0, 0.0)
    return isinstance(node, TexturePlugin) or alphas[0] != alphas[1]


class Cylinder(Solid):
    """A tube from ``p0`` to ``p1`` without caps, facing outwards."""

    type: Literal["cylinder"] = "cylinder"
    p0: Vec3 = (0.0, 0.0, 0.0)
    p1: Vec3 = (0.0, 0.0, 1.0)
    radius: PositiveFloat = 1.0

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        if self.p0 == self.p1:
            raise ValueError("p0 and p1 are the same point: the cylinder has no length")
        if isinstance(self.to_world, Animation) and any(
            linear_scale(matrix) is None for matrix in poses(self.to_world)
        ):
            raise ValueError("to_world of a cylinder that moves must scale all directions alike, without shear")
        if self._scale is None:
            raise ValueError("to_world of a cylinder must scale all directions across its axis alike, without shear")
        return self

    @property
    def _scale(self) -> float | None:
        matrix = poses(self.to_world)[0]
        axis = [b - a for a, b in zip(self.p0, self.p1, strict=True)]
        return linear_scale(matrix) or scale_across(matrix, axis)

    @property
    def world_radius(self) -> float:
        """Radius in world space at the first key."""
        return (self._scale or 1.0) * self.radius  # never None: the model refuses such a cylinder


class MeshFile(Solid):
    """Base of the triangle meshes that are read from a file."""

    old: ClassVar[frozenset[str]] = frozenset({"max_smooth_angle"})

    filename: MeshName
    """The file, relative to the scene file; an animation of files, an extension to Mitsuba, deforms the mesh."""
    face_normals: bool = False
    """Shade flat, without the file's vertex normals. Otherwise missing normals are computed smooth."""
    flip_tex_coords: bool = False
    """Flip the texture vertically: v becomes 1 - v."""


class Ply(MeshFile):
    """A mesh in the Stanford PLY format."""

    type: Literal["ply"] = "ply"


class Obj(MeshFile):
    """A mesh in the Wavefront OBJ format."""

    type: Literal["obj"] = "obj"
    flip_tex_coords: bool = True
    material: str | None = None
    """Only the faces after a ``usemtl`` of this name, an extension to Mitsuba; without it, all faces."""


class Serialized(MeshFile):
    """A mesh in Mitsuba's own binary format."""

    type: Literal["serialized"] = "serialized"
    shape_index: NonNegativeInt = 0
    """Index of the mesh in the file."""


class Gltf(MeshFile):
    """A mesh in a glTF file, an extension to Mitsuba: ``model.glb#/meshes/0/primitives/1``."""

    type: Literal["gltf"] = "gltf"


class ShapeGroup(Plugin):
    """Shapes that are seen only where an `Instance` places them."""

    kind: ClassVar[Kind] = "shape"
    roles: ClassVar[Mapping[Kind, str]] = {"shape": "shapes"}
    lists: ClassVar[frozenset[str]] = frozenset({"shapes"})

    type: Literal["shapegroup"] = "shapegroup"
    shapes: Annotated[tuple[InGroup, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _dark_and_still(self) -> Self:
        if any(shape.emitter is not None for shape in self.shapes):
            raise ValueError("the shapes of a group cannot emit, as in Mitsuba")
        if any(shape.priority is not None for shape in self.shapes):
            raise ValueError("the shapes of a group have no priority: their copies could not be told apart")
        if any(isinstance(shape.to_world, Animation) for shape in self.shapes):
            raise ValueError("the shapes of a group cannot move by themselves; its instances can")
        return self


class Instance(ShapePlugin):
    """A copy of a group of shapes, with a placement of its own."""

    roles: ClassVar[Mapping[Kind, str]] = {"shape": "shapegroup"}

    type: Literal["instance"] = "instance"
    shapegroup: ShapeGroup


InGroup = Annotated[
    Rectangle | Disk | Cube | Sphere | Cylinder | Ply | Obj | Serialized | Gltf,
    Field(discriminator="type"),
]
"""Any shape with a surface of its own."""
Shape = Annotated[
    Rectangle | Disk | Cube | Sphere | Cylinder | Ply | Obj | Serialized | Gltf | Instance,
    Field(discriminator="type"),
]
"""Any shape that is seen."""

ShapeGroup.model_rebuild()
Instance.model_rebuild()
