"""Error against time: how long to a wanted error, what at equal time, how steep.

A strategy's curve is that of the *expected* squared error: at each checkpoint the mean of relMSE over repeats. The
reference's noise is subtracted in relMSE, and averages away there even where single repeats fall below 0. Between
checkpoints the curve is straight in log-log, through the block means of its isotonic regression (errors fall; noise may
make them rise). Whatever is read off the curve is a smooth function of means over repeats, formed on the logarithm; its
interval comes from the jackknife over repeats, which sees that checkpoints of one run share samples, and that two
strategies' repeats share a machine that drifts. What the reference's noise does to all repeats alike no spread shows:
everything is formed again with all of relMSE moved by its standard error, of two strategies by the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from equaltime.cost.metrics import signed_root
from equaltime.cost.statistics import UNKNOWN, Interval, exp, few, jackknife, mean_interval

__all__ = [
    "Runs",
    "error_at",
    "error_curve",
    "interval_of",
    "least_error_at",
    "log_time",
    "second_curve",
    "slope",
    "time_to_error",
]

Floats = NDArray[np.float64]

INDEPENDENT = -0.5
"""Slope of error against time where samples are independent: variance falls as 1 / n."""
TRUSTED_REACH = 10.0
"""How far beyond the longest run a fitted slope is trusted, as a factor of time."""
FARTHEST_REACH = 100.0
"""And how far it is used at all."""
_FARTHEST_ERROR = 2.0
"""How far outside the runs an error is told, as a factor of time."""
_NEAR_ENOUGH = 1.15
"""And where no slope is known: runs may end a tenth of their time early."""
_CLEAR = 4.0
"""An error drowns where its square is not so many standard errors of the reference's part in it."""
_TAIL_OCTAVES = 3.0
_Z95 = 1.959964
_FEWEST_POINTS = 3


@dataclass(frozen=True, eq=False)
class Runs:
    """All repeats of one strategy on one scene, at the same checkpoints."""

    seconds: Floats
    """(K, C): since the first sample; increasing."""
    relmse: Floats
    """(K, C): realised, with the reference's noise subtracted."""
    independent: bool = False
    """Whether samples are known to be independent, so that error falls as time to the power -1/2 for ever."""
    biased: bool = False
    """Whether the error may stop falling: then nothing is extrapolated."""
    doubt: str = ""
    """Why upper ends of errors and times cannot be trusted, if so (see `tails`); lower ones can."""
    unseen: float = 0.0
    """By how much larger relMSE may be for what no repeat saw (relative)."""
    shared: float = 0.0
    """Standard error of relMSE that all repeats share: the reference's."""

    @property
    def repeats(self) -> int:
        """K."""
        return len(self.seconds)

    def points(self, kept: Floats) -> tuple[Floats, Floats]:
        """Return log seconds and log error of the mean over the repeats that are kept, up to where it drowns."""
        seconds, square = kept @ self.seconds / kept.sum(), kept @ self.relmse / kept.sum()
        sunk = np.flatnonzero(~(square > _CLEAR * self.shared))
        end = int(sunk[0]) if sunk.size else square.size
        return np.log(seconds[:end]), 0.5 * np.log(square[:end])

    def moved(self, errors: float) -> Runs:
        """Return the runs as the reference would show them that is off by so many of its standard errors."""
        return replace(self, relmse=self.relmse + errors * self.shared)

    def judged(self, interval: Interval, power: float = 1.0) -> Interval:
        """Say of an error's interval (or a time's) how far its upper end can be trusted.

        ``power`` is that of relMSE in the number: of a time at most 1, since errors fall at least as 1 / sqrt(time).
        """
        if self.doubt:
            return interval.bounded("low", self.doubt)
        return interval.widened((1.0 + self.unseen) ** power - 1.0)


def interval_of(statistic: Callable[[Floats, float], float], repeats: int) -> Interval:
    """Return the jackknife's interval of a statistic, with what the reference's noise leaves open.

    ``statistic`` takes the weights of the repeats, and by how many of its standard errors the reference is off.
    """
    found = jackknife(lambda kept: statistic(kept, 0.0), repeats)
    everything = np.ones(repeats)
    moved = 0.5 * abs(statistic(everything, 1.0) - statistic(everything, -1.0))
    if moved == 0.0 or not math.isfinite(found.value):
        return found
    if not math.isfinite(moved):
        return found.doubted("the noise of the reference leaves it open")
    half = math.hypot(0.5 * (found.high - found.low), _Z95 * moved)
    return replace(found, low=found.value - half, high=found.value + half)


def falling(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the block means of the decreasing regression of y on x, by pooling adjacent violators (Ayer 1955)."""
    blocks: list[tuple[float, float, int]] = []
    for point in zip(x.tolist(), y.tolist(), strict=True):
        at, level, count = *point, 1
        while blocks and blocks[-1][1] <= level:
            left_at, left_level, left_count = blocks.pop()
            total = left_count + count
            at, level = ((at * count + left_at * left_count) / total, (level * count + left_level * left_count) / total)
            count = total
        blocks.append((at, level, count))
    table = np.array(blocks)
    return table[:, 0], table[:, 1]


def _steepness(x: Floats, y: Floats) -> float:
    """Return the slope of the least squares line; NaN for fewer than two points."""
    centred = x - x.mean() if x.size else x
    square = float(centred @ centred)
    return float(centred @ y) / square if square > 0.0 else math.nan


def _outside(runs: Runs, x: Floats, y: Floats, late: bool) -> float:
    """Return the slope by which the curve goes on after its end (or before its beginning)."""
    if runs.independent and not runs.biased:
        return INDEPENDENT
    near = np.abs(x - (x[-1] if late else x[0])) <= _TAIL_OCTAVES * math.log(2.0)
    return _steepness(x[near], y[near]) if np.count_nonzero(near) >= _FEWEST_POINTS else math.nan


def log_time(runs: Runs, target: float, kept: Floats) -> float:
    """Return the log of the seconds at which the curve falls to the target; ``inf`` if it never does."""
    x, y = runs.points(kept)
    if not x.size:
        return math.nan
    wanted = math.log(target)
    level_x, level_y = falling(x, y)
    if level_y[-1] <= wanted <= level_y[0]:
        return float(np.interp(-wanted, -level_y, level_x))
    late = bool(wanted < level_y[-1])
    if late and runs.biased:
        return math.inf
    steep = _outside(runs, x, y, late)
    if not steep < 0.0:
        return math.nan if math.isnan(steep) else math.inf
    end = -1 if late else 0
    return float(level_x[end] + (wanted - level_y[end]) / steep)


def time_to_error(runs: Runs, target: float) -> Interval:
    """Return the seconds to a relative error (0.02 is 2 %).

    Beyond the runs' end the curve is continued, by slope -1/2 where samples are independent, else by the slope of its
    last three octaves, and the note says so; not beyond 100 times the longest run by a fitted slope, nor at all for a
    biased strategy: then the value is ``inf`` and ``low`` what is known.
    """
    whole = np.ones(runs.repeats)
    x = runs.points(whole)[0]
    if not x.size:
        return UNKNOWN.doubted("the error is below what the reference can show")
    value = log_time(runs, target, whole)
    begin, end = float(x[0]), float(x[-1])
    if math.isinf(value):
        reason = "biased, not extrapolated" if runs.biased else "the error no longer falls"
        return runs.judged(Interval(math.inf, math.exp(end), math.inf).noted(f"not reached: {reason}"))
    if math.isnan(value):
        return runs.judged(UNKNOWN.doubted("too few checkpoints to extrapolate"))
    if value > end + math.log(FARTHEST_REACH) and not runs.independent:
        note = f"not reached in {FARTHEST_REACH:g} times the longest run"
        return runs.judged(Interval(math.inf, FARTHEST_REACH * math.exp(end), math.inf).noted(note))
    found = interval_of(lambda kept, off: log_time(runs.moved(off), target, kept), runs.repeats).map(exp)
    return runs.judged(_with_reach(found, value, begin, end, runs.independent))


def _with_reach(found: Interval, value: float, begin: float, end: float, independent: bool) -> Interval:
    """Say how far outside the runs the number lies, and doubt it where nothing vouches for the way there."""
    reach = math.exp(max(value - end, begin - value, 0.0))
    if reach <= 1.0 + 1e-9:
        return found
    side = "beyond the longest run" if value > end else "before the first checkpoint"
    by = "by slope -1/2" if independent else "by the fitted slope"
    noted = replace(found, reach=reach).noted(f"extrapolated {reach:.3g} times {side} {by}")
    if independent or reach <= (TRUSTED_REACH if value > end else 2.0):
        return noted
    return noted.doubted("a fitted slope may not hold so far")


def error_at(runs: Runs, seconds: float) -> Interval:
    """Return the relative error at a time; a little outside the runs (twice at most) by the slope there."""
    wanted = math.log(seconds)

    def log_error(kept: Floats, off: float) -> float:
        x, y = runs.moved(off).points(kept)
        if not x.size:
            return math.nan
        level_x, level_y = falling(x, y)
        if level_x[0] <= wanted <= level_x[-1]:
            return float(np.interp(wanted, level_x, level_y))
        late = bool(wanted > level_x[-1])
        end, steep = -1 if late else 0, _outside(runs, x, y, late)
        beyond = max(wanted - x[-1], 0.0) if late else min(wanted - x[0], 0.0)  # blocks may end within the runs
        if abs(beyond) > math.log(_NEAR_ENOUGH if math.isnan(steep) else _FARTHEST_ERROR):
            return math.nan
        return float(level_y[end] + (0.0 if math.isnan(steep) else min(steep, 0.0)) * beyond)

    found = interval_of(log_error, runs.repeats).map(exp)
    if math.isnan(found.value):
        return UNKNOWN.doubted("no run is near that time, or the error is below what the reference can show")
    return runs.judged(found, 0.5)


def least_error_at(runs: Runs, seconds: float) -> float:
    """Return the relative error at a time; 0 where it ended below what the reference can show, NaN if none is known."""
    found, last = error_at(runs, seconds).value, float(runs.relmse[:, -1].mean())
    return 0.0 if math.isnan(found) and last <= _CLEAR * runs.shared else found


def slope(runs: Runs) -> Interval:
    """Return the slope of log error against log time over all checkpoints: -0.5 for independent samples."""

    def steepness(kept: Floats, off: float) -> float:
        return _steepness(*runs.moved(off).points(kept))

    found = interval_of(steepness, runs.repeats)
    if math.isnan(found.value):
        return UNKNOWN.doubted("too few checkpoints")
    return found.doubted(runs.doubt) if runs.doubt else found


def error_curve(runs: Runs) -> tuple[Interval, ...]:
    """Return the relative error at each checkpoint: the root of the mean of relMSE over repeats."""
    return tuple(runs.judged(_root_mean(column, runs.shared), 0.5) for column in runs.relmse.T)


def second_curve(runs: Runs) -> tuple[Interval, ...]:
    """Return the mean time of each checkpoint."""
    return tuple(mean_interval(column) for column in runs.seconds.T)


def _root_mean(squares: Floats, shared: float) -> Interval:
    mean = float(squares.mean())
    if not mean > 0.0:
        return mean_interval(squares).map(signed_root).doubted("below what the reference can show")

    def log_root(kept: Floats, off: float) -> float:
        square = float(kept @ squares) / float(kept.sum()) + off * shared
        return 0.5 * math.log(square) if square > 0.0 else math.nan

    if np.ptp(squares) == shared == 0.0:
        return few(Interval(math.sqrt(mean), math.sqrt(mean), math.sqrt(mean)), squares.size)
    return interval_of(log_root, squares.size).map(exp)
