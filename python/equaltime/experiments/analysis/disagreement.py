"""Numbers that a renderer with another picture does not get: errors and times that its difference would spoil.

A renderer that fails the test of agreement is measured against a reference of its own, which tells its noise alone. Its
error against the common reference is at least its difference. So errors that are not much larger than the difference
mean nothing beside errors of other strategies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from equaltime.experiments.model.summary import DISAGREES, StrategyResult
from equaltime.statistics.curves import BELOW
from equaltime.statistics.in_words import in_percent
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.words import percent

__all__ = ["NEGLIGIBLE", "least_error", "off_by", "reason", "withheld"]

NEGLIGIBLE = 5.0
"""Least multiple of a renderer's difference that an error must be: noise and difference add as squares, so the
difference then makes at most 2 % of the error."""


def least_error(difference: Interval | None) -> float:
    """Return the smallest relative error that a renderer gets whose picture is off by ``difference``.

    It is 0 without a difference (None), and infinite if the difference has no known upper limit.
    """
    if difference is None:
        return 0.0
    known = (difference.trusted or difference.bound == "high") and math.isfinite(difference.high)
    return NEGLIGIBLE * max(difference.high, 0.0) if known else math.inf


def off_by(difference: Interval) -> str:
    """Return a difference of pictures in per cent: ``35 % (30 to 41)``.

    If only the upper end of its interval is valid, the text is ``up to 41 %``.
    """
    return f"up to {percent(difference.high)}" if difference.bound == "high" else in_percent(difference)


def reason(difference: Interval | None) -> str:
    """Return a sentence on why a renderer lacks errors and times; empty for a renderer without a difference (None)."""
    if difference is None:
        return ""
    least = least_error(difference)
    if math.isinf(least):
        return f"its picture {DISAGREES}, by how much is not known: no error and no time is given"
    return (
        f"its picture {DISAGREES} by {off_by(difference)}: no error below {percent(least)} is given, and no time to one"
    )


def withheld(result: StrategyResult, baseline: Interval | None) -> StrategyResult:
    """Return ``result`` without the numbers that cannot be trusted, since a strategy converges to another picture.

    If the strategy's own picture differs from the reference (``result.difference``), its errors and times below the
    difference are unknown, and its ``bias`` is the difference. ``baseline`` is the difference of the baseline's
    picture; it makes ratios unknown too. None means no difference. The note of an unknown number tells the `reason`.
    """
    own, theirs = result.difference, baseline
    least = least_error(own)
    least_ratio = max(least, least_error(theirs))
    if least_ratio == 0.0:
        return result
    why, why_ratio = reason(own), reason(own) if least > 0.0 else f"baseline: {reason(theirs)}"

    def is_spoilt(error: Interval) -> bool:
        """Tell whether an error is too small beside the difference, below what its own reference shows, or unknown."""
        return least > 0.0 and (not error.value >= least or BELOW in error.note)

    def kept(error: Interval) -> Interval:
        return UNKNOWN.noted(why) if is_spoilt(error) else error

    def at_targets(given: Callable[[float], bool], numbers: dict[float, Interval], note: str) -> dict[float, Interval]:
        known = {target: given(target) and BELOW not in number.note for target, number in numbers.items()}
        return {target: number if known[target] else UNKNOWN.noted(note) for target, number in numbers.items()}

    curve = result.curve
    spoilt = any(map(is_spoilt, curve.error))
    last = curve.error[-1].value if curve.error else math.nan
    ratios_spoilt = last < least_ratio
    return replace(
        result,
        bias=result.bias if own is None else own,
        curve=replace(
            curve,
            error=tuple(map(kept, curve.error)),
            slope=UNKNOWN.noted(why) if spoilt else curve.slope,
        ),
        time_to=at_targets(lambda target: target >= least, dict(result.time_to), why),
        ratio=at_targets(lambda target: target >= least_ratio, dict(result.ratio), why_ratio),
        efficiency=UNKNOWN.noted(why_ratio) if ratios_spoilt else result.efficiency,
        fewer_samples=UNKNOWN.noted(why_ratio) if ratios_spoilt else result.fewer_samples,
        error_at_budget=kept(result.error_at_budget),
        image_error=None if (result.image_error or 0.0) < least else result.image_error,
        notes=(*result.notes, why) if why else result.notes,
    )
