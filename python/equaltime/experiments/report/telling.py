"""Cells of tables that give no answer, such as dashes and "unknown", and the sentences that say so once."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report.footnotes import merged
from equaltime.experiments.report.words import Cell
from equaltime.statistics.curves import ERROR_OF, ERRORS_OF, TOO_NOISY
from equaltime.statistics.intervals import UNKNOWN, Interval

__all__ = [
    "DASH",
    "NO_COMMON_MEAN",
    "column_says_something",
    "commands",
    "is_quick",
    "says_slower",
    "silenced",
    "unsaid",
]

DASH = "\N{EN DASH}"
_BIASED = re.compile("biased, not extrapolated|its bias is larger")
"""Part of the note of a time that a biased strategy does not reach."""
_NOISY = re.compile(f"{ERROR_OF} .*{re.escape(TOO_NOISY)}")
"""Remark on a time that is not given because of the reference's noise; its number differs from scene to scene."""
NO_COMMON_MEAN = "speed-ups of typical runs and of mean errors have no common mean"
"""Remark on a geometric mean over scenes whose speed-ups are of two kinds."""
_NOT_KNOWN = ("unknown", "cannot tell", "not trusted", "not reached", "never")


def commands(summary: Summary) -> tuple[str, ...]:
    """Return the command lines that made an experiment, each once; empty if it was made from Python."""
    sessions = summary.provenance.get("sessions", {})
    found = [summary.provenance.get("command"), *(session.get("command") for session in sessions.values())]
    return tuple(dict.fromkeys(str(command) for command in found if command))


def is_quick(summary: Summary) -> bool:
    """Tell whether an experiment was shrunk for a first look (``--quick``)."""
    return any("--quick" in command.split() for command in commands(summary))


def says_slower(scene: SceneResult, target: float, time: Interval) -> bool:
    """Tell whether the lower limit of a time to the error ``target`` is longer than another strategy's known time.

    If so, the other strategy is faster, and the limit is worth printing.
    """
    others = (strategy.time_to.get(target, UNKNOWN) for strategy in scene.strategies)
    return any(other.trusted and 0.0 < other.high < time.low for other in others)


def _is_silent(cell: Cell) -> bool:
    return cell.state != "trusted" and cell.text in (DASH, *_NOT_KNOWN)


def _answers(cell: Cell) -> bool:
    """Tell whether a cell has a number or a word that answers; a remark on another number does not."""
    return cell.state in ("trusted", "untrusted") and not _is_silent(cell)


def column_says_something(cells: Iterable[tuple[Cell, ...]]) -> bool:
    """Tell whether any cell of a table's column holds an answer, such as a number; dashes and "unknown" are none."""
    return any(_answers(cell) for several in cells for cell in several)


def silenced(cells: tuple[Cell, ...]) -> tuple[Cell, ...]:
    """Return the numbers of a table's cell that hold an answer, without those such as "unknown".

    If no number is left, a dash takes its place; the page shows the reason when the pointer is on the dash.
    """
    telling = tuple(cell for cell in cells if not _is_silent(cell))
    if any(map(_answers, telling)):
        return telling
    known = cells[0].text == DASH
    return (cells[0] if known else replace(cells[0], text=DASH, interval="", state="silent"), *telling)


def unsaid(names: Iterable[str], dashes: bool, quick: bool, cells: Iterable[Cell]) -> str:
    """Return a sentence that tells which columns a table leaves out, and why; empty if it shows every number.

    ``names`` are the headings of the left-out columns. ``dashes`` tells whether a cell shows a dash instead of its
    number, and ``quick`` whether longer runs would give more numbers. ``cells`` are all cells of the table, also in
    left-out columns: their notes give the reasons.
    """
    listed = ", ".join(names)
    silent = [cell.note for cell in cells if _is_silent(cell)]
    if any("heavy tail" in note for note in silent):
        why = "these runs cannot tell, where rare events make most of an error"
    else:
        why = "these runs are too short to tell; run without --quick" if quick else "these runs cannot tell"
    if any(NO_COMMON_MEAN in note for note in silent):
        why += f"; {NO_COMMON_MEAN}"
    if any(_BIASED.search(note) for note in silent):
        why += "; biased strategies may never reach an error, and are not extrapolated"
    if noisy := [remark for note in silent for remark in note.split("; ") if _NOISY.match(remark)]:
        told = merged(noisy)
        why += f"; {told if told in noisy else told.replace(ERROR_OF, ERRORS_OF)}"
    if not listed:
        return f"{DASH}: {why}." if dashes else ""
    return f"Left out ({listed}){f', and {DASH}' if dashes else ''}: {why}."
