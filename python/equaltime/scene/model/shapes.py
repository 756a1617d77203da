"""Shapes: meshes from files and the analytic ones, with the material and the light that they carry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, PositiveFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.bsdfs import Bsdf
from equaltime.scene.model.emitters import Area
from equaltime.scene.model.values import IDENTITY, Transform, Vec3, linear_scale

__all__ = ["Cube", "Disk", "MeshFile", "Obj", "Ply", "Rectangle", "Shape", "Sphere"]


class ShapePlugin(Plugin):
    """Base of the shapes."""

    kind: ClassVar[Kind] = "shape"
    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf", "emitter": "emitter"}
    later: ClassVar[frozenset[str]] = frozenset({"silhouette_sampling_weight", "interior", "exterior"})

    to_world: Transform = IDENTITY
    flip_normals: bool = False
    """Turn the front side, which reflects and emits, to the other side."""
    bsdf: Bsdf | None = None
    """Without one: diffuse, reflectance 0.5, or 0 if the shape emits (Mitsuba's default)."""
    emitter: Area | None = None


class Rectangle(ShapePlugin):
    """The square [-1, 1]^2 in the plane z = 0, facing +z."""

    type: Literal["rectangle"] = "rectangle"


class Disk(ShapePlugin):
    """The unit disk in the plane z = 0, facing +z."""

    type: Literal["disk"] = "disk"


class Cube(ShapePlugin):
    """The cube [-1, 1]^3, facing outwards."""

    type: Literal["cube"] = "cube"
    face_normals: bool = False
    """Has no effect: the faces of a cube are flat either way."""

    hints: ClassVar[frozenset[str]] = frozenset({"face_normals"})


class Sphere(ShapePlugin):
    """A sphere, facing outwards; a reflection in ``to_world`` turns it inside out, as in Mitsuba."""

    type: Literal["sphere"] = "sphere"
    center: Vec3 = (0.0, 0.0, 0.0)
    radius: PositiveFloat = 1.0

    @model_validator(mode="after")
    def _stays_a_sphere(self) -> Self:
        if linear_scale(self.to_world) is None:
            raise ValueError("to_world of a sphere must scale all directions alike, without shear")
        return self


class MeshFile(ShapePlugin):
    """Base of the triangle meshes that are read from a file."""

    filename: str
    """The file, relative to the scene file."""
    face_normals: bool = False
    """Shade flat, without the file's vertex normals; otherwise normals that the file lacks are made smooth."""
    flip_tex_coords: bool = False
    """Turn the texture upside down: v becomes 1 - v."""


class Ply(MeshFile):
    """A mesh in the Stanford PLY format."""

    type: Literal["ply"] = "ply"


class Obj(MeshFile):
    """A mesh in the Wavefront OBJ format."""

    type: Literal["obj"] = "obj"
    flip_tex_coords: bool = True


Shape = Annotated[Rectangle | Disk | Cube | Sphere | Ply | Obj, Field(discriminator="type")]
"""Any shape."""
