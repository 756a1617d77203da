"""Numbers and values as people write and read them."""

from __future__ import annotations

import html
import re

__all__ = ["Shown", "duration", "percent", "seconds_of"]

_UNITS = [("ms", 1e-3, 0.9995), ("s", 1.0, 299.5), ("min", 60.0, 1.8e4), ("h", 3600.0, 3.6e5)]
"""Units of time: name, seconds, and the number of seconds from which the next unit serves better."""
_SECONDS = {"ms": 0.001, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "day": 86400.0, "days": 86400.0}
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
_PART = rf"({_NUMBER})({'|'.join(sorted(_SECONDS, key=len, reverse=True))})"


def seconds_of(text: str) -> float:
    """Read ``10s``, ``500ms``, ``2.5m``, ``1h30m``, ``2d`` or plain seconds; raises ValueError for anything else."""
    words = text.strip().lower().replace(" ", "")
    if re.fullmatch(_NUMBER, words):
        words += "s"
    if not re.fullmatch(f"({_PART})+", words):
        raise ValueError(f"'{text}' is no duration; write 10s, 500ms, 2.5m or 1h30m")
    return sum(float(number) * _SECONDS[unit] for number, unit in re.findall(_PART, words))


def duration(seconds: float) -> str:
    """Write a time for people: ``12.3 ms``, ``4.56 s``, ``7.89 min``, ``12.3 h``, ``456 days``."""
    unit, size = next(((name, size) for name, size, most in _UNITS if seconds < most), ("days", 86400.0))
    return f"{seconds / size:.3g} {unit}"


def percent(error: float) -> str:
    """Write an error for people: ``2.5 %``."""
    return f"{100.0 * error:.3g} %"


class Shown:
    """Base of values that functions return: printed and in notebooks they show their answer, not all their fields.

    A subclass defines ``__str__``: the answer in the first line, then at most ten lines.
    """

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self).splitlines()[0]})"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"
