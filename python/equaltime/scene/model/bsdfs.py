"""BSDFs that contain no other BSDF; see `wrappers` for BSDFs that do."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, PositiveFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.ior import as_ior
from equaltime.scene.model.metals import METALS, Metal, as_metal
from equaltime.scene.model.textures import (
    CoefficientTexture,
    ConstantRoughness,
    ReflectanceTexture,
    Roughness,
    Texture,
)
from equaltime.scene.model.values import Color, as_lower

__all__ = [
    *("BsdfPlugin", "Conductor", "Dielectric", "Diffuse", "Null", "Plastic"),
    *("RoughConductor", "RoughDielectric", "RoughPlastic", "ThinDielectric"),
]

Ior = Annotated[PositiveFloat, Field(ge=1e-3, le=1e3), BeforeValidator(as_ior)]
"""An index of refraction: a number from 0.001 to 1000 or one of Mitsuba's names. Beyond this range float32 loses the
light."""
Distribution = Annotated[Literal["beckmann", "ggx"], BeforeValidator(as_lower)]
WHITE: Color = (1.0, 1.0, 1.0)


class BsdfPlugin(Plugin):
    """Base of the BSDFs."""

    kind: ClassVar[Kind] = "bsdf"

    @property
    def transmits(self) -> bool:
        """Whether light passes through, so that one description serves both sides of the surface."""
        return False


class Diffuse(BsdfPlugin):
    """Lambertian reflection from the front side; the back side absorbs."""

    type: Literal["diffuse"] = "diffuse"
    reflectance: ReflectanceTexture = (0.5, 0.5, 0.5)


class Conductor(BsdfPlugin):
    """A smooth metal, seen from the front side; without material, eta and k a perfect mirror."""

    type: Literal["conductor"] = "conductor"
    material: Annotated[str, BeforeValidator(as_metal)] = "none"
    """A metal by name, instead of eta and k; ``none`` is a perfect mirror."""
    eta: CoefficientTexture = (0.0, 0.0, 0.0)
    """Real part of the index of refraction relative to the outside; see `ior`."""
    k: CoefficientTexture = WHITE
    """Extinction, the imaginary part; see `ior`."""
    specular_reflectance: ReflectanceTexture = WHITE

    @model_validator(mode="after")
    def _one_metal(self) -> Self:
        given = {"eta", "k"} & self.model_fields_set
        if self.material != "none" and given:
            raise ValueError(f"give either material or eta and k (found material and {' and '.join(sorted(given))})")
        return self

    @property
    def ior(self) -> tuple[Texture | Color, Texture | Color]:
        """Real part and extinction of the index of refraction, from ``material`` or from ``eta`` and ``k``."""
        metal: Metal | None = METALS.get(self.material)
        return (self.eta, self.k) if metal is None else (metal.eta, metal.k)


class Rough(BsdfPlugin):
    """Base of the BSDFs with a microfacet surface whose roughness may differ along tangent and bitangent."""

    distribution: Distribution = "beckmann"
    alpha: Roughness = 0.1
    """Root mean square slope."""
    alpha_u: Roughness | None = None
    """Roughness along the tangent; with ``alpha_v`` instead of ``alpha``."""
    alpha_v: Roughness | None = None
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
    def alphas(self) -> tuple[Texture | float, Texture | float]:
        """Roughness along the tangent and the bitangent."""
        if self.alpha_u is None or self.alpha_v is None:
            return self.alpha, self.alpha
        return self.alpha_u, self.alpha_v


class RoughConductor(Conductor, Rough):
    """A metal with a microfacet surface."""

    type: Literal["roughconductor"] = "roughconductor"  # type: ignore[assignment]  # narrows the tag of Conductor


class Dielectric(BsdfPlugin):
    """A smooth interface between two transparent media; the inside is behind the front side."""

    type: Literal["dielectric"] = "dielectric"
    int_ior: Ior = 1.5046
    ext_ior: Ior = 1.000277
    specular_reflectance: ReflectanceTexture = WHITE
    specular_transmittance: ReflectanceTexture = WHITE

    @property
    def transmits(self) -> bool:
        """Always true."""
        return True


class ThinDielectric(Dielectric):
    """A pane of glass as one surface: light passes straight on, reflections between its two sides are summed."""

    type: Literal["thindielectric"] = "thindielectric"  # type: ignore[assignment]  # narrows the tag of Dielectric


class RoughDielectric(Dielectric, Rough):
    """A microfacet interface between two transparent media."""

    type: Literal["roughdielectric"] = "roughdielectric"  # type: ignore[assignment]  # narrows the tag of Dielectric


class Plastic(BsdfPlugin):
    """A diffuse base under a smooth clear coat, seen from the front side."""

    type: Literal["plastic"] = "plastic"
    diffuse_reflectance: ReflectanceTexture = (0.5, 0.5, 0.5)
    specular_reflectance: ReflectanceTexture = WHITE
    int_ior: Ior = 1.49
    ext_ior: Ior = 1.000277
    nonlinear: bool = False
    """Whether light takes the colour of the base at each reflection inside the coat."""


class RoughPlastic(Plastic):
    """A diffuse base under a microfacet clear coat, seen from the front side."""

    type: Literal["roughplastic"] = "roughplastic"  # type: ignore[assignment]  # narrows the tag of Plastic
    distribution: Distribution = "beckmann"
    alpha: ConstantRoughness = 0.1
    """Root mean square slope."""
    sample_visible: bool = True
    """A sampling hint of Mitsuba; visible normals are always sampled here."""

    hints: ClassVar[frozenset[str]] = frozenset({"sample_visible"})


class Null(BsdfPlugin):
    """The null BSDF: light passes as if there were no surface."""

    type: Literal["null"] = "null"

    @property
    def transmits(self) -> bool:
        """Always true."""
        return True
