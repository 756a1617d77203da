"""Numbers as text for reports: three digits, a unit that fits the magnitude, intervals with significant digits only."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from equaltime.experiments.model.summary import DISAGREES, SceneResult, StrategyResult, Summary
from equaltime.statistics.curves import BEFORE, BEYOND, RISES
from equaltime.statistics.in_words import beside_one, exponent, places, probability, read_off
from equaltime.statistics.intervals import TELLING, TOO_WIDE, UNKNOWN, Interval, sound
from equaltime.statistics.runs import TYPICAL

__all__ = [
    "AT_LEAST",
    "AT_MOST",
    "DISAGREEING",
    "EARLY",
    "ERROR_UNIT",
    "EXTRAPOLATED",
    "LESS_THAN",
    "MEDIAN",
    "MORE_THAN",
    "NOT_REACHED",
    "RISEN",
    "Cell",
    "Unit",
    "column_unit",
    "error_cell",
    "factor_cell",
    "facts",
    "in_brackets_stands",
    "known_gains",
    "marked",
    "meanings",
    "measured_cell",
    "percent",
    "plain_cell",
    "probability_cell",
    "provenance_groups",
    "ratio_cell",
    "same_cell",
    "samples_cell",
    "seconds",
    "seconds_cell",
    "slug",
    "spread_sentence",
    "worker_runs",
]

AT_LEAST, AT_MOST = "\N{GREATER-THAN OR EQUAL TO}", "\N{LESS-THAN OR EQUAL TO}"

LESS_THAN, MORE_THAN = "< ", "> "
"""Signs of a speed-up where one of the two strategies does not reach the error."""

_MINUS = "\N{MINUS SIGN}"

_THIN = "\N{NARROW NO-BREAK SPACE}"

_TIMES = "\N{MULTIPLICATION SIGN}"

EXTRAPOLATED, MEDIAN, EARLY, RISEN = (f"{_THIN}{sign}" for sign in "*\N{DAGGER}\N{DOUBLE DAGGER}\N{SECTION SIGN}")
"""Marks after numbers: beyond the runs, of typical runs (a median over repeats), before the first measurement, and
where measured errors rise. The space keeps them apart from a star in a label."""

NOT_REACHED = "not reached"
"""Text of a time, or of a count of samples, that is infinite."""

DISAGREEING = "disagrees"
"""Text of a number that a renderer does not get, because its picture is another one."""

_UNTOLD = "cannot tell"
"""Text of a number that is not given, because both ends of its interval are far away."""

_MEANINGS: Mapping[str, str] = {
    "(biased)": "the strategy may converge to another picture",
    "(another picture)": "a test found that the strategy's expected picture is not the standard's",
    DISAGREEING: "no number, since the renderer's picture differs from the reference",
    _UNTOLD: f"both ends of the interval are more than {TELLING:g} times off the number",
    AT_LEAST: "at least, since the upper end of the interval cannot be trusted",
    AT_MOST: "at most, since the lower end of the interval is not known",
    LESS_THAN: "less than, since the strategy does not reach the error in 100 times its longest run, or in its runs "
    "if it is biased",
    MORE_THAN: "more than, since the baseline does not reach the error in 100 times its longest run, or in its runs if "
    "it is biased",
    NOT_REACHED: "in 100 times the longest run; by a biased strategy, in its runs",
    EXTRAPOLATED: "extrapolated beyond the longest run",
    MEDIAN: "of typical runs: a median over repeats. A speed-up is the median over pairs of repeats. Errors are root "
    "mean squares, and a few rare events make most of them: such a time is not where a curve crosses the error",
    EARLY: "extrapolated to a time before the first measurement",
    RISEN: "read off where measured errors rise with time: the last measured error is larger again",
}

_MARKS: Mapping[str, str] = {EXTRAPOLATED: BEYOND, EARLY: BEFORE, RISEN: RISES, MEDIAN: TYPICAL}
"""Marks of numbers, each with the part of a number's note that calls for it."""


@dataclass(frozen=True)
class Cell:
    """One number of a table as text, with its interval and remarks."""

    text: str
    """The number with its unit, or a word instead."""
    interval: str = ""
    """Interval as text, ``(low to high)``, in the unit of the number; empty if no interval is known."""
    note: str = ""
    """Remarks on the number, which become footnotes."""
    state: Literal["trusted", "untrusted", "unknown", "silent"] = "trusted"
    """Whether both ends of the interval can be trusted (``trusted``), not both (``untrusted``), or the number is
    ``unknown``. ``silent`` marks a dash whose note does not become a footnote."""

    def __str__(self) -> str:
        return f"{self.text} {self.interval}".rstrip()


@dataclass(frozen=True)
class Unit:
    """A unit to print numbers in: ``number * scale`` and the symbol after it."""

    scale: float
    symbol: str
    """Space and symbol of the unit; empty for a table whose heading has the unit."""


ERROR_UNIT = Unit(100.0, f"{_THIN}%")
"""Unit of relative errors: per cent."""

_WIDEST_COLUMN = 1e4
"""Largest ratio of two durations in a column of one unit: beyond it, some numbers have five digits or many zeros."""

_FARTHEST_END = 100.0
"""Largest upper end of an error's interval, in numbers, that is printed: a larger one means that it is not known."""

_FACTOR = Unit(1.0, _TIMES)

_PLAIN = Unit(1.0, "")

_SAMPLES = Unit(1.0, f"{_THIN}spp")


def error_cell(interval: Interval) -> Cell:
    """Return a table cell with a relative error (0.02 is 2 %) and its interval in per cent.

    An error of 0 without an interval is printed as "exact". An upper end beyond 100 times the number says nothing, so
    that the lower end is printed alone.
    """
    if interval.trusted and interval.value == interval.low == interval.high == 0.0:
        return Cell("exact", note=interval.note)
    return _cell(_without_far_end(interval), ERROR_UNIT)


def _without_far_end(interval: Interval) -> Interval:
    if interval.trusted and interval.high > _FARTHEST_END * interval.value > 0.0 and interval.low > 0.0:
        return interval.bounded("low", f"the upper end is beyond {_FARTHEST_END:g} times the number")
    return interval


def measured_cell(interval: Interval) -> Cell:
    """Return a table cell with a measured relative error in per cent.

    If only one end of the interval is valid, the cell shows that end and then the measured value, which charts and
    captions show too. A value outside the runs is called extrapolated instead of measured.
    """
    interval = _without_far_end(interval)
    cell = error_cell(interval)
    if cell.state != "untrusted" or not interval.bound or not 0.0 < interval.value < math.inf:
        return cell
    return replace(cell, interval=f"({read_off(interval)} {percent(interval.value)})")


def factor_cell(interval: Interval) -> Cell:
    """Return a table cell with a ratio, such as ``31x (27 to 35)`` but with a real multiplication sign.

    A ratio of 0 or infinity means that one of the two strategies does not reach the error; it is printed as a limit,
    with `LESS_THAN` or `MORE_THAN`. It is printed as "never" if the strategy's bias exceeds the error.
    """
    if interval.trusted and interval.value == interval.high == 0.0:
        return Cell("never", note=interval.note, state="unknown")
    if interval.trusted and interval.value in (0.0, math.inf):
        end, sign = (interval.low, MORE_THAN) if interval.value else (interval.high, LESS_THAN)
        if 0.0 < end < math.inf:
            return Cell(f"{sign}{_short(end)}{_TIMES}", note=interval.note, state="untrusted")
    return _cell(interval, _FACTOR)


def ratio_cell(scene: SceneResult, strategy: StrategyResult, target: float) -> Cell:
    """Return a table cell with a strategy's speed-up over the scene's baseline to the error ``target``.

    The baseline's own cell has the factor 1 without an interval.
    """
    if strategy.label == scene.baseline:
        return Cell(f"1{_TIMES}")
    return factor_cell(strategy.ratio.get(target, UNKNOWN))


def marked(text: str, number: Interval) -> str:
    """Return the text of a number or bound with the marks of what limits it: one mark for each of its limits.

    A word or a dash in place of a number has no mark.
    """
    if not any(map(str.isdigit, text)):
        return text
    return text + "".join(mark for mark, words in _MARKS.items() if words in number.note)


def known_gains(summary: Summary) -> list[str]:
    """Return the gains at equal time of strategies without a known speed-up, or with a mere limit, in one sentence.

    The gain needs no time to an error. The list is empty if no such gain is known.
    """
    found = [
        f"{one.label}{f' on {scene.name}' if len(summary.scenes) > 1 else ''} {factor_cell(one.efficiency)}"
        for scene in summary.scenes
        for one in scene.strategies
        if sound(one.efficiency)
        and one.label != scene.baseline
        and (
            any(ratio.trusted and ratio.value in (0.0, math.inf) for ratio in one.ratio.values())
            or not any(map(sound, one.ratio.values()))
        )
    ]
    baseline = " or ".join(dict.fromkeys(scene.baseline for scene in summary.scenes))
    told = f"squared error {_TIMES} time of the baseline over the strategy's, median over pairs of runs"
    return [f"gain over {baseline} at equal time ({told}): {', '.join(found)}"] if found else []


def plain_cell(interval: Interval) -> Cell:
    """Return a table cell with a number without unit and its interval."""
    return _cell(interval, _PLAIN)


def samples_cell(interval: Interval) -> Cell:
    """Return a table cell with a count of samples per pixel; an infinite count is printed as "not reached"."""
    if math.isinf(interval.value):
        return Cell(NOT_REACHED, note=interval.note, state="unknown")
    return _cell(interval, _SAMPLES)


def probability_cell(p: float | None, note: str = "") -> Cell:
    """Return a table cell with the p-value ``p`` and a remark ``note``; None is printed as a dash."""
    if p is None:
        return Cell("\N{EN DASH}", note=note, state="unknown")
    return Cell(probability(p).removeprefix("p = ").removeprefix("p "), note=note)


def same_cell(p: float | None, unequal: bool) -> Cell:
    """Return a table cell that tells whether two strategies have the same expected image; None is printed as a dash.

    ``p`` is the p-value of the test that both expected images are equal. ``unequal`` tells whether it is below the
    level of the test.
    """
    if p is None:
        return Cell("\N{EN DASH}", state="unknown")
    return Cell("no" if unequal else "yes", f"({probability(p)})")


def seconds_cell(interval: Interval, unit: Unit | None = None) -> Cell:
    """Return a table cell with a duration in ms, s, min, h or d; an infinite duration is printed as "not reached".

    ``interval`` is in seconds. ``unit`` is the unit to print; None takes the one that suits the duration.
    """
    if math.isinf(interval.value) and interval.trusted:
        return Cell(NOT_REACHED, note=interval.note, state="unknown")
    return _cell(interval, unit or _time_unit(_shown(interval)))


def column_unit(intervals: Iterable[Interval]) -> Unit | None:
    """Return one unit for a column of durations, ``intervals`` in seconds: the unit that suits their median.

    The result is None if the longest duration is more than `_WIDEST_COLUMN` times the shortest, so that each number
    needs a unit of its own.
    """
    shown = sorted(number for interval in intervals if 0.0 < (number := _shown(interval)) < math.inf)
    if shown and shown[-1] > _WIDEST_COLUMN * shown[0]:
        return None
    return _time_unit(shown[len(shown) // 2] if shown else 1.0)


def _shown(interval: Interval) -> float:
    """Return the number that a cell shows: the end of the interval that can be trusted if there is only one."""
    return {"low": interval.low, "high": interval.high}.get(interval.bound, interval.value)


def in_brackets_stands(texts: Iterable[str]) -> str:
    """Return the meaning of the numbers in brackets in a table with these ``texts``."""
    measured = ", or the error that was measured" if any("(measured" in text for text in texts) else ""
    return f"in brackets: 95 % intervals, by the spread over repeats and the noise of the reference{measured}"


def meanings(texts: Iterable[str]) -> dict[str, str]:
    """Return the marks that the ``texts`` of a table have, in a fixed order, each with its meaning."""
    every = list(texts)
    return {mark: meaning for mark, meaning in _MEANINGS.items() if any(mark in text for text in every)}


def _cell(interval: Interval, unit: Unit) -> Cell:
    """Format an interval; an untrusted one is printed as its valid end or "not trusted", with the reason as note.

    A number that a renderer with another picture does not get is printed as "disagrees".
    """
    if DISAGREES in interval.note and not interval.known:
        return Cell(DISAGREEING, note=interval.note, state="untrusted")
    if math.isnan(interval.value) and interval.bound == "high":
        return Cell(
            f"{AT_MOST} {_short(interval.high * unit.scale)}{unit.symbol}", note=interval.note, state="untrusted"
        )
    if not interval.known:
        return Cell(_UNTOLD if TOO_WIDE in interval.note else "unknown", note=interval.note, state="unknown")
    if not interval.trusted:
        end = {"low": interval.low, "high": interval.high}.get(interval.bound, math.nan) * unit.scale
        sign = AT_LEAST if interval.bound == "low" else AT_MOST
        said = f"{sign} {_short(end)}{unit.symbol}" if math.isfinite(end) and end > 0.0 else "not trusted"
        return Cell(said, note=interval.note or "no reason was recorded", state="untrusted")
    value, low, high = (number * unit.scale for number in (interval.value, interval.low, interval.high))
    if not (math.isfinite(low) and math.isfinite(high)):
        return Cell("not trusted", note=interval.note or "its interval has no end", state="untrusted")
    of_value, of_low, of_high = places(value, low, high)
    if unit is _FACTOR:
        of_value, of_low, of_high = map(beside_one, (value, low, high), (of_value, of_low, of_high))
    ends = f"({_fixed(low, of_low)} to {_fixed(high, of_high)})"
    return Cell(_fixed(value, of_value) + unit.symbol, ends, note=interval.note)


def percent(value: float) -> str:
    """Return a relative error (0.02 is 2 %) as text in per cent, with up to three digits."""
    return _short(100.0 * value) + ERROR_UNIT.symbol


def seconds(value: float) -> str:
    """Return a duration, given in seconds, as text in ms, s, min, h or d, with up to three digits."""
    unit = _time_unit(value)
    return _short(value * unit.scale) + unit.symbol


def slug(name: str, taken: Iterable[str] = ()) -> str:
    """Return a name made safe for file names, URLs and ids: lower-case letters, digits and ``-``.

    If the result is in ``taken``, a number is appended.
    """
    base = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:60] or "scene"
    used, result, count = set(taken), base, 1
    while result in used:
        count += 1
        result = f"{base}-{count}"
    return result


def _time_unit(value: float) -> Unit:
    size = abs(value)
    if size < 0.9995:  # as `words.time_unit`, so that sentences and tables have one unit
        return Unit(1e3, f"{_THIN}ms")
    if not math.isfinite(size) or size < 600.0:
        return Unit(1.0, f"{_THIN}s")
    if size < 7190.0:
        return Unit(1.0 / 60.0, f"{_THIN}min")
    return Unit(1.0 / 3600.0, f"{_THIN}h") if size < 864000.0 else Unit(1.0 / 86400.0, f"{_THIN}d")


def _fixed(value: float, decimals: int) -> str:
    if not math.isfinite(value):
        return "unknown" if math.isnan(value) else f"{_MINUS if value < 0.0 else ''}\N{INFINITY}"
    if abs(value) >= 1e9:
        return f"{value:.2g}".replace("e+", "e")
    text = f"{value:,.{min(decimals, 9)}f}"
    return text.replace("-", _MINUS) if float(text.replace(",", "")) else text.lstrip("-")


def _short(value: float) -> str:
    text = _fixed(value, max(0, min(9, 2 - exponent(value))))
    return text.rstrip("0").rstrip(".") if "." in text else text


def facts(scene: SceneResult) -> str:
    """Return a sentence with a scene's size, path depth, reference, number of repeats and equal time."""
    width, height = scene.size
    depth = "paths of any length" if scene.max_depth < 0 else f"max_depth {scene.max_depth}"
    if scene.other_depth:
        depth += f" ({scene.other_depth.partition('; ')[2]})"
    repeats = {strategy.repeats for strategy in scene.strategies}
    counted = f"{min(repeats)} to {max(repeats)}" if len(repeats) > 1 else str(*repeats)
    decided = f" {scene.decisions}." if scene.decisions else ""
    notes = "".join(f" Note: {note}." for note in (scene.other_ends, scene.late, scene.reference_caveat) if note)
    return (
        f"{width}\N{MULTIPLICATION SIGN}{height} pixels, {depth}; {_against(scene)}; {counted} repeats of each "
        f"strategy; equal time is {seconds(scene.budget_s)}.{notes}{decided}"
    )


def _against(scene: SceneResult) -> str:
    """Describe the reference; a reference with a caveat is never called the exact truth."""
    if scene.reference_error:
        return f"reference with an error of {percent(scene.reference_error)}"
    return "reference without a stated error" if scene.reference_caveat else "exact truth"


def provenance_groups(summary: Summary) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the facts needed to repeat an experiment (machine, build, command and so on), in groups.

    Each group is a heading and its rows; each row is the name and the value of a fact.
    """
    groups: dict[str, list[tuple[str, str]]] = {"": []}
    in_full = summary.provenance.get("strategies", {})
    apart = ("strategies", "workers")
    _sort_into(groups, "", {key: facts for key, facts in summary.provenance.items() if key not in apart})
    groups["workers"] = list(worker_runs(summary).items())
    groups["digests of the scenes"] = [(scene.name, scene.digest) for scene in summary.scenes]
    names = {(strategy.label, strategy.name): None for scene in summary.scenes for strategy in scene.strategies}
    told = {label: f": {facts['words']}" for label, facts in in_full.items() if facts.get("words")}
    groups["strategies"] = [(label, f"{name}{told.get(label, '')}") for label, name in names]
    return [(heading, rows) for heading, rows in groups.items() if rows]


def worker_runs(summary: Summary) -> dict[str, str]:
    """Return the host of each worker of a cluster and its runs, by the worker's address; empty without a cluster.

    A run is told as scene, label and number of the repeat.
    """
    return {
        address: f"{facts.get('host', '?')}: {'; '.join(_text(run) for run in facts.get('ran', ()))}"
        for address, facts in summary.provenance.get("workers", {}).items()
    }


def spread_sentence(summary: Summary) -> str:
    """Return a sentence on the machines of a cluster that took runs; empty without a cluster."""
    runs = Counter[str]()
    for facts in summary.provenance.get("workers", {}).values():
        runs[str(facts.get("host", "?"))] += len(facts.get("ran", ()))
    if not runs:
        return ""
    each = ", ".join(f"{host} ({count})" for host, count in sorted(runs.items()))
    over = f"spread over {len(runs)} like machines" if len(runs) > 1 else "given to 1 machine"
    return f"{sum(runs.values())} of {summary.provenance.get('runs', 0)} runs were {over} of a cluster: {each}."


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
