"""What a JSON document must look like, put together from small rules; each finds what is wrong and says where.

A rule takes a value, its place (``materials[2].alphaCutoff``) and the whole document, and yields the problems.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from equaltime.scene.known import shortened

__all__ = [
    *("Problems", "Rule", "every", "flag", "index", "integer", "mapping", "number", "numbers", "one_of"),
    *("table", "text"),
]

Problems = Iterator[tuple[str, str]]
"""Pairs of place and message."""
LARGEST = 3.4028235e38
"""Of float32, which is what glTF's numbers are."""
Rule = Callable[[Any, str, Mapping[str, Any]], Problems]


def _expected(what: str, value: object) -> str:
    return f"expected {what}, found {shortened(value, 60)}"


def _is_number(value: object, low: float, high: float) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return low <= value <= high and abs(value) <= LARGEST


def _range(low: float, high: float) -> str:
    if math.isfinite(low) and math.isfinite(high):
        return f" from {low:g} to {high:g}"
    return f" of at least {low:g}" if math.isfinite(low) else ""


def number(low: float = -math.inf, high: float = math.inf) -> Rule:
    """Return the rule of a finite number within [low, high]."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not _is_number(value, low, high):
            yield place, _expected(f"a number{_range(low, high)}", value)

    return rule


def integer(low: int = 0) -> Rule:
    """Return the rule of an integer of at least `low`; 3.0 is one."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not _is_number(value, low, 2**53) or value != int(value):
            yield place, _expected(f"an integer of at least {low}", value)

    return rule


def numbers(count: int, low: float = -math.inf, high: float = math.inf) -> Rule:
    """Return the rule of a list of `count` finite numbers within [low, high]."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, list) or len(value) != count or not all(_is_number(v, low, high) for v in value):
            yield place, _expected(f"{count} numbers{_range(low, high)}", value)

    return rule


def index(of: str) -> Rule:
    """Return the rule of an index into the list that stands at the dotted path `of` of the document."""
    *parents, name = of.split("/")

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        items: Any = document
        for step in (*parents, name):
            items = items.get(step, []) if isinstance(items, Mapping) else []
        count = len(items) if isinstance(items, list) else 0
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < count:
            yield place, _expected(f"the index of one of {count} {name}", value)

    return rule


def one_of(*choices: object) -> Rule:
    """Return the rule of a value that is one of the choices."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, str | int) or value not in choices:
            yield place, _expected(" or ".join(map(repr, choices)), value)

    return rule


def text(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
    """Yield what is wrong with `value` if it is no string."""
    if not isinstance(value, str):
        yield place, _expected("a string", value)


def flag(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
    """Yield what is wrong with `value` if it is not true or false."""
    if not isinstance(value, bool):
        yield place, _expected("true or false", value)


def every(item: Rule) -> Rule:
    """Return the rule of a list of which each item follows `item`."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, list):
            yield place, _expected("a list", value)
            return
        for i, entry in enumerate(value):
            yield from item(entry, f"{place}[{i}]", document)

    return rule


def mapping(item: Rule) -> Rule:
    """Return the rule of an object with any names, of which each value follows `item`."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, dict):
            yield place, _expected("an object", value)
            return
        for name, entry in value.items():
            yield from item(entry, f"{place}.{name}", document)

    return rule


def table(needs: str = "", /, **fields: Rule) -> Rule:
    """Return the rule of an object with these fields, of which those in `needs` must be there; others are let pass."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, dict):
            yield place, _expected("an object", value)
            return
        for name in needs.split():
            if name not in value:
                yield place, f"needs '{name}'" if place else f"the file needs '{name}'"
        for name, entry in value.items():
            if name in fields:
                yield from fields[name](entry, f"{place}.{name}" if place else name, document)

    return rule
