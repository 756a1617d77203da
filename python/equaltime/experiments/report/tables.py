"""Tables of a report: times to an error, checks of each strategy, checkpoints of the curves, overview of all scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from equaltime.experiments.model.experiment import Quantity
from equaltime.experiments.model.summary import Beside, SceneResult, StrategyResult, Summary
from equaltime.experiments.report.footnotes import grouped, letter, merged, remarks, shape
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.telling import (
    DASH,
    NO_COMMON_MEAN,
    column_says_something,
    is_quick,
    says_slower,
    silenced,
    unsaid,
)
from equaltime.experiments.report.words import (
    Cell,
    error_cell,
    factor_cell,
    measured_cell,
    percent,
    plain_cell,
    probability_cell,
    same_cell,
    samples_cell,
    seconds,
    seconds_cell,
)
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.curves import AGAINST_SAMPLES
from equaltime.statistics.intervals import UNKNOWN, Interval, join, product_mean
from equaltime.statistics.runs import of_one_kind

__all__ = [
    "PAGE_NOTE",
    "Table",
    "TableRow",
    "beside_table",
    "check_table",
    "geometric_mean",
    "label_row",
    "overview_tables",
    "point_table",
    "time_table",
]

PAGE_NOTE = "notes_"
"""Beginning of the id of a note for the whole page; the id of a scene has no underscore."""


@dataclass(frozen=True)
class TableRow:
    """A row of a table in a report: a label with tags, and the cells of each column."""

    label: str
    look: Style | None
    """Colour, marker and line style of the strategy; None for a row without one."""
    tags: tuple[str, ...]
    """Words beside the label: baseline, biased, another picture, or the name of another renderer."""
    cells: tuple[tuple[Cell, ...], ...]
    """Cells of each column: one number, or two numbers one below the other."""
    title: str = ""
    """Full name of the strategy, of which the label may be a short form."""


@dataclass(frozen=True)
class Table:
    """A table of numbers in a report, with numbered footnotes below the table."""

    slug: str
    caption: str
    corner: str
    """Head of the first column."""
    columns: tuple[str, ...]
    rows: tuple[TableRow, ...]
    unsaid: str = ""
    """Sentence on columns that are left out and on dashes; empty if there are none."""
    shared: tuple[str, ...] = ()
    """Shapes of the remarks that the page says once for all of its tables."""

    def telling(self, quick: bool, all_columns: bool = False) -> Table:
        """Return the table without columns that hold no answer, and with dashes in other cells that hold none.

        A number, or a bound that tells which strategy is faster, is an answer; dashes and "unknown" are none. ``quick``
        tells whether longer runs would give more answers. ``all_columns`` keeps columns of dashes. Without it, a table
        that holds no answer has no columns.
        """
        columns = range(len(self.columns))
        kept = [i for i in columns if all_columns or column_says_something(row.cells[i] for row in self.rows)]
        rows = tuple(replace(row, cells=tuple(silenced(row.cells[i]) for i in kept)) for row in self.rows)
        left_out = [name for i, name in enumerate(self.columns) if i not in kept]
        told = replace(self, columns=tuple(self.columns[i] for i in kept), rows=rows)
        dashes = any(cell.state == "silent" for cell in told.every_cell)
        return replace(told, unsaid=unsaid(left_out, dashes, quick, self.every_cell))

    @property
    def every_cell(self) -> Iterator[Cell]:
        """All cells of the table in reading order."""
        return (cell for row in self.rows for cells in row.cells for cell in cells)

    @property
    def footnotes(self) -> tuple[str, ...]:
        """Footnotes below the table, each once, in reading order; a note's number is its position from 1.

        Remarks that differ only in their numbers become one footnote with the smallest and the largest numbers.
        """
        return tuple(merged(same) for key, same in grouped(self.every_cell).items() if key not in self.shared)

    def marks(self, cell: Cell) -> tuple[str, ...]:
        """Return the marks of the footnotes that a cell refers to: numbers from 1, then letters of the page's notes."""
        own = [key for key in grouped(self.every_cell) if key not in self.shared]
        keys = {shape(remark) for remark in remarks(cell)}
        numbers = (str(number) for number, key in enumerate(own, 1) if key in keys)
        return (*numbers, *(letter(number) for number, key in enumerate(self.shared) if key in keys))

    def address(self, mark: str) -> str:
        """Return the id of the note that a mark refers to, below this table or on the page."""
        return f"{self.slug}-note-{mark}" if mark.isdecimal() else f"{PAGE_NOTE}{mark}"


_CELLS: Mapping[Quantity, Callable[[Interval], Cell]] = {
    "slope": plain_cell,
    "speed-up": factor_cell,
    "efficiency": factor_cell,
    "fewer samples": factor_cell,
    "time": seconds_cell,
    "samples": samples_cell,
    "time of a sample": factor_cell,
    "error": measured_cell,
    "last error": measured_cell,
    "bias": lambda interval: _bias_cell(interval),
    "p": lambda interval: probability_cell(interval.value if interval.known else None, interval.note),
}


def beside_table(slug: str, summary: Summary) -> Table | None:
    """Return a table of published and measured numbers; None if the experiment compares no published numbers.

    ``slug`` begins the table's id on the page.
    """
    if not summary.beside:
        return None
    rows = tuple(_row(line, len(summary.scenes) > 1) for line in summary.beside)
    said = any(line.theirs for line in summary.beside)
    heading = "they say" if summary.theirs is None else summary.theirs.heading
    columns = (heading, "we measure") if said else ("we measure",)
    if not said:
        rows = tuple(TableRow(row.label, None, (), row.cells[1:], row.title) for row in rows)
    return Table(f"{slug}-beside", "", "", columns, rows).telling(is_quick(summary), all_columns=True)


def _row(line: Beside, several: bool) -> TableRow:
    place = [line.scene] if several else []
    if line.target is not None:
        place.append(f"at {percent(line.target)}")
    theirs = Cell(line.theirs or "\N{EN DASH}", state="trusted" if line.theirs else "unknown")
    if line.quantity == "slope" and line.value.known:
        place.append(_against(line.value))
    ours = _CELLS[line.quantity](line.value)
    note = (Cell(", ".join(place), state="unknown"),) if place else ()
    return TableRow(line.what, None, (), ((theirs,), (ours, *note)), f"{line.quantity}: {line.strategy}")


_NOTHING = Cell(DASH, state="unknown")


def label_row(
    scene: SceneResult, strategy: StrategyResult, look: Style, cells: Sequence[Sequence[Cell]] = ()
) -> TableRow:
    """Return a row of a strategy for a table; tags such as "baseline" and "biased" follow its label.

    ``cells`` are the cells of each column. ``look`` is the strategy's colour, marker and line style.
    """
    baseline = "baseline" if strategy.label == scene.baseline else ""
    renderer = strategy.renderer if strategy.renderer != "core" else ""
    tags = tuple(filter(None, (baseline, strategy.remark, renderer)))
    return TableRow(strategy.label, look, tags, tuple(map(tuple, cells)), strategy.name)


_START = (
    ". Times of other programs than equaltime may contain a start, and so may speed-ups and the gain at equal time. "
    "The gain at equal samples does not depend on times"
)
"""Why the numbers of a table of times may not agree with the samples that are needed."""
_GAINS = ("gain at equal time", "gain at equal samples")


def time_table(slug: str, scene: SceneResult, targets: Sequence[float], looks: Mapping[str, Style]) -> Table:
    """Return a table with each strategy's time to each target error, and below it the speed-up over the baseline.

    The last two columns are the gains at equal time and at equal samples, which verdicts may tell. Below the latter
    stands the count of samples per pixel. ``slug`` begins the
    table's id. ``looks`` gives colour, marker and line style by label of a strategy.
    """
    rows = []
    for strategy in scene.strategies:
        cells = []
        for target in targets:
            time = _time_cell(scene, strategy, target)
            ratio = strategy.ratio.get(target)
            faster = [] if ratio is None or strategy.label == scene.baseline else [factor_cell(ratio)]
            cells.append([time, *faster])
        for gain in (strategy.efficiency, strategy.fewer_samples):
            cells.append([_NOTHING if strategy.label == scene.baseline else factor_cell(gain)])
        count = scene.equal_samples(strategy)
        if strategy.label != scene.baseline and strategy.fewer_samples.known and count is not None:
            cells[-1].append(Cell(f"at {count:,} samples"))
        rows.append(label_row(scene, strategy, looks[strategy.label], cells))
    others = any(strategy.renderer != "core" for strategy in scene.strategies)
    caption = f"Time to a given error, and speed-up and gain over {scene.baseline}; 95 % intervals{_START * others}"
    columns = [*(f"to {percent(target)}" for target in targets), *_GAINS]
    return Table(f"{slug}-times", caption, "strategy", tuple(columns), tuple(rows))


def _time_cell(scene: SceneResult, strategy: StrategyResult, target: float) -> Cell:
    """Format a strategy's time to an error; a lower limit that says nothing about the others is unknown."""
    time = strategy.time_to.get(target, UNKNOWN)
    if time.bound == "low" and not time.trusted and not says_slower(scene, target, time):
        time = UNKNOWN.noted(time.note)
    return seconds_cell(time)


def _against(slope: Interval) -> str:
    """Return against what a slope of the error was measured, in words."""
    return "against samples" if slope.note.startswith(AGAINST_SAMPLES) else "against time"


def check_table(slug: str, scene: SceneResult, looks: Mapping[str, Style]) -> Table:
    """Return a table that shows whether each strategy's numbers can be trusted.

    Columns are the slope of the error, the error at equal time and at the end of the runs, and the error that the
    renders themselves state at the end. Two more are the bias, and whether the expected image equals the standard
    strategy's. ``slug`` begins the table's id. ``looks`` gives colour, marker and line style by label of a strategy.
    """
    standard = scene.standard or "the standard"
    errors = [f"error after {seconds(scene.budget_s)}; below: at the end", "own estimate at the end"]
    slopes = [strategy.curve.slope for strategy in scene.strategies]
    axes = sorted({_against(slope) for slope in slopes if slope.known}, reverse=True) or ["against time"]
    columns = [f"slope {axes[0]}" if len(axes) == 1 else "slope", *errors, "bias", f"same picture as {standard}?"]
    rows = []
    for strategy in scene.strategies:
        curve = strategy.curve
        cells = [
            [plain_cell(curve.slope), *(Cell(_against(curve.slope)) for _ in axes[1:] if curve.slope.known)],
            [measured_cell(strategy.error_at_budget), *map(measured_cell, curve.error[-1:])],
            [_own_estimate(curve.own_estimate, strategy.biased)],
            [_beside_the_test(strategy)],
            [same_cell(strategy.picture_p, strategy.another_picture)],
        ]
        rows.append(label_row(scene, strategy, looks[strategy.label], cells))
    axis = " or ".join(f"against log {axis.split()[-1]}" for axis in axes)
    caption = (
        f"Slope of log error {axis} (independent samples: \N{MINUS SIGN}0.5), errors, bias, and test for an equal "
        "picture; 95 % intervals. The end is the last point of a curve, at a fixed number of samples. An interval "
        "after a time also has the scatter of times. The interval of a bias contains the noise of the "
        f"reference, whose error may be larger.{_WHY_STANDARD * (scene.standard is not None)}"
    )
    return Table(f"{slug}-checks", caption, "strategy", tuple(columns), tuple(rows))


_WHY_STANDARD = (
    " Pictures are compared with those of the standard: the baseline where the question is bias, else best, and "
    "without it the unbiased strategy with the smallest error on the scene"
)
"""Why the strategy that others are compared with may differ from scene to scene."""


_NONE_FOUND = "none found"
"""Text of a bias that cannot be told from 0."""


def _bias_cell(bias: Interval | None) -> Cell:
    """Format a bias; one that cannot be told from zero is "none found", with its upper limit if that is trusted.

    A bias of a picture that differs, of which only the upper limit is known, is that limit alone.
    """
    if bias is None:
        return _NOTHING
    if bias.trusted and bias.value == bias.low == bias.high == 0.0:
        return Cell("none", note=bias.note)
    if bias.trusted and bias.low <= 0.0 < bias.high:
        return Cell(_NONE_FOUND, f"(at most {percent(bias.high)})", bias.note)
    if bias.bound == "high":
        return Cell(f"at most {percent(bias.high)}", note=bias.note)
    if not bias.trusted and bias.low <= 0.0:
        return Cell(_NONE_FOUND, note=bias.note, state="untrusted")
    return error_cell(bias)


def _beside_the_test(strategy: StrategyResult) -> Cell:
    """Format a strategy's bias; a note explains an interval that excludes 0 where the test finds an equal picture."""
    cell, bias = _bias_cell(strategy.bias), strategy.bias
    if bias is None or strategy.picture_p is None or strategy.another_picture:
        return cell
    if not (bias.trusted and (bias.low > 0.0 or bias.high < 0.0)):
        return cell
    return replace(cell, note=join((cell.note, _BIASED_BY_LITTLE if strategy.biased else _BY_CHANCE)))


_ALARMS = f"which finds a difference by chance in 1 of {1.0 / LEVEL:g} experiments, all rows and scenes together"
_BY_CHANCE = f"the interval excludes 0, as 1 of 20 does by chance: the test for an equal picture decides, {_ALARMS}"
"""Remark on a bias that is not told from 0."""
_BIASED_BY_LITTLE = f"biased by its settings, but too little for the test for an equal picture, {_ALARMS}"
"""Remark on a bias that is known to be one."""


def point_table(slug: str, scene: SceneResult, looks: Mapping[str, Style]) -> Table:
    """Return a table of the points of all error curves: samples, time, error, and the error that renders state.

    ``slug`` begins the table's id. ``looks`` gives colour, marker and line style by label of a strategy.
    """
    rows = []
    for strategy in scene.strategies:
        curve = strategy.curve
        for i, spp in enumerate(curve.spp):
            own = curve.own_estimate[i] if i < len(curve.own_estimate) else UNKNOWN
            cells = [
                [Cell(str(spp))],
                [seconds_cell(curve.seconds[i])],
                [measured_cell(curve.error[i])],
                [_own_estimate((own,), strategy.biased)],
            ]
            tags = tuple(filter(None, (strategy.remark,)))
            rows.append(TableRow(strategy.label, looks[strategy.label], tags, tuple(map(tuple, cells)), strategy.name))
    columns = ["samples a pixel", "time", "error", "own estimate"]
    return Table(f"{slug}-points", "The points of the curves", "strategy", tuple(columns), tuple(rows))


def overview_tables(summary: Summary, looks: Mapping[str, Style]) -> list[Table]:
    """Return one table per target error: times and speed-ups, one row per scene and one column per strategy.

    The last row is the geometric mean of speed-ups over scenes. ``looks`` gives colour, marker and line style by label
    of a strategy.
    """
    labels = list(dict.fromkeys(strategy.label for scene in summary.scenes for strategy in scene.strategies))
    return [_overview(summary, labels, target) for target in summary.targets]


def geometric_mean(summary: Summary, label: str, target: float) -> Interval | None:
    """Return the geometric mean over scenes of a strategy's speed-ups to the error ``target``; None for the baseline.

    ``label`` is the strategy's. The interval combines the intervals of the scenes, and holds for these scenes only. If
    a speed-up is missing, or if only some are of typical runs, the mean is unknown and has a note with the reason.
    """
    ratios = []
    for scene in summary.scenes:
        strategy = _find(scene, label)
        if strategy is not None and label == scene.baseline:
            return None
        ratio = strategy.ratio.get(target, UNKNOWN) if strategy else UNKNOWN
        if factor_cell(ratio).state != "trusted" or ratio.low <= 0.0:
            return replace(UNKNOWN, note=f"on {scene.name} it has no speed-up that can be trusted")
        ratios.append(ratio)
    if not of_one_kind(ratios):
        return replace(UNKNOWN, note=NO_COMMON_MEAN)
    return product_mean(ratios)


def _overview(summary: Summary, labels: Sequence[str], target: float) -> Table:
    rows = []
    for scene in summary.scenes:
        cells: list[tuple[Cell, ...]] = []
        for label in labels:
            strategy = _find(scene, label)
            if strategy is None:
                cells.append((_NOTHING,))
                continue
            time = _time_cell(scene, strategy, target)
            ratio = strategy.ratio.get(target) if label != scene.baseline else None
            cells.append((time,) if ratio is None else (time, factor_cell(ratio)))
        rows.append(TableRow(scene.name, None, (), tuple(cells)))
    means = [geometric_mean(summary, label, target) for label in labels]
    last = tuple((_NOTHING if mean is None else factor_cell(mean),) for mean in means)
    rows.append(TableRow("geometric mean", None, (), last, "of the speed-ups over all scenes"))
    caption = f"Time to an error of {percent(target)}, and speed-up over the baseline; 95 % intervals"
    return Table(f"overview-{target:g}".replace(".", "-"), caption, "scene", tuple(labels), tuple(rows))


def _find(scene: SceneResult, label: str) -> StrategyResult | None:
    return next((strategy for strategy in scene.strategies if strategy.label == label), None)


def _own_estimate(estimates: Sequence[Interval], biased: bool) -> Cell:
    """Format the last estimate; a biased strategy's is marked as noise, a missing one is a dash."""
    if not estimates or math.isnan(estimates[-1].value):
        return _NOTHING
    cell = measured_cell(estimates[-1])
    if not biased:
        return cell
    note = "; ".join(filter(None, (cell.note, "the strategy's bias is not in it")))
    return replace(cell, text=f"noise {cell.text}", note=note)
