"""Numbers with their intervals in a person's words: two digits, one unit, ends in brackets."""

from __future__ import annotations

import math

from equaltime.statistics.intervals import Interval
from equaltime.words import time_unit

__all__ = ["count", "error_range", "megabytes", "rounded", "time_range"]


def rounded(number: float, digits: int = 2) -> str:
    """Return a number with this many significant digits, and without an exponent: ``0.035``, ``3.5``, ``1,200``."""
    if number == 0.0 or not math.isfinite(number):
        return f"{number:g}"
    number = float(f"{number:.{digits - 1}e}")
    places = digits - 1 - math.floor(math.log10(abs(number)))
    return f"{number:,.{max(places, 0)}f}"


def error_range(error: Interval) -> str:
    """Return a relative error with its interval, such as ``3.5 % (3.3 to 3.9)``."""
    return _range(error, 0.01, "%")


def time_range(seconds: Interval) -> str:
    """Return a time with its interval, all in the unit of the value, such as ``5.8 min (4 to 12)``."""
    unit, size = time_unit(seconds.value)
    return _range(seconds, size, unit)


def count(number: float) -> str:
    """Return a number of samples per pixel: whole from 10 on, else with two digits."""
    return f"{number:,.0f}" if number >= 10.0 else f"{number:.2g}"


def megabytes(size: float) -> str:
    """Return a number of bytes in MB, or in GB from 1000 MB on."""
    return f"{rounded(size / 1e6)} MB" if size < 1e9 else f"{rounded(size / 1e9)} GB"


def _range(found: Interval, size: float, unit: str) -> str:
    if not found.known:
        return "unknown"
    value, low, high = (rounded(number / size) for number in (found.value, found.low, found.high))
    if not found.high > found.low:
        return f"{value} {unit}"
    return f"{value} {unit} ({low} to {high if math.isfinite(found.high) else 'unknown'})"
