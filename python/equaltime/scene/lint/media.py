"""Checks for hazards of media: densities that are too large for rays in single precision."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from equaltime.scene.compile_media import sees_media
from equaltime.scene.lint.facts import Finding, first_places
from equaltime.scene.lint.parts import LintScene
from equaltime.scene.model import Medium

__all__ = ["check_media"]

SHORTEST: Final = 1e-7
"""Shortest mean free path that is accepted, as a fraction of the scene's extent. The core has the same limit."""


def check_media(world: LintScene) -> Iterator[Finding]:
    """Yield a finding for media whose mean free path is too short compared with the extent of the scene."""
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
