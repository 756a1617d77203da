"""Lint: checks a scene for hazards before the render, such as lights without power or meshes with gaps.

Each module checks one group of hazards: `surfaces` (triangles, orientation, gaps, rounding), `lights`, and
`materials` (with media). A scene that cannot be rendered at all is refused when it is loaded: for
example a scene with a duplicate id, or with a vertex that is not finite. Remarks of the readers of files are reported,
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

__all__ = ["FILE_REMARKS", "Finding", "Severity", "lint"]

FILE_REMARKS = "file-remarks"
"""Name of the check that lists what the readers of files told. Its places are whole remarks."""


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
            *_remarks(scene),
        ]
    return tuple(sorted(found, key=lambda finding: finding.severity != "warning"))


def _remarks(scene: Scene) -> list[Finding]:
    """Return a note with all remarks by the readers of files: on choices, additions, replacements and repairs."""
    if not scene.warnings:
        return []
    return [
        Finding(
            FILE_REMARKS,
            "note",
            f"remarks while reading files: {len(scene.warnings)}",
            first_places(scene.warnings),
            len(scene.warnings),
            "renders the scene as these lines say",
            "change the files or give the named definitions, if you want something else",
        )
    ]
