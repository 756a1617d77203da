"""Checks for hazards of materials: surfaces that reflect nearly all light, and textures with values out of range."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from equaltime.scene.checks import of_mesh, of_textures
from equaltime.scene.lint.facts import Finding, first_places
from equaltime.scene.lint.parts import LintScene
from equaltime.scene.model import Diffuse, Plugin

__all__ = ["check_materials"]

WHITE: Final = 0.999
"""Reflectance above which a path needs about a thousand bounces to lose its throughput."""


def check_materials(world: LintScene) -> Iterator[Finding]:
    """Yield findings for surfaces that reflect nearly all light, and for textures with values out of range.

    Such surfaces are reported only if the scene sets no limit on the path length. The range is that of the parameter
    that uses the texture.
    """
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


def _textures(world: LintScene, nodes: list[Plugin]) -> Iterator[Finding]:
    """Find numbers of textures and meshes that are out of the range of the parameters that use them."""
    assets = world.scene.assets
    shapes = [(shape, str(name)) for shape, name, _ in world.names.solids()]
    found = [(outside, world.called(outside.texture)) for node in nodes for outside in of_textures(node, assets)]
    found += [(outside, name) for shape, name in shapes for outside in of_mesh(shape, assets)]
    if found:
        count = sum(outside.count for outside, _ in found)
        least, most = min(outside.least for outside, _ in found), max(outside.most for outside, _ in found)
        yield Finding(
            "textures-out-of-range",
            "warning",
            f"numbers beyond what their parameters may be: {count:,}; they reach from {least:.4g} to {most:.4g}",
            first_places(f"{name} as {outside.name} of {world.called(outside.node)}" for outside, name in found),
            count,
            "takes reflectances as they are, so that surfaces make light or take more than there is",
            "scale the image into [0, 1], or set raw where the numbers are no colours",
        )
