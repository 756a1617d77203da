"""The principled BSDF: one material with intuitive parameters (Burley 2012, 2015)."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, NonNegativeFloat, model_validator

from equaltime.scene.model.bsdfs import BsdfPlugin
from equaltime.scene.model.textures import ReflectanceTexture, UnitTexture

__all__ = ["Principled"]


class Principled(BsdfPlugin):
    """A mixture of diffuse, metal, glass and coat; without ``spec_trans`` the back side absorbs all light."""

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

    @property
    def transmits(self) -> bool:
        """True if any point of the surface may be glass: ``spec_trans`` is a texture, or a number above 0."""
        return self.spec_trans != 0.0
