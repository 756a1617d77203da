"""Reads Mitsuba 3's XML into the tree, replacing variables on the way."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.known import suggestion
from equaltime.scene.model import NOT_YET, Kind
from equaltime.scene.tree import Child, Node, Object, Place, Reference, Report, Value
from equaltime.scene.variables import Variables
from equaltime.scene.xml_elements import Element, parse_elements
from equaltime.scene.xml_values import STEPS, VALUES, Rule

__all__ = ["read_xml"]

Names = tuple[str, ...]
T = TypeVar("T")

OBJECTS: Final[dict[str, Kind]] = {kind: kind for kind in get_args(Kind) if kind != "scene"}
NOT_READ: Final = ("alias", "include", "path")
ELEMENTS: Final = (*OBJECTS, *VALUES, *NOT_READ, "default", "ref", "scene", "transform")


def read_xml(file: str, content: bytes, defines: Mapping[str, object], report: Report) -> Object | None:
    """Return the scene in the XML `content` of `file`; problems go to `report`, None if there is no scene at all."""
    root = parse_elements(file, content, report)
    if root is None:
        return None
    if root.tag != "scene":
        report.add(root.place, f"expected the element <scene>, found <{root.tag}>")
        return None
    version = root.attributes.pop("version", None)
    if version is None or not version.split(".")[0].isdigit() or int(version.split(".")[0]) < 2:
        found = "no version" if version is None else f"version {version!r}"
        report.add(root.place, f"<scene> has {found}, expected 3.0.0; older files than 2.0 are not supported yet")
        return None
    variables = Variables(defines)
    scene = _Interpreter(variables, report).nested(root, "scene")
    variables.report_unused(Place(file), report)
    return scene


class _Interpreter:
    """Turns elements into nodes. What cannot be read is reported and left out, so that the rest is still looked at."""

    def __init__(self, variables: Variables, report: Report) -> None:
        self._variables = variables
        self._report = report

    def nested(self, element: Element, kind: Kind) -> Object | None:
        """Return the object that `element` describes, with its children."""
        attributes = self._attributes(element, () if kind == "scene" else ("type",), ("id", "name", "type"))
        if attributes is None:
            return None
        variable = self._variables.single(element.attributes.get("type", ""))
        result = Object(
            element.place,
            attributes.get("type", "scene"),
            kind,
            key=attributes.get("name"),
            id=attributes.get("id"),
            variable=variable,
        )
        for child in element.children:
            if child.tag == "default":
                self._declare(child)
            elif (node := self._node(child)) is not None:
                result.children.append(Child(self._expand(child, "name") or None, node))
        return result

    def _declare(self, element: Element) -> None:
        attributes = self._attributes(element, ("name", "value"))
        if attributes is not None:
            self._variables.declare(attributes["name"], attributes["value"])

    def _node(self, element: Element) -> Node | None:
        tag, place = element.tag, element.place
        if tag == "spectrum" and "type" in element.attributes:
            return self.nested(element, "texture")
        if tag in OBJECTS:
            return self.nested(element, OBJECTS[tag])
        if tag == "ref":
            attributes = self._attributes(element, ("id",), ("name",))
            return None if attributes is None else Reference(place, attributes["id"])
        if tag == "transform":
            self._attributes(element, ("name",))
            return Value(place, transforms.compose([self._step(step) for step in element.children]))
        if tag in VALUES:
            for child in element.children:
                self._report.add(child.place, f"<{child.tag}> cannot stand inside <{tag}>")
            data = self._read(element, VALUES[tag])
            return None if data is None else Value(place, data)
        if tag in NOT_READ:
            self._report.add(place, f"<{tag}> is {NOT_YET}")
        elif tag in STEPS:
            self._report.add(place, f"<{tag}> belongs into a <transform>")
        else:
            self._report.add(place, f"unknown element <{tag}>{suggestion(tag, ELEMENTS)}")
        return None

    def _step(self, element: Element) -> NDArray[np.float64]:
        """Return one step of a transform; one that cannot be read does nothing."""
        if element.tag not in STEPS:
            self._report.add(element.place, f"unknown transform step <{element.tag}>{suggestion(element.tag, STEPS)}")
            return np.eye(4)
        step = self._read(element, STEPS[element.tag])
        return np.eye(4) if step is None else step

    def _read(self, element: Element, rule: Rule[T]) -> T | None:
        """Return what `rule` makes of `element`, or None if that cannot be read."""
        attributes = self._attributes(element, rule.required, rule.optional)
        if attributes is None:
            return None
        try:
            return rule.parse(attributes)
        except ValueError as error:
            self._report.add(element.place, f"{attributes.get('name', f'<{element.tag}>')}: {error}")
            return None

    def _attributes(self, element: Element, required: Names, optional: Names = ()) -> dict[str, str] | None:
        """Return the attributes with variables replaced.

        What is wrong is reported; None if the element cannot be read because something is missing or undefined.
        """
        known = {*required, *optional}
        for name in sorted(element.attributes.keys() - known):
            self._report.add(element.place, f"unknown attribute '{name}' of <{element.tag}>{suggestion(name, known)}")
        missing = [name for name in required if name not in element.attributes]
        for name in missing:
            self._report.add(element.place, f"<{element.tag}> needs the attribute '{name}'")
        expanded = {name: self._expand(element, name) for name in element.attributes}
        defined = {name: text for name, text in expanded.items() if text is not None}
        return None if missing or len(defined) < len(expanded) else defined

    def _expand(self, element: Element, name: str) -> str | None:
        """Return an attribute with variables replaced; None, and a report, if one of them is undefined."""
        try:
            return self._variables.expand(element.attributes.get(name, ""))
        except ValueError as error:
            self._report.add(element.place, str(error))
            return None
