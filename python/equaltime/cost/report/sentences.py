"""Facts in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from equaltime.cost.report.words import percent, seconds
from equaltime.cost.summary import SceneResult, Summary

__all__ = ["facts", "provenance_rows"]


def facts(scene: SceneResult) -> str:
    """Say what was rendered and against what it was measured."""
    width, height = scene.size
    depth = "paths of any length" if scene.max_depth < 0 else f"max_depth {scene.max_depth}"
    against = f"reference with an error of {percent(scene.reference_error)}" if scene.reference_error else "exact truth"
    repeats = {strategy.repeats for strategy in scene.strategies}
    counted = f"{min(repeats)} to {max(repeats)}" if len(repeats) > 1 else str(*repeats)
    return (
        f"{width}\N{MULTIPLICATION SIGN}{height} pixels, {depth}; {against}; {counted} repeats of each strategy; "
        f"equal time is {seconds(scene.budget_s)}."
    )


def provenance_rows(summary: Summary) -> list[tuple[str, str]]:
    """Return what a reader needs to repeat it all, as rows of a table."""
    rows = list(_flat("", summary.provenance))
    for scene in summary.scenes:
        rows.append((f"digest of {scene.name}", scene.digest))
    names = {(strategy.label, strategy.name) for scene in summary.scenes for strategy in scene.strategies}
    rows.extend((f"strategy {label}", name) for label, name in sorted(names))
    return rows


def _flat(prefix: str, value: Any) -> Iterator[tuple[str, str]]:
    """Take nested tables apart into rows."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(f"{prefix} {key}".lstrip(), inner)
    elif isinstance(value, (list, tuple)) and any(isinstance(inner, (Mapping, list, tuple)) for inner in value):
        for number, inner in enumerate(value, 1):
            yield from _flat(f"{prefix} {number}", inner)
    elif isinstance(value, (list, tuple)):
        yield prefix, ", ".join(map(str, value))
    else:
        yield prefix, str(value)
