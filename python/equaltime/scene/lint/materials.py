"""Checks for hazards of materials and media.

The hazards are surfaces that reflect nearly all light, textures with values out of range, media too dense for single
precision, and cameras inside a medium.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.checks import of_mesh, of_textures
from equaltime.scene.compile_media import sees_media
from equaltime.scene.geometry import MeshSurface, SphereSurface
from equaltime.scene.lint.facts import Finding, first_places
from equaltime.scene.lint.parts import LintScene, Part
from equaltime.scene.model import Diffuse, Medium, Plugin

__all__ = ["check_materials", "check_media"]

Array = NDArray[np.float64]

WHITE: Final = 0.999
"""Reflectance above which a path needs about a thousand bounces to lose its throughput."""


def check_materials(world: LintScene) -> Iterator[Finding]:
    """Yield findings for surfaces of `world` that reflect nearly all light, and for textures with values out of range.

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
            f"values outside the range of their parameters: {count:,}; they range from {least:.4g} to {most:.4g}",
            first_places(f"{name} as {outside.name} of {world.called(outside.node)}" for outside, name in found),
            count,
            "uses the values unchanged, so that surfaces may create energy",
            "scale the image into [0, 1], or set raw where the values are not colours",
        )


# -- media -------------------------------------------------------------------------------------------------------------

SHORTEST: Final = 1e-7
"""Shortest mean free path that is accepted, as a fraction of the scene's extent. The core has the same limit."""


def check_media(world: LintScene) -> Iterator[Finding]:
    """Yield findings for media that are too dense, and for a medium around the camera that the sensor does not name."""
    yield from _dense(world)
    yield from _around_camera(world)


def _dense(world: LintScene) -> Iterator[Finding]:
    """Find media whose mean free path is too short compared with the extent of the scene."""
    extent = _extent(world)
    if extent == 0.0 or not sees_media(world.scene.model.integrator):
        return
    media = {id(node): node for node in world.scene.model.nodes() if isinstance(node, Medium)}
    shares = {node: 1.0 / (densest * extent) for node in media.values() if (densest := _densest(node)) > 0.0}
    found = [node for node, share in shares.items() if share < SHORTEST]
    if found:
        least = min(shares[node] for node in found)
        yield Finding(
            "dense-media",
            "warning",
            f"media with a mean free path below {SHORTEST:.0e} of the scene's extent: {len(found)}; "
            f"the shortest: {least:.3g} of the scene",
            first_places(world.called(node) for node in found),
            len(found),
            "refuses them: single precision leaves shapes and lights many mean free paths from where they are",
            "lower sigma_t or scale (a body many mean free paths thick looks the same), leave out what is far away, or "
            "give the shape an opaque BSDF",
        )


def _densest(medium: Medium) -> float:
    return max(medium.scale * sigma for sigma in medium.sigma_t)


def _extent(world: LintScene) -> float:
    """Return the longest side of the scene's bounds; 0 if it has instances, or if meshes were skipped."""
    if not world.parts or world.skipped or any(part.grouped for part in world.parts):
        return 0.0
    corners = np.array([part.bounds for part in world.parts])
    return float((corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0)).max())


def _around_camera(world: LintScene) -> Iterator[Finding]:
    """Find shapes with an interior medium that contain the camera, while the sensor names no medium."""
    model = world.scene.model
    if model.sensor.medium is not None or not sees_media(model.integrator):
        return
    filled = [part for part in world.parts if part.shape.interior is not None and _holds(part, world.camera)]
    if filled:
        yield Finding(
            "camera-in-medium",
            "note",
            f"shapes around the camera with a medium that the sensor does not name: {len(filled)}",
            first_places(part.name for part in filled),
            len(filled),
            "begins paths in the medium; Mitsuba begins them in vacuum, and renders another image",
            "name the medium in the sensor: then both begin paths in it",
        )


def _holds(part: Part, point: Array) -> bool:
    """Tell whether a point is inside a sphere or a mesh."""
    if part.grouped:  # its coordinates are in the group's own space
        return False
    if isinstance(part.surface, SphereSurface):
        return bool(np.linalg.norm(point - part.surface.center) < part.surface.radius)
    return isinstance(part.surface, MeshSurface) and abs(_winding(part.surface, point)) > 0.5


def _winding(mesh: MeshSurface, point: Array) -> float:
    """Return the winding number of a mesh about a point: its signed solid angle divided by 4 pi.

    The solid angles are computed triangle by triangle, as by van Oosterom & Strackee (1983).
    """
    corners = mesh.vertices[mesh.faces] - point
    a, b, c = np.moveaxis(corners, 1, 0)
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    around = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2(volume, around).sum() / (2.0 * np.pi))
