"""Numbers with their 95 % intervals, from a few independent repeats.

A repeat is a whole run with its own seed. So repeats are independent of each other, even if a run uses low-discrepancy
points, lets one image grow from checkpoint to checkpoint, or divides pixels by a common denominator. Every interval
comes from the spread over K repeats alone, by Student's t with K - 1 degrees of freedom. The one remaining assumption
is that the numbers are near enough to normal. It fails where a few rare events make up the error.
`equaltime.film.tails` detects that case; the fields ``trusted`` and ``note`` of an interval tell it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.words import Shown, figure, time_unit, with_ends

__all__ = [
    "FEWEST_REPEATS",
    "TELLING",
    "TOO_WIDE",
    "UNKNOWN",
    "Z95",
    "Estimate",
    "Interval",
    "Unit",
    "exp",
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

Z95 = 1.959964
"""Two-sided quantile of the normal distribution: a deviate is within ± `Z95` with a probability of 95 %."""

FEWEST_REPEATS = 3
"""Least number of repeats for a trusted interval. With two, Student's interval reaches 12.7 standard errors to each
side, and heavy tails cannot be detected."""
FEWEST_FOR_MEDIAN = 6
"""Least number of repeats for a trusted median. The true median is between the smallest and the largest of six values
with a probability of 1 - 2 / 2^6 = 97 %; with five values, of 94 %."""


TELLING = 10.0
"""Largest factor between a number and an end of its interval: an end farther away says nothing about the number."""
TOO_WIDE = f"these runs cannot tell it within a factor of {TELLING:g}"
"""Note of a number that is not given, because both ends of its interval are farther away than `TELLING`."""

Unit = Literal["", "%", "s", "spp", "MB"]
_SIZES: Mapping[str, float] = {"": 1.0, "%": 0.01, "s": 1.0, "spp": 1.0, "MB": 1e6}
"""Sizes of the units, by which numbers are divided when they are printed."""


@dataclass(frozen=True, repr=False)
class Interval(Shown):
    """A number with its 95 % interval, and notes that tell whether the interval can be trusted.

    A format specification prints the number in a unit: ``%`` for fractions, ``s``, ``spp``, ``MB`` for bytes. Without
    one, the number is printed in its own ``unit``. A unit that does not exist raises ValueError. Two significant digits
    are printed, or more where the ends are so near that two would be the same.

    >>> error = Interval(0.0231, 0.0228, 0.0234)
    >>> print(f"{error:%}")
    2.31 % (2.28 to 2.34)
    >>> print(error.in_unit("%"))
    2.31 % (2.28 to 2.34)
    """

    value: float
    """The estimate; NaN if it is unknown. ``inf`` is a result, such as the time of an event that never happens."""
    low: float
    high: float
    trusted: bool = True
    """Whether the interval holds the truth in 95 % of cases; if not, ``note`` says why."""
    note: str = ""
    """Caveats beside the number: why it cannot be trusted, or that it is extrapolated."""
    bound: Literal["", "low", "high"] = ""
    """The end that is still valid by itself (97.5 %, one-sided) although the interval is not trusted; empty if none
    is."""
    reach: float = 1.0
    """Factor by which a time lies outside the measured times; above 1 the value is extrapolated, else it is 1."""
    unit: Unit = field(default="", compare=False)
    """Unit in which the number is printed; empty for a plain number."""

    @property
    def known(self) -> bool:
        """Whether the value is a finite number."""
        return math.isfinite(self.value)

    @property
    def doubt(self) -> str:
        """Reason why the interval cannot be trusted; empty if it can be."""
        return "" if self.trusted else self.note

    def in_unit(self, unit: Unit) -> Interval:
        """Return a copy that is printed in ``unit``; the numbers stay the same."""
        return replace(self, unit=unit)

    def doubted(self, reason: str) -> Interval:
        """Return a copy that is marked as not trusted; ``reason`` is added to its note."""
        return replace(self, trusted=False, bound="", note=join((self.note, reason)))

    def bounded(self, end: Literal["low", "high"], reason: str) -> Interval:
        """Return a copy that is marked as not trusted, except for one end.

        ``end`` names the end that is still valid by itself, if it was valid before. ``reason``, in words, is added to
        the note.
        """
        kept = end if self.trusted or self.bound == end else ""
        return replace(self.doubted(reason), bound=kept)

    def telling(self) -> Interval:
        """Return a copy of this interval of a positive number that does not state what says too little.

        An end is far if it is more than `TELLING` times off the value. If both ends of a trusted interval are far, the
        result is unknown and has the note `TOO_WIDE`. If one end of a trusted interval is 0 or infinite, the other end
        alone stays valid. An untrusted interval loses its valid end if that is far. An infinite value only loses a
        valid lower end of 0. A value of 0, or an unknown one, changes nothing.
        """
        if self.value == 0.0 or math.isnan(self.value) or (math.isinf(self.value) and (self.trusted or self.low > 0.0)):
            return self
        far_below, far_above = not self.low * TELLING >= self.value, not self.high <= TELLING * self.value
        if self.trusted and far_below and far_above:
            return replace(UNKNOWN, note=join((self.note, TOO_WIDE)))
        if self.trusted and not self.low > 0.0:
            return self.bounded("high", "the interval has no lower end")
        if self.trusted and not self.high < math.inf:
            return self.bounded("low", "the interval has no upper end")
        far = (self.bound == "low" and far_below) or (self.bound == "high" and far_above)
        return replace(self, bound="") if far else self

    def deciding(self) -> Interval:
        """Return a copy of this interval of a ratio, for the question which of the two numbers is larger.

        If only one end of the interval is valid, the copy keeps that end as valid only if it excludes 1. Otherwise the
        end does not decide the question.
        """
        lost = (self.bound == "low" and not self.low > 1.0) or (self.bound == "high" and not self.high < 1.0)
        return replace(self, bound="") if lost else self

    def widened(self, more: float, end: Literal["low", "high"] = "high") -> Interval:
        """Return a copy of this interval of a positive number with one end moved outwards.

        If ``end`` is ``high``, the upper end is multiplied by ``1 + more``. If it is ``low``, the lower end is divided
        by ``1 + more``.
        """
        if end == "high":
            return replace(self, high=self.high * (1.0 + more))
        return replace(self, low=self.low / (1.0 + more))

    def noted(self, note: str) -> Interval:
        """Return a copy with the text ``note`` added to the field of that name."""
        return replace(self, note=join((self.note, note)))

    def map(self, function: Callable[[float], float]) -> Interval:
        """Return the interval of ``function(x)``, where x is this interval's number, from its value and its ends.

        ``function`` must be monotonic. If it decreases, the ends change places. The result has no unit.
        """
        ends = function(self.low), function(self.high)
        turned: dict[str, Literal["", "low", "high"]] = {"": "", "low": "high", "high": "low"}
        bound = self.bound if ends[0] <= ends[1] else turned[self.bound]
        return replace(self, value=function(self.value), low=min(ends), high=max(ends), bound=bound, unit="")

    def with_bias(self, bias: Interval | None) -> Interval:
        """Return the total error of an image, with this interval as its noise: the root of noise² plus bias².

        The total keeps the reasons for doubt (``doubt``) of both. ``bias`` None stands for no bias.
        """
        if bias is None:
            return self
        value, low, high = (
            math.hypot(*both) for both in ((self.value, bias.value), (self.low, bias.low), (self.high, bias.high))
        )
        total = Interval(value, low, high)
        reasons = join((self.doubt, bias.doubt))
        return total.doubted(reasons) if reasons else total

    def as_dict(self) -> dict[str, Any]:
        """Return the interval as JSON data; numbers that are not finite are None.

        The keys are ``value``, ``low``, ``high`` and ``trusted``. Further keys are present only if they apply.
        ``never`` is true if the value is infinite. ``doubt`` says why the interval is not trusted, and ``note`` has the
        caveats of a trusted one. ``bound`` is the end that is still valid, and ``reach`` the factor of extrapolation.
        """
        numbers = {"value": self.value, "low": self.low, "high": self.high}
        more = {
            "never": math.isinf(self.value),
            "doubt": self.doubt,
            "note": self.note if self.trusted else "",
            "bound": self.bound,
            "reach": self.reach if self.reach != 1.0 else None,
        }
        return {
            **{name: number if math.isfinite(number) else None for name, number in numbers.items()},
            "trusted": self.trusted,
            **{name: said for name, said in more.items() if said},
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Interval:
        """Return the interval from the data that `as_dict` made; limits that are None are infinite."""
        never = bool(data.get("never"))
        none = {"value": math.inf if never else math.nan, "low": math.inf if never else -math.inf, "high": math.inf}
        value, low, high = (other if data[key] is None else float(data[key]) for key, other in none.items())
        doubt = data.get("doubt") or ""
        trusted, note = data.get("trusted", not doubt), doubt or data.get("note") or ""
        return cls(value, low, high, trusted, note, data.get("bound", ""), float(data.get("reach", 1.0)))

    def __format__(self, unit: str) -> str:
        if unit not in _SIZES:
            raise ValueError(f"'{unit}' is no unit of an interval; expected %, s, spp or MB")
        if not self.known:
            return "never" if math.isinf(self.value) else "unknown"
        unit = unit or self.unit
        name, size = time_unit(self.value) if unit == "s" else (unit, _SIZES[unit])
        if not self.high > self.low:
            return f"{figure(self.value / size)}{name and f' {name}'}"
        value, low, high = with_ends(*(number / size for number in (self.value, self.low, self.high)))
        return f"{value}{name and f' {name}'} ({low} to {high if math.isfinite(self.high) else 'unknown'})"

    def __str__(self) -> str:
        return format(self, "")

    def __repr__(self) -> str:
        ends = f"{self.value!r}, {self.low!r}, {self.high!r}"
        others = ((field.name, field.default, getattr(self, field.name)) for field in fields(self)[3:])
        said = "".join(f", {name}={value!r}" for name, default, value in others if value != default)
        return f"Interval({ends}{said})"


Estimate = Interval
"""Second name of `Interval`, which ``equaltime`` exports for the estimates that a render makes of itself."""

UNKNOWN = Interval(math.nan, math.nan, math.nan, trusted=False)


@lru_cache
def student(degrees: float, level: float = 0.95) -> float:
    """Return the two-sided quantile of Student's t with ``degrees`` degrees of freedom.

    A deviate is between minus and plus this quantile with a probability of ``level``, in (0, 1).
    """
    from scipy import stats  # late: slow to import

    return float(stats.t.ppf(0.5 + 0.5 * level, degrees))


def mean_interval(values: ArrayLike) -> Interval:
    """Return the mean of independent values (N,) with its 95 % interval, by Student's t.

    A single value has an interval without limits. With fewer than `FEWEST_REPEATS` values the interval is not trusted.
    The mean is NaN without values, or if a value is not finite.
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
    """Return ``interval``, marked as not trusted if it comes from too few ``repeats``: fewer than `FEWEST_REPEATS`."""
    if repeats >= FEWEST_REPEATS:
        return interval
    return interval.doubted(f"only {repeats} repeat{'s' * (repeats != 1)}, and {FEWEST_REPEATS} are the least")


def median_interval(values: ArrayLike) -> Interval:
    """Return the median of independent values with a 95 % interval that is valid for any distribution.

    The sign test's intervals reach from one of the ordered values to another. The returned interval is interpolated
    between the narrowest one with more than 95 % and the next narrower one (Hettmansperger & Sheather 1986). With fewer
    than six values the interval is the range of all values, which holds less than 95 % and is not trusted. Values and
    ends may be infinite.
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
    """Return the mean of ``numerators`` over the mean of ``denominators``, with the 95 % interval of this ratio.

    Both are positive values (N,), one pair for each repeat. The values of a pair may be correlated; the jackknife over
    pairs allows for that. The interval is formed on the logarithm. A mean of ratios would be biased by the noise of the
    denominators.
    """
    top, bottom = np.asarray(numerators, np.float64), np.asarray(denominators, np.float64)

    def log_ratio(kept: Floats) -> float:
        above, below = float(top[_chosen(kept)].mean()), float(bottom[_chosen(kept)].mean())
        return math.log(above / below) if above > 0.0 and below > 0.0 else math.nan

    return jackknife(log_ratio, top.size).map(exp)


def jackknife(statistic: Callable[[Floats], float], repeats: int) -> Interval:
    """Return the value and 95 % interval of a smooth function of means over repeats, by the jackknife.

    Pseudo-values ``K s - (K - 1) s_r``, with s_r the statistic without repeat r, are treated as K independent values
    (Tukey 1958; Efron & Tibshirani 1993, ch. 11). The value returned is their mean. To first order it is free of the
    bias from the function's curvature.

    Parameters
    ----------
    statistic
        Function of the weights of the repeats, (K,), each 0 or 1; it returns the statistic of repeats with weight 1.
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
        return Interval(whole, -math.inf, math.inf).doubted("the value is unknown without one of the repeats")
    return mean_interval(repeats * whole - (repeats - 1) * left_out)


def join(reasons: Iterable[str]) -> str:
    """Return several reasons or notes in one text, separated by semicolons; empty and repeated ones are dropped."""
    return "; ".join(dict.fromkeys(reason for reason in reasons if reason))


def _chosen(kept: Floats) -> NDArray[np.bool_]:
    return kept > 0.0


def exp(value: float) -> float:
    """Return e to the power ``value``: infinity where float64 would overflow, and NaN for NaN."""
    return math.inf if value >= 700.0 else math.exp(value)


def sound(interval: Interval) -> bool:
    """Tell whether an interval of a positive number is complete: trusted, with a finite value and ends above 0."""
    return interval.trusted and all(0.0 < x < math.inf for x in (interval.value, interval.low, interval.high))


def sound_below(interval: Interval) -> bool:
    """Tell whether an interval of a positive number gives a lower limit: its lower end is valid and above 0."""
    return (interval.trusted or interval.bound == "low") and 0.0 < interval.low <= interval.value < math.inf


def product_mean(intervals: Sequence[Interval]) -> Interval:
    """Return the geometric mean of positive numbers that were measured independently, with its interval.

    All ends of ``intervals`` must be above 0. The result is trusted if all ``intervals`` are. If the lower ends of all
    are valid, but not all are trusted, only the lower end of the result is valid.
    """
    logs = [[math.log(x) for x in (i.value, i.low, i.high)] for i in intervals]
    mean = sum(value for value, _, _ in logs) / len(logs)
    below = math.sqrt(sum((value - low) ** 2 for value, low, _ in logs)) / len(logs)
    above = math.sqrt(sum((high - value) ** 2 for value, _, high in logs)) / len(logs)
    trusted = all(interval.trusted for interval in intervals)
    bound: Literal["", "low"] = "low" if not trusted and all(map(sound_below, intervals)) else ""
    return Interval(math.exp(mean), math.exp(mean - below), math.exp(mean + above), trusted, bound=bound)


def signed_root(square: float) -> float:
    """Return the square root of the absolute value of ``square``, with the sign of ``square``."""
    return math.copysign(math.sqrt(abs(square)), square)
