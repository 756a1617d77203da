"""Lint: checks a scene for hazards before the render, such as lights without power or meshes with gaps.

Each module checks one group of hazards: `surfaces` (triangles, orientation, gaps, rounding), `lights`, and
`materials` (with media). A scene that cannot be rendered at all is refused when it is loaded: for
example a scene with a duplicate id, or with a vertex that is not finite. Repairs made while reading files are reported,
too.

The option ``fast`` skips checks that would delay a render: meshes beyond 10 000 triangles in total, and the values of
textures.
"""

from __future__ import annotations

import numpy as np

from equaltime.scene.lint.facts import Finding, Severity, first_places
from equaltime.scene.lint.lights import check_lights
from equaltime.scene.lint.materials import check_materials, check_media
from equaltime.scene.lint.parts import LintScene
from equaltime.scene.lint.surfaces import check_surfaces
from equaltime.scene.scene import Scene

__all__ = ["Finding", "Severity", "lint"]


def lint(scene: Scene, *, fast: bool = False) -> tuple[Finding, ...]:
    """Return the hazards found in a scene as findings, warnings first. `fast` skips slow checks.

    Raises SceneError or ValueError if a file of the scene no longer exists.
    """
    with np.errstate(all="ignore"):  # overflow is not among the hazards, and NumPy's warnings would not help the user
        world = LintScene(scene, fast=fast)
        found = [
            *check_surfaces(world),
            *check_lights(world),
            *check_materials(world),
            *check_media(world),
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
            f"repairs and replacements while reading files: {len(scene.warnings)}",
            first_places(scene.warnings),
            len(scene.warnings),
            "uses the repaired data",
            "correct the named places in the files",
        )
    ]
