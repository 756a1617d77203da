"""Text for people: numbers, times and values in messages, and suggestions for misspelt names."""

from __future__ import annotations

import difflib
import html
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from typing import Final, cast

__all__ = [
    "Shown",
    "a",
    "duration",
    "duration_of_runs",
    "error_of",
    "figure",
    "nearest",
    "percent",
    "rough_duration",
    "rounded",
    "seconds_of",
    "shortened",
    "suggestion",
    "time_unit",
    "with_ends",
    "without_numbers",
]

MOST_LISTED: Final = 20
"""Largest number of names that a message lists: all types of surfaces."""
MOST_NAMES: Final = 512
LONGEST_NAME: Final = 100
"""Limits of `nearest`: it looks for a similar name among at most `MOST_NAMES` names, for a word of at most
`LONGEST_NAME` letters. Its time grows with the product of both."""
_BRACKETS: Mapping[type[object], tuple[str, str]] = {list: ("[", "]"), tuple: ("(", ")"), dict: ("{", "}")}
_UNITS = [("ms", 1e-3, 0.9995), ("s", 1.0, 299.5), ("min", 60.0, 7190.0), ("h", 3600.0, 3.6e5)]
"""Units of time: name, seconds, and the number of seconds from which the next unit serves better."""
_SECONDS = {"ms": 0.001, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "day": 86400.0, "days": 86400.0}
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
_PART = rf"({_NUMBER})({'|'.join(sorted(_SECONDS, key=len, reverse=True))})"


def seconds_of(text: str) -> float:
    """Return the number of seconds in a text such as ``10s``, ``500ms``, ``2.5m``, ``1h30m``, ``2d`` or ``10``.

    Raises ValueError for a text that is no duration.
    """
    words = text.strip().lower().replace(" ", "")
    if re.fullmatch(_NUMBER, words):
        words += "s"
    if not re.fullmatch(f"({_PART})+", words):
        raise ValueError(f"'{text}' is no duration; write 10s, 500ms, 2.5m or 1h30m")
    return sum(float(number) * _SECONDS[unit] for number, unit in re.findall(_PART, words))


def error_of(text: str) -> float:
    """Return the fraction that a text such as ``5%``, ``5 %`` or ``0.5%`` stands for: 0.05, 0.05 or 0.005.

    Raises ValueError for a text that is no percentage.
    """
    found = re.fullmatch(rf"({_NUMBER})\s*%", text.strip().lower())
    if found is None:
        raise ValueError(f"{shortened(text, 40)} is no error; write 5%, or 0.05 without quotes")
    return float(Decimal(found[1]) / 100)  # the float64 nearest to 0.05, as the number 0.05 has it


def duration(seconds: float) -> str:
    """Return a time in seconds as text: ``12.3 ms``, ``4.56 s``, ``7.89 min``, ``12.3 h`` or ``456 days``."""
    unit, size = time_unit(seconds)
    return f"{seconds / size:.3g} {unit}"


def rough_duration(seconds: float) -> str:
    """Return a predicted duration as text, with two digits: ``1.3 min``."""
    return duration(float(f"{seconds:.2g}"))


def duration_of_runs(seconds: float, runs: int) -> str:
    """Return the time that all ``runs`` of a render took together, in seconds, as text: ``4.56 s over 2 runs``."""
    return duration(seconds) + (f" over {runs} runs" if runs > 1 else "")


def time_unit(seconds: float) -> tuple[str, float]:
    """Return the unit in which a time of this many seconds is best read, and the unit's length in seconds.

    The unit is ``ms``, ``s``, ``min``, ``h`` or ``days``.
    """
    return next(((name, size) for name, size, most in _UNITS if seconds < most), ("days", 86400.0))


def figure(number: float) -> str:
    """Return a number as text with three significant digits and without exponent: ``0.0523``, ``6.4``, ``1,040``."""
    return f"{float(f'{number:.3g}'):,.12g}"


def rounded(number: float, digits: int = 2) -> str:
    """Return a number with this many significant digits, and without an exponent: ``0.035``, ``3.5``, ``1,200``."""
    if number == 0.0 or not math.isfinite(number):
        return f"{number:g}"
    number = float(f"{number:.{digits - 1}e}")
    places = digits - 1 - math.floor(math.log10(abs(number)))
    return f"{number:,.{max(places, 0)}f}"


def with_ends(value: float, low: float, high: float) -> tuple[str, str, str]:
    """Return a number and the ends of its interval as text, with as many digits as tell the number from both ends.

    These are two to six significant digits. A number that equals an end has the digits that tell it from the other.
    """
    for digits in range(2, 7):
        number, least, most = (rounded(each, digits) for each in (value, low, high))
        if (number != least or value == low) and (number != most or value == high):
            break
    return number, least, most


def percent(error: float) -> str:
    """Return a relative error as text in percent, with three digits: 0.025 becomes ``2.5 %``, and 14 ``1,400 %``."""
    return f"{figure(100.0 * error)} %"


class Shown:
    """Base class of results that print a short summary instead of all their fields.

    A subclass defines ``__str__``: the answer in the first line, then at most ten lines. ``repr`` shows the class and
    the first line, and a notebook shows all lines.
    """

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self).splitlines()[0]})"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def without_numbers(text: str) -> str:
    """Return a text without its numbers, to find texts that differ in them alone."""
    return re.sub(r"[0-9][0-9.,e+]*", "", text)


def a(noun: str) -> str:
    """Return a noun with its indefinite article: ``an image``, ``a mesh``."""
    return f"an {noun}" if noun[0] in "aeiou" else f"a {noun}"


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the name in `known` that is most similar to `word`, or None if no name is similar.

    Return None too for a word of more than `LONGEST_NAME` letters, or for more than `MOST_NAMES` names, to save time.
    """
    names = sorted(known)
    if len(names) > MOST_NAMES or len(word) > LONGEST_NAME:
        return None
    for candidate in (word, word.lower()):
        if found := difflib.get_close_matches(candidate, names, n=1, cutoff=0.6):
            return found[0]
    return None


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return the end of an error message about the unknown name `word`.

    The text is "; did you mean 'x'?" if a name in `known` is similar, else "; expected one of ...". With an empty
    `known`, the text is empty too.
    """
    names = sorted(known)
    if near := nearest(word, names):
        return f"; did you mean '{near}'?"
    if not names:
        return ""
    listed = ", ".join(f"'{name}'" for name in names[:MOST_LISTED]) + (", ..." if len(names) > MOST_LISTED else "")
    return f"; expected {'one of ' if len(names) > 1 else ''}{listed}"


def shortened(value: object, width: int) -> str:
    """Return ``repr(value)`` in at most `width` characters; a longer text is cut, and ends with ``...``.

    Only the shown beginning of a large list or dictionary is formatted.
    """
    text = ""
    for piece in _pieces(value, width):
        text += piece
        if len(text) > width:
            return text[: width - 3] + "..."
    return text


def _pieces(value: object, width: int) -> Iterator[str]:
    """Yield the text of a value piece by piece, so that a huge list, or one that contains itself, can be cut short."""
    if isinstance(value, str | bytes):
        yield repr(value[: width + 1])
    elif (brackets := _BRACKETS.get(type(value))) is not None:
        opening, closing = brackets
        yield opening
        for number, item in enumerate(cast(Iterable[object], value)):
            yield ", " if number else ""
            yield from _pieces(item, width)
            if isinstance(value, dict):
                yield ": "
                yield from _pieces(value[item], width)
        yield "," + closing if isinstance(value, tuple) and len(value) == 1 else closing
    else:
        yield _plain(value)


def _plain(value: object) -> str:
    try:
        return repr(value)
    except Exception as error:  # a user's object may raise anything
        if isinstance(value, int) and isinstance(error, ValueError):  # Python refuses more than 4300 digits
            return "a number of thousands of digits"
        return f"an object of type {type(value).__name__}"
