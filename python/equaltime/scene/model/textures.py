"""Textures, which vary over a surface, and the types of parameters that accept a texture.

A parameter that accepts a texture, such as one of type ``ReflectanceTexture``, holds either a constant (a colour or a
number) or a node of a texture.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Final, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.values import (
    IDENTITY,
    Color,
    Row,
    Transform,
    as_coefficient,
    as_number,
    as_radiance,
    as_reflectance,
    as_share,
    as_weight,
)

__all__ = [
    *("Bitmap", "Checkerboard", "MeshAttribute", "Texture", "TexturePlugin"),
    *("CoefficientTexture", "ConstantRoughness", "RadianceTexture", "ReflectanceTexture", "Roughness", "Slope"),
    *("UnitTexture", "WeightTexture"),
]


SMALLEST_ROUGHNESS = 1e-4
"""Roughness that replaces a roughness of 0, as in Mitsuba; the core does the same for texels."""


class TexturePlugin(Plugin):
    """Base class of all textures."""

    kind: ClassVar[Kind] = "texture"


FARTHEST_UV: Final = 2.0**24
"""Largest offset of texture coordinates: above 2^24, float32 numbers have no fractional part."""


class OnUv(TexturePlugin):
    """Base class of the textures that are evaluated at texture coordinates (u, v)."""

    to_uv: Transform = IDENTITY
    """Transform (4, 4) of the texture coordinates before the lookup; only rows 0 and 1, columns 0, 1 and 3, are
    used."""

    @model_validator(mode="after")
    def _not_far_away(self) -> Self:
        offset = max(abs(self.to_uv[0][3]), abs(self.to_uv[1][3]))
        if offset > FARTHEST_UV:
            raise ValueError(f"to_uv moves the texture by {offset:g}: more than {FARTHEST_UV:g} leaves no digit for it")
        return self

    @property
    def uv_rows(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Matrix (2, 3) that maps (u, v, 1) to the texture coordinates of the lookup.

        The entries are rows 0 and 1 of ``to_uv``, columns 0, 1 and 3.
        """
        return _plane(self.to_uv[0]), _plane(self.to_uv[1])


def _plane(row: Row) -> tuple[float, float, float]:
    return row[0], row[1], row[3]


class Bitmap(OnUv):
    """A texture from an image, whose first row is at v = 0, as in Mitsuba 3 and in glTF."""

    type: Literal["bitmap"] = "bitmap"
    filename: str
    """File of the image, relative to the scene file, in any format that OpenImageIO reads."""
    filter_type: Literal["bilinear", "nearest"] = "bilinear"
    wrap_mode: Literal["repeat", "mirror", "clamp"] = "repeat"
    raw: bool = False
    """Use the numbers of the file without sRGB decoding, as for normals and roughness."""
    format: Literal["variant", "auto", "fp16"] = "variant"
    """Without effect: a texture keeps the precision of its file."""
    accel: bool = True
    """Without effect: a hint for GPUs."""

    hints: ClassVar[frozenset[str]] = frozenset({"format", "accel"})
    later: ClassVar[frozenset[str]] = frozenset({"bitmap", "data"})
    old: ClassVar[frozenset[str]] = frozenset({"channel", "gamma"})


class Checkerboard(OnUv):
    """A checkerboard of two colours, in squares with sides of half a unit of u and v.

    If the checkerboard sets a single number (such as weight, opacity or roughness), its two colours are exchanged, as
    in Mitsuba 3.
    """

    type: Literal["checkerboard"] = "checkerboard"
    color0: CoefficientTexture = (0.4, 0.4, 0.4)
    color1: CoefficientTexture = (0.2, 0.2, 0.2)


def _of_vertices_or_faces(name: str) -> str:
    if not name.startswith(("vertex_", "face_")):
        raise ValueError("must begin with 'vertex_' or 'face_', as 'vertex_color' does")
    return name


class MeshAttribute(TexturePlugin):
    """A texture that reads an attribute of a mesh, such as a colour: per vertex (interpolated) or per face."""

    type: Literal["mesh_attribute"] = "mesh_attribute"
    name: Annotated[str, AfterValidator(_of_vertices_or_faces)]
    """Name of the attribute: ``vertex_`` or ``face_`` and the name in the mesh.

    In a PLY file, ``r, g, b`` or ``red, green, blue`` are ``vertex_color`` or ``face_color``. The properties
    ``p_r, p_g, p_b`` are ``vertex_p_color``; ``p_x, p_y, p_z`` or ``p_0, p_1, p_2`` are ``vertex_p``. The colours of
    OBJ files, serialized meshes and glTF are ``vertex_color``.
    """
    scale: float = 1.0
    """Factor on the attribute's values. Integers are not normalised: for colours in bytes, set 1/255."""
    cut: bool = False
    """Clamp the scaled values to [0, 1]; an extension to Mitsuba."""
    times: Bitmap | Checkerboard | None = None
    """Texture by which the attribute is multiplied, for parameters of BSDFs; an extension to Mitsuba."""

    def numbers(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the attribute's `values` times ``scale``, clamped to [0, 1] if ``cut`` is set.

        The field ``times``, a texture that multiplies the attribute, is not applied.
        """
        scaled = self.scale * values
        return np.clip(scaled, 0.0, 1.0) if self.cut else scaled


Texture = Annotated[Bitmap | Checkerboard | MeshAttribute, Field(discriminator="type")]
"""Any texture."""


def _or_texture(constant: Callable[[Any], object]) -> BeforeValidator:
    """Return a validator that lets textures pass and applies `constant` to anything else."""
    return BeforeValidator(lambda value: value if isinstance(value, TexturePlugin) else constant(value))


def _slope(value: object) -> float:
    if (number := as_number(value)) < 0.0:
        raise ValueError("must not be negative")
    return number


def _roughness(value: object) -> float:
    return _slope(value) or SMALLEST_ROUGHNESS


ReflectanceTexture = Annotated[Texture | Color, _or_texture(as_reflectance)]
"""A factor in [0, 1] per channel, or a texture of such factors."""
CoefficientTexture = Annotated[Texture | Color, _or_texture(as_coefficient)]
"""A non-negative number per channel, or a texture of such numbers."""
RadianceTexture = Annotated[Texture | Color, _or_texture(as_radiance)]
"""Non-negative emission per channel, or a texture of emission."""
UnitTexture = Annotated[Texture | float, _or_texture(as_share)]
"""A number in [0, 1], or a texture of such numbers."""
WeightTexture = Annotated[Texture | float, _or_texture(as_weight)]
"""A number in [0, 1], or a texture of such numbers. A plain number outside [0, 1] is clamped."""
Roughness = Annotated[Texture | float, _or_texture(_roughness)]
"""A positive number, or a texture of such numbers; 0 becomes `SMALLEST_ROUGHNESS`."""
ConstantRoughness = Annotated[float, BeforeValidator(_roughness)]
"""A positive number, not a texture; 0 becomes `SMALLEST_ROUGHNESS`."""
Slope = Annotated[Texture | float, _or_texture(_slope)]
"""A non-negative number, or a texture of such numbers."""
Checkerboard.model_rebuild()
