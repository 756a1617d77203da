"""Rules that check a JSON document, composed of smaller rules.

A rule is a function of three arguments: a value, the value's path in the JSON (such as ``materials[2].alphaCutoff``)
and the whole document. The function yields the problems of the value, as pairs (path, message). `walk` visits all parts
of a value along a rule, and finds properties that no rule lists.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from equaltime.words import shortened

__all__ = [
    *("Index", "Problems", "Rule", "every", "flag", "index", "integer", "mapping", "number", "numbers", "one_of"),
    *("table", "text", "walk"),
]

Problems = Iterator[tuple[str, str]]
"""Problems of a value, as pairs (path in the JSON, message)."""
LARGEST = 3.4028235e38
"""Largest float32, and so the largest number in a glTF file."""
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
    """Return a rule that accepts finite numbers from `low` to `high`, both included."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not _is_number(value, low, high):
            yield place, _expected(f"a number{_range(low, high)}", value)

    return rule


def integer(low: int = 0) -> Rule:
    """Return a rule that accepts integers of at least `low`. The number 3.0 counts as an integer."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not _is_number(value, low, 2**53) or value != int(value):
            yield place, _expected(f"an integer of at least {low}", value)

    return rule


def numbers(count: int, low: float = -math.inf, high: float = math.inf) -> Rule:
    """Return a rule that accepts lists of `count` finite numbers from `low` to `high`, both included."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, list) or len(value) != count or not all(_is_number(v, low, high) for v in value):
            yield place, _expected(f"{count} numbers{_range(low, high)}", value)

    return rule


@dataclass(frozen=True, slots=True)
class Index:
    """A rule that accepts an index into one of the document's lists, and refuses one that is negative or too large."""

    path: tuple[str, ...]
    """Keys from the top of the document to the list."""

    def __call__(self, value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        """Yield a problem if `value` is not an index into the list; `place` is the value's path in the JSON."""
        items: Any = document
        for step in self.path:
            items = items.get(step, []) if isinstance(items, Mapping) else []
        count = len(items) if isinstance(items, list) else 0
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < count:
            yield place, _expected(f"the index of one of {count} {self.path[-1]}", value)


def index(of: str) -> Rule:
    """Return a rule that accepts an index into one of the document's lists.

    The parameter `of` is the path of the list, such as ``extensions/X/lights``.
    """
    return Index(tuple(of.split("/")))


def one_of(*choices: object) -> Rule:
    """Return a rule that accepts only the strings or integers in `choices`."""

    def rule(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, str | int) or value not in choices:
            yield place, _expected(" or ".join(map(repr, choices)), value)

    return rule


def text(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
    """Yield a problem if `value` is not a string. The function can itself be used as a rule, such as in `table`.

    `place` is the value's path in the JSON. `document` is not used.
    """
    if not isinstance(value, str):
        yield place, _expected("a string", value)


def flag(value: Any, place: str, document: Mapping[str, Any]) -> Problems:
    """Yield a problem if `value` is not a boolean. The function can itself be used as a rule, such as in `table`.

    `place` is the value's path in the JSON. `document` is not used.
    """
    if not isinstance(value, bool):
        yield place, _expected("true or false", value)


@dataclass(frozen=True, slots=True)
class _Every:
    item: Rule

    def __call__(self, value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, list):
            yield place, _expected("a list", value)
            return
        for i, entry in enumerate(value):
            yield from self.item(entry, f"{place}[{i}]", document)


@dataclass(frozen=True, slots=True)
class _Mapping:
    item: Rule

    def __call__(self, value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, dict):
            yield place, _expected("an object", value)
            return
        for name, entry in value.items():
            yield from self.item(entry, f"{place}.{name}", document)


@dataclass(frozen=True, slots=True)
class _Table:
    needs: tuple[str, ...]
    fields: Mapping[str, Rule] = field(hash=False)

    def __call__(self, value: Any, place: str, document: Mapping[str, Any]) -> Problems:
        if not isinstance(value, dict):
            yield place, _expected("an object", value)
            return
        for name in self.needs:
            if name not in value:
                yield place, f"needs '{name}'" if place else f"the file needs '{name}'"
        for name, entry in value.items():
            if name in self.fields:
                yield from self.fields[name](entry, f"{place}.{name}" if place else name, document)


def every(item: Rule) -> Rule:
    """Return a rule that accepts lists in which every item follows the rule `item`."""
    return _Every(item)


def mapping(item: Rule) -> Rule:
    """Return a rule that accepts JSON objects with any keys, in which every value follows the rule `item`."""
    return _Mapping(item)


def table(needs: str = "", /, **fields: Rule) -> Rule:
    """Return a rule that accepts JSON objects whose values follow the rules in `fields`, by key.

    The string `needs` lists the required keys, separated by spaces. Keys that are not in `fields` are allowed.
    """
    return _Table(tuple(needs.split()), fields)


def walk(rule: Rule, value: Any, place: str = "") -> Iterator[tuple[Rule | None, Any, str]]:
    """Iterate over the leaves of a JSON value that follows `rule`, to find properties that are not read.

    Each leaf comes as a triple (rule, leaf, path in the JSON). A leaf is a value whose rule has no smaller rules for
    parts of the value. Properties that no `table` lists are leaves, too, with None as their rule. `place` is the path
    of `value` in the JSON.
    """
    if isinstance(rule, _Every):
        for i, entry in enumerate(value):
            yield from walk(rule.item, entry, f"{place}[{i}]")
    elif isinstance(rule, _Mapping):
        for name, entry in value.items():
            yield from walk(rule.item, entry, f"{place}.{name}")
    elif isinstance(rule, _Table):
        for name, entry in value.items():
            inner = f"{place}.{name}" if place else name
            if name in rule.fields:
                yield from walk(rule.fields[name], entry, inner)
            else:
                yield None, entry, inner
    else:
        yield rule, value, place
