"""The command ``equaltime lint``: lists hazards of a scene."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence

from equaltime.cli.messages import print_json
from equaltime.cli.options import AsJson, Define, SceneFile, Substitute, parse_definitions
from equaltime.scene import Scene, load_file
from equaltime.scene.lint import Finding
from equaltime.scene.lint import lint as hazards

__all__ = ["lint", "print_hazards", "summary"]


def lint(
    scene: SceneFile,
    define: Define = None,
    substitute: Substitute = False,
    as_json: AsJson = False,
) -> int:
    """List the hazards of a scene before it renders.

    Warnings name causes of a wrong image. Notes name problems that equaltime handles, or that may be intended. The exit
    code is 1 if there are warnings, else 0.
    """
    findings = hazards(load_file(scene, parse_definitions(define or ()), substitute=substitute))
    warnings = sum(finding.severity == "warning" for finding in findings)
    if as_json:
        data = {"scene": str(scene), "warnings": warnings, "notes": len(findings) - warnings}
        print_json({**data, "findings": findings})
    else:
        print("\n\n".join([*map(_told, findings), summary(findings) or "nothing found"]))
    return 1 if warnings else 0


def print_hazards(scene: Scene) -> tuple[Finding, ...]:
    """Run the fast checks of a scene, and return their findings.

    Prints one line to stderr if there are findings. Returns no findings for a scene that cannot be checked.
    """
    try:
        findings = tuple(finding for finding in hazards(scene, fast=True) if finding.check != "mended-files")
    except ValueError:
        return ()  # the build of the scene reports it
    if told := summary(findings):
        more = shlex.join(("equaltime", "lint", str(scene.source))) if scene.source else "equaltime lint"
        print(f"lint: {told}; see {more}", file=sys.stderr)
    return findings


def summary(findings: Sequence[Finding]) -> str:
    """Return one line that counts warnings and notes and names their checks; empty without findings."""
    told = []
    for severity in ("warning", "note"):
        checks = [finding.check for finding in findings if finding.severity == severity]
        if checks:
            told.append(f"{len(checks)} {severity}{'s' * (len(checks) != 1)} ({', '.join(checks)})")
    return ", ".join(told)


def _told(finding: Finding) -> str:
    lines = [f"{finding.severity}: {finding.check}: {finding.what}"]
    lines += [f"  at {place}" for place in finding.where]
    return "\n".join([*lines, f"  equaltime {finding.becomes}", f"  you can: {finding.advice}"])
