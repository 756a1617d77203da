"""Surface scattering: the BSDF plugins and what they look like on each side of a surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, PositiveFloat, model_validator

from equaltime.scene.model.base import NOT_YET, Kind, Plugin
from equaltime.scene.model.ior import as_ior
from equaltime.scene.model.values import Coefficient, Reflectance

__all__ = ["Bsdf", "Conductor", "Dielectric", "Diffuse", "RoughConductor", "TwoSided"]

Ior = Annotated[PositiveFloat, BeforeValidator(as_ior)]
"""An index of refraction: a positive number or one of Mitsuba's names."""


class BsdfPlugin(Plugin):
    """Base of the BSDFs."""

    kind: ClassVar[Kind] = "bsdf"
    transmits: ClassVar[bool] = False
    """Whether light passes through, so that one description serves both sides of the surface."""


class Diffuse(BsdfPlugin):
    """Lambertian reflection from the front side; the back side absorbs."""

    type: Literal["diffuse"] = "diffuse"
    reflectance: Reflectance = (0.5, 0.5, 0.5)


def _no_preset(material: str) -> str:
    if material != "none":
        raise ValueError(f"named materials are {NOT_YET}: give eta and k, or 'none' for a perfect mirror")
    return material


class Conductor(BsdfPlugin):
    """A smooth metal, seen from the front side; without eta and k a perfect mirror."""

    type: Literal["conductor"] = "conductor"
    material: Annotated[str, AfterValidator(_no_preset)] = "none"
    eta: Coefficient = (0.0, 0.0, 0.0)
    """Real part of the index of refraction relative to the outside."""
    k: Coefficient = (1.0, 1.0, 1.0)
    """Extinction, the imaginary part."""
    specular_reflectance: Reflectance = (1.0, 1.0, 1.0)


class RoughConductor(Conductor):
    """A metal with a microfacet surface; ``alpha`` is the root mean square slope."""

    type: Literal["roughconductor"] = "roughconductor"  # type: ignore[assignment]  # narrows the tag of Conductor
    distribution: Literal["beckmann", "ggx"] = "beckmann"
    alpha: PositiveFloat = 0.1
    alpha_u: PositiveFloat | None = None
    """Roughness along the tangent; with ``alpha_v`` instead of ``alpha``."""
    alpha_v: PositiveFloat | None = None
    """Roughness along the bitangent."""
    sample_visible: bool = True
    """A sampling hint of Mitsuba; visible normals are always sampled here."""

    hints: ClassVar[frozenset[str]] = frozenset({"sample_visible"})

    @model_validator(mode="after")
    def _one_roughness(self) -> Self:
        given = {"alpha", "alpha_u", "alpha_v"} & self.model_fields_set
        if given not in (set(), {"alpha"}, {"alpha_u", "alpha_v"}):
            raise ValueError(f"give either alpha, or both alpha_u and alpha_v (found {', '.join(sorted(given))})")
        return self

    @property
    def alphas(self) -> tuple[float, float]:
        """Roughness along the tangent and the bitangent."""
        if self.alpha_u is None or self.alpha_v is None:
            return self.alpha, self.alpha
        return self.alpha_u, self.alpha_v


class Dielectric(BsdfPlugin):
    """A smooth interface between two transparent media; the inside is behind the front side."""

    type: Literal["dielectric"] = "dielectric"
    int_ior: Ior = 1.5046
    ext_ior: Ior = 1.000277
    specular_reflectance: Reflectance = (1.0, 1.0, 1.0)
    specular_transmittance: Reflectance = (1.0, 1.0, 1.0)

    transmits: ClassVar[bool] = True


Opaque = Annotated[Diffuse | Conductor | RoughConductor, Field(discriminator="type")]


class TwoSided(BsdfPlugin):
    """Makes a one-sided BSDF work on both sides, or puts one on each side (front, back)."""

    type: Literal["twosided"] = "twosided"
    bsdf: Annotated[tuple[Opaque, ...], Field(min_length=1, max_length=2)]
    """One or two opaque, one-sided BSDFs."""

    roles: ClassVar[Mapping[Kind, str]] = {"bsdf": "bsdf"}
    lists: ClassVar[frozenset[str]] = frozenset({"bsdf"})


Bsdf = Annotated[Diffuse | Conductor | RoughConductor | Dielectric | TwoSided, Field(discriminator="type")]
"""Any BSDF that a shape may carry."""
