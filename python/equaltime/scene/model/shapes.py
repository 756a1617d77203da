"""Shapes: meshes from files, analytic shapes and instances, with their materials and emitters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, NonNegativeFloat, NonNegativeInt, PositiveFloat, model_validator

from equaltime.scene.model.animation import Animation, MeshName, Placement, poses
from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.bsdfs import Principled, RoughConductor, RoughDielectric
from equaltime.scene.model.emitters import Area
from equaltime.scene.model.media import Medium
from equaltime.scene.model.textures import TexturePlugin
from equaltime.scene.model.values import IDENTITY, Vec3, linear_scale, scale_across
from equaltime.scene.model.wrappers import Bsdf

__all__ = [
    *("Cube", "Cylinder", "Disk", "Gltf", "Instance", "MeshFile", "Obj", "Ply", "Rectangle"),
    *("Serialized", "Shape", "ShapeGroup", "ShapePlugin", "Solid", "Sphere"),
]


class ShapePlugin(Plugin):
    """Base class of all shapes, instances included."""

    kind: ClassVar[Kind] = "shape"
    hints: ClassVar[frozenset[str]] = frozenset({"silhouette_sampling_weight"})

    to_world: Placement = IDENTITY
    """Placement of the shape. An animation moves the shape while the shutter is open, an extension to Mitsuba."""
    silhouette_sampling_weight: NonNegativeFloat = 1.0
    """A hint of Mitsuba for derivatives, not used."""


class Solid(ShapePlugin):
    """Base class of the shapes that have a surface of their own: all shapes except instances."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf", "emitter": "emitter"}

    flip_normals: bool = False
    """Exchange front and back side. Emitters and one-sided BSDFs act on the front side."""
    bsdf: Bsdf | None = None
    """Material. By default diffuse with reflectance 0.5, or with reflectance 0 if the shape emits, as in Mitsuba."""
    emitter: Area | None = None
    interior: Medium | None = None
    """Medium on the back side of the surface."""
    exterior: Medium | None = None
    """Medium on the front side of the surface."""
    priority: Annotated[int, Field(ge=-(2**31), lt=2**31)] | None = None
    """Priority among overlapping closed shapes, an extension to Mitsuba. The interior of the shape with the highest
    priority fills the overlap. Among equal priorities, the last shape counts."""


class Faceted(Solid):
    """Base class of the analytic shapes whose faces are flat."""

    face_normals: bool = False
    """Without effect: the faces are always flat."""

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
    """A sphere, facing outwards. If ``to_world`` reflects, the sphere faces inwards, as in Mitsuba."""

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
        """True if ``to_world`` scales unevenly or shears. The shape stays a sphere, with radius `world_radius`."""
        return any(linear_scale(matrix) is None for matrix in poses(self.to_world))

    @property
    def world_radius(self) -> float:
        """Radius of the sphere in world space. For an animated sphere, the radius at the first key.

        If ``to_world`` scales unevenly or shears, lengths along x set the radius, as in Mitsuba.
        """
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
            rule = "must scale all directions across its axis alike, without shear"
            raise ValueError(f"to_world of a cylinder {rule}; a tube of another form needs a mesh, such as a ply file")
        return self

    @property
    def _scale(self) -> float | None:
        matrix = poses(self.to_world)[0]
        axis = [b - a for a, b in zip(self.p0, self.p1, strict=True)]
        return linear_scale(matrix) or scale_across(matrix, axis)

    @property
    def world_radius(self) -> float:
        """Radius of the cylinder in world space. For an animated cylinder, the radius at the first key."""
        return (self._scale or 1.0) * self.radius  # never None: the model refuses such a cylinder


class MeshFile(Solid):
    """Base class of the triangle meshes that are read from a file."""

    old: ClassVar[frozenset[str]] = frozenset({"max_smooth_angle"})

    filename: MeshName
    """File name, relative to the scene file. A `Deformation` deforms the mesh, an extension to Mitsuba."""
    face_normals: bool = False
    """Use flat face normals instead of the file's vertex normals. If False, missing vertex normals are computed."""
    crease_angle: Annotated[float, Field(ge=0.0, le=180.0)] | None = None
    """Angle between two faces, in degrees, above which their edge is hard; an extension to Mitsuba. Only for meshes
    without normals, which get some as if they stood in the file. None: such meshes are smooth everywhere."""
    flip_tex_coords: bool = False
    """Flip the texture vertically: v becomes 1 - v."""

    newer: ClassVar[frozenset[str]] = frozenset({"crease_angle"})

    @model_validator(mode="after")
    def _keeps_its_vertices(self) -> Self:
        if self.crease_angle is not None and not isinstance(self.filename, str):
            raise ValueError("crease_angle would split each pose of a mesh that deforms in another way: use normals")
        return self


class Ply(MeshFile):
    """A mesh in the Stanford PLY format."""

    type: Literal["ply"] = "ply"


class Obj(MeshFile):
    """A mesh in the Wavefront OBJ format."""

    type: Literal["obj"] = "obj"
    flip_tex_coords: bool = True
    material: str | None = None
    """Name of a ``usemtl`` material, whose faces alone are read; None: all faces. An extension to Mitsuba."""


class Serialized(MeshFile):
    """A mesh in Mitsuba's own binary format."""

    type: Literal["serialized"] = "serialized"
    shape_index: NonNegativeInt = 0
    """Index of the mesh in the file."""


class Gltf(MeshFile):
    """A mesh in a glTF file, an extension to Mitsuba.

    An example of a file name is ``model.glb#/meshes/0/primitives/1``.
    """

    type: Literal["gltf"] = "gltf"


class ShapeGroup(Plugin):
    """A group of shapes. The shapes are visible only through an `Instance` of the group."""

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
    """A placed copy of a `ShapeGroup`."""

    roles: ClassVar[Mapping[Kind, str]] = {"shape": "shapegroup"}

    type: Literal["instance"] = "instance"
    shapegroup: ShapeGroup


InGroup = Annotated[
    Rectangle | Disk | Cube | Sphere | Cylinder | Ply | Obj | Serialized | Gltf,
    Field(discriminator="type"),
]
"""Any shape with a surface of its own: all shapes that a group can contain."""
Shape = Annotated[
    Rectangle | Disk | Cube | Sphere | Cylinder | Ply | Obj | Serialized | Gltf | Instance,
    Field(discriminator="type"),
]
"""Any shape of a scene: shapes with a surface of their own, and instances."""

ShapeGroup.model_rebuild()
Instance.model_rebuild()
