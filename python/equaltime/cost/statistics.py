"""Numbers with their 95 % intervals, from a few independent repeats.

A repeat is a whole run with its own seed, so repeats are independent whatever a run does inside (low-discrepancy
points, images that grow from checkpoint to checkpoint, pixels that share a denominator). Nothing here looks inside:
every interval comes from the spread over K repeats, by Student's t with K - 1 degrees of freedom. That the numbers are
near enough to normal is the one assumption left; it fails where a few rare events make up the error. `tails` looks
for that, and what it finds is carried as ``trusted`` and ``note`` of the interval.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.cost.extras import optional

__all__ = [
    "FEWEST_REPEATS",
    "UNKNOWN",
    "Interval",
    "geometric_interval",
    "jackknife",
    "mean_interval",
    "ratio_interval",
    "student",
]

Floats = NDArray[np.float64]

FEWEST_REPEATS = 3
"""With two, Student's interval is 12.7 standard errors wide, and nothing can be seen of the tails."""


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval."""

    value: float
    """NaN where nothing is known; ``inf`` is a statement, such as a time that never comes."""
    low: float
    high: float
    trusted: bool = True
    """Whether the interval holds the truth in 95 % of cases; if not, ``note`` says why."""
    note: str = ""
    """What must be said beside the number: why it cannot be trusted, or that it is extrapolated."""

    @property
    def known(self) -> bool:
        """Whether there is a number at all."""
        return math.isfinite(self.value)

    def doubted(self, reason: str) -> Interval:
        """Return the same numbers, not to be trusted for this reason as well."""
        return replace(self, trusted=False, note=f"{self.note}; {reason}" if self.note else reason)

    def noted(self, note: str) -> Interval:
        """Return the same numbers with one more thing to say."""
        return replace(self, note=f"{self.note}; {note}" if self.note else note)

    def map(self, function: Callable[[float], float]) -> Interval:
        """Return the interval of an increasing or decreasing function of the number."""
        ends = function(self.low), function(self.high)
        return replace(self, value=function(self.value), low=min(ends), high=max(ends))


UNKNOWN = Interval(math.nan, math.nan, math.nan, trusted=False)


@lru_cache
def student(degrees: float, level: float = 0.95) -> float:
    """Return the two-sided quantile of Student's t: 95 % of deviates are within plus and minus this."""
    return float(optional("scipy.stats").t.ppf(0.5 + 0.5 * level, degrees))


def mean_interval(values: ArrayLike) -> Interval:
    """Return the mean of independent values with Student's interval.

    One value has no interval (``low`` and ``high`` are infinite); fewer than `FEWEST_REPEATS` are not trusted.
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
    """Doubt an interval that rests on too few repeats."""
    if repeats >= FEWEST_REPEATS:
        return interval
    return interval.doubted(f"only {repeats} repeat{'s' * (repeats != 1)}, and {FEWEST_REPEATS} are the least")


def geometric_interval(values: ArrayLike) -> Interval:
    """Return the geometric mean of positive independent values with Student's interval of their logarithms."""
    numbers = np.asarray(values, np.float64)
    if (numbers <= 0.0).any():
        return replace(UNKNOWN, note="a value is not positive")
    return mean_interval(np.log(numbers)).map(_exp)


def ratio_interval(numerators: ArrayLike, denominators: ArrayLike) -> Interval:
    """Return the ratio of the means of two paired sets of positive values, formed on the logarithm.

    The pairs (one a repeat) may be correlated; the jackknife over pairs sees that. Means are compared, not the mean of
    ratios, which is biased by the noise of the denominators.
    """
    top, bottom = np.asarray(numerators, np.float64), np.asarray(denominators, np.float64)

    def log_ratio(kept: Floats) -> float:
        above, below = float(top[_chosen(kept)].mean()), float(bottom[_chosen(kept)].mean())
        return math.log(above / below) if above > 0.0 and below > 0.0 else math.nan

    return jackknife(log_ratio, top.size).map(_exp)


def jackknife(statistic: Callable[[Floats], float], repeats: int) -> Interval:
    """Return the interval of a smooth function of the means over repeats (Tukey 1958; Efron & Tibshirani 1993, ch. 11).

    Pseudo-values ``K s - (K - 1) s_r``, with s_r the statistic without repeat r, are treated as K independent values.
    Their mean is the value returned: to first order free of the bias that comes of the function's curvature.

    Parameters
    ----------
    statistic
        Takes the weights of the repeats, (K,), each 0 or 1.
    repeats
        K.

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
    """Join what is to be said, each once."""
    return "; ".join(dict.fromkeys(reason for reason in reasons if reason))


def _chosen(kept: Floats) -> NDArray[np.bool_]:
    return kept > 0.0


def _exp(value: float) -> float:
    return math.exp(value) if value < 700.0 else math.inf
