"""The table of an experiment's results as LaTeX, for a paper: it needs the package booktabs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.telling import DASH
from equaltime.experiments.report.words import (
    AT_LEAST,
    AT_MOST,
    DISAGREEING,
    EARLY,
    ERROR_UNIT,
    EXTRAPOLATED,
    LESS_THAN,
    MEDIAN,
    MORE_THAN,
    NOT_REACHED,
    RISEN,
    Cell,
    Unit,
    column_unit,
    in_brackets_stands,
    known_gains,
    marked,
    meanings,
    measured_cell,
    percent,
    ratio_cell,
    seconds,
    seconds_cell,
)
from equaltime.files import replacing
from equaltime.statistics.intervals import TELLING, UNKNOWN, Interval

__all__ = ["latex_table", "write_latex"]

_LATEX: Final[Mapping[str, str]] = {
    "\\": r"\textbackslash{}",
    **{character: rf"\{character}" for character in "%&#_${}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "\N{NARROW NO-BREAK SPACE}": r"\,",
    "\N{GREATER-THAN OR EQUAL TO}": r"$\ge$",
    "\N{LESS-THAN OR EQUAL TO}": r"$\le$",
    "<": "$<$",
    ">": "$>$",
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{MINUS SIGN}": "$-$",
    "\N{EN DASH}": "--",
    "\N{ASTERISK OPERATOR}": "$^*$",
    "\N{DAGGER}": r"$^\dagger$",
    "\N{DOUBLE DAGGER}": r"$^\ddagger$",
    "\N{SECTION SIGN}": r"$^\S$",
}
_STAR: Final = "\N{ASTERISK OPERATOR}"
_TIMES: Final = "\N{MULTIPLICATION SIGN}"
_MARKS: Final = {EXTRAPOLATED: _STAR, **{mark: mark.strip() for mark in (MEDIAN, EARLY, RISEN)}}
"""Marks after numbers, each without the space before it; the star is not one that a label may have."""
_BOUNDS: Final = (AT_LEAST, AT_MOST, LESS_THAN, MORE_THAN)


_Column = tuple[Literal["time", "speed-up"], float]
"""Column after the error at equal time: what it has, and the target error that it is for."""
_Units = Mapping[float, Unit | None]
"""Unit of the times to each target; None if each time has its own."""


def latex_table(summary: Summary) -> str:
    """Return a table with a row for each strategy of each scene: error at equal time, times and speed-ups.

    Each target error has a column of times and one of speed-ups over the scene's baseline. Columns without any number
    are left out, and a note names them. All errors are in per cent, and all times of a column are in the unit that its
    heading has. If a column's times span more than a factor of 10,000, each has its own unit. Numbers have their 95 %
    intervals in brackets, as in the report. If only one end of an interval can be trusted, it stands as a bound; a dash
    stands for a number that is not known. A row below each scene gives its size, its repeats and the error of its
    reference. Notes below the table explain the marks that it has, such as the star of extrapolated numbers.

    Headings have two lines, and notes are broken at the width of a line. All is one box, which may stand in a float or
    in a ``resizebox``.
    """
    units = {target: column_unit(_times(summary, target)) for target in summary.targets}
    compared = any(one.label != scene.baseline for scene in summary.scenes for one in scene.strategies)
    every: list[_Column] = [("time", target) for target in units]
    every += [("speed-up", target) for target in units] * compared
    columns = [column for column in every if _is_known(summary, column, units)]
    told = [cell for scene in summary.scenes for row in _rows(scene, columns, units) for cell in row]
    width = 2 + len(columns)
    lines = [
        f"% {summary.title}: error after the same time, time to an error, and speed-up, with 95 % intervals",
        r"{\footnotesize\setlength{\tabcolsep}{4pt}%",
        r"\begin{tabular}{@{}c@{}}",
        rf"\begin{{tabular}}{{@{{}}l{'r' * (width - 1)}@{{}}}}",
        r"\toprule",
    ]
    for number, scene in enumerate(summary.scenes):
        lines += [r"\midrule"] * (number > 0)
        lines += [_headings(_titles(scene, columns, units)), r"\midrule", *map(_row, _rows(scene, columns, units))]
        lines.append(_across(_conditions(scene), width))
    left_out = [f"{what} to {percent(target)}" for what, target in every if (what, target) not in columns]
    notes = [rf"{_escaped(note)}\par" for note in _notes(told, left_out, known_gains(summary))]
    lines += [r"\bottomrule", r"\end{tabular} \\[1ex]", r"\parbox{\linewidth}{\raggedright", *notes, r"}"]
    return "\n".join([*lines, r"\end{tabular}}", ""])


def write_latex(summary: Summary, path: Path) -> None:
    """Write the results of an experiment as a table in LaTeX to a file; the file's folder is made if missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part:
        part.write_text(latex_table(summary), encoding="utf-8")


def _times(summary: Summary, target: float) -> list[Interval]:
    """Return the times to the error ``target`` of all strategies on all scenes, in seconds."""
    return [one.time_to.get(target, UNKNOWN) for scene in summary.scenes for one in scene.strategies]


def _is_known(summary: Summary, column: _Column, units: _Units) -> bool:
    """Tell whether any cell of a column has a number; the baseline's speed-up of 1 is none."""
    cells = (
        _cell(scene, strategy, column, units)
        for scene in summary.scenes
        for strategy in scene.strategies
        if column[0] == "time" or strategy.label != scene.baseline
    )
    return any(cell != DASH for cell in cells)


def _titles(scene: SceneResult, columns: Sequence[_Column], units: _Units) -> tuple[str, ...]:
    """Return the headings of the columns; headings of numbers have two lines."""
    return (
        scene.name,
        f"error after\n{seconds(scene.budget_s)} [%]",
        *(_title(scene, column, units) for column in columns),
    )


def _title(scene: SceneResult, column: _Column, units: _Units) -> str:
    what, target = column
    if what == "speed-up":
        return f"speed-up over\n{scene.baseline} to {percent(target)}"
    unit = units[target]
    return f"time to\n{percent(target)}" + ("" if unit is None else f" [{unit.symbol.strip()}]")


def _rows(scene: SceneResult, columns: Sequence[_Column], units: _Units) -> Iterator[tuple[str, ...]]:
    """Yield the cells of each strategy."""
    for strategy in scene.strategies:
        error = strategy.error_at_budget
        told = marked(_text(measured_cell(error)).replace(ERROR_UNIT.symbol, ""), error)
        yield (strategy.named, told, *(_cell(scene, strategy, column, units) for column in columns))


def _cell(scene: SceneResult, strategy: StrategyResult, column: _Column, units: _Units) -> str:
    """Return a time without the unit that the heading has, or a speed-up over the baseline without its sign."""
    what, target = column
    if what == "time":
        time, unit = strategy.time_to.get(target, UNKNOWN), units[target]
        return marked(_text(seconds_cell(time, None if unit is None else replace(unit, symbol=""))), time)
    cell = ratio_cell(scene, strategy, target)
    text = cell.text if strategy.label == scene.baseline else _text(cell)
    return marked(text.replace(_TIMES, ""), strategy.ratio.get(target, UNKNOWN))


def _text(cell: Cell) -> str:
    told = cell.interval or cell.text in (NOT_REACHED, DISAGREEING) or cell.text.startswith(_BOUNDS)
    return str(cell) if told else DASH


def _conditions(scene: SceneResult) -> str:
    """Return the conditions of a scene's runs: size, number of repeats and error of the reference."""
    reference = f"reference {percent(scene.reference_error)} off" if scene.reference_error > 0.0 else "exact reference"
    repeats = max((strategy.repeats for strategy in scene.strategies), default=0)
    return f"{scene.size[0]}x{scene.size[1]} pixels, {repeats} repeats, {reference}"


def _notes(texts: Sequence[str], left_out: Sequence[str], gains: Sequence[str]) -> Iterator[str]:
    """Yield notes on brackets, on each mark of the cells ``texts``, on ``gains``, and on columns ``left_out``."""
    yield in_brackets_stands(texts)
    yield from (f"{mark.rstrip()}: {meaning}" for mark, meaning in meanings(texts).items())
    yield from gains
    if DASH in texts:
        yield f"{DASH}: unknown, not trusted, or both ends of the interval more than {TELLING:g} times off the number"
    if left_out:
        yield f"left out, since no number is known: {', '.join(left_out)}"


def _across(text: str, columns: int) -> str:
    """Return a row in small print over all columns."""
    return rf"\multicolumn{{{columns}}}{{@{{}}l}}{{\scriptsize {_escaped(text)}}} \\"


def _headings(titles: tuple[str, ...]) -> str:
    """Return a row of headings; each line of a heading is a row of a small table in its cell."""
    first, *others = titles
    stacked = (r" \\ ".join(map(_cell_text, one.splitlines())) for one in others)
    boxes = (rf"\begin{{tabular}}[b]{{@{{}}r@{{}}}}{lines}\end{{tabular}}" for lines in stacked)
    return " & ".join((_cell_text(first), *boxes)) + r" \\"


def _row(texts: tuple[str, ...]) -> str:
    return " & ".join(map(_cell_text, texts)) + r" \\"


def _cell_text(text: str) -> str:
    """Return a text as a cell. LaTeX would take a bracket or a star at its start for an argument of the row above."""
    return "{}" * text.startswith(("[", "*")) + _escaped(text)


def _escaped(text: str) -> str:
    for mark, sign in _MARKS.items():
        text = text.replace(mark, sign)
    return "".join(_LATEX.get(character, character) for character in text)
