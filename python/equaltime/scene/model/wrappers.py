"""BSDFs that contain other BSDFs (two-sided, blended, masked, bumped), and the type `Bsdf` of all BSDFs.

`sides` splits the BSDF of a surface into a BSDF for the front and a BSDF for the back, without ``twosided``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self, Union

from pydantic import Field, model_validator

from equaltime.scene.model.base import Kind
from equaltime.scene.model.bsdfs import LEAVES, BsdfPlugin, Diffuse
from equaltime.scene.model.textures import Texture, WeightTexture

__all__ = ["BlendBsdf", "Bsdf", "BumpMap", "Mask", "NormalMap", "TwoSided", "sides", "turns"]


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
                    f"'twosided' cannot contain '{side.title}', which lets light through: it describes both sides"
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
    """Base class of the BSDFs that perturb the shading normal of another BSDF."""

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


if TYPE_CHECKING:
    Bsdf = BsdfPlugin
else:
    Bsdf = Annotated[
        Union[(*LEAVES, TwoSided, BlendBsdf, Mask, BumpMap, NormalMap)],  # made of a tuple
        Field(discriminator="type"),
    ]
"""Any BSDF that a shape may carry."""

for _wrapper in (TwoSided, BlendBsdf, Mask, BumpMap, NormalMap):
    _wrapper.model_rebuild()


# -- sides of a surface ------------------------------------------------------------------------------------------------

BLACK = Diffuse(reflectance=(0.0, 0.0, 0.0))


def sides(bsdf: Bsdf) -> tuple[Bsdf | None, Bsdf | None]:
    """Return the BSDF of the front and the BSDF of the back; a ``twosided`` around them is removed.

    None stands for a side that absorbs all light. A transmitting BSDF is returned for both sides, because it
    distinguishes the sides itself. A mask, bump map or normal map around a BSDF is put around the BSDF of each side.
    So a mask's hole is in both sides, even if the back absorbs light elsewhere.
    """
    if isinstance(bsdf, TwoSided):
        return sides(bsdf.bsdf[0])[0], sides(bsdf.bsdf[-1])[0]
    if isinstance(bsdf, Mask):
        front, back = sides(bsdf.bsdf)
        return _around(bsdf, front or BLACK), _around(bsdf, back or BLACK)
    if isinstance(bsdf, BumpMap | NormalMap):
        front, back = sides(bsdf.bsdf)
        return front and _around(bsdf, front), back and _around(bsdf, back)
    if isinstance(bsdf, BlendBsdf):
        (front, back), (other_front, other_back) = map(sides, bsdf.bsdf)
        return _blend(bsdf, front, other_front), _blend(bsdf, back, other_back)
    if isinstance(bsdf, Diffuse) and bsdf.reflectance == BLACK.reflectance:
        return None, None
    return bsdf, bsdf if bsdf.transmits else None


def turns(bsdf: Bsdf) -> bool:
    """Tell whether the bent normal on the back of a surface is the negative of the bent normal on the front.

    Return True if `bsdf` has a bump or normal map that no ``twosided`` wraps. Return False if ``twosided`` wraps the
    map: the back then shows a mirror image of the front. Return False too without a map.
    """
    if isinstance(bsdf, BlendBsdf):
        return any(map(turns, bsdf.bsdf))
    return isinstance(bsdf, BumpMap | NormalMap) or (isinstance(bsdf, Mask) and turns(bsdf.bsdf))


def _around(wrapper: Mask | BumpMap | NormalMap, inner: Bsdf) -> Bsdf:
    return wrapper if inner is wrapper.bsdf else wrapper.replace(bsdf=inner)


def _blend(blend: BlendBsdf, first: Bsdf | None, second: Bsdf | None) -> Bsdf | None:
    if first is None and second is None:
        return None
    both = (first or BLACK, second or BLACK)
    return blend if both == blend.bsdf else blend.replace(bsdf=both)
