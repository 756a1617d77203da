"""Tables that ``equaltime cost`` prints at its end: errors at equal time, times to an error, the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from equaltime.cli.messages import plain_console
from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.statistics.intervals import Interval

__all__ = ["print_summary"]

_REPORT = "report.html"
_MOST_TARGETS = 2
_EXTRAPOLATED = " *"
_ANY_WIDTH = 1000


def print_summary(summary: Summary, folder: Path) -> None:
    """Print one table per scene, the paths of report and records in ``folder``, and the verdict in one sentence."""
    console = plain_console()
    if not console.is_terminal:
        console.width = _ANY_WIDTH
    for scene in summary.scenes:
        if len(summary.scenes) > 1:
            console.print(scene.name, style="bold")
        console.print(table := _fitting(scene, summary.targets, console.width))
        if any(str(cell).endswith(_EXTRAPOLATED) for column in table.columns for cell in column.cells):
            console.print(f"{_EXTRAPOLATED.strip()} extrapolated beyond the runs", style="dim")
        if scene.other_depth:
            console.print(f"errors and times are of {scene.other_depth}", soft_wrap=True)
        if scene.reference_caveat:
            console.print(f"note: {scene.reference_caveat}", style="dim", soft_wrap=True)
        for label, reason in _without_error(scene):
            console.print(f"{label}: {reason}", style="dim")
    console.print(f"wrote {folder / _REPORT} and {folder / 'records.csv'}", style="dim", soft_wrap=True)
    print(summary.verdict)


def _without_error(scene: SceneResult) -> Iterator[tuple[str, str]]:
    """Yield the strategies that are left out or lack an interval of the error at equal time, with the reason."""
    yield from scene.left_out
    for result in scene.strategies:
        if not result.error_at_budget.trusted and result.error_at_budget.note:
            yield result.label, result.error_at_budget.note


def _fitting(scene: SceneResult, targets: tuple[float, ...], width: int) -> Table:
    """Return the table with as many columns of times as fit the width; a truncated number would mislead."""
    anywhere = plain_console()
    anywhere.width = _ANY_WIDTH
    for most in range(_MOST_TARGETS, 0, -1):
        table = _table(scene, targets, most)
        if anywhere.measure(table).maximum <= width:
            return table
    return _table(scene, targets, 0)


def _table(scene: SceneResult, targets: tuple[float, ...], most: int) -> Table:
    """Return errors at equal time, and times to up to ``most`` targets that most strategies have trusted times for.

    Of several such targets the smallest are chosen.
    """
    from equaltime.experiments.report.words import error_cell, percent, seconds, seconds_cell

    cells = {target: [seconds_cell(result.time_to[target]) for result in scene.strategies] for target in targets}
    counts = {target: sum(cell.state == "trusted" for cell in cells[target]) for target in targets}
    known = [target for target in targets if counts[target] == max(counts.values()) > 0]
    known = known[max(0, len(known) - most) :]
    table = Table(box=None, pad_edge=False)
    table.add_column("strategy", overflow="fold", min_width=12)
    table.add_column(f"error in {seconds(scene.budget_s)}", justify="right", no_wrap=True)
    for target in known:
        table.add_column(f"time to {percent(target)}", justify="right", no_wrap=True)
    for number, result in enumerate(scene.strategies):
        times = (_marked(cells[target][number], result.time_to[target]) for target in known)
        table.add_row(result.label, str(error_cell(result.error_at_budget)), *times)
    return table


def _marked(cell: object, time: Interval) -> str:
    return f"{cell}{_EXTRAPOLATED}" if time.reach > 1.0 and time.trusted else str(cell)
