"""Hazards of materials: surfaces that return all light, textures beyond what a factor may be."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from equaltime.scene.lint.finding import Finding, first_places
from equaltime.scene.lint.parts import World
from equaltime.scene.model import Bitmap, Diffuse, Plugin

__all__ = ["check_materials"]

WHITE: Final = 0.999
"""From here on a path needs a thousand bounces to lose its light."""
FACTORS: Final = frozenset(
    {
        *("reflectance", "diffuse_reflectance", "specular_reflectance", "specular_transmittance", "base_color"),
        *("roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"),
        *("clearcoat", "clearcoat_gloss", "weight", "opacity"),
    }
)
"""Parameters that lie in [0, 1]."""
POSITIVE: Final = frozenset({"alpha", "alpha_u", "alpha_v", "radiance", "eta", "k"})
"""Parameters that are not negative."""


def check_materials(world: World) -> Iterator[Finding]:
    """Look at all BSDFs and textures."""
    nodes = list({id(node): node for node in world.scene.model.nodes()}.values())
    white = [node for node in nodes if isinstance(node, Diffuse) and _reflects(node) >= WHITE]
    if white and world.scene.max_depth == -1:
        yield Finding(
            "white-surfaces",
            "note",
            f"diffuse BSDFs that reflect {WHITE:.1%} of the light or more, while paths have no limit: {len(white)}",
            first_places(world.called(node) for node in white),
            len(white),
            "follows paths until roulette ends them: no bias, but in a closed room they take very long",
            "keep to 0.9: nothing is whiter than fresh snow; or give the integrator a max_depth",
        )
    if not world.fast:
        yield from _textures(world, nodes)


def _reflects(node: Diffuse) -> float:
    return max(node.reflectance) if isinstance(node.reflectance, tuple) else 0.0


def _textures(world: World, nodes: list[Plugin]) -> Iterator[Finding]:
    """Texels outside what the parameters that use them may be."""
    count, users, least, most = 0, [], 0.0, 0.0
    for node in nodes:
        for name in type(node).model_fields:
            texture = getattr(node, name)
            if name not in FACTORS | POSITIVE or not isinstance(texture, Bitmap):
                continue
            texels = world.scene.assets.texture(texture).texels
            if texels.dtype == np.uint8:
                continue
            outside = (texels < 0) | ((texels > 1) if name in FACTORS else False)
            if outside.any():
                count += int(outside.any(axis=-1).sum())
                users.append(f"{world.called(texture)} as {name} of {world.called(node)}")
                least, most = min(least, float(texels.min())), max(most, float(texels.max()))
    if users:
        yield Finding(
            "textures-out-of-range",
            "warning",
            f"texels beyond what their parameters may be: {count:,}; they reach from {least:.4g} to {most:.4g}",
            first_places(users),
            count,
            "takes reflectances as they are, so that surfaces make light or take more than there is",
            "scale the image into [0, 1], or set raw where the numbers are no colours",
        )
