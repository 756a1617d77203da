"""What stands for the principled BSDF as long as the core has none: diffuse and microfacet parts in fixed shares."""

from __future__ import annotations

from typing import Final

from equaltime.scene.gltf.plant import add, plant
from equaltime.scene.tree import Object, Place

__all__ = ["SHARE", "is_needed", "stand_in"]

SHARE: Final = 0.06
"""What a dielectric of index 1.5 and moderate roughness reflects at its surface, averaged over directions."""


def is_needed() -> bool:
    """Tell whether the core lacks the principled BSDF."""
    from equaltime.scene.compile_bsdfs import LEAVES  # which asks for assets, and those for this package
    from equaltime.scene.model import Principled

    return Principled not in LEAVES


def stand_in(place: Place, base_color: object, metallic: object, alpha: object, base_of_metal: object) -> Object:
    """Return a blend by metalness: below diffuse with a little gloss, above a coloured metal.

    Colours and numbers may be textures. Nothing grows towards grazing angles, as Fresnel's reflection would.
    """
    plastic = plant("bsdf", "blendbsdf", place, weight=SHARE)
    add(plastic, None, plant("bsdf", "diffuse", place, reflectance=base_color))
    add(plastic, None, plant("bsdf", "roughconductor", place, material="none", distribution="ggx", alpha=alpha))
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
