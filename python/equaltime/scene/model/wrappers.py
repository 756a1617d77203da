"""BSDFs made of BSDFs: on both sides, blended, with holes, with bumps; and the union of all BSDFs."""

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
    """Makes a one-sided BSDF work on both sides, or puts one on each side (front, back)."""

    type: Literal["twosided"] = "twosided"
    bsdf: Annotated[tuple[Bsdf, ...], Field(min_length=1, max_length=2)]
    """One or two BSDFs that let no light through."""

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
    """How much of the second there is: 0 is the first alone, 1 the second alone."""
    bsdf: Annotated[tuple[Bsdf, ...], Field(min_length=2, max_length=2)]

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}
    lists: ClassVar[frozenset[str]] = frozenset({"bsdf"})

    @property
    def transmits(self) -> bool:
        """Whether any of the two does."""
        return any(bsdf.transmits for bsdf in self.bsdf)


class Mask(BsdfPlugin):
    """A BSDF with holes: where it is not opaque, light passes as if there were no surface."""

    type: Literal["mask"] = "mask"
    opacity: WeightTexture = 0.5
    cutoff: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] | None = None
    """Makes it opaque where the opacity is at least this, and a hole elsewhere; an extension to Mitsuba."""
    bsdf: Bsdf

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}

    @property
    def transmits(self) -> bool:
        """Always."""
        return True


class Bent(BsdfPlugin):
    """Base of the BSDFs that bend the normal of another."""

    bsdf: Bsdf
    flip_invalid_normals: bool = True
    """Turn a bent normal over that looks away from the viewer."""
    use_shadowing_function: bool = True
    """Darken softly where the bent and the real normal disagree (Chiang et al. 2019)."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}

    @property
    def transmits(self) -> bool:
        """Whether the BSDF inside does."""
        return self.bsdf.transmits


class BumpMap(Bent):
    """A BSDF whose normals follow a height given by a texture."""

    type: Literal["bumpmap"] = "bumpmap"
    texture: Texture
    """The height, in the scene's units of length."""
    scale: float = 1.0
    """Factor on the height."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf", "texture": "texture"}


class NormalMap(Bent):
    """A BSDF whose normals are given by a texture, in the frame of the tangents: colours (n + 1) / 2."""

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
