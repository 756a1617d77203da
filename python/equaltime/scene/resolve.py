"""Turns the tree (parsed nodes) into the model: follows references, makes each object's plugin, reports problems."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from pydantic import ValidationError

from equaltime.scene.model import (
    NO_MORE,
    NOT_YET,
    PLUGINS,
    Area,
    FreeEmitter,
    Kind,
    Perspective,
    Plugin,
    SceneModel,
    Shape,
    ShapeGroup,
    SpectrumPlugin,
)
from equaltime.scene.report import Report
from equaltime.scene.substitutes import MITSUBA, OLD, SCENE_HINTS, has_substitute, mitsuba_kind
from equaltime.scene.tree import FREE_ENTRIES, USES_OF_EACH, Alias, Child, Object, Plain, Ref
from equaltime.scene.validate import explain, shown
from equaltime.words import a, nearest, suggestion

__all__ = ["VOLUMETRIC", "Resolved", "resolve", "unmerged"]

HOLDERS = ("scene", "shapegroup")
"""Types of objects that contain shapes, beside ``merge``."""


def unmerged(root: Object, report: Report) -> Object:
    """Return the scene `root` with every shape of type ``merge`` replaced by the shapes inside.

    Contents of a ``merge`` that are no shapes are problems, and go to `report`.
    """
    if not any(node.type == "merge" for node in root.objects()):
        return root
    return dataclasses.replace(root, children=list(_opened(root, report)))


def _opened(holder: Object, report: Report) -> Iterator[Child]:
    """Iterate over the children of a scene, a group or a ``merge``, with every ``merge`` replaced by its shapes."""
    for child in holder.children:
        node = child.node
        if not isinstance(node, Object) or node.type not in ("merge", *HOLDERS):
            yield child
        elif node.type == "merge" and node.kind in (None, "shape"):
            parts = dataclasses.replace(node, children=[part for part in node.children if _fits(part, report)])
            yield from (Child(None, part.node) for part in _opened(parts, report))
        else:
            yield Child(child.name, dataclasses.replace(node, children=list(_opened(node, report))))


def _fits(part: Child, report: Report) -> bool:
    if isinstance(part.node, Plain):
        report.add(part.node.place, f"unknown parameter '{part.name}' of 'merge', which takes shapes alone")
        return False
    if not isinstance(part.node, Object):
        return True
    kind = part.node.kind or mitsuba_kind(part.node.type)
    if kind not in (None, "shape"):
        report.add(part.node.place, f"'merge' cannot contain a {kind} ('{part.node.type}'): it takes shapes alone")
    return kind in (None, "shape")


_EVERYDAY: Final = {
    **{"metal": "conductor", "mirror": "conductor", "glass": "dielectric", "matte": "diffuse", "lambertian": "diffuse"},
    **{"disney": "principled", "pbr": "principled", "glossy": "rough", "frosted": "rough"},
}
"""Everyday words in the names of materials, with the words of Mitsuba's types."""
_BEGINNING: Final = 5
"""Number of first letters that similar names share, as in ``rough``."""
VOLUMETRIC: Final = ("medium", "phase")
"""Families of plugins whose parameters may be volumes."""


@dataclass(frozen=True, slots=True)
class Resolved:
    """The model of a scene, and the objects of the file from which the model's plugins were made, for messages.

    `model` is None if the scene is invalid. `parts` are all valid plugins, each in a pair after its object.
    """

    model: SceneModel | None
    shapes: list[Object] = field(hash=False)
    """The objects from which the model's shapes were made, in the same order."""
    parts: list[tuple[Object, Plugin]] = field(hash=False)


@dataclass(slots=True)
class _Fields:
    """Values of an object's parameters, and the parameters whose problems were already reported."""

    values: dict[str, Any] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)
    size: int = 1
    """Number of objects, this one included, with all references followed."""


def resolve(root: Object, report: Report) -> Resolved:
    """Return the model of the scene whose tree (parsed nodes) has the root `root`, with the objects that it comes from.

    Problems go to `report`. The result's `model` is None if the scene is invalid.
    """
    return _Resolver(root, report).scene()


class _Resolver:
    def __init__(self, root: Object, report: Report) -> None:
        self._root = root
        self._report = report
        self._built: dict[Object, Plugin | None] = {}
        self._open: list[Object] = []
        self._used: set[Object] = set()
        self._sizes: dict[Object, int] = {}
        self._most = FREE_ENTRIES + USES_OF_EACH * sum(1 for _ in root.objects())
        self._top = {child.node: child.name for child in root.children if isinstance(child.node, Object)}
        self._by_id: dict[str, Object] = {}
        self._mentioned = root.mentioned()
        for node in root.objects():
            for name in dict.fromkeys((self._top.get(node), node.id)):
                if name is not None and (first := self._by_id.setdefault(name, node)) is not node:
                    report.add(node.place, f"the name '{name}' is already taken (at {first.place})")

        for alias in root.aliases:
            self._add_alias(alias)

    def _add_alias(self, alias: Alias) -> None:
        if alias.id not in self._by_id:
            message = f"no object has the name '{alias.id}'{suggestion(alias.id, self._by_id)}"
            self._report.add(alias.place, message)
        elif (first := self._by_id.setdefault(alias.name, self._by_id[alias.id])) is not self._by_id[alias.id]:
            self._report.add(alias.place, f"the name '{alias.name}' is already taken (at {first.place})")

    def _name(self, node: Object) -> str | None:
        """Return the name of `node`: its id, or its key at the top level."""
        return node.id or self._top.get(node)

    # -- the scene ---------------------------------------------------------------------------------------------------

    def scene(self) -> Resolved:
        """Build all objects, then the scene from those that are part of it."""
        parts: dict[Kind, list[tuple[Object, Any]]] = {}
        size = 0
        for child in self._root.children:
            node = self._target(child, self._root)
            if node is not None and not self._is_idle(node) and (part := self.plugin(node)) is not None:
                parts.setdefault(part.kind, []).append((node, part))
                size += self._sizes[node]
        self._check_size(self._root, size)
        shapes = [(node, part) for node, part in parts.get("shape", []) if not isinstance(part, ShapeGroup)]
        emitters = self._free(parts.get("emitter", []))
        model = self._model(parts, [shape for _, shape in shapes], [emitter for _, emitter in emitters])
        valid = [(node, part) for node, part in self._built.items() if part is not None]
        return Resolved(model, [node for node, _ in shapes], valid)

    def _model(
        self,
        parts: dict[Kind, list[tuple[Object, Any]]],
        shapes: list[Shape],
        emitters: list[FreeEmitter],
    ) -> SceneModel | None:
        """Return the scene with these parts, or None if it has no sensor."""
        fields: dict[str, Any] = {}
        for kind in ("integrator", "sensor"):
            nodes = [node for node in self._top if self._kind(node) == kind]
            if len(nodes) > 1 and kind == "sensor":
                self._report.note(f"{nodes[0].place}: of {len(nodes)} sensors the first is used")
            elif len(nodes) > 1:
                message = f"the scene has another {kind} (at {nodes[0].place}); several are {NOT_YET}"
                self._report.add(nodes[1].place, message)
            for _, part in parts.get(kind, [])[:1]:
                fields[kind] = part
            if kind == "sensor" and not nodes and shapes:
                fields[kind] = Perspective()  # replaced once all files are read
                self._report.note("the scene has no sensor: a camera that sees the whole scene is added")
            elif kind == "sensor" and not nodes and None not in self._built.values():
                self._report.add(self._root.place, "the scene has no sensor; expected one of type 'perspective'")
        return SceneModel(shapes=tuple(shapes), emitters=tuple(emitters), **fields) if "sensor" in fields else None

    def _is_idle(self, node: Object) -> bool:
        """Tell whether an unsupported `node` can be ignored because nothing refers to it; if so, note it."""
        helps = self._kind(node) in ("bsdf", "texture", "medium", "phase", "volume")
        if not helps or node.id is None or {node.id, self._top.get(node)} & self._mentioned:
            return False
        unknown = next((n for n in node.objects() if n.type not in PLUGINS and mitsuba_kind(n.type)), None)
        if unknown is not None:
            self._report.note(f"{unknown.place}: nothing refers to '{unknown.type}', which is {NOT_YET}: ignored")
        return unknown is not None

    def _free(self, emitters: list[tuple[Object, Any]]) -> list[tuple[Object, Any]]:
        """Return the emitters that need no shape, at most one of them an environment; misplaced ones are reported."""
        free: list[tuple[Object, FreeEmitter]] = []
        for node, emitter in emitters:
            if isinstance(emitter, Area):
                if node not in self._used:
                    message = "an 'area' emitter needs a shape: nest it in one, or refer to it there"
                    self._report.add(node.place, message)
            elif emitter.surrounds and (first := next((n for n, e in free if e.surrounds), None)):
                self._report.add(node.place, f"a scene can have only one environment (the first is at {first.place})")
            else:
                free.append((node, emitter))
        return free

    # -- objects -----------------------------------------------------------------------------------------------------

    def plugin(self, node: Object) -> Plugin | None:
        """Return the plugin that `node` describes, or None if it is invalid; the same node gives the same plugin."""
        if node in self._open:
            names = " -> ".join(f"'{self._name(step) or step.type}'" for step in [*self._open, node])
            self._report.add(node.place, f"the object contains itself: {names}")
            return None
        if node not in self._built:
            self._open.append(node)
            self._built[node] = self._build(node)
            self._open.pop()
        return self._built[node]

    def _build(self, node: Object) -> Plugin | None:
        plugin = PLUGINS.get(node.type)
        if plugin is None or (node.kind is not None and node.kind != plugin.kind):
            self._report.add(node.place, self._wrong_type(node, plugin))
            return None
        fields = self._fields(node, plugin)
        if not self._check_size(node, fields.size):
            return None
        # All instances share one group, so it counts once.
        self._sizes[node] = 1 if issubclass(plugin, ShapeGroup) else fields.size
        try:
            return plugin(id=self._name(node), **fields.values)
        except ValidationError as error:
            for name, message in explain(plugin, error).items():
                if name not in fields.failed:
                    place = node.place_of(name)
                    named = not name or f"'{name}'" in message or place.path.rsplit(".", 1)[-1] == name
                    self._report.add(place, message if named else f"{name}: {message}")
            return None

    def _check_size(self, node: Object, size: int) -> bool:
        """Tell whether `node` is within the limit on objects; references can double its size with each level."""
        if size > self._most:
            message = f"with all references followed these are {size} objects; the limit for this file is {self._most}"
            self._report.add(node.place, message)
        return size <= self._most

    def _wrong_type(self, node: Object, plugin: type[Plugin] | None) -> str:
        """Return a message about the type of `node`: misspelt, of another family, or not supported yet."""
        what = self._kind(node) or self._kind_of_use(node) or "plugin"
        origin = "" if node.variable is None else f", the value of ${node.variable},"
        if plugin is not None:
            return f"'{node.type}'{origin} is {a(plugin.kind)}, not {a(what)}"
        hint = f"; choose one with -D {node.variable}=path" if what == "integrator" and node.variable else ""
        if (known_kind := mitsuba_kind(node.type)) is not None and node.kind in (None, known_kind):
            hint = hint or ("; --substitute replaces it" if has_substitute(known_kind, node.type) else "")
            return f"the {what} '{node.type}'{origin} is {NOT_YET}{hint}"
        if what != "plugin" and node.type in OLD.get(what, ()):
            hint = hint or ("; --substitute replaces it" if has_substitute(what, node.type) else "")
            return f"the {what} '{node.type}'{origin} is {NO_MORE}{hint}"
        known = {name for kind, names in MITSUBA.items() if what in ("plugin", kind) for name in names}
        supported = {name for name, known_plugin in PLUGINS.items() if what in ("plugin", known_plugin.kind)}
        hint = hint or _like(node.type, known, supported)
        if what != "plugin" and has_substitute(what, node.type):
            hint += "; --substitute replaces it"
        return f"unknown {what} '{node.type}'{origin.rstrip(',')}{hint}"

    def _kind(self, node: Object) -> Kind | None:
        """Return the family of `node`, if its spelling or its type tells it."""
        if node.kind is not None:
            return node.kind
        if node.type in PLUGINS:
            return PLUGINS[node.type].kind
        return mitsuba_kind(node.type) or next((kind for kind in MITSUBA if kind == node.key), None)

    def _kind_of_use(self, node: Object) -> Kind | None:
        """Return the family that the first object takes which contains `node` or refers to it; None if none tells."""
        names = {node.id, self._top.get(node)} - {None}
        for parent in self._root.objects():
            if (plugin := PLUGINS.get(parent.type)) is None:
                continue
            for child in parent.children:
                held = child.node.id if isinstance(child.node, Ref) else getattr(child.node, "data", None)
                if child.node is node or (isinstance(held, str) and held in names):
                    takes = {kind for kind, role in plugin.roles.items() if role == child.name}
                    takes |= plugin.slots().get(child.name or "", frozenset())
                    if len(takes) == 1:
                        return takes.pop()
        return None

    # -- contents of an object ---------------------------------------------------------------------------------------

    def _fields(self, node: Object, plugin: type[Plugin]) -> _Fields:
        """Return the parameters that the children of `node` give."""
        result = _Fields()
        for child in node.children:
            if isinstance(child.node, Plain) and not self._is_reference(child, plugin):
                self._set_value(result, plugin, child.name or "", child.node)
                continue
            target = self._target(child, node)
            nested = None if target is None else self.plugin(target)
            result.size += 0 if target is None else self._sizes.get(target, 1)
            if target is None or nested is None:
                role = plugin.roles.get(kind) if target is not None and (kind := self._kind(target)) else None
                slot = child.name if child.name in plugin.slots() else role
                result.failed |= {slot} if slot else {*plugin.roles.values(), child.name or ""}
            elif isinstance(nested, SpectrumPlugin) and (nested.kind == "texture" or plugin.kind in VOLUMETRIC):
                self._set_value(result, plugin, child.name or "", Plain(child.node.place, nested.meaning))
            else:
                self._used.add(target)
                self._set_object(result, plugin, child, nested)
        return result

    def _set_value(self, fields: _Fields, plugin: type[Plugin], name: str, value: Plain) -> None:
        if name in ("", "id", "type"):
            self._report.add(value.place, f"a parameter cannot have the name '{name}'")
        elif name in fields.values:
            self._report.add(value.place, f"'{name}' is given more than once")
        elif name in plugin.lists:
            self._report.add(value.place, f"'{name}' takes objects, or their names, found {shown(value.data)}")
            fields.failed.add(name)
        else:
            fields.values[name] = value.data

    def _set_object(self, fields: _Fields, plugin: type[Plugin], child: Child, nested: Plugin) -> None:
        """Assign `nested` to the parameter of its name if that takes its family, else to its family's parameter."""
        place, role = child.node.place, plugin.roles.get(nested.kind)
        if nested.kind in plugin.slots().get(child.name or "", ()):
            role = child.name
        has_surface = plugin.kind == "shape" and "bsdf" in plugin.roles
        if role is None and has_surface and self._is_spare(child.name or "", nested):
            self._report.note(f"{place}: the texture {shown(nested)} of the shape has no effect: ignored")
        elif role is None:
            names = [name for name, kinds in plugin.slots().items() if nested.kind in kinds]
            message = f"'{_title(plugin)}' cannot contain {a(nested.kind)} ({shown(nested)})"
            if names:
                called = f" as '{child.name}'" if child.name else " without a name"
                message += f"{called}{suggestion(child.name or '', names)}"
            self._report.add(place, message)
            fields.failed.add(child.name or "")
        elif role in plugin.lists:
            fields.values[role] = (*fields.values.get(role, ()), nested)
        elif role in fields.values:
            what = f"'{role}'" if role in plugin.slots() else nested.kind
            self._report.add(place, f"'{_title(plugin)}' can have only one {what}; {shown(nested)} is another")
        else:
            fields.values[role] = nested

    def _is_spare(self, name: str, nested: Plugin) -> bool:
        """Tell whether a shape's part is named like a mesh attribute, and no reference mentions it."""
        is_attribute = nested.kind == "texture" and name.startswith(("vertex_", "face_"))
        return is_attribute and name not in self._mentioned

    # -- references --------------------------------------------------------------------------------------------------

    def _is_reference(self, child: Child, plugin: type[Plugin]) -> bool:
        """Tell whether a string stands in place of an object, so that it is the object's name."""
        data = child.node.data if isinstance(child.node, Plain) else None
        if not isinstance(data, str):
            return False
        kinds = plugin.slots().get(child.name or "", frozenset())
        if kinds & {"texture", "volume"} and data.startswith("#") and data not in self._by_id:
            return False  # a colour in hexadecimal digits
        return bool(kinds) or child.name in plugin.roles.values()

    def _target(self, child: Child, parent: Object) -> Object | None:
        """Return the object that `child` is or refers to, else None; problems are reported."""
        node = child.node
        if isinstance(node, Object):
            return node
        if isinstance(node, Plain) and parent is self._root:
            if child.name in SCENE_HINTS and isinstance(node.data, bool):
                return None
            message = f"unknown parameter '{child.name}' of the scene; expected an object with a 'type'"
            self._report.add(node.place, message)
            return None
        name = node.id if isinstance(node, Ref) else str(node.data)
        if name not in self._by_id:
            hint = suggestion(name, self._by_id)
            slots = PLUGINS[parent.type].slots() if parent.type in PLUGINS else {}
            if isinstance(node, Plain) and "did you mean" not in hint and "texture" in slots.get(child.name or "", ()):
                hint = "; expected a number, a colour, or the name of a texture"
            self._report.add(node.place, f"no object has the name '{name}'{hint}")
        return self._by_id.get(name)


def _like(word: str, known: set[str], supported: set[str]) -> str:
    """Return the end of a message on an unknown type: similar names among `known`, else the `supported` ones.

    Names are similar in their letters, by the everyday words in `_EVERYDAY`, or in the letters with which they begin.
    """
    technical = word.lower().replace("_", "")
    for everyday, term in _EVERYDAY.items():
        technical = technical.replace(everyday, term)
    for meant in (technical,) if technical in known else (word, technical):
        if nearest(meant, known):
            return suggestion(meant, known)
    alike = sorted(name for name in supported if name[:_BEGINNING] == technical[:_BEGINNING])
    if len(alike) > 1:
        return f"; did you mean one of {', '.join(map(repr, alike))}?"
    return suggestion(word, supported)


def _title(plugin: type[Plugin]) -> str:
    return str(plugin.model_fields["type"].default)
