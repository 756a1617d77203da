"""All runs of one strategy on one scene, and ratios between the runs of a baseline and another strategy.

Records and images are joined into the data from which intervals follow. Ratios (time to an error, efficiency, samples)
come from paired repeats.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import StrategyError
from equaltime.experiments.run.folder import read_array
from equaltime.experiments.run.record import Row
from equaltime.images.bias_variance import BiasVariance, relmse_of_parts
from equaltime.images.metrics import Reference, squared_errors, tail_of
from equaltime.statistics.curves import (
    BELOW,
    interval_of,
    log_time,
    log_times,
    slope_doubt,
    steep_doubt,
    time_to_error,
    typical_interval,
)
from equaltime.statistics.intervals import FEWEST_REPEATS, UNKNOWN, Z95, Interval, exp, join, sound_below
from equaltime.statistics.runs import MISSING, TYPICAL, Runs
from equaltime.strategy import Strategy

__all__ = ["StrategyRuns", "efficiency", "fewer_samples", "runs_of", "speed_up"]

Floats = NDArray[np.float64]

_MOST_BYTES = 5e8
"""Most bytes of final images (float64) in memory at once; further repeats' images are left out."""
_MOST_BIAS = 0.1
"""If bias² exceeds this share of an unbiased strategy's squared error, its runs have missed light.

Its later error is then not predictable."""


_ANEW = ("command", "mitsuba")
"""Renderers whose time of every checkpoint may contain a start, since most render each from its first sample on."""


@dataclass(frozen=True, eq=False)
class StrategyRuns:
    """All runs of one strategy on one scene: the data from which its results are computed."""

    label: str
    rows: tuple[Row, ...]
    """Rows of the records: one for each checkpoint (measured moment) of each run."""
    folder: Path
    spp: tuple[int, ...]
    """Samples per pixel at which the error was measured in all repeats."""
    runs: Runs
    """Times and errors of all repeats at the sample counts ``spp``."""
    parts: BiasVariance | None = None
    """Bias and variance of the final images; None without images or without a reference of their size."""
    tail_share: float = 0.0
    """Share of the squared error of all repeats that one pixel of one repeat makes, if few pixels of few repeats make
    most of it (a heavy tail); else 0."""

    @classmethod
    def of(cls, label: str, rows: Sequence[Row], folder: Path, reference: Reference | None) -> StrategyRuns:
        """Join the records of a strategy on one scene, and check its final images for heavy tails and for missed light.

        The tail is heavy if few pixels of few repeats make most of the error. ``label`` is the strategy's, and ``rows``
        are the records. Images are read from ``folder``. Without images or without a reference of their size, the
        checks are left out.
        """
        spp, runs = runs_of(rows)
        plain = cls(label, tuple(rows), folder, spp, runs)
        images = plain.images() if spp else None
        if images is None or reference is None or reference.mean.shape != images.shape[1:]:
            return plain
        parts, tail = relmse_of_parts(images, reference), tail_of(squared_errors(images, reference))
        missing = "" if runs.biased else _missing(parts, float(runs.relmse[:, -1].mean()))
        own = math.sqrt(max(reference.relmse, 0.0))
        judged = replace(
            runs,
            bias=math.sqrt(parts.bias2.low) if runs.biased and sound_below(parts.bias2) else 0.0,
            doubt=tail.doubt,
            missing=missing,
            unseen=tail.unseen,
            shared=parts.shared,
            reference=own,
        )
        return replace(plain, runs=judged, parts=parts, tail_share=tail.share if tail.doubt else 0.0)

    @property
    def heavy(self) -> bool:
        """Whether few pixels of few repeats make most of the squared error (a heavy tail): means are not typical."""
        return self.tail_share > 0.0

    @property
    def last(self) -> tuple[Row, ...]:
        """Last row of the records of each finished repeat, which has its final image, in the order of repeats."""
        return tuple(sorted((row for row in self.rows if row.last), key=lambda row: row.repeat))

    def apart_from(self, other: StrategyRuns) -> bool:
        """Tell whether all runs of one of the two strategies began before all runs of the other.

        If so, one of the strategies was added to the experiment later, and the machine may have changed its speed
        between.
        """
        own, others = ([row.started for row in runs.last] for runs in (self, other))
        return bool(own and others) and (max(own) < min(others) or max(others) < min(own))

    def images(self) -> Floats | None:
        """Return the final images of the first K repeats as one array (K, H, W, 3); memory limits K.

        Returns None if one of these images is missing or not finite.

        Raises
        ------
        ImageError
            If an image file is damaged.
        """
        width, height = self.rows[0].crop[2:]
        most = max(int(_MOST_BYTES / (24 * width * height)), FEWEST_REPEATS)
        last = self.last[:most]
        if not all(row.image and math.isfinite(row.mse or 0.0) for row in last):
            return None
        try:
            images = [read_array(self.folder / (row.image or ""), (height, width, 3)) for row in last]
        except FileNotFoundError:
            return None
        return np.stack(images).astype(np.float64)


def runs_of(rows: Sequence[Row]) -> tuple[tuple[int, ...], Runs]:
    """Return the samples per pixel that every repeat of a strategy has, and the times and errors at these counts.

    ``rows`` are the strategy's records on one scene. The arrays of `Runs` have the shape (repeats, counts).
    """
    table: dict[int, dict[int, Row]] = defaultdict(dict)
    for row in rows:
        table[row.repeat][row.spp] = row
    common = sorted(set.intersection(*(set(run) for run in table.values())))
    chosen = [[table[repeat][spp] for spp in common] for repeat in sorted(table)]
    seconds = np.array([[row.wall_s for row in run] for run in chosen])
    relmse = np.array([[math.nan if row.relmse is None else row.relmse for row in run] for run in chosen])
    anew = np.array(common, np.float64) if rows[0].renderer in _ANEW else None
    return tuple(common), Runs(seconds, relmse, _independent(rows[0]), rows[0].biased, spp=anew)


def _independent(row: Row) -> bool:
    """Tell whether samples are known to be independent; for a command this is unknown."""
    if row.renderer == "core":
        with suppress(StrategyError):  # a user's own subject may have any name
            return Strategy.parse(row.name).sampler == "independent"
    return row.renderer == "mitsuba" and re.search(r"\bindependent\b", row.name) is not None


def _missing(parts: BiasVariance, relmse: float) -> str:
    """Return a warning if an unbiased strategy's images share an offset from the reference, else an empty text.

    The spread over repeats does not show a common offset.
    """
    return MISSING if parts.bias2.low > _MOST_BIAS * abs(relmse) else ""


def speed_up(baseline: Runs, runs: Runs, target: float) -> Interval:
    """Return the baseline's time to the error ``target``, divided by the time to that error in ``runs``.

    If the ratio is above 1, ``runs`` are faster. Each repeat of one strategy is paired with the repeat of the other
    that ran beside it; surplus repeats are left out. If few events make most of an error (a heavy tail), the ratio is
    the median over pairs of repeats. If one strategy does not reach the target, the ratio is a bound: its interval
    reaches to 0 or to infinity. It is 0 without a width if the bias of ``runs`` alone exceeds the target. A bound that
    does not tell which strategy is faster is returned as `equaltime.statistics.intervals.UNKNOWN`, all of whose numbers
    are NaN.
    """
    repeats = min(baseline.repeats, runs.repeats)
    first, second = (_first(r, repeats) for r in (baseline, runs))
    slow, fast = time_to_error(first, target), time_to_error(second, target)
    note = join(f"{name}: {time.note}" for name, time in (("baseline", slow), ("this", fast)) if time.note)
    trusted = (slow.trusted or slow.bound == "low") and fast.trusted
    if math.isnan(slow.value) or math.isnan(fast.value) or (math.isinf(slow.value) and math.isinf(fast.value)):
        return Interval(math.nan, math.nan, math.nan, False, note or "neither reaches it")
    if math.isinf(slow.value):
        until = slow.low if math.isfinite(slow.low) else float(first.seconds[:, -1].mean())  # so a limit can be told
        low = until / fast.high
        return Interval(math.inf, low, math.inf, trusted, note) if low > 1.0 else UNKNOWN.noted(note)
    if math.isinf(fast.value):
        trusted = slow.trusted and (fast.trusted or fast.bound == "low")
        high = slow.high / fast.low if fast.low > 0.0 else math.inf
        return Interval(0.0, 0.0, high, trusted, note) if high < 1.0 else UNKNOWN.noted(note)
    ratio = _typical_ratio(first, second, target) if first.tail or second.tail else _mean_ratio(first, second, target)
    for less, more in (steep_doubt(first, target), steep_doubt(second, target)[::-1]):
        ratio = ratio.widened(less, "low").widened(more)
    if not slow.trusted:
        ratio = ratio.bounded("low", note) if slow.bound else ratio.doubted(note)
    if not fast.trusted:
        ratio = ratio.bounded("high", note) if fast.bound else ratio.doubted(note)
    return replace(ratio, reach=max(slow.reach, fast.reach)).noted(note).telling().deciding()


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
    extrapolated. An error that the reference's noise hides makes the ratio a bound. The result is unknown if either
    strategy is biased, or if its images have missed light.
    """
    if missing := join((baseline.missing, runs.missing)):
        return UNKNOWN.doubted(missing)
    repeats = min(baseline.repeats, runs.repeats)
    whole = [_first(r, repeats) for r in (baseline, runs)]
    first, second = (_raised(r, -1) for r in whole)
    ends = [part[:, -1] for r in (first, second) for part in (r.relmse, r.seconds)]
    if any(r.biased for r in whole) or min(part.min() for part in ends) <= 0.0:
        return UNKNOWN.doubted("a bias or the noise of the reference leaves the ratio open")

    def logs(off: float) -> Floats:
        with np.errstate(invalid="ignore", divide="ignore"):  # if the reference's noise makes up a repeat's error
            return _log_work(first.moved(off)) - _log_work(second.moved(off))

    ratio = _hidden(typical_interval(logs, 0.0).map(exp), first is not whole[0], second is not whole[1])
    return ratio.noted(_typical(*whole)).telling().deciding()


def _log_work(runs: Runs) -> Floats:
    """Return log(squared error x time) at the end of each repeat, (K,): the product itself may leave float64."""
    work: Floats = np.log(runs.relmse[:, -1]) + np.log(runs.seconds[:, -1])
    return work


def _raised(runs: Runs, checkpoint: int) -> Runs:
    """Return ``runs``, or upper limits of its squared errors if the reference's noise hides those at a checkpoint."""
    return replace(runs, relmse=np.maximum(runs.relmse, 0.0)).moved(Z95) if runs.is_below(checkpoint) else runs


def _hidden(ratio: Interval, baseline: bool, this: bool) -> Interval:
    """Return a ratio of squared errors with the one valid end if the reference's noise hides one of the errors.

    ``baseline`` and ``this`` tell of which strategy the ratio has the upper limits by `_raised` instead of the errors.
    """
    ratio = ratio.bounded("high", f"baseline: {BELOW}") if baseline else ratio
    return ratio.bounded("low", f"this: {BELOW}") if this else ratio


def _typical(first: Runs, second: Runs) -> str:
    """Return the note of a ratio of medians if few events make most of an error of the two; else an empty text."""
    tails = join((first.tail and f"baseline: {first.tail}", second.tail and f"this: {second.tail}"))
    return f"{TYPICAL}; {tails}" if tails else ""


def fewer_samples(baseline: StrategyRuns, other: StrategyRuns) -> Interval:
    """Return the baseline's squared error divided by the other's, at the largest sample count that both have.

    For independent samples, the ratio is the factor by which the other strategy needs fewer samples for equal error. If
    few events make most of an error (a heavy tail), the ratio is the median over pairs of repeats. An error that the
    reference's noise hides makes the ratio a bound.
    """
    common = sorted(set(baseline.spp) & set(other.spp))
    if not common or baseline.runs.biased or other.runs.biased:
        return UNKNOWN.doubted("a bias leaves the ratio open" if common else "they have no sample count in common")
    repeats = min(baseline.runs.repeats, other.runs.repeats)
    whole = [_first(s.runs, repeats) for s in (baseline, other)]
    above, below = (s.spp.index(common[-1]) for s in (baseline, other))
    if not whole[1].relmse[:, below].any():
        return Interval(math.inf, math.inf, math.inf)
    first, second = _raised(whole[0], above), _raised(whole[1], below)

    def log_ratio(kept: Floats, off: float) -> float:
        squares = kept @ first.moved(off).relmse[:, above], kept @ second.moved(off).relmse[:, below]
        return math.log(squares[0]) - math.log(squares[1]) if min(squares) > 0.0 else math.nan  # a ratio may underflow

    def logs(off: float) -> Floats:
        return np.array([log_ratio(one, off) for one in np.eye(repeats)])

    if typical := _typical(*whole):
        ratio = typical_interval(logs, 0.0).map(exp).noted(typical)
    else:
        ratio = interval_of(log_ratio, repeats).map(exp).widened(first.unseen).widened(second.unseen, "low")
    if math.isnan(ratio.value):
        return UNKNOWN.doubted("an error is below what the reference can show")
    ratio = _hidden(ratio, first is not whole[0], second is not whole[1])
    if first.missing:
        ratio = ratio.bounded("low", f"baseline: {first.missing}")
    return (ratio.bounded("high", f"this: {second.missing}") if second.missing else ratio).telling().deciding()


def _first(runs: Runs, repeats: int) -> Runs:
    return replace(runs, seconds=runs.seconds[:repeats], relmse=runs.relmse[:repeats])
