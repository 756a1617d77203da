"""Table of measured numbers beside published ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from equaltime.experiments.model.summary import Beside, Summary
from equaltime.experiments.model.theirs import Quantity
from equaltime.experiments.report.views import Row, Table
from equaltime.experiments.report.words import (
    Cell,
    error_cell,
    factor_cell,
    percent,
    plain_cell,
    probability_cell,
    samples_cell,
    seconds_cell,
)
from equaltime.statistics.intervals import Interval

__all__ = ["beside_table"]

_CELLS: Mapping[Quantity, Callable[[Interval], Cell]] = {
    "slope": plain_cell,
    "speed-up": factor_cell,
    "efficiency": factor_cell,
    "fewer samples": factor_cell,
    "time": seconds_cell,
    "samples": samples_cell,
    "time of a sample": factor_cell,
    "error": error_cell,
    "last error": error_cell,
    "bias": error_cell,
    "p": lambda interval: probability_cell(interval.value if interval.known else None, interval.note),
}


def beside_table(slug: str, summary: Summary) -> Table | None:
    """Tabulate published and measured numbers; None if the summary compares none."""
    if not summary.beside:
        return None
    rows = tuple(_row(line, len(summary.scenes) > 1) for line in summary.beside)
    said = any(line.theirs for line in summary.beside)
    columns = ("they say", "we measure") if said else ("we measure",)
    if not said:
        rows = tuple(Row(row.label, None, (), row.cells[1:], row.title) for row in rows)
    return Table(f"{slug}-beside", "", "", columns, rows)


def _row(line: Beside, several: bool) -> Row:
    place = [line.scene] if several else []
    if line.target is not None:
        place.append(f"at {percent(line.target)}")
    theirs = Cell(line.theirs or "\N{EN DASH}", state="trusted" if line.theirs else "unknown")
    ours = _CELLS[line.quantity](line.value)
    note = (Cell(", ".join(place), state="unknown"),) if place else ()
    return Row(line.what, None, (), ((theirs,), (ours, *note)), f"{line.quantity}: {line.strategy}")
