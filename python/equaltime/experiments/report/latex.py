"""The table of an experiment's results as LaTeX, for a paper: it needs the package booktabs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.telling import DASH
from equaltime.experiments.report.words import (
    DISAGREEING,
    ERROR_UNIT,
    EXTRAPOLATED,
    MEDIAN,
    Cell,
    Unit,
    column_unit,
    in_brackets_stands,
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
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{MINUS SIGN}": "$-$",
    "\N{EN DASH}": "--",
    "\N{ASTERISK OPERATOR}": "$^*$",
    "\N{DAGGER}": r"$^\dagger$",
}
_STAR: Final = "\N{ASTERISK OPERATOR}"
_TIMES: Final = "\N{MULTIPLICATION SIGN}"
_DAGGER: Final = "\N{DAGGER}"
_BOUNDS: Final = "\N{GREATER-THAN OR EQUAL TO}\N{LESS-THAN OR EQUAL TO}"


def latex_table(summary: Summary) -> str:
    """Return a table with a row for each strategy of each scene: error at equal time, time to each target, speed-up.

    The speed-up is over the scene's baseline, to the error `Summary.ratio_target`. All errors are in per cent, and all
    times of a column are in the unit that its heading has. If a column's times span more than a factor of 10,000, each
    has its own unit. Numbers have their 95 % intervals in brackets, as in the
    report. If only one end of an interval can be trusted, it stands as a bound; a dash stands for a number that is not
    known. A row below each scene gives its size, its repeats and the error of its reference. Notes below the table
    explain the marks that it has, such as the star of extrapolated numbers.
    """
    ratio = summary.ratio_target
    columns = 2 + len(summary.targets) + (ratio is not None)
    units = {target: column_unit(_times(summary, target)) for target in summary.targets}
    told = [cell for scene in summary.scenes for row in _rows(scene, units, ratio) for cell in row]
    lines = [
        f"% {summary.title}: error after the same time, time to an error, and speed-up, with 95 % intervals",
        rf"\begin{{tabular}}{{l{'r' * (columns - 1)}}}",
        r"\toprule",
    ]
    for number, scene in enumerate(summary.scenes):
        lines += [r"\midrule"] * (number > 0)
        lines += [_row(_titles(scene, units, ratio)), r"\midrule", *map(_row, _rows(scene, units, ratio))]
        lines.append(_across(_conditions(scene), columns))
    notes = (_across(note, columns) for note in _notes(told))
    return "\n".join([*lines, r"\bottomrule", *notes, r"\end{tabular}", ""])


def write_latex(summary: Summary, path: Path) -> None:
    """Write the results of an experiment as a table in LaTeX to a file; the file's folder is made if missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part:
        part.write_text(latex_table(summary), encoding="utf-8")


def _times(summary: Summary, target: float) -> list[Interval]:
    """Return the times to the error ``target`` of all strategies on all scenes, in seconds."""
    return [one.time_to.get(target, UNKNOWN) for scene in summary.scenes for one in scene.strategies]


def _titles(scene: SceneResult, units: Mapping[float, Unit | None], ratio: float | None) -> tuple[str, ...]:
    heads = {target: "" if unit is None else f" [{unit.symbol.strip()}]" for target, unit in units.items()}
    times = (f"time to {percent(target)}{head}" for target, head in heads.items())
    speed_up = () if ratio is None else (f"speed-up over {scene.baseline} to {percent(ratio)}",)
    return (scene.name, f"error after {seconds(scene.budget_s)} [%]", *times, *speed_up)


def _rows(scene: SceneResult, units: Mapping[float, Unit | None], ratio: float | None) -> Iterator[tuple[str, ...]]:
    """Yield the cells of each strategy; ``units`` has the unit of the times to each target, or None.

    ``ratio`` is the error of the last column's speed-ups; None leaves the column out.
    """
    for strategy in scene.strategies:
        error = strategy.error_at_budget
        told = marked(_text(measured_cell(error)).replace(ERROR_UNIT.symbol, ""), error)
        yield (
            strategy.named,
            told,
            *(_time(strategy, target, unit) for target, unit in units.items()),
            *_speed_up(scene, strategy, ratio),
        )


def _time(strategy: StrategyResult, target: float, unit: Unit | None) -> str:
    time = strategy.time_to.get(target, UNKNOWN)
    return marked(_text(seconds_cell(time, None if unit is None else replace(unit, symbol=""))), time)


def _speed_up(scene: SceneResult, strategy: StrategyResult, target: float | None) -> Iterator[str]:
    """Yield the speed-up over the baseline to the error ``target`` without its sign; nothing if there is no target."""
    if target is None:
        return
    cell = ratio_cell(scene, strategy, target)
    text = cell.text if strategy.label == scene.baseline else _text(cell)
    yield marked(text.replace(_TIMES, ""), strategy.ratio.get(target, UNKNOWN))


def _text(cell: Cell) -> str:
    told = cell.interval or cell.text in ("not reached", DISAGREEING) or cell.text[0] in _BOUNDS
    return str(cell) if told else DASH


def _conditions(scene: SceneResult) -> str:
    """Return the conditions of a scene's runs: size, number of repeats and error of the reference."""
    reference = f"reference {percent(scene.reference_error)} off" if scene.reference_error > 0.0 else "exact reference"
    repeats = max((strategy.repeats for strategy in scene.strategies), default=0)
    return f"{scene.size[0]}x{scene.size[1]} pixels, {repeats} repeats, {reference}"


def _notes(texts: Sequence[str]) -> Iterator[str]:
    """Yield a note on the numbers in brackets, and one on each mark that the cells with these ``texts`` have."""
    yield in_brackets_stands(texts)
    yield from (f"{mark}: {meaning}" for mark, meaning in meanings(texts).items())
    if DASH in texts:
        yield f"{DASH}: unknown, not trusted, or both ends of the interval more than {TELLING:g} times off the number"


def _across(text: str, columns: int) -> str:
    """Return a row in small print over all columns."""
    return rf"\multicolumn{{{columns}}}{{l}}{{\footnotesize {_escaped(text)}}} \\"


def _row(texts: tuple[str, ...]) -> str:
    return " & ".join(map(_escaped, texts)) + r" \\"


def _escaped(text: str) -> str:
    return "".join(
        _LATEX.get(character, character) for character in text.replace(EXTRAPOLATED, _STAR).replace(MEDIAN, _DAGGER)
    )
