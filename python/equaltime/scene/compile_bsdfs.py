"""Hands BSDFs to the core: each once, however often it is used and whatever it is called."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from equaltime.scene.builder import Builder
from equaltime.scene.compile_textures import Textures
from equaltime.scene.model import Bsdf, Conductor, Dielectric, Diffuse, Plastic, RoughConductor, ThinDielectric
from equaltime.scene.unsupported import Unsupported, constant

__all__ = ["Materials"]


class Materials:
    """The BSDFs that a builder has been given; equal ones share one index."""

    def __init__(self, builder: Builder, textures: Textures) -> None:
        self._builder = builder
        self._textures = textures
        self._known: dict[Bsdf, int] = {}

    def index(self, bsdf: Bsdf | None) -> int | None:
        """Return the core's index of `bsdf`, one side of a surface; None for one that absorbs everything."""
        if bsdf is None:
            return None
        nameless = bsdf.model_copy(update={"id": None})
        if nameless not in self._known:
            self._known[nameless] = self._add(bsdf)
        return self._known[nameless]

    def _add(self, bsdf: Bsdf) -> int:
        step = LEAVES.get(type(bsdf))
        if step is None:
            raise Unsupported(bsdf)
        return step(self._builder, bsdf)


def _diffuse(builder: Builder, bsdf: Diffuse) -> int:
    return builder.add_diffuse(constant(bsdf.reflectance))


def _conductor(builder: Builder, bsdf: Conductor) -> int:
    eta, k = map(constant, bsdf.ior)
    return builder.add_conductor(eta, k, constant(bsdf.specular_reflectance))


def _rough_conductor(builder: Builder, bsdf: RoughConductor) -> int:
    (eta, k), (alpha_u, alpha_v) = map(constant, bsdf.ior), map(constant, bsdf.alphas)
    reflectance = constant(bsdf.specular_reflectance)
    return builder.add_rough_conductor(bsdf.distribution, alpha_u, alpha_v, eta, k, reflectance)


def _dielectric(builder: Builder, bsdf: Dielectric) -> int:
    reflectance, transmittance = constant(bsdf.specular_reflectance), constant(bsdf.specular_transmittance)
    return builder.add_dielectric(bsdf.int_ior / bsdf.ext_ior, reflectance, transmittance)


def _thin_dielectric(builder: Builder, bsdf: ThinDielectric) -> int:
    reflectance, transmittance = constant(bsdf.specular_reflectance), constant(bsdf.specular_transmittance)
    return builder.add_thin_dielectric(bsdf.int_ior / bsdf.ext_ior, reflectance, transmittance)


def _plastic(builder: Builder, bsdf: Plastic) -> int:
    diffuse, specular = constant(bsdf.diffuse_reflectance), constant(bsdf.specular_reflectance)
    return builder.add_plastic(bsdf.int_ior / bsdf.ext_ior, diffuse, specular, bsdf.nonlinear)


Step = Callable[[Builder, Any], int]
LEAVES: Final[dict[type, Step]] = {
    Diffuse: _diffuse,
    Conductor: _conductor,
    RoughConductor: _rough_conductor,
    Dielectric: _dielectric,
    ThinDielectric: _thin_dielectric,
    Plastic: _plastic,
}
"""How each BSDF that wraps no other is added."""
