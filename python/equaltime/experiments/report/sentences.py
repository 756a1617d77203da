"""Facts about scenes and provenance as text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report.words import percent, seconds

__all__ = ["facts", "provenance_groups"]


def facts(scene: SceneResult) -> str:
    """Return a sentence on a scene's size, depth, reference, repeats and equal time."""
    width, height = scene.size
    depth = "paths of any length" if scene.max_depth < 0 else f"max_depth {scene.max_depth}"
    if scene.other_depth:
        depth += f" ({scene.other_depth.partition('; ')[2]})"
    repeats = {strategy.repeats for strategy in scene.strategies}
    counted = f"{min(repeats)} to {max(repeats)}" if len(repeats) > 1 else str(*repeats)
    note = f" Note: {scene.reference_caveat}." if scene.reference_caveat else ""
    return (
        f"{width}\N{MULTIPLICATION SIGN}{height} pixels, {depth}; {_against(scene)}; {counted} repeats of each "
        f"strategy; equal time is {seconds(scene.budget_s)}.{note}"
    )


def _against(scene: SceneResult) -> str:
    """Describe the reference; a reference with a caveat is never called the exact truth."""
    if scene.reference_error:
        return f"reference with an error of {percent(scene.reference_error)}"
    return "reference without a stated error" if scene.reference_caveat else "exact truth"


def provenance_groups(summary: Summary) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the facts needed to repeat the experiment: headings, each with the rows of a table."""
    groups: dict[str, list[tuple[str, str]]] = {"": []}
    _sort_into(groups, "", summary.provenance)
    groups["digests of the scenes"] = [(scene.name, scene.digest) for scene in summary.scenes]
    names = {(strategy.label, strategy.name): None for scene in summary.scenes for strategy in scene.strategies}
    groups["strategies"] = list(names)
    return [(heading, rows) for heading, rows in groups.items() if rows]


def _sort_into(groups: dict[str, list[tuple[str, str]]], heading: str, facts: Mapping[Any, Any]) -> None:
    """Put the plain facts of a table under its heading, and each nested table under its own heading."""
    for key, value in facts.items():
        if isinstance(value, Mapping):
            _sort_into(groups, f"{heading} / {key}" if heading else str(key), value)
        else:
            groups.setdefault(heading, []).append((str(key), _text(value)))


def _text(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)
