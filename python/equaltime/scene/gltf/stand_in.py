"""What stands for the principled BSDF as long as the core has none: diffuse and microfacet parts in fixed shares."""

from __future__ import annotations

from typing import Final

from equaltime.scene.gltf.plant import add, plant
from equaltime.scene.tree import Object, Place

__all__ = ["coated", "is_needed", "share", "stand_in"]

OF_HEAD_ON: Final = 1.5
"""What a dielectric surface reflects, averaged over directions, in terms of what it reflects head on."""


def is_needed() -> bool:
    """Tell whether the core lacks the principled BSDF."""
    from equaltime.scene.compile_bsdfs import LEAVES  # which asks for assets, and those for this package
    from equaltime.scene.model import Principled

    return Principled not in LEAVES


def share(eta: float) -> float:
    """Return how much of the light a dielectric surface of index `eta` reflects, averaged over directions."""
    return min(OF_HEAD_ON * ((eta - 1.0) / (eta + 1.0)) ** 2, 1.0)


def coated(place: Place, inner: Object, weight: object, alpha: object) -> Object:
    """Return `inner` under a coat that reflects this much of the light, without colour."""
    result = plant("bsdf", "blendbsdf", place, weight=weight)
    add(result, None, inner)
    add(result, None, plant("bsdf", "roughconductor", place, material="none", distribution="ggx", alpha=alpha))
    return result


def stand_in(
    place: Place, gloss: float, base_color: object, metallic: object, alpha: object, base_of_metal: object
) -> Object:
    """Return a blend by metalness: below diffuse with a little gloss, above a coloured metal.

    The gloss is a share of the light; colours and numbers may be textures. Nothing grows towards grazing angles, as
    Fresnel's reflection would.
    """
    plastic = coated(place, plant("bsdf", "diffuse", place, reflectance=base_color), gloss, alpha)
    metal = plant("bsdf", "roughconductor", place, material="none", distribution="ggx", alpha=alpha)
    add(metal, "specular_reflectance", base_of_metal)
    if metallic == 0.0:
        return plastic
    if metallic == 1.0:
        return metal
    result = plant("bsdf", "blendbsdf", place, weight=metallic)
    add(result, None, plastic)
    add(result, None, metal)
    return result
