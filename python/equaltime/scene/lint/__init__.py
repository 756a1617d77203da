"""Lint: the hazards of a scene, told before it renders.

Each module looks at one kind: `surfaces` (triangles, their facing, what closes), `lights`, `materials`, `media`,
`extent` (size and place), `camera`. What cannot be rendered at all, such as an id that is taken twice or a vertex that
is no number, is an error of loading and told there; what the readers of files mended is among the findings here.
``fast`` leaves out what takes longer than a render should wait for: meshes beyond some ten thousand triangles, and
texels.
"""

from __future__ import annotations

import numpy as np

from equaltime.scene.lint.camera import check_camera
from equaltime.scene.lint.extent import check_extent
from equaltime.scene.lint.finding import Finding, Severity, first_places
from equaltime.scene.lint.lights import check_lights
from equaltime.scene.lint.materials import check_materials
from equaltime.scene.lint.media import check_media
from equaltime.scene.lint.parts import World
from equaltime.scene.lint.surfaces import check_surfaces
from equaltime.scene.scene import Scene

__all__ = ["Finding", "Severity", "lint"]


def lint(scene: Scene, *, fast: bool = False) -> tuple[Finding, ...]:
    """Return the hazards of a scene, warnings first; raises SceneError or ValueError for a file that is gone."""
    with np.errstate(all="ignore"):  # what overflows is no hazard that is known, and NumPy's words help nobody
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
    """Return what the readers of files had to mend."""
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
