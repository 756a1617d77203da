"""Footnotes of a report's tables: each remark on numbers is said once, below its table or for the whole page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from equaltime.experiments.report.words import Cell

__all__ = ["grouped", "letter", "merged", "remarks", "shape", "shared_remarks"]

_LONG = 25
"""Fewest words of a remark that is said once for the page if several tables have it: it is a paragraph by itself."""
_NUMBER = re.compile(r"\d+(?:,\d{3})*(?:\.\d+)?(?:e[+-]?\d+)?")
_POWER = re.compile(r"\d+(?:\.\d+)?e\+\d+")
_OUTSIDE = re.compile(r"extrapolated (\S+) times (beyond|before) .*")


def remarks(cell: Cell) -> list[str]:
    """Split the note of a cell into remarks in plain words, without the prefix "this: "; a silent cell has none."""
    if cell.state == "silent":
        return []
    return [_OUTSIDE.sub(_extrapolated, remark.removeprefix("this: ")) for remark in cell.note.split("; ") if remark]


def shape(remark: str) -> str:
    """Return the remark with its numbers replaced by #; remarks that begin with a scene's name are unchanged.

    Remarks that differ only in their numbers thus have one shape.
    """
    return remark if remark.startswith("on ") else _NUMBER.sub("#", remark)


def grouped(cells: Iterable[Cell]) -> dict[str, list[str]]:
    """Return all remarks of these cells by their shape, in reading order."""
    groups: dict[str, list[str]] = {}
    for cell in cells:
        for remark in remarks(cell):
            groups.setdefault(shape(remark), []).append(remark)
    return groups


def merged(same: Sequence[str]) -> str:
    """Return remarks of one shape as one, with the smallest and the largest of the numbers that differ."""
    if same[0] == shape(same[0]):
        return same[0]
    ranges = map(_range, zip(*map(_NUMBER.findall, same), strict=True))
    return _NUMBER.sub(lambda _: next(ranges), same[0])


def shared_remarks(tables: Iterable[Iterable[Cell]]) -> dict[str, str]:
    """Return the long remarks that the cells of several tables have, merged, by their shape."""
    found: dict[str, list[list[str]]] = {}
    for cells in tables:
        for key, same in grouped(cells).items():
            found.setdefault(key, []).append(same)
    return {
        key: merged([remark for same in groups for remark in same])
        for key, groups in found.items()
        if len(groups) > 1 and len(key.split()) >= _LONG
    }


def letter(number: int) -> str:
    """Return the mark of the page's note with this number, from 0: a to z, then aa to zz and so on."""
    return "abcdefghijklmnopqrstuvwxyz"[number % 26] * (number // 26 + 1)


def _extrapolated(found: re.Match[str]) -> str:
    """Say in plain words how far a time lies outside the runs, and of an early one also how it is made."""
    if found[2] == "before":
        slope = "slope -1/2" if found[0].endswith("-1/2") else "the slope of its first three doublings of time"
        return (
            f"extrapolated before the first measurement, which was {found[1]} times later: the curve is carried back "
            f"with {slope}"
        )
    return f"extrapolated beyond the longest run, {found[1]} times as long"


def _range(numbers: Sequence[str]) -> str:
    ends = [pick(numbers, key=_value) for pick in (min, max)]
    return " to ".join(dict.fromkeys(map(_spelt, ends)))


def _value(number: str) -> float:
    return float(number.replace(",", ""))


def _spelt(number: str) -> str:
    """Write a number with a power of ten in full."""
    return f"{_value(number):,.0f}" if _POWER.fullmatch(number) else number
