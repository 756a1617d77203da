"""Intervals in words, such as ``2.1 s (1.9 to 2.4)``: one unit for the number and both ends."""

from __future__ import annotations

import math

from equaltime.statistics.intervals import Interval
from equaltime.words import time_unit

__all__ = ["about", "figure", "in_percent", "in_time", "span"]


def figure(number: float) -> str:
    """Return a number with three significant digits and without exponent: ``0.0523``, ``6.4``, ``1,040``."""
    return f"{float(f'{number:.3g}'):,.12g}"


def span(interval: Interval, scale: float = 1.0) -> str:
    """Return the ends of an interval, multiplied by ``scale``, in brackets: ``(1.9 to 2.4)``; empty without ends."""
    low, high = scale * interval.low, scale * interval.high
    if math.isfinite(low) and math.isfinite(high):
        return f"({figure(low)} to {figure(high)})"
    return f"({figure(low)} or more)" if math.isfinite(low) else ""


def in_percent(interval: Interval) -> str:
    """Return a fraction and its interval in per cent: ``1.7 % (1.5 to 2)``."""
    return f"{figure(100.0 * interval.value)} % {span(interval, 100.0)}".rstrip()


def in_time(interval: Interval) -> str:
    """Return a number of seconds and its interval, all in the unit that fits the number: ``5.8 min (4 to 12)``."""
    unit, size = time_unit(interval.value)
    return f"{figure(interval.value / size)} {unit} {span(interval, 1.0 / size)}".rstrip()


def about(interval: Interval) -> str:
    """Return the number with two digits if the rounded number is within the interval, else with three."""
    rounded = float(f"{interval.value:.2g}")
    return figure(rounded if interval.low <= rounded <= interval.high else interval.value)
