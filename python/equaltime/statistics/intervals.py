"""Numbers with their 95 % intervals, from a few independent repeats.

A repeat is a whole run with its own seed. So repeats are independent whatever a run does inside: low-discrepancy
points, images that grow from checkpoint to checkpoint, pixels that share a denominator. Every interval comes from the
spread over K repeats alone, by Student's t with K - 1 degrees of freedom. The one remaining assumption is that the
numbers are near enough to normal. It fails where a few rare events make up the error. `equaltime.film.tails` detects
that; the interval carries the finding as ``trusted`` and ``note``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "FEWEST_REPEATS",
    "UNKNOWN",
    "Interval",
    "exp",
    "geometric_interval",
    "jackknife",
    "mean_interval",
    "median_interval",
    "product_mean",
    "ratio_interval",
    "signed_root",
    "sound",
    "sound_below",
    "student",
]

Floats = NDArray[np.float64]

FEWEST_REPEATS = 3
"""Least number of repeats for a trusted interval. With two, Student's interval is 12.7 standard errors wide, and the
tails cannot be seen."""
FEWEST_FOR_MEDIAN = 6
"""Least number of repeats for a trusted median. The extremes of six hold their median between them in 1 - 2 / 2^6 = 97
% of cases; of five, in 94 %."""


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval, and notes on whether the interval can be trusted."""

    value: float
    """The estimate. NaN where nothing is known; ``inf`` is a statement, such as a time that never comes."""
    low: float
    high: float
    trusted: bool = True
    """Whether the interval holds the truth in 95 % of cases; if not, ``note`` says why."""
    note: str = ""
    """Caveats beside the number: why it cannot be trusted, or that it is extrapolated."""
    bound: Literal["", "low", "high"] = ""
    """The end that is still valid (97.5 %, one-sided) when the interval as a whole is not trusted."""
    reach: float = 1.0
    """Distance from the measured range, as a factor: above 1 the number is extrapolated."""

    @property
    def known(self) -> bool:
        """Whether the value is a finite number."""
        return math.isfinite(self.value)

    def doubted(self, reason: str) -> Interval:
        """Return the same numbers, marked as not trusted, with this reason added to the note."""
        return replace(self, trusted=False, bound="", note=join((self.note, reason)))

    def bounded(self, end: Literal["low", "high"], reason: str) -> Interval:
        """Return the same numbers, marked as not trusted, with at most one end that still holds by itself.

        ``end`` is that end, if it held before; ``reason`` is added to the note.
        """
        kept = end if self.trusted or self.bound == end else ""
        return replace(self.doubted(reason), bound=kept)

    def telling(self, within: float) -> Interval:
        """Return the same numbers; a valid lower end no longer counts if it is ``within`` times below the value.

        An end that far off says nothing. If the value is infinite, every lower end above 0 says something.
        """
        if self.bound != "low" or (math.isinf(self.value) and self.low > 0.0) or self.low * within >= self.value:
            return self
        return replace(self, bound="")

    def deciding(self) -> Interval:
        """Return the same ratio; a single valid end no longer counts if it does not exclude 1.

        Such an end does not decide which of the two numbers is larger.
        """
        lost = (self.bound == "low" and not self.low > 1.0) or (self.bound == "high" and not self.high < 1.0)
        return replace(self, bound="") if lost else self

    def widened(self, more: float, end: Literal["low", "high"] = "high") -> Interval:
        """Return the interval of a positive number with one end moved outwards by the factor ``1 + more``."""
        if end == "high":
            return replace(self, high=self.high * (1.0 + more))
        return replace(self, low=self.low / (1.0 + more))

    def noted(self, note: str) -> Interval:
        """Return the same numbers with an additional note."""
        return replace(self, note=join((self.note, note)))

    def map(self, function: Callable[[float], float]) -> Interval:
        """Return the interval of ``function`` of the number; the function is monotonic."""
        ends = function(self.low), function(self.high)
        turned: dict[str, Literal["", "low", "high"]] = {"": "", "low": "high", "high": "low"}
        bound = self.bound if ends[0] <= ends[1] else turned[self.bound]
        return replace(self, value=function(self.value), low=min(ends), high=max(ends), bound=bound)


UNKNOWN = Interval(math.nan, math.nan, math.nan, trusted=False)


@lru_cache
def student(degrees: float, level: float = 0.95) -> float:
    """Return the two-sided quantile of Student's t with these degrees of freedom.

    The deviate is between minus and plus this quantile with a probability of ``level``.
    """
    from scipy import stats  # late: slow to import

    return float(stats.t.ppf(0.5 + 0.5 * level, degrees))


def mean_interval(values: ArrayLike) -> Interval:
    """Return the mean of independent values with Student's interval.

    A single value has an interval without limits. With fewer than `FEWEST_REPEATS` values the interval is not trusted.
    """
    numbers = np.asarray(values, np.float64)
    if numbers.size == 0 or not np.isfinite(numbers).all():
        return replace(UNKNOWN, note="no value" if numbers.size == 0 else "a value is not finite")
    value = float(numbers.mean())
    if numbers.size == 1:
        return Interval(value, -math.inf, math.inf).doubted("one repeat has no spread")
    half = student(numbers.size - 1) * float(numbers.std(ddof=1)) / math.sqrt(numbers.size)
    return few(Interval(value, value - half, value + half), numbers.size)


def few(interval: Interval, repeats: int) -> Interval:
    """Return the interval, marked as not trusted if it comes from fewer than `FEWEST_REPEATS` repeats."""
    if repeats >= FEWEST_REPEATS:
        return interval
    return interval.doubted(f"only {repeats} repeat{'s' * (repeats != 1)}, and {FEWEST_REPEATS} are the least")


def geometric_interval(values: ArrayLike) -> Interval:
    """Return the geometric mean of positive independent values with Student's interval of their logarithms."""
    numbers = np.asarray(values, np.float64)
    if (numbers <= 0.0).any():
        return replace(UNKNOWN, note="a value is not positive")
    return mean_interval(np.log(numbers)).map(exp)


def median_interval(values: ArrayLike) -> Interval:
    """Return the median of independent values with an interval that is valid for any distribution.

    The sign test's intervals reach from one of the ordered values to another. The result is interpolated between the
    narrowest interval with more than 95 % and the next narrower one (Hettmansperger & Sheather 1986). With fewer than
    six values the range of all is returned, which holds less than 95 % and is not trusted. Values and ends may be
    infinite.
    """
    numbers = np.sort(np.asarray(values, np.float64))
    if numbers.size == 0 or np.isnan(numbers).any():
        return replace(UNKNOWN, note="no value" if numbers.size == 0 else "a value is not known")
    middle, count = float(np.median(numbers)), numbers.size
    if count < FEWEST_FOR_MEDIAN:
        reason = f"only {count} repeat{'s' * (count != 1)}, and {FEWEST_FOR_MEDIAN} are the least for a median"
        return Interval(middle, float(numbers[0]), float(numbers[-1])).doubted(reason)
    first, weight = _sign_test(count)
    low, high = (_between(ends[first - 1], ends[first], weight) for ends in (numbers, numbers[::-1]))
    return Interval(middle, low, high)


@lru_cache
def _sign_test(count: int) -> tuple[int, float]:
    """Return the place of the wider interval's lower end, from 1, and how far it moves towards the next place."""
    from scipy.stats import binom as binomial  # late: slow to import

    first = int(binomial.ppf(0.025, count, 0.5))
    wide, narrow = (1.0 - 2.0 * float(binomial.cdf(first - 1 + more, count, 0.5)) for more in (0, 1))
    share = (wide - 0.95) / (wide - narrow)
    return first, (count - first) * share / (first + (count - 2 * first) * share)


def _between(outer: float, inner: float, weight: float) -> float:
    """Return the outer of two numbers moved towards the inner one; an infinite one stays unchanged."""
    return float(outer + weight * (inner - outer)) if math.isfinite(outer) else float(outer)


def ratio_interval(numerators: ArrayLike, denominators: ArrayLike) -> Interval:
    """Return the ratio of the means of two paired sets of positive values, with its interval.

    The interval is formed on the logarithm. The pairs (one per repeat) may be correlated, which the jackknife over
    pairs takes into account. The ratio of means is used, since the mean of ratios is biased by the noise of the
    denominators.
    """
    top, bottom = np.asarray(numerators, np.float64), np.asarray(denominators, np.float64)

    def log_ratio(kept: Floats) -> float:
        above, below = float(top[_chosen(kept)].mean()), float(bottom[_chosen(kept)].mean())
        return math.log(above / below) if above > 0.0 and below > 0.0 else math.nan

    return jackknife(log_ratio, top.size).map(exp)


def jackknife(statistic: Callable[[Floats], float], repeats: int) -> Interval:
    """Return the value and interval of a smooth function of means over repeats, by the jackknife.

    Pseudo-values ``K s - (K - 1) s_r``, with s_r the statistic without repeat r, are treated as K independent values
    (Tukey 1958; Efron & Tibshirani 1993, ch. 11). The value returned is their mean. To first order it is free of the
    bias from the function's curvature.

    Parameters
    ----------
    statistic
        Function of the weights of the repeats, (K,), each 0 or 1.
    repeats
        K, the number of repeats.

    """
    everything = np.ones(repeats)
    whole = statistic(everything)
    if not math.isfinite(whole):
        return Interval(whole, math.nan, math.nan, trusted=False)
    if repeats < 2:
        return Interval(whole, -math.inf, math.inf).doubted("one repeat has no spread")
    left_out = np.array([statistic(np.where(np.arange(repeats) == r, 0.0, everything)) for r in range(repeats)])
    if not np.isfinite(left_out).all():
        return Interval(whole, -math.inf, math.inf).doubted("without one of the repeats there is no value")
    return mean_interval(repeats * whole - (repeats - 1) * left_out)


def join(reasons: Iterable[str]) -> str:
    """Return the notes in one text, separated by semicolons, each once."""
    return "; ".join(dict.fromkeys(reason for reason in reasons if reason))


def _chosen(kept: Floats) -> NDArray[np.bool_]:
    return kept > 0.0


def exp(value: float) -> float:
    """Return e to the power ``value``: infinity where float64 would overflow, and NaN for NaN."""
    return math.inf if value >= 700.0 else math.exp(value)


def sound(interval: Interval) -> bool:
    """Tell whether an interval of a positive number is trusted, with value and ends finite and above 0."""
    return interval.trusted and all(0.0 < x < math.inf for x in (interval.value, interval.low, interval.high))


def sound_below(interval: Interval) -> bool:
    """Tell whether at least the lower end of an interval of a positive number is valid, and is above 0."""
    return (interval.trusted or interval.bound == "low") and 0.0 < interval.low <= interval.value < math.inf


def product_mean(intervals: Sequence[Interval]) -> Interval:
    """Return the geometric mean of independently measured positive numbers, with the interval that follows from theirs.

    If only the lower end of some of the numbers is valid, only the lower end of the mean is.
    """
    logs = [[math.log(x) for x in (i.value, i.low, i.high)] for i in intervals]
    mean = sum(value for value, _, _ in logs) / len(logs)
    below = math.sqrt(sum((value - low) ** 2 for value, low, _ in logs)) / len(logs)
    above = math.sqrt(sum((high - value) ** 2 for value, _, high in logs)) / len(logs)
    trusted = all(interval.trusted for interval in intervals)
    bound: Literal["", "low"] = "low" if not trusted and all(map(sound_below, intervals)) else ""
    return Interval(math.exp(mean), math.exp(mean - below), math.exp(mean + above), trusted, bound=bound)


def signed_root(square: float) -> float:
    """Return the square root of the absolute value, with the sign of the argument."""
    return math.copysign(math.sqrt(abs(square)), square)
