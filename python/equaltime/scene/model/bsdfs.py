"""BSDFs that contain no other BSDF. The module `wrappers` has the BSDFs that contain others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import BeforeValidator, Field, NonNegativeFloat, PositiveFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.ior import METALS, Metal, as_ior, as_metal
from equaltime.scene.model.textures import (
    CoefficientTexture,
    ConstantRoughness,
    ReflectanceTexture,
    Roughness,
    Slope,
    Texture,
    UnitTexture,
)
from equaltime.scene.model.values import Color, as_lower

__all__ = [
    "LEAVES",
    "BsdfPlugin",
    "Conductor",
    "Dielectric",
    "Diffuse",
    "Null",
    "PPlastic",
    "Plastic",
    "Principled",
    "RoughConductor",
    "RoughDielectric",
    "RoughDiffuse",
    "RoughPlastic",
    "ThinDielectric",
]

Ior = Annotated[PositiveFloat, Field(ge=1e-3, le=1e3), BeforeValidator(as_ior)]
"""An index of refraction: a number from 0.001 to 1000, or one of Mitsuba's names. Outside of this
range, light is lost to the rounding of float32."""
Distribution = Annotated[Literal["beckmann", "ggx"], BeforeValidator(as_lower)]
WHITE: Color = (1.0, 1.0, 1.0)


def without(parameters: Mapping[str, Any], *names: str) -> dict[str, Any]:
    """Return the parameters that have other names."""
    return {name: value for name, value in parameters.items() if name not in names}


def relative(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters with ``ior``, the interior's index over the exterior's, in place of the two."""
    ior = parameters["int_ior"] / parameters["ext_ior"]
    return without(parameters, "int_ior", "ext_ior") | {"ior": ior}


class BsdfPlugin(Plugin):
    """Base class of all BSDFs, which describe how a surface scatters light."""

    kind: ClassVar[Kind] = "bsdf"

    @property
    def transmits(self) -> bool:
        """True if light passes through the surface. A transmitting BSDF describes both sides of the surface."""
        return False

    def textures(self) -> dict[str, Any]:
        """Return the parameters that textures may give, by the core's names; other values are among them."""
        return self.parameters()


class Diffuse(BsdfPlugin):
    """Lambertian reflection from the front side; the back side absorbs all light."""

    type: Literal["diffuse"] = "diffuse"
    reflectance: ReflectanceTexture = (0.5, 0.5, 0.5)


class RoughDiffuse(Diffuse):
    """Grooves of diffuse facets, as of plaster or clay (Oren and Nayar 1994); the back side absorbs all light.

    The plugin is from Mitsuba 0.6, and an extension to Mitsuba 3. The model does not keep energy exactly: a white
    surface reflects from 0.67 to 1.051 of the light, and for ``alpha`` up to 0.5 at least 0.94.
    """

    type: Literal["roughdiffuse"] = "roughdiffuse"  # type: ignore[assignment]  # narrows the tag of Diffuse
    alpha: Slope = 0.2
    """Root mean square of the facets' slopes; 0 is ``diffuse``. The standard deviation of Oren and Nayar's angles is
    alpha/√2 radians."""
    use_fast_approx: bool = False
    """Use Oren and Nayar's qualitative model, which leaves out the light between facets. It is darker: a white surface
    reflects from 0.5 to 1.016 of the light."""


class Conductor(BsdfPlugin):
    """A smooth metal, by default a perfect mirror; the back side absorbs all light."""

    type: Literal["conductor"] = "conductor"
    material: Annotated[str, BeforeValidator(as_metal)] = "none"
    """Name of a metal, instead of ``eta`` and ``k``; ``none``, without ``eta`` and ``k``, is a perfect mirror."""
    eta: CoefficientTexture = (0.0, 0.0, 0.0)
    """Real part of the index of refraction, relative to the exterior, per channel; not used if ``material`` names a
    metal."""
    k: CoefficientTexture = WHITE
    """Extinction coefficient: the imaginary part of the index of refraction, per channel; not used if ``material``
    names a metal."""
    specular_reflectance: ReflectanceTexture = WHITE

    @model_validator(mode="after")
    def _one_metal(self) -> Self:
        given = {"eta", "k"} & self.model_fields_set
        if self.material != "none" and given:
            raise ValueError(f"give either material or eta and k (found material and {' and '.join(sorted(given))})")
        return self

    @property
    def ior(self) -> tuple[Texture | Color, Texture | Color]:
        """Complex index of refraction as a pair: real part ``eta`` and extinction ``k``.

        If ``material`` names a metal, the pair has the values of this metal.
        """
        metal: Metal | None = METALS.get(self.material)
        return (self.eta, self.k) if metal is None else (metal.eta, metal.k)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters, with the metal's ``eta`` and ``k`` in place of its name."""
        eta, k = self.ior
        return without(super().parameters(), "material") | {"eta": eta, "k": k}


class Rough(BsdfPlugin):
    """Base class of the microfacet BSDFs whose roughness may differ between tangent and bitangent."""

    distribution: Distribution = "beckmann"
    alpha: Roughness = 0.1
    """Roughness alpha of the microfacets; for ``beckmann`` the root mean square of their slopes."""
    alpha_u: Roughness | None = None
    """Roughness along the tangent. Give both ``alpha_u`` and ``alpha_v``, or ``alpha`` alone."""
    alpha_v: Roughness | None = None
    """Roughness along the bitangent."""
    sample_visible: bool = True
    """A sampling hint of Mitsuba, not used: visible normals are always sampled."""

    hints: ClassVar[frozenset[str]] = frozenset({"sample_visible"})

    @model_validator(mode="after")
    def _one_roughness(self) -> Self:
        given = {"alpha", "alpha_u", "alpha_v"} & self.model_fields_set
        if given not in (set(), {"alpha"}, {"alpha_u", "alpha_v"}):
            raise ValueError(f"give either alpha, or both alpha_u and alpha_v (found {', '.join(sorted(given))})")
        return self

    @property
    def alphas(self) -> tuple[Texture | float, Texture | float]:
        """Roughness alpha as a pair: along the tangent, and along the bitangent."""
        if self.alpha_u is None or self.alpha_v is None:
            return self.alpha, self.alpha
        return self.alpha_u, self.alpha_v

    def parameters(self) -> dict[str, Any]:
        """Return the BSDF's parameters by name, with the roughness along u and along v, even if they are equal."""
        alpha_u, alpha_v = self.alphas
        return without(super().parameters(), "alpha") | {"alpha_u": alpha_u, "alpha_v": alpha_v}

    def textures(self) -> dict[str, Any]:
        """Return the parameters that textures may give, with ``alpha`` where it gives both directions."""
        if self.alpha_u is not None:
            return super().textures()
        return without(super().textures(), "alpha_u", "alpha_v") | {"alpha": self.alpha}


class RoughConductor(Conductor, Rough):
    """A metal with a microfacet surface; the back side absorbs all light."""

    type: Literal["roughconductor"] = "roughconductor"  # type: ignore[assignment]  # narrows the tag of Conductor


class Dielectric(BsdfPlugin):
    """A smooth interface between two transparent media; the front side faces the exterior medium."""

    type: Literal["dielectric"] = "dielectric"
    int_ior: Ior = 1.5046
    ext_ior: Ior = 1.000277
    specular_reflectance: ReflectanceTexture = WHITE
    specular_transmittance: ReflectanceTexture = WHITE

    @property
    def transmits(self) -> bool:
        """Always True: light passes through the surface."""
        return True

    def parameters(self) -> dict[str, Any]:
        """Return the parameters, with ``ior``, the interior's index over the exterior's, in place of the two."""
        return relative(super().parameters())


class ThinDielectric(Dielectric):
    """A thin pane of glass, modelled as one surface.

    Light passes without deflection. Repeated reflections inside the pane are summed.
    """

    type: Literal["thindielectric"] = "thindielectric"  # type: ignore[assignment]  # narrows the tag of Dielectric


class RoughDielectric(Dielectric, Rough):
    """A microfacet interface between two transparent media."""

    type: Literal["roughdielectric"] = "roughdielectric"  # type: ignore[assignment]  # narrows the tag of Dielectric


class Plastic(BsdfPlugin):
    """A diffuse base under a smooth clear coat; the back side absorbs all light."""

    type: Literal["plastic"] = "plastic"
    diffuse_reflectance: ReflectanceTexture = (0.5, 0.5, 0.5)
    specular_reflectance: ReflectanceTexture = WHITE
    int_ior: Ior = 1.49
    ext_ior: Ior = 1.000277
    nonlinear: bool = False
    """True: each reflection below the coat takes on the colour of the base. False: only the first one does."""

    def parameters(self) -> dict[str, Any]:
        """Return the parameters, with ``ior``, the interior's index over the exterior's, in place of the two."""
        return relative(super().parameters())


class RoughPlastic(Plastic):
    """A diffuse base under a microfacet clear coat; the back side absorbs all light."""

    type: Literal["roughplastic"] = "roughplastic"  # type: ignore[assignment]  # narrows the tag of Plastic
    distribution: Distribution = "beckmann"
    alpha: ConstantRoughness = 0.1
    """Roughness alpha of the microfacets; for ``beckmann`` the root mean square of their slopes."""
    sample_visible: bool = True
    """A sampling hint of Mitsuba, not used: visible normals are always sampled."""

    hints: ClassVar[frozenset[str]] = frozenset({"sample_visible"})


class PPlastic(Rough):
    """A diffuse base under a microfacet clear coat that reflects nothing back down; the back side absorbs all light.

    Mitsuba's polarised plastic, for light that is not polarised.
    """

    type: Literal["pplastic"] = "pplastic"
    diffuse_reflectance: ReflectanceTexture = (0.5, 0.5, 0.5)
    specular_reflectance: ReflectanceTexture = WHITE
    int_ior: Ior = 1.49
    ext_ior: Ior = 1.000277

    def parameters(self) -> dict[str, Any]:
        """Return the parameters, with ``ior``, the interior's index over the exterior's, in place of the two."""
        return relative(super().parameters())


class Null(BsdfPlugin):
    """The null BSDF: light passes through as if the surface did not exist."""

    type: Literal["null"] = "null"

    @property
    def transmits(self) -> bool:
        """Always True: light passes through the surface."""
        return True


class Principled(BsdfPlugin):
    """A mixture of diffuse, metal, glass and coat (Burley 2012, 2015).

    Without ``spec_trans`` the back side absorbs all light.
    """

    type: Literal["principled"] = "principled"
    base_color: ReflectanceTexture = (0.5, 0.5, 0.5)
    roughness: UnitTexture = 0.5
    """Square root of the alpha of the microfacet distribution, in [0, 1]."""
    anisotropic: UnitTexture = 0.0
    metallic: UnitTexture = 0.0
    spec_trans: UnitTexture = 0.0
    """Share of glass, in [0, 1]."""
    eta: Annotated[float, Field(ge=1e-3, le=1e3)] | None = None
    """Index of refraction of the interior relative to the exterior; instead of ``specular``."""
    specular: Annotated[float, Field(ge=0.0, le=1.0)] = 0.5
    """Reflectance at normal incidence, in [0, 1], where 1 means 8 %; not used if ``eta`` is given."""
    spec_tint: UnitTexture = 0.0
    sheen: UnitTexture = 0.0
    sheen_tint: UnitTexture = 0.0
    flatness: UnitTexture = 0.0
    """Share, in [0, 1], of a diffuse lobe that approximates subsurface scattering."""
    clearcoat: UnitTexture = 0.0
    clearcoat_gloss: UnitTexture = 0.0
    diffuse_reflectance_sampling_rate: NonNegativeFloat = 1.0
    """A sampling hint of Mitsuba, not used, like the other two sampling rates."""
    main_specular_sampling_rate: NonNegativeFloat = 1.0
    clearcoat_sampling_rate: NonNegativeFloat = 1.0

    hints: ClassVar[frozenset[str]] = frozenset(
        {"diffuse_reflectance_sampling_rate", "main_specular_sampling_rate", "clearcoat_sampling_rate"}
    )

    @model_validator(mode="after")
    def _one_index(self) -> Self:
        if {"eta", "specular"} <= self.model_fields_set and self.eta is not None:
            raise ValueError("give either eta or specular, not both")
        return self

    @property
    def ior(self) -> float:
        """Index of refraction of the interior relative to the exterior, from ``eta`` or ``specular``.

        Glass needs an index other than 1. As in Mitsuba, an ``eta`` of 1 therefore counts as 1.001, and a ``specular``
        of 0 as 0.001.
        """
        if self.eta is not None:
            return 1.001 if self.transmits and self.eta == 1.0 else self.eta
        specular = 1e-3 if self.transmits and self.specular == 0.0 else self.specular
        return 2.0 / (1.0 - math.sqrt(0.08 * specular)) - 1.0

    def parameters(self) -> dict[str, Any]:
        """Return the parameters, with ``ior`` in place of ``eta`` and ``specular``."""
        return without(super().parameters(), "eta", "specular") | {"ior": self.ior}

    @property
    def transmits(self) -> bool:
        """True if any point of the surface may be glass: ``spec_trans`` is a texture, or a number above 0."""
        return self.spec_trans != 0.0


def _leaves(base: type[BsdfPlugin]) -> Iterator[type[BsdfPlugin]]:
    for plugin in base.__subclasses__():
        if "type" in plugin.model_fields:
            yield plugin
        yield from _leaves(plugin)


LEAVES: Final = tuple(dict.fromkeys(_leaves(BsdfPlugin)))
"""The classes of this module that are plugins."""
