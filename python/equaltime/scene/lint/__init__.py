"""Lint: the hazards of a scene, reported before it renders.

Each module looks at one kind: `surfaces` (triangles, their orientation, gaps), `lights`, `materials`, `media`, `extent`
(size and place), `camera`. A scene that cannot be rendered at all is an error of loading: for example one with a
duplicate id, or with a vertex that is not finite. Repairs by the readers of files are among the findings. ``fast``
skips whatever takes longer than a render should wait for: meshes beyond some ten thousand triangles, and texels.
"""

from __future__ import annotations

import numpy as np

from equaltime.scene.lint.camera import check_camera
from equaltime.scene.lint.extent import check_extent
from equaltime.scene.lint.facts import Finding, Severity, first_places
from equaltime.scene.lint.lights import check_lights
from equaltime.scene.lint.materials import check_materials
from equaltime.scene.lint.media import check_media
from equaltime.scene.lint.parts import World
from equaltime.scene.lint.surfaces import check_surfaces
from equaltime.scene.scene import Scene

__all__ = ["Finding", "Severity", "lint"]


def lint(scene: Scene, *, fast: bool = False) -> tuple[Finding, ...]:
    """Return the hazards of a scene, warnings first; raises SceneError or ValueError if a file is gone."""
    with np.errstate(all="ignore"):  # overflow is not among the hazards, and NumPy's warnings would not help the user
        world = World(scene, fast=fast)
        found = [
            *check_surfaces(world),
            *check_extent(world),
            *check_lights(world),
            *check_materials(world),
            *check_media(world),
            *check_camera(world),
            *_mended(scene),
        ]
    return tuple(sorted(found, key=lambda finding: finding.severity != "warning"))


def _mended(scene: Scene) -> list[Finding]:
    """Return a note on the repairs by the readers of files, if there are any."""
    if not scene.warnings:
        return []
    return [
        Finding(
            "mended-files",
            "note",
            f"things that were mended or replaced while reading files: {len(scene.warnings)}",
            first_places(scene.warnings),
            len(scene.warnings),
            "goes on with what was mended",
            "write the files anew without what is named",
        )
    ]
