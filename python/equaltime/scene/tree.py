"""The tree of a scene as it was parsed: objects, references and values, each with its file and line.

Every reader makes such a tree from its file. `equaltime.scene.resolve` turns the tree into the model. The tree has the
same form for all file formats, and its types and parameters are not checked yet.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from equaltime.scene.model import Kind, Plugin

__all__ = [
    "FREE_ENTRIES",
    "MAX_DEPTH",
    "NOWHERE",
    "USES_OF_EACH",
    "Alias",
    "Child",
    "Node",
    "Object",
    "Place",
    "Places",
    "Plain",
    "Ref",
    "add",
    "plant",
]

MAX_DEPTH = 64
"""Deepest nesting of objects; real scenes need about five levels, and a hostile file must not exhaust the stack."""

FREE_ENTRIES = 4096

USES_OF_EACH = 64
"""Limit on a scene's objects and entries, where a shared one counts at each use: `FREE_ENTRIES`, plus this number for
each that is in the file."""


class Place(NamedTuple):
    """A position in the description of a scene, for messages: a file with a line, a path of keys, or both."""

    file: str = ""
    line: int | None = None
    path: str = ""

    def __str__(self) -> str:
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        return ": ".join(part for part in (where, self.path) if part)

    def key(self, name: str | int, line: int | None = None) -> Place:
        """Return the position of the key or index `name` inside the object at this position.

        The path of keys gets one more key. Without `line`, the line stays the same.
        """
        step = f"[{name}]" if isinstance(name, int) else f".{name}" if self.path else name
        return Place(self.file, self.line if line is None else line, self.path + step)


@dataclass(frozen=True, slots=True)
class Plain:
    """The value of a parameter, with its place: a number, string, boolean, tuple, `Spectrum`, (4, 4) transform, ..."""

    place: Place
    data: object


@dataclass(frozen=True, slots=True)
class Ref:
    """A reference, in place of an object, to the object whose name is `id`."""

    place: Place
    id: str


@dataclass(frozen=True, slots=True)
class Alias:
    """A further name, `name`, for the object whose name is `id`."""

    place: Place
    id: str
    name: str


class Child(NamedTuple):
    """A node inside an object: a value, a reference or an object. `name` is None if the file names no parameter."""

    name: str | None
    node: Node


@dataclass(slots=True, eq=False)
class Object:
    """A plugin as the file describes it, unchecked, with its type and contents. Objects are compared by identity."""

    place: Place
    type: str
    kind: Kind | None = None
    """Family of the plugin, such as ``bsdf``, if the format states it (XML does)."""
    key: str | None = None
    """The object's name inside the object around it."""
    id: str | None = None
    variable: str | None = None
    """Name of the variable that gave the type, if any."""
    children: list[Child] = field(default_factory=list)
    aliases: list[Alias] = field(default_factory=list)
    """Further names of objects; only the scene itself has such aliases."""

    def objects(self) -> Iterator[Object]:
        """Yield this object and all objects nested in it, depth first; references are not followed."""
        yield self
        for child in self.children:
            if isinstance(child.node, Object):
                yield from child.node.objects()

    def mentioned(self) -> set[str]:
        """Return all names in this object that may refer to objects, to find out which objects of a scene are used.

        These are the ids of all references and aliases, and all string values, because a string may be a reference.
        """
        nodes = [child.node for inner in self.objects() for child in inner.children]
        words = {node.data for node in nodes if isinstance(node, Plain) and isinstance(node.data, str)}
        return words | {node.id for node in nodes if isinstance(node, Ref)} | {alias.id for alias in self.aliases}

    def place_of(self, name: str) -> Place:
        """Return file and line of the first child called `name`, or of the object itself if there is no such child."""
        return next((child.node.place for child in self.children if child.name == name), self.place)


Node = Plain | Ref | Object

ALONE: Final = ("sensor", "integrator")


class Places:
    """Files and lines at which the plugins of a scene are described, for messages about the scene.

    `shapes` has file and line of each of the model's shapes, in order. `of` finds file and line of any plugin.
    """

    def __init__(self, shapes: tuple[Place, ...], parts: Iterable[tuple[Plugin, Place]]) -> None:
        self.shapes = shapes
        self._parts = tuple(parts)
        self._known = {id(part): place for part, place in self._parts}

    def of(self, part: Plugin) -> Place | None:
        """Return file and line of the plugin `part`, or of the first plugin equal to `part`.

        Return None if no file describes such a plugin. A scene has only one sensor and one integrator. These two are
        therefore found even if a parameter has changed.
        """
        if (place := self._known.get(id(part))) is not None:
            return place
        kind = part.kind if part.kind in ALONE else None
        return next((place for known, place in self._parts if known == part or known.kind == kind), None)


NOWHERE: Final = Places((), ())
"""`Places` without any file or line, for a model that was made in memory."""


def plant(kind: Kind, type_: str, place: Place, id_: str | None = None, **fields: object) -> Object:
    """Return a new object of the scene tree, with plugin family `kind` (such as ``bsdf``) and plugin type `type_`.

    `place` is the object's position in the file, for error messages. The `fields` are the object's parameters: plain
    values, objects or references. A field that is None is left out.
    """
    result = Object(place, type_, kind, id=id_)
    for name, value in fields.items():
        add(result, name, value)
    return result


def add(parent: Object, name: str | None, value: object) -> None:
    """Add `value` to `parent`: as the parameter `name`, or as an unnamed nested object if `name` is None.

    A `value` of None is not added.
    """
    if value is None:
        return
    node = value if isinstance(value, Object | Ref | Plain) else Plain(parent.place, value)
    parent.children.append(Child(name, node))
