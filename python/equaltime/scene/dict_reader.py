"""Reads nested dictionaries, Mitsuba 3's Python spelling of a scene, into the tree of parsed nodes.

TOML files are read through this module too, because TOML tables become such dictionaries.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from equaltime.scene import deforming, transforms
from equaltime.scene.model import Spectrum
from equaltime.scene.motion import animation
from equaltime.scene.report import Report
from equaltime.scene.search import Search
from equaltime.scene.spectrum_values import curve, parse_spectrum, read_spectrum
from equaltime.scene.tree import FREE_ENTRIES, MAX_DEPTH, USES_OF_EACH, Child, Node, Object, Place, Plain, Ref
from equaltime.words import shortened

__all__ = ["DictReader", "read_dict"]

TRANSFORMS: Final = ("to_world", "to_uv")
"""Names of parameters that are transforms in all plugins."""


def read_dict(scene: Mapping[str, object], report: Report, search: Search) -> Object | None:
    """Return the root of the tree (parsed nodes) of `scene`, nested dictionaries with Mitsuba's names.

    Problems go to `report`. Return None if `scene` has no ``"type": "scene"``, is nested too deeply, or repeats its
    parts too often.
    """
    place = Place(path="")
    if not isinstance(kind := scene.get("type"), str) or kind != "scene":
        report.add(place, f"expected a dictionary with 'type': 'scene', found {_shown(scene.get('type'))}")
        return None
    return DictReader(report, search).nested(scene, place)


class DictReader:
    """Reader that turns a scene's dictionaries into nodes of the tree. Invalid entries are reported and left out."""

    def __init__(self, report: Report, search: Search) -> None:
        self._report = report
        self._search = search
        self._depth = 0
        self._extent = _Extent()

    def locate(self, place: Place) -> Place:
        """Return `place` (file, line and key path) with a better line number if one is known.

        Here, return `place` unchanged. A reader that knows line numbers overrides this method.
        """
        return place

    def string(self, text: str) -> object:
        """Return the value of the string `text` after variables are replaced.

        Here, return `text` itself. A reader with variables overrides this method, which may then raise ValueError.
        """
        return text

    def variable(self, text: str) -> str | None:
        """Return the variable's name if `text` is exactly one variable such as ``$name``, else None.

        Here, always return None. A reader with variables overrides this method.
        """
        return None

    def nested(self, table: Mapping[str, object], place: Place, key: str | None = None) -> Object | None:
        """Return the object that the dictionary `table` describes; if it is invalid, report that and return None.

        `place` is the position of the table. `key` is the key under which it was found, None for the whole scene.
        """
        kind = table.get("type")
        if not isinstance(kind, str):
            given = "none" if kind is None else _shown(kind)
            self._report.add(place, f"an object needs a 'type' with the name of a plugin, found {given}")
            return None
        if self._depth >= MAX_DEPTH:
            self._report.add(place, f"objects are nested more than {MAX_DEPTH} deep")
            return None
        if not self._extent.take(table):
            self._report.add(Place(place.file), self._extent.complaint)
            return None
        name = table.get("id")
        if name is not None and not isinstance(name, str):
            self._report.add(place, f"'id' must be a string, found {_shown(name)}")
            name = None
        try:
            result = Object(place, str(self.string(kind)), key=key, id=name, variable=self.variable(kind))
        except ValueError as error:
            self._report.add(place, str(error))
            return None
        self._depth += 1
        for entry, value in table.items():
            if entry not in ("type", "id"):
                self._add(result, str(entry), value, self.locate(place.key(str(entry))))
        self._depth -= 1
        return result

    def _add(self, parent: Object, name: str, value: object, place: Place) -> None:
        """Add the entry `name` to `parent`; a list of objects becomes one nameless child per object."""
        if name in TRANSFORMS or not isinstance(value, list | tuple) or not _has_objects(value):
            if (node := self._node(name, value, place)) is not None:
                parent.children.append(Child(name, node))
            return
        if not self._extent.take(value):
            self._report.add(Place(place.file), self._extent.complaint)
            return
        for index, item in enumerate(value):
            if (node := self._node(name, item, self.locate(place.key(index)))) is not None:
                parent.children.append(Child(None if isinstance(node, Object) else name, node))

    def _node(self, name: str, value: object, place: Place) -> Node | None:
        try:
            if name in TRANSFORMS:
                return Plain(place, _transform(self._expanded(value), flat=name == "to_uv"))
            if not isinstance(value, Mapping):
                return Plain(place, self._plain(value))
            if name == "filename" and "animation" in value:
                return Plain(place, deforming.parse({key: self._expanded(item) for key, item in value.items()}))
            kind = self._type_of(value)
            if kind == "ref":
                return self._reference(value, place)
            if kind in ("rgb", "spectrum"):
                return Plain(place, self._color(value, kind))
        except ValueError as error:
            self._report.add(place, str(error))
            return None
        return self.nested(value, place, name)

    def _expanded(self, steps: object, depth: int = 0) -> object:
        """Return steps or keys with the values of their strings; arrays and Mitsuba's transforms stay unchanged."""
        if isinstance(steps, str):
            return self.string(steps)
        if not isinstance(steps, list | tuple | Mapping):
            return steps
        self._extent.check(steps, depth)
        if isinstance(steps, Mapping):
            return {key: self._expanded(step, depth + 1) for key, step in steps.items()}
        return [self._expanded(step, depth + 1) for step in steps]

    def _reference(self, table: Mapping[str, object], place: Place) -> Ref:
        if set(table) != {"type", "id"} or not isinstance(table["id"], str):
            raise ValueError("a reference has a 'type' and an 'id' that is a string, nothing else")
        return Ref(place, str(self.string(table["id"])))

    def _type_of(self, table: Mapping[str, object]) -> str | None:
        """Return the type of a table if it is a string; other values may not even support comparison."""
        kind = table.get("type")
        return str(self.string(kind)) if isinstance(kind, str) else None

    def _color(self, table: Mapping[str, object], kind: str) -> object:
        """Return the value of a table such as ``{"type": "rgb", "value": ...}`` or ``{"type": "spectrum", ...}``."""
        sources = {"value"} if kind == "rgb" else {"value", "filename"}
        given = set(table) - {"type"}
        if len(given) != 1 or not given <= sources:
            found = ", ".join(sorted(map(str, given))) or "none"
            raise ValueError(f"'{kind}' needs a {' or a '.join(map(repr, sorted(sources)))}, found {found}")
        value = self._plain(table[given.pop()])
        if kind == "rgb":
            return value
        if "filename" in table:
            return read_spectrum(self._search.find(str(value)))
        if isinstance(value, str):
            return parse_spectrum(value)
        if isinstance(value, tuple):
            return curve(value)
        if not isinstance(value, float | int) or isinstance(value, bool):
            raise ValueError(f"expected a number or pairs of wavelength and value, found {_shown(value)}")
        return Spectrum(float(value))

    def _plain(self, value: object, depth: int = 0, *, expand: bool = True) -> object:
        """Return numbers, strings, and sequences of them as plain Python values; anything else is refused.

        The value of a variable is not expanded again.
        """
        if isinstance(value, str):
            found = self.string(value) if expand else value
            return found if isinstance(found, str) else self._plain(found, depth, expand=False)
        if isinstance(value, np.generic | np.ndarray):
            value = value.tolist()
        if isinstance(value, list | tuple):
            self._extent.check(value, depth)
            return tuple(self._plain(item, depth + 1, expand=expand) for item in value)
        if isinstance(value, bool | float) or (isinstance(value, int) and abs(value) <= sys.float_info.max):
            return value
        if isinstance(value, int):
            raise ValueError(f"expected a number below 1.8e308, found {_shown(value)}")
        raise ValueError(f"expected plain data, found an object of type {type(value).__name__}")


def _transform(value: object, *, flat: bool) -> object:
    """Return the transform or the animation that `value` describes."""
    keys = None if flat else transforms.parse_animation(value)
    return transforms.parse(value, flat=flat) if keys is None else animation(keys)


def _has_objects(items: list[object] | tuple[object, ...]) -> bool:
    """Tell whether a list contains objects or references instead of numbers."""
    return any(isinstance(item, Mapping | str) for item in items)


def _shown(value: object) -> str:
    return shortened(value, 60)


Container = Mapping[str, object] | Sequence[object]


class _Extent:
    """Counter of the entries in nested dictionaries and lists, with a limit.

    A container that occurs several times counts each time it is read. The limit grows with the entries in distinct
    containers.
    """

    def __init__(self) -> None:
        self._known: dict[int, Container] = {}  # keeps the containers alive, so that no id is reused
        self._own = self._read = 0

    def take(self, table: Container) -> bool:
        """Count the entries of one dictionary or list. Return True if all counted entries are within the limit."""
        size = 1 + len(table)
        if id(table) not in self._known:
            self._known[id(table)] = table
            self._own += size
        self._read += size
        return self._read <= FREE_ENTRIES + USES_OF_EACH * self._own

    @property
    def complaint(self) -> str:
        """Error message for a scene whose entries exceed the limit, with the limit's value."""
        most = FREE_ENTRIES + USES_OF_EACH * self._own
        return f"its dictionaries and lists are repeated too often; the limit for this scene is {most} entries"

    def check(self, table: Container, depth: int) -> None:
        """Count the entries of a list or dictionary at nesting level `depth`.

        Raises ValueError if the level reaches `MAX_DEPTH`, or if the entries exceed the limit.
        """
        if depth >= MAX_DEPTH:
            raise ValueError(f"lists are nested more than {MAX_DEPTH} deep")
        if not self.take(table):
            raise ValueError(self.complaint)
