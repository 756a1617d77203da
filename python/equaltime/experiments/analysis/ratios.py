"""Ratios between a baseline and another strategy, from paired repeats: time to an error, efficiency, samples."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.analysis.strategy_runs import StrategyRuns
from equaltime.statistics.curves import (
    TYPICAL,
    Runs,
    interval_of,
    log_time,
    log_times,
    slope_doubt,
    time_to_error,
    typical_interval,
)
from equaltime.statistics.intervals import UNKNOWN, Interval, exp, join, median_interval

__all__ = ["efficiency", "fewer_samples", "speed_up"]

Floats = NDArray[np.float64]


def speed_up(baseline: Runs, runs: Runs, target: float) -> Interval:
    """Return the baseline's time to the error ``target``, divided by the time to that error in ``runs``.

    If the ratio is above 1, ``runs`` are faster. Each repeat of one strategy is paired with the same repeat of the
    other, which ran beside it; surplus repeats are left out. If few events make most of an error (a heavy tail), the
    ratio is the median over pairs of repeats. If the target is not reached, or only one limit of a time can be
    trusted, the ratio is a bound. A bound that does not tell which strategy is faster becomes unknown.
    """
    repeats = min(baseline.repeats, runs.repeats)
    first, second = (_first(r, repeats) for r in (baseline, runs))
    slow, fast = time_to_error(first, target), time_to_error(second, target)
    note = join(f"{name}: {time.note}" for name, time in (("baseline", slow), ("this", fast)) if time.note)
    trusted = (slow.trusted or slow.bound == "low") and fast.trusted
    if math.isnan(slow.value) or math.isnan(fast.value) or (math.isinf(slow.value) and math.isinf(fast.value)):
        return Interval(math.nan, math.nan, math.nan, False, note or "neither reaches it")
    if math.isinf(slow.value):
        low = slow.low / fast.high
        return Interval(math.inf, low, math.inf, trusted, note) if low > 1.0 else UNKNOWN.noted(note)
    if math.isinf(fast.value):
        trusted = slow.trusted and (fast.trusted or fast.bound == "low")
        high = slow.high / fast.low if fast.low > 0.0 else math.inf
        return Interval(0.0, 0.0, high, trusted, note) if high < 1.0 else UNKNOWN.noted(note)
    ratio = _typical_ratio(first, second, target) if first.tail or second.tail else _mean_ratio(first, second, target)
    if not slow.trusted:
        ratio = ratio.bounded("low", note) if slow.bound else ratio.doubted(note)
    if not fast.trusted:
        ratio = ratio.bounded("high", note) if fast.bound else ratio.doubted(note)
    return replace(ratio, reach=max(slow.reach, fast.reach)).noted(note).deciding()


def _mean_ratio(first: Runs, second: Runs, target: float) -> Interval:
    """Return the ratio of the times at which the mean errors reach the target."""

    def log_ratio(kept: Floats, off: float) -> float:
        return log_time(first.moved(off), target, kept) - log_time(second.moved(off), target, kept)

    return interval_of(log_ratio, first.repeats).map(exp).widened(first.unseen).widened(second.unseen, "low")


def _typical_ratio(first: Runs, second: Runs, target: float) -> Interval:
    """Return the median ratio of times over pairs of repeats."""

    def logs(off: float) -> Floats:
        with np.errstate(invalid="ignore"):  # if neither repeat reaches the target
            return log_times(first.moved(off), target) - log_times(second.moved(off), target)

    doubts = (slope_doubt(runs, float(np.median(log_times(runs, target)))) for runs in (first, second))
    return typical_interval(logs, math.hypot(*doubts)).map(exp)


def efficiency(baseline: Runs, runs: Runs) -> Interval:
    """Return the baseline's squared error x time at the end of its runs, divided by the same product for ``runs``.

    The ratio is the median over pairs of repeats. For independent samples, the ratio also holds for times to equal
    error. The median describes typical runs, also for heavy-tailed errors, and ignores rare bad runs. No time is
    extrapolated. The result is unknown if either strategy is biased.
    """
    repeats = min(baseline.repeats, runs.repeats)
    ends = [part[:repeats, -1] for r in (baseline, runs) for part in (r.relmse, r.seconds)]
    if any(r.biased for r in (baseline, runs)) or min(part.min() for part in ends) <= 0.0:
        return UNKNOWN.doubted("a bias or the noise of the reference leaves it open")
    relmse, seconds, other_relmse, other_seconds = map(np.log, ends)  # products and ratios may leave float64
    return median_interval(relmse + seconds - other_relmse - other_seconds).map(exp)


def fewer_samples(baseline: StrategyRuns, other: StrategyRuns) -> Interval:
    """Return the baseline's squared error divided by the other's, at the largest sample count that both have.

    For independent samples, the ratio is the factor by which the other strategy needs fewer samples for equal error. If
    few events make most of an error (a heavy tail), the ratio is the median over pairs of repeats.
    """
    common = sorted(set(baseline.spp) & set(other.spp))
    if not common or baseline.runs.biased or other.runs.biased:
        return UNKNOWN.doubted("a bias leaves it open" if common else "they have no sample count in common")
    repeats = min(baseline.runs.repeats, other.runs.repeats)
    first, second = (_first(s.runs, repeats) for s in (baseline, other))
    above, below = (s.spp.index(common[-1]) for s in (baseline, other))
    if not second.relmse[:, below].any():
        return Interval(math.inf, math.inf, math.inf)

    def log_ratio(kept: Floats, off: float) -> float:
        squares = kept @ first.moved(off).relmse[:, above], kept @ second.moved(off).relmse[:, below]
        return math.log(squares[0]) - math.log(squares[1]) if min(squares) > 0.0 else math.nan  # a ratio may underflow

    def logs(off: float) -> Floats:
        return np.array([log_ratio(one, off) for one in np.eye(repeats)])

    if typical := join((first.tail and f"baseline: {first.tail}", second.tail and f"this: {second.tail}")):
        ratio = typical_interval(logs, 0.0).map(exp).noted(f"{TYPICAL}; {typical}")
    else:
        ratio = interval_of(log_ratio, repeats).map(exp).widened(first.unseen).widened(second.unseen, "low")
    if math.isnan(ratio.value):
        return UNKNOWN.doubted("an error is below what the reference can show")
    if first.missing:
        ratio = ratio.bounded("low", f"baseline: {first.missing}")
    return (ratio.bounded("high", f"this: {second.missing}") if second.missing else ratio).deciding()


def _first(runs: Runs, repeats: int) -> Runs:
    return replace(runs, seconds=runs.seconds[:repeats], relmse=runs.relmse[:repeats])
