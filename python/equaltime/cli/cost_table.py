"""Output of ``equaltime cost``: the verdict, a table of errors and times, caveats, and the verdict once more."""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from rich.table import Table

from equaltime.cli.messages import ANY_WIDTH, MOST_LINES, plain_console, print_line, print_lines
from equaltime.experiments.analysis.sentences import WHAT_TO_DO, listed
from equaltime.experiments.model.summary import DISAGREES, SceneResult, StrategyResult, Summary
from equaltime.experiments.report.words import (
    AT_LEAST,
    AT_MOST,
    EARLY,
    EXTRAPOLATED,
    LESS_THAN,
    MEDIAN,
    MORE_THAN,
    NOT_REACHED,
    RISEN,
    Cell,
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
from equaltime.statistics.curves import BELOW, BETTER, ERROR_OF, ERRORS_OF, TOO_NOISY
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.statistics.runs import TYPICAL

__all__ = ["every_row", "legend", "print_summary"]

_REPORT = "report.html"
_MOST_TARGETS = 2
_FEW_ROWS = 8
"""Largest number of rows that are all shown: a strategy that the user has named should not be missing."""
_FEWEST_ROWS = 4
"""Least number of rows that a line on targets without times leaves room for, where not all rows are shown."""
_MOST_NOTES = 2
"""Largest number of notes on the verdict that are shown without ``-v``."""
_MOST_SCENES = 2
"""Largest number of scenes that are named beside a strategy whose error is hidden; more are counted."""
_OTHER_LINES = 6
"""Lines beside rows and caveats: verdict twice, heading, what ``*`` means, what ``-v`` adds, what to open next.

Times of typical runs have one more, what their mark means. So have times that are not reached. Errors with a lower
or an upper limit alone have one each."""

_LINES_AROUND = 5
"""Lines beside rows, caveats and meanings of marks."""

_BEHIND = tuple(map(str.strip, (EXTRAPOLATED, MEDIAN, EARLY, RISEN)))
_EXPLAINED = (AT_LEAST, AT_MOST, LESS_THAN, MORE_THAN, NOT_REACHED, *_BEHIND)
"""Marks whose meanings are told without ``-v``: they cannot be guessed."""

_Row = tuple[SceneResult, StrategyResult]


def print_summary(summary: Summary, folder: Path, verbose: bool = False, quick: bool = False) -> None:
    """Print the verdict as first and last line; between them a table, notes, and the files in ``folder`` to open.

    All of up to `_FEW_ROWS` rows are shown. With more rows, the output has at most `MOST_LINES` lines, unless
    ``verbose`` asks for all rows and reasons. ``quick`` tells that the experiment was run with ``--quick``, so that
    longer runs may tell more.
    """
    console = plain_console()
    print_lines([summary.verdict])
    every = [(scene, strategy) for scene in summary.scenes for strategy in scene.strategies]
    notes = summary.verdict_notes if verbose else _shown_notes(summary.verdict_notes)
    caveats = [*notes, *_rule(summary), *_caveats(summary, verbose), *(() if verbose else _below(summary))]
    telling = [row for row in every if _tells(row[1])]
    few = len(every) <= _FEW_ROWS
    others = _OTHER_LINES + any(TYPICAL in time.note for _, one in every for time in one.time_to.values())
    others += any(time.trusted and math.isinf(time.value) for _, one in every for time in one.time_to.values())
    others += len({bound for _, one in every if (bound := one.error_at_budget.bound)})
    absent = [*_without_times(summary, quick)]
    room = MOST_LINES - others - len(caveats)
    if verbose or few or room - len(absent) >= _FEWEST_ROWS:
        caveats, room = [*caveats, *absent], room - len(absent)
    rows = every if verbose or few else _first(telling, room)
    table = _fitting(rows, summary, console.width, len(summary.targets) if verbose else _MOST_TARGETS)
    if rows:
        console.print(table)
    reasons = _reasons(summary)
    more = [_count(len(every) - len(rows), "more row")] if len(rows) < len(every) else []
    more += [f"times to {', '.join(left)}"] if (left := _left_out(table, summary)) and not verbose else []
    more += [_count(hidden, "more note")] if (hidden := len(summary.verdict_notes) - len(notes)) else []
    more += [*_questions(summary), *_unknown_cells(table)]
    faster = _speed_ups(summary) if verbose else []
    beyond = _short_legend(table, faster)
    unknown = (
        _reasons(summary, unknown=True) if len(rows) + len(caveats) + len(beyond) + _LINES_AROUND < MOST_LINES else []
    )
    last = (
        [*faster, *_too_wide(table, summary), *reasons]
        if verbose
        else [*unknown, f"equaltime info {shlex.quote(str(folder))} -v shows {listed(more)}"]
        if more
        else []
    )
    for line in (*beyond, *caveats, *last):
        print_line(console, line, "dim")
    longer = "; without --quick the numbers are more exact" if quick else ""
    print_line(console, f"Curves and pictures: open {folder / _REPORT}{longer}", "dim")
    print_lines([summary.verdict])


def every_row(summary: Summary) -> Table:
    """Return the table of all strategies on all scenes for ``-v``: errors at equal time, and times to errors."""
    rows = [(scene, strategy) for scene in summary.scenes for strategy in scene.strategies]
    return _fitting(rows, summary, plain_console().width, len(summary.targets))


def legend(summary: Summary, table: Table) -> list[str]:
    """Return the lines below ``table``, which has all strategies: meaning of numbers and marks, then caveats."""
    caveats = [*summary.verdict_notes, *_rule(summary), *_caveats(summary, verbose=True), *_without_times(summary)]
    caveats += _too_wide(table, summary)
    faster = _speed_ups(summary)
    return [*faster, in_brackets_stands(_texts(table, faster)), *_marks(table, faster), *caveats, *_reasons(summary)]


def _speed_ups(summary: Summary) -> list[str]:
    """Return a line for each scene with the speed-ups of its strategies over the baseline, to one error."""
    target = summary.ratio_target
    if target is None:
        return []
    several = len(summary.scenes) > 1
    lines = []
    for scene in summary.scenes:
        told = [
            f"{one.label} {_marked(ratio_cell(scene, one, target), one.ratio.get(target, UNKNOWN))}"
            for one in scene.strategies
            if one.label != scene.baseline
        ]
        on = f"{scene.name}: " if several else ""
        if told:
            lines.append(f"{on}speed-up over {scene.baseline} to {percent(target)}: {', '.join(told)}")
    return [*lines, *known_gains(summary)]


def _left_out(table: Table, summary: Summary) -> list[str]:
    """Return the errors in per cent whose times the table has no column for, although some strategy reaches them."""
    headings = {column.header for column in table.columns}
    every = [one for scene in summary.scenes for one in scene.strategies]
    reached = [target for target in summary.targets if any(one.time_to[target].known for one in every)]
    return [percent(target) for target in reached if _heading(target) not in headings]


def _too_wide(table: Table, summary: Summary) -> list[str]:
    """Return a line on the times that a table of all targets has no room for; none if there is room."""
    absent = _left_out(table, summary)
    return [f"Too wide for this terminal: times to {', '.join(absent)}; {_REPORT} has them"] if absent else []


def _heading(target: float) -> str:
    return f"time to {percent(target)}"


def _marks(table: Table, lines: Sequence[str]) -> list[str]:
    """Return a line for each mark that a cell of the table or one of the ``lines`` has, with its meaning."""
    return [f"{mark.strip()} {meaning}" for mark, meaning in meanings(_texts(table, lines)).items()]


def _short_legend(table: Table, lines: Sequence[str]) -> list[str]:
    """Return the legend that is shown without ``-v``: marks after numbers, lower bounds, and the errors beside them."""
    found = [text for text in _marks(table, lines) if text.startswith(_EXPLAINED)]
    beside = "; in brackets: the error that was measured" * any("(measured" in text for text in _texts(table, lines))
    return [text + beside * text.startswith(AT_LEAST) for text in found]


def _texts(table: Table, lines: Sequence[str]) -> list[str]:
    """Return the cells of a table and the lines below it, which may have marks."""
    return [*(str(cell) for column in table.columns for cell in column.cells), *lines]


def _rule(summary: Summary) -> Iterator[str]:
    """Yield the sentence on the error of the verdict, if the verdict gives a time to one."""
    if summary.headline_rule:
        yield summary.headline_rule


def _caveats(summary: Summary, verbose: bool) -> Iterator[str]:
    """Yield what holds for all numbers of a scene: other depths, limits of the reference, other times of runs.

    Without ``verbose``, one of each is enough.
    """
    for told in (
        [(scene.name, f"errors and times are of {scene.other_depth}") for scene in summary.scenes if scene.other_depth],
        [(scene.name, f"note: {scene.other_ends}") for scene in summary.scenes if scene.other_ends],
        [(scene.name, f"note: {scene.late}") for scene in summary.scenes if scene.late],
        [(scene.name, f"note: {scene.reference_caveat}") for scene in summary.scenes if scene.reference_caveat],
    ):
        names: dict[str, list[str]] = {}
        for name, text in told:
            names.setdefault(text, []).append(name)
        lines = [text if len(on) == len(summary.scenes) else f"{', '.join(on)}: {text}" for text, on in names.items()]
        yield from lines if verbose else lines[:1]


def _shown_notes(notes: Sequence[str]) -> list[str]:
    """Return the first notes, and the one that tells what to do."""
    return [note for number, note in enumerate(notes) if number < _MOST_NOTES or note.startswith(WHAT_TO_DO)]


def _reasons(summary: Summary, unknown: bool = False) -> list[str]:
    """Return a line for each strategy that is left out or lacks an interval of the error at equal time.

    With ``unknown``, only those whose error is not known at all, and whose reason neither the verdict nor `_below`
    tells.
    """
    return [reason for scene in summary.scenes for reason in _without_error(scene, len(summary.scenes) > 1, unknown)]


def _without_times(summary: Summary, quick: bool = False) -> Iterator[str]:
    """Yield a line for the targets to which no strategy has a time, with the most frequent reason; targets share it.

    Strategies are named if others have another reason. A reason of biased strategies is given if no other strategy has
    one. ``quick`` tells that the experiment was run with ``--quick``, so that a better reference needs no other keys.
    """
    every = [(scene, one) for scene in summary.scenes for one in scene.strategies]
    reasons: dict[tuple[str, str], list[float]] = {}
    for target in summary.targets:
        noted = [row for row in every if row[1].time_to[target].note]
        asked = [row for row in noted if not row[1].biased] or noted
        notes = [_reason_without_time(one.time_to[target].note, summary, quick) for _, one in asked]
        if notes and not any(one.time_to[target].known for _, one in every):
            why = Counter(notes).most_common(1)[0][0]
            these = [row for row, note in zip(asked, notes, strict=True) if note == why]
            whose = "" if len(these) == len(asked) else f". {_named(these, summary)}"
            reasons.setdefault((whose, why), []).append(target)
    for (whose, why), targets in reasons.items():
        yield f"No times to {listed([percent(one) for one in targets])}{whose}: {why}"


def _named(rows: Iterable[_Row], summary: Summary) -> str:
    """Return the labels of strategies, with their scenes if the experiment has several."""
    names: dict[str, list[str]] = {}
    for scene, result in rows:
        names.setdefault(result.label, []).append(scene.name)
    several = len(summary.scenes) > 1
    return listed(
        [
            f"{label} on {listed(on) if len(on) <= _MOST_SCENES else f'{len(on)} scenes'}" if several else label
            for label, on in names.items()
        ]
    )


def _reason_without_time(note: str, summary: Summary, quick: bool) -> str:
    """Return the note of a time that is not known; several references have the smallest and the largest error named."""
    if TOO_NOISY not in note:
        return note
    better = "without --quick it is better" if quick else BETTER
    ordered = sorted(summary.scenes, key=lambda scene: scene.reference_error)
    least, most = ordered[0], ordered[-1]
    if percent(least.reference_error) == percent(most.reference_error):
        told = f"{ERROR_OF} {percent(most.reference_error)}"
    else:
        ends = " to ".join(f"{percent(scene.reference_error)} ({scene.name})" for scene in (least, most))
        told = f"{ERRORS_OF} {ends}"
    return f"{told}{TOO_NOISY} ({better})"


def _below(summary: Summary) -> Iterator[str]:
    """Yield one line on all errors that the references hide, with the keys that ask for better references."""
    rows = [
        (scene, result)
        for scene in summary.scenes
        for result in scene.strategies
        if not result.error_at_budget.known and BELOW in result.error_at_budget.note
    ]
    if rows:
        yield f"{_named(rows, summary)}: {BELOW}"


def _questions(summary: Summary) -> list[str]:
    """Return the questions that `_reasons` answers: why errors are unknown, are not trusted, or were never measured."""
    doubted = [one.error_at_budget for scene in summary.scenes for one in scene.strategies if _has_reason(one)]
    unknown = sum(not (error.known or error.bound) for error in doubted)
    counts = (
        (sum(len(scene.left_out) for scene in summary.scenes), "strategy was", "strategies were", "left out"),
        (unknown, "error is", "errors are", "unknown"),
        (len(doubted) - unknown, "error", "errors", "cannot be trusted"),
    )
    return [f"why {number} {one if number == 1 else many} {what}" for number, one, many, what in counts if number]


def _unknown_cells(table: Table) -> list[str]:
    """Return the question why times of the table are unknown, which `_reasons` answers; none if all are known."""
    times = [column for column in table.columns if str(column.header).startswith("time to ")]
    count = sum(str(cell) == "unknown" for column in times for cell in column.cells)
    return [f"why {_count(count, 'time')} {'is' if count == 1 else 'are'} unknown"] if count else []


def _has_reason(result: StrategyResult) -> bool:
    return not result.error_at_budget.trusted and bool(result.error_at_budget.note)


def _without_error(scene: SceneResult, several: bool, unknown: bool) -> Iterator[str]:
    """Yield the lines of `_reasons` for one scene."""
    on = f" on {scene.name}" if several else ""
    for label, reason in () if unknown else scene.left_out:
        yield f"{label}{on}: {reason}"
    for result in scene.strategies:
        error = result.error_at_budget
        told = DISAGREES in error.note or BELOW in error.note
        if _has_reason(result) and not (unknown and (error.known or told)):
            yield f"{result.label}{on}: {error.note}"
        if not unknown:
            yield from (f"{result.label}{on}, {told}" for told in _unknown_times(result))


def _unknown_times(result: StrategyResult) -> Iterator[str]:
    """Yield why times are unknown, each reason once, with its targets: ``time to 5 % and 2 %: too few checkpoints``."""
    targets: dict[str, list[str]] = {}
    for target, time in result.time_to.items():
        if math.isnan(time.value) and time.note:
            targets.setdefault(time.note, []).append(percent(target))
    yield from (f"time to {listed(these)}: {note}" for note, these in targets.items())


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _tells(result: StrategyResult) -> bool:
    """Tell whether a row has a finite number that is trusted or a limit."""
    numbers = (result.error_at_budget, *result.time_to.values())
    return any(number.known and (number.trusted or number.bound) for number in numbers)


def _first(rows: Sequence[_Row], most: int) -> list[_Row]:
    """Return up to ``most`` rows in their order: standards and baselines before other renderers and strategies."""

    def rank(row: _Row) -> int:
        scene, strategy = row
        named = (scene.standard, scene.baseline)
        return named.index(strategy.label) if strategy.label in named else 2 + (strategy.renderer == "core")

    chosen = sorted(range(len(rows)), key=lambda number: rank(rows[number]))[:most]
    return [rows[number] for number in sorted(chosen)]


def _fitting(rows: Sequence[_Row], summary: Summary, width: int, most: int) -> Table:
    """Return the table with as many columns of times as fit the width, up to ``most``.

    A truncated number would mislead.
    """
    anywhere = plain_console()
    anywhere.width = ANY_WIDTH
    for count in range(most, 0, -1):
        table = _table(rows, summary, count)
        if anywhere.measure(table).maximum <= width:
            return table
    return _table(rows, summary, 0)


def _table(rows: Sequence[_Row], summary: Summary, most: int) -> Table:
    """Return errors at equal time, and times to up to ``most`` targets.

    The first target is the verdict's, then come those that most strategies have trusted times for. Of several such
    targets the smallest are chosen. If ``most`` is more than the tables of a terminal usually have, or the experiment
    has few targets, the others that some strategy reaches follow.
    """
    targets, headline = summary.targets, summary.headline_target
    cells = {target: [seconds_cell(result.time_to[target]) for _, result in rows] for target in targets}
    counts = {target: sum(cell.state == "trusted" for cell in cells[target]) for target in targets}
    known = [target for target in targets if counts[target] == max(counts.values()) > 0]
    preferred = [*reversed(known)] if headline is None else [headline, *reversed(known)]
    if most > _MOST_TARGETS or len(targets) <= _MOST_TARGETS:
        preferred += [target for target in targets if any(result.time_to[target].known for _, result in rows)]
    known = sorted(list(dict.fromkeys(preferred))[:most], reverse=True)
    several = len(summary.scenes) > 1
    budgets = {scene.budget_s for scene, _ in rows}
    table = Table(box=None, pad_edge=False)
    if several:
        table.add_column("scene", overflow="fold")
    table.add_column("strategy", overflow="fold", min_width=12)
    after = f"after {seconds(*budgets)}" if len(budgets) == 1 else "at equal time"
    table.add_column(f"error {after}", justify="right", no_wrap=True)
    for target in known:
        table.add_column(_heading(target), justify="right", no_wrap=True)
    for number, (scene, result) in enumerate(rows):
        times = (_marked(cells[target][number], result.time_to[target]) for target in known)
        first = (scene.name,) if several else ()
        error = _marked(measured_cell(result.error_at_budget), result.error_at_budget)
        table.add_row(*first, result.named, error, *times)
    return table


def _marked(cell: Cell, number: Interval) -> str:
    return marked(str(cell), number)
