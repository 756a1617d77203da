"""Surfaces of a scene that may focus light, in words, for the doubt that focused light causes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from equaltime.scene import Scene
from equaltime.scene.effects.kinds import nodes_of
from equaltime.scene.model import (
    BsdfPlugin,
    Conductor,
    Dielectric,
    Plastic,
    Plugin,
    PPlastic,
    Principled,
    RoughConductor,
    RoughDielectric,
    RoughPlastic,
)

__all__ = ["focusing_surfaces"]

_ROUGHEST: Final = 0.15
"""Largest roughness alpha of a surface that may focus light: rougher ones scatter into less than 100 a steradian, even
at grazing incidence. The core counts denser directions as specular (`analysis/specular.cpp`)."""


def focusing_surfaces(scene: Scene) -> str:
    """Return the kinds of surfaces of a scene that may focus light, such as ``glass and mirrors``.

    A rough surface counts if its roughness alpha may be at most 0.15. The text is empty without such surfaces.
    """
    kinds = list(dict.fromkeys(kind for node in nodes_of(scene) for kind in _kinds(node)))
    return " and ".join([", ".join(kinds[:-1]), kinds[-1]] if len(kinds) > 1 else kinds)


def _kinds(node: Plugin) -> Iterator[str]:
    """Yield the kinds of one BSDF that is smooth enough; no other node has any."""
    if isinstance(node, Principled):
        yield from _kinds_of_principled(node)
    elif isinstance(node, Dielectric) and _is_smooth(node):
        yield "glass"
    elif isinstance(node, Conductor) and _is_smooth(node):
        yield "rough metal" if isinstance(node, RoughConductor) else "mirrors"
    elif isinstance(node, Plastic | PPlastic) and _is_smooth(node):
        yield "plastics"


def _kinds_of_principled(node: Principled) -> Iterator[str]:
    if node.clearcoat != 0.0:
        yield "clear coats"
    if isinstance(node.roughness, float) and node.roughness**2 > _ROUGHEST:
        return
    kinds = [kind for share, kind in ((node.spec_trans, "glass"), (node.metallic, "rough metal")) if share != 0.0]
    yield from kinds or ["glossy surfaces"]


def _is_smooth(node: BsdfPlugin) -> bool:
    """Tell whether a BSDF may be smooth enough to focus light; a texture of its roughness may have any value."""
    if isinstance(node, RoughConductor | RoughDielectric | PPlastic):
        return any(not isinstance(alpha, float) or alpha <= _ROUGHEST for alpha in node.alphas)
    return not isinstance(node, RoughPlastic) or node.alpha <= _ROUGHEST
