"""The command ``equaltime lint``: lists hazards of a scene."""

from __future__ import annotations

from collections.abc import Sequence

from equaltime.cli.messages import MOST_LINES, lint_command, once_each, print_aside, print_json, print_lines
from equaltime.cli.options import AsJson, Define, SceneFile, Substitute, Verbose, parse_definitions
from equaltime.scene import Scene, load_file
from equaltime.scene.lint import FILE_REMARKS, Finding
from equaltime.scene.lint import lint as hazards

__all__ = ["lint", "print_hazards", "summary"]

_CHECKED = "lights, camera, geometry, materials, files"


def lint(
    scene: SceneFile,
    define: Define = None,
    substitute: Substitute = False,
    as_json: AsJson = False,
    verbose: Verbose = False,
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
        print_lines(_everything(findings, scene.name) if verbose else _short(findings, scene.name))
    return 1 if warnings else 0


def print_hazards(scene: Scene) -> tuple[Finding, ...]:
    """Run the fast checks of a scene for likely mistakes, and return their findings.

    Prints one line to stderr if there are findings. Returns no findings for a scene that cannot be checked.
    """
    try:
        findings = tuple(finding for finding in hazards(scene, fast=True) if finding.check != FILE_REMARKS)
    except ValueError:
        return ()  # the build of the scene reports it
    if told := summary(findings):
        print_aside(f"lint: {told}; see {lint_command(scene)}")
    return findings


def summary(findings: Sequence[Finding]) -> str:
    """Return one line that counts the warnings and notes of `lint` and names their checks; empty without findings."""
    told = []
    for severity in ("warning", "note"):
        checks = [finding.check for finding in findings if finding.severity == severity]
        if checks:
            told.append(f"{len(checks)} {severity}{'s' * (len(checks) != 1)} ({', '.join(checks)})")
    return ", ".join(told)


def _answer(findings: Sequence[Finding], name: str) -> str:
    """Return the first line: whether the scene has problems, and of which kinds."""
    if not findings:
        return f"No problems in {name} (checked: {_CHECKED})."
    if any(finding.severity == "warning" for finding in findings):
        return f"Problems in {name} that may make the image wrong or slow: {summary(findings)}."
    return f"No problems in {name} that make the image wrong: {summary(findings)}."


def _short(findings: Sequence[Finding], name: str) -> list[str]:
    """Return the answer and a line for each finding, warnings first; notes only if there is room for all of them."""
    warnings = [line for finding in findings if finding.severity == "warning" for line in _lines(finding)]
    notes = [line for finding in findings if finding.severity == "note" for line in _lines(finding)]
    room = MOST_LINES - 2
    shown = [*warnings, *notes] if len(warnings) + len(notes) <= room else warnings[:room]
    left = len(warnings) + len(notes) - len(shown)
    more = f"{left} more lines, " if left else ""
    last = [f"-v shows {more}all places, and what equaltime does about them"] if findings else []
    return [_answer(findings, name), *shown, *last]


def _lines(finding: Finding) -> list[str]:
    """Return a line with the finding, its first place and what to do; a line for each kind of remark on the files."""
    if finding.check == FILE_REMARKS:
        return [f"{finding.severity}: {place}" for place in once_each(finding.where)]
    others = len(finding.where) - 1
    place = f", at {finding.where[0]}" if finding.where else ""
    more = f" and {others} other {'place' if others == 1 else 'places'}" if others > 0 else ""
    return [f"{finding.severity}: {finding.what}{place}{more}. You can: {finding.advice}."]


def _everything(findings: Sequence[Finding], name: str) -> list[str]:
    lines = [_answer(findings, name)]
    for finding in findings:
        lines += ["", f"{finding.severity}: {finding.check}: {finding.what}"]
        at = "" if finding.check == FILE_REMARKS else "at "
        lines += [f"  {at}{place}" for place in finding.where]
        lines += [f"  equaltime {finding.becomes}", f"  you can: {finding.advice}"]
    return lines
