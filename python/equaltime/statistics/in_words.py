"""Intervals in words, such as ``2.1 s (1.9 to 2.4)``: one unit for the number and both ends.

Estimates of a render have at least two significant digits (`Interval.__format__`). Results of measurements have the
digits that their interval leaves sure (`in_percent`, `in_time`), as in tables (`places`).
"""

from __future__ import annotations

import math

from equaltime.statistics.intervals import Interval
from equaltime.words import figure, rounded, time_unit

__all__ = [
    "about",
    "beside_one",
    "count",
    "exponent",
    "figure",
    "in_percent",
    "in_time",
    "megabytes",
    "places",
    "probability",
    "read_off",
    "rounded",
    "span",
]


def places(value: float, low: float, high: float) -> tuple[int, int, int]:
    """Return the decimals with which a number and the two ends of its interval are printed.

    They show one digit of the half width, or two if its first digit is 1. The number has at least two significant
    digits, whatever its unit. A number without width gets three significant digits. Over powers of ten, decimals that
    suit the upper end would turn the lower end into 0, so it gets two digits.
    """
    half = 0.5 * (high - low)
    if half <= 0.0:
        digits = max(0, min(9, 2 - exponent(value)))
    else:
        first = exponent(half)
        digits = max(0, min(9, -first + (half / 10.0**first < 2.0)))
    if 0.0 < 10.0 * low <= high:
        return max(digits, 1 - exponent(value)), max(digits, 1 - exponent(low)), digits
    digits = max(digits, min(9, 1 - exponent(max(abs(value), half))))
    return digits, digits, digits


def exponent(value: float) -> int:
    """Return the power of ten of a number's first digit; 0 for 0 and for numbers that are not finite."""
    return math.floor(math.log10(abs(value))) if value and math.isfinite(value) else 0


def _texts(interval: Interval, scale: float) -> tuple[str, str, str]:
    """Return value and ends of an interval, multiplied by ``scale``, with their `places` but no zeros at the end."""
    numbers = tuple(scale * number for number in (interval.value, interval.low, interval.high))
    if not all(map(math.isfinite, numbers)):
        value, low, high = map(figure, numbers)
    else:
        value, low, high = (
            f"{round(x, beside_one(x, n)):,.12g}" for x, n in zip(numbers, places(*numbers), strict=True)
        )
    return value, low, high


def beside_one(number: float, digits: int) -> int:
    """Return the decimals with which ``number`` is printed: up to 3 more than ``digits``, if it would be rounded to 1.

    Whether an end of a ratio's interval is above or below 1 tells if there is a difference.
    """
    return next((n for n in range(digits, digits + 3) if round(number, n) != 1.0 or number == 1.0), digits + 3)


def span(interval: Interval, scale: float = 1.0) -> str:
    """Return the ends of an interval, multiplied by ``scale``, in brackets, as text: ``(1.9 to 2.4)``.

    If the upper end is infinite, the text is ``(1.9 or more)``. If the lower end is infinite or NaN, the text is empty.
    """
    low, high = scale * interval.low, scale * interval.high
    if math.isfinite(low) and math.isfinite(high):
        _, least, most = _texts(interval, scale)
        return f"({least} to {most})"
    return f"({figure(low)} or more)" if math.isfinite(low) else ""


def in_percent(interval: Interval) -> str:
    """Return a fraction and its interval in per cent: ``1.7 % (1.5 to 2)``."""
    return f"{_texts(interval, 100.0)[0]} % {span(interval, 100.0)}".rstrip()


def in_time(interval: Interval) -> str:
    """Return a number of seconds and its interval, all in the unit that fits the number: ``5.8 min (4 to 12)``."""
    unit, size = time_unit(interval.value)
    return f"{_texts(interval, 1.0 / size)[0]} {unit} {span(interval, 1.0 / size)}".rstrip()


def about(interval: Interval) -> str:
    """Return an interval's value as text with two significant digits, or more if rounding would leave the interval."""
    short = (float(f"{interval.value:.{digits}g}") for digits in (2, 3))
    held = next((number for number in short if interval.low <= number <= interval.high), None)
    if held is None and interval.low <= interval.value <= interval.high:
        return _texts(interval, 1.0)[0]
    return figure(interval.value if held is None else held)


def count(number: float) -> str:
    """Return a count of samples per pixel as text: a whole number from 10 on, else two significant digits."""
    return f"{number:,.0f}" if number >= 10.0 else f"{number:.2g}"


def megabytes(size: float) -> str:
    """Return ``size``, a number of bytes, as text in MB, or in GB from 1000 MB on."""
    return f"{rounded(size / 1e6)} MB" if size < 1e9 else f"{rounded(size / 1e9)} GB"


def probability(p: float) -> str:
    """Return a p-value as text, such as ``p = 0.03``, or ``p < 0.0001`` if it is smaller."""
    return f"p = {p:.2f}" if p >= 0.01 else f"p = {p:.4f}" if p >= 0.0001 else "p < 0.0001"


def read_off(*errors: Interval) -> str:
    """Return ``measured``, or ``extrapolated`` if one of these errors lies outside the runs."""
    return "measured" if all(error.reach == 1.0 for error in errors) else "extrapolated"
