"""BSDFs that contain other BSDFs (two-sided, blended, masked, bumped), and the type `Bsdf` of all BSDFs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from equaltime.scene.model.base import Kind
from equaltime.scene.model.bsdfs import (
    BsdfPlugin,
    Conductor,
    Dielectric,
    Diffuse,
    Null,
    Plastic,
    RoughConductor,
    RoughDielectric,
    RoughPlastic,
    ThinDielectric,
)
from equaltime.scene.model.principled import Principled
from equaltime.scene.model.textures import Texture, WeightTexture

__all__ = ["BlendBsdf", "Bsdf", "BumpMap", "Mask", "NormalMap", "TwoSided"]


class TwoSided(BsdfPlugin):
    """One opaque BSDF on both sides of a surface, or one BSDF for the front and one for the back."""

    type: Literal["twosided"] = "twosided"
    bsdf: Annotated[tuple[Bsdf, ...], Field(min_length=1, max_length=2)]
    """One opaque BSDF for both sides, or two: for the front and for the back."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}
    lists: ClassVar[frozenset[str]] = frozenset({"bsdf"})

    @model_validator(mode="after")
    def _opaque(self) -> Self:
        for side in self.bsdf:
            if side.transmits:
                raise ValueError(
                    f"'twosided' cannot contain '{side.type}', which lets light through: it serves both sides alone"
                )
        return self


class BlendBsdf(BsdfPlugin):
    """Two BSDFs, mixed by a weight."""

    type: Literal["blendbsdf"] = "blendbsdf"
    weight: WeightTexture
    """Share of the second BSDF, in [0, 1]: 0 is the first alone, 1 the second alone."""
    bsdf: Annotated[tuple[Bsdf, ...], Field(min_length=2, max_length=2)]

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}
    lists: ClassVar[frozenset[str]] = frozenset({"bsdf"})

    @property
    def transmits(self) -> bool:
        """True if at least one of the two BSDFs lets light through."""
        return any(bsdf.transmits for bsdf in self.bsdf)


class Mask(BsdfPlugin):
    """A BSDF with an opacity in [0, 1]. The remaining share of the light passes as if the surface did not exist."""

    type: Literal["mask"] = "mask"
    opacity: WeightTexture = 0.5
    cutoff: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] | None = None
    """Threshold: the surface is opaque at or above this opacity, and a hole below. An extension to Mitsuba."""
    bsdf: Bsdf

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}

    @property
    def transmits(self) -> bool:
        """Always True: light passes through the holes."""
        return True


class Bent(BsdfPlugin):
    """Base of the BSDFs that perturb the shading normal of another BSDF."""

    bsdf: Bsdf
    flip_invalid_normals: bool = True
    """Flip a perturbed normal that faces away from the viewer."""
    use_shadowing_function: bool = True
    """Darken smoothly where the perturbed normal differs from the unperturbed normal (Chiang et al. 2019)."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}

    @property
    def transmits(self) -> bool:
        """True if the nested BSDF lets light through."""
        return self.bsdf.transmits


class BumpMap(Bent):
    """A BSDF whose shading normals follow a height texture."""

    type: Literal["bumpmap"] = "bumpmap"
    texture: Texture
    """Height of the surface, in the scene's units of length."""
    scale: float = 1.0
    """Factor by which the height is multiplied."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf", "texture": "texture"}


class NormalMap(Bent):
    """A BSDF whose shading normals come from a texture.

    A normal n in tangent space is stored as the colour (n + 1) / 2.
    """

    type: Literal["normalmap"] = "normalmap"
    normalmap: Texture


Bsdf = Annotated[
    Diffuse
    | Conductor
    | RoughConductor
    | Dielectric
    | ThinDielectric
    | RoughDielectric
    | Plastic
    | RoughPlastic
    | Principled
    | Null
    | TwoSided
    | BlendBsdf
    | Mask
    | BumpMap
    | NormalMap,
    Field(discriminator="type"),
]
"""Any BSDF that a shape may carry."""

for _wrapper in (TwoSided, BlendBsdf, Mask, BumpMap, NormalMap):
    _wrapper.model_rebuild()
