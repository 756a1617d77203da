"""The table of an experiment's results as LaTeX, for a paper: it needs the package booktabs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.telling import DASH
from equaltime.experiments.report.words import Cell, measured_cell, percent, seconds, seconds_cell
from equaltime.files import replacing
from equaltime.statistics.intervals import UNKNOWN

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
}
_STAR: Final = "\N{ASTERISK OPERATOR}"
_BOUNDS: Final = "\N{GREATER-THAN OR EQUAL TO}\N{LESS-THAN OR EQUAL TO}"


def latex_table(summary: Summary) -> str:
    """Return a table with a row for each strategy of each scene: error at equal time, and the time to each target.

    Numbers have their 95 % intervals in brackets, as in the report. A star marks times that are extrapolated beyond the
    runs. If only one end of an interval can be trusted, it stands as a bound; a dash stands for a number that is not
    known. Biased strategies, and those with another picture than the standard's, say so. A note below each scene gives
    its size, its repeats and the error of its reference.
    """
    lines = [
        f"% {summary.title}: error after the same time, and time to an error, with 95 % intervals",
        rf"\begin{{tabular}}{{l{'r' * (1 + len(summary.targets))}}}",
        r"\toprule",
    ]
    for scene in summary.scenes:
        lines += _rows(scene, summary.targets)
    return "\n".join([*lines[:-1], r"\bottomrule", r"\end{tabular}", ""])


def write_latex(summary: Summary, path: Path) -> None:
    """Write the results of an experiment as a table in LaTeX to a file; the file's folder is made if missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part:
        part.write_text(latex_table(summary), encoding="utf-8")


def _rows(scene: SceneResult, targets: tuple[float, ...]) -> Iterator[str]:
    titles = (
        scene.name,
        f"error after {seconds(scene.budget_s)}",
        *(f"time to {percent(target)}" for target in targets),
    )
    yield _row(titles)
    yield r"\midrule"
    for strategy in scene.strategies:
        yield _row((strategy.named, *_cells(strategy, targets)))
    yield _note(scene, 2 + len(targets))
    yield r"\midrule"


def _note(scene: SceneResult, columns: int) -> str:
    """Return a row with the conditions of the scene's runs, over all columns."""
    reference = f"reference {percent(scene.reference_error)} off" if scene.reference_error > 0.0 else "exact reference"
    repeats = max((strategy.repeats for strategy in scene.strategies), default=0)
    said = f"{scene.size[0]}x{scene.size[1]} pixels, {repeats} repeats, {reference}"
    return rf"\multicolumn{{{columns}}}{{l}}{{\footnotesize {_escaped(said)}; $^*$: extrapolated}} \\"


def _cells(strategy: StrategyResult, targets: tuple[float, ...]) -> Iterator[str]:
    yield _text(measured_cell(strategy.error_at_budget))
    for target in targets:
        time = strategy.time_to.get(target, UNKNOWN)
        text = _text(seconds_cell(time))
        yield text + _STAR * (text != DASH and time.known and time.reach > 1.0)


def _text(cell: Cell) -> str:
    told = cell.interval or cell.text == "not reached" or cell.text[0] in _BOUNDS
    return str(cell) if told else DASH


def _row(texts: tuple[str, ...]) -> str:
    return " & ".join(map(_escaped, texts)) + r" \\"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(character, character) for character in text)
