"""Reads Mitsuba's XML into the tree of parsed nodes.

The reader replaces variables, includes other files, and translates files older than Mitsuba 2. Text between elements
has no meaning, as in Mitsuba, and gives a warning.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final, NamedTuple, TypeVar, get_args
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.model import Deformation, Kind
from equaltime.scene.motion import animation
from equaltime.scene.report import Report
from equaltime.scene.search import Includes, Search
from equaltime.scene.spectrum_values import read_spectrum
from equaltime.scene.tree import MAX_DEPTH, Alias, Child, Node, Object, Place, Plain, Ref
from equaltime.scene.variables import Variables
from equaltime.scene.xml_upgrade import upgraded
from equaltime.scene.xml_values import OLD_VALUES, STEPS, VALUES, Rule, number
from equaltime.words import suggestion

__all__ = ["Element", "parse_elements", "read_xml"]

Names = tuple[str, ...]
T = TypeVar("T")

OBJECTS: Final[dict[str, Kind]] = {kind: kind for kind in get_args(Kind) if kind != "scene"}
_MAJOR: Final = re.compile(r"([0-9]{1,9})(?:\.|$)")
"""Pattern of the major number at the beginning of a version."""
ELEMENTS: Final = (*OBJECTS, *VALUES, "alias", "animation", "default", "include", "path", "ref", "scene", "transform")


def read_xml(file: str, content: bytes, defines: Mapping[str, object], report: Report, search: Search) -> Object | None:
    """Return the root of the tree (parsed nodes) of the scene in `content`, the XML text of `file`.

    `defines` are the user's values of variables. `search` finds included files. Problems go to `report`. Return None if
    the file has no scene at all.
    """
    root = parse_elements(file, content, report)
    if root is None:
        return None
    if root.tag != "scene":
        report.add(root.place, f"expected the element <scene>, found <{root.tag}>")
        return None
    if (old := _is_old(root, report)) is None:
        return None
    variables, aliases = Variables(defines), list[Alias]()
    reader = _Interpreter(variables, report, search, aliases, old=old, files=(Path(file),), includes=Includes())
    scene = reader.nested(root, "scene")
    reader.report_unread(root)
    variables.report_unused(Place(file), report)
    if scene is not None:
        scene.aliases.extend(aliases)
    return scene


def _time(attributes: Mapping[str, str]) -> float:
    return number(attributes["time"])


def _is_old(root: Element, report: Report) -> bool | None:
    """Tell whether the root's version is older than 2; None, with a report, if it has no valid version."""
    version = root.attributes.pop("version", None)
    if version is not None and (major := _MAJOR.match(version)) is not None:
        return int(major[1]) < 2
    found = "no version" if version is None else f"version {version!r}"
    report.add(root.place, f"<{root.tag}> has {found}, expected one such as 3.0.0")
    return None


class _Interpreter:
    """Turns elements into nodes. An unreadable element is reported and left out, so that the rest is still checked."""

    def __init__(
        self,
        variables: Variables,
        report: Report,
        search: Search,
        aliases: list[Alias],
        *,
        old: bool,
        files: tuple[Path, ...],
        includes: Includes,
    ) -> None:
        self._variables = variables
        self._report = report
        self._search = search
        self._aliases = aliases
        self._old = old
        self._files = files
        self._includes = includes
        self._values = VALUES | OLD_VALUES if old else VALUES
        self._looked_at: set[int] = set()

    def report_unread(self, root: Element) -> None:
        """Report the elements within `root` that were never read, such as one inside a number."""
        for child in root.children:
            if id(child) in self._looked_at:
                self.report_unread(child)
            else:
                self._report.add(child.place, f"<{child.tag}> cannot stand inside <{root.tag}>")

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
            self._looked_at.add(id(child))
            if child.tag == "default":
                self._declare(child)
            elif child.tag == "alias":
                self._add_alias(child)
            elif child.tag == "path" and kind == "scene":
                self._add_folder(child)
            elif child.tag == "include":
                result.children.extend(self._included(child))
            elif (node := self._node(child)) is not None:
                result.children.append(Child(self._expand(child, "name") or None, node))
        return upgraded(result, self._report) if self._old else result

    def _declare(self, element: Element) -> None:
        attributes = self._attributes(element, ("name", "value"))
        if attributes is not None:
            self._variables.declare(attributes["name"], attributes["value"])

    def _add_alias(self, element: Element) -> None:
        attributes = self._attributes(element, ("id", "as"))
        if attributes is not None:
            self._aliases.append(Alias(element.place, attributes["id"], attributes["as"]))

    def _add_folder(self, element: Element) -> None:
        attributes = self._attributes(element, ("value",))
        if attributes is None:
            return
        folder = self._search.find(attributes["value"], beside=self._files[-1])
        if not folder.is_dir():
            self._report.add(element.place, f"no such folder: {folder}")
        self._search.add(folder, first=True)

    def _included(self, element: Element) -> list[Child]:
        """Return the children that the file named by `element` adds: the contents of a scene, or one object."""
        attributes = self._attributes(element, ("filename",), ("name",))
        if attributes is None:
            return []
        path = self._search.find(attributes["filename"], beside=self._files[-1])
        try:
            content = self._includes.read(path, len(self._files))
        except ValueError as error:
            self._report.add(element.place, str(error))
            return []
        root = parse_elements(str(path), content, self._report)
        if root is None or (old := _is_old(root, self._report)) is None:
            return []
        if root.tag != "scene" and root.tag not in OBJECTS:
            self._report.add(root.place, f"expected the element <scene> or an object, found <{root.tag}>")
            return []
        self._search.add(path.parent)
        files = (*self._files, path)
        inner = _Interpreter(
            self._variables,
            self._report,
            self._search,
            self._aliases,
            old=old,
            files=files,
            includes=self._includes,
        )
        node = inner.nested(root, "scene" if root.tag == "scene" else OBJECTS[root.tag])
        inner.report_unread(root)
        if node is None:
            return []
        return node.children if root.tag == "scene" else [Child(attributes.get("name", node.key), node)]

    def _node(self, element: Element) -> Node | None:
        tag, place = element.tag, element.place
        if tag == "spectrum" and "type" in element.attributes:
            return self.nested(element, "texture")
        if tag in OBJECTS:
            return self.nested(element, OBJECTS[tag])
        if tag == "ref":
            attributes = self._attributes(element, ("id",), ("name",))
            return None if attributes is None else Ref(place, attributes["id"])
        if tag == "transform":
            self._attributes(element, ("name",))
            return Plain(place, transforms.compose([self._step(step) for step in element.children]))
        if tag == "animation":
            return self._animation(element)
        if tag == "spectrum" and "filename" in element.attributes:
            return self._spectrum_file(element)
        if tag in self._values:
            data = self._read(element, self._values[tag])
            return None if data is None else Plain(place, data)
        if tag == "path":
            self._report.add(place, "<path> belongs in <scene>, not deeper")
        elif tag in STEPS:
            self._report.add(place, f"<{tag}> belongs in a <transform>")
        else:
            self._report.add(place, f"unknown element <{tag}>{suggestion(tag, ELEMENTS)}")
        return None

    def _spectrum_file(self, element: Element) -> Plain | None:
        rule = Rule(("name", "filename"), (), lambda a: read_spectrum(self._search.find(a["filename"])))
        curve = self._read(element, rule)
        return None if curve is None else Plain(element.place, curve)

    def _animation(self, element: Element) -> Plain:
        """Return an animation: of files if it contains strings, else of transforms."""
        if any(child.tag == "string" for child in element.children):
            when = self._attributes(element, ("name",), ("time",)) or {}
            files = [file for child in element.children if (file := self._file(child)) is not None]
            times, names = tuple(time for time, _ in files), tuple(name for _, name in files)
            held = None if "time" not in when else self._read(element, Rule(("name", "time"), (), _time))
            return Plain(element.place, Deformation(times, names, held))
        self._attributes(element, ("name",))
        keys = [key for child in element.children if (key := self._key(child)) is not None]
        return Plain(element.place, animation(keys))

    def _file(self, element: Element) -> tuple[float, str] | None:
        """Return a key of an animation of files."""
        self._looked_at.add(id(element))
        if element.tag != "string":
            self._report.add(element.place, f"an <animation> of files holds <string time=...>, not <{element.tag}>")
            return None
        return self._read(element, Rule(("time", "value"), (), lambda a: (_time(a), a["value"])))

    def _key(self, element: Element) -> tuple[float, NDArray[np.float64]] | None:
        """Return a key of an animation: a transform with a time."""
        self._looked_at.add(id(element))
        if element.tag != "transform":
            self._report.add(element.place, f"<animation> holds <transform time=...>, not <{element.tag}>")
            return None
        time = self._read(element, Rule(("time",), (), _time))
        steps = transforms.compose([self._step(step) for step in element.children])
        return None if time is None else (time, steps)

    def _step(self, element: Element) -> NDArray[np.float64]:
        """Return one step of a transform; an unreadable step becomes the identity."""
        self._looked_at.add(id(element))
        if element.tag not in STEPS:
            self._report.add(element.place, f"unknown transform step <{element.tag}>{suggestion(element.tag, STEPS)}")
            return np.eye(4)
        step = self._read(element, STEPS[element.tag])
        return np.eye(4) if step is None else step

    def _read(self, element: Element, rule: Rule[T]) -> T | None:
        """Return the value that `rule` reads from `element`; None, with a report, if it is unreadable."""
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

        Problems are reported. The result is None if an attribute is missing or a variable is undefined.
        """
        given, known = element.attributes, required + optional
        for name in sorted(given.keys() - known):
            near = suggestion(name, {*known})
            self._report.add(element.place, f"unknown attribute '{name}' of <{element.tag}>{near}")
        missing = [name for name in required if name not in given]
        for name in missing:
            self._report.add(element.place, f"<{element.tag}> needs the attribute '{name}'")
        if not missing and "$" not in "".join(given.values()):
            return given
        defined = {name: text for name in given if (text := self._expand(element, name)) is not None}
        return None if missing or len(defined) < len(given) else defined

    def _expand(self, element: Element, name: str) -> str | None:
        """Return an attribute with variables replaced; None, with a report, if a variable is undefined."""
        try:
            return self._variables.expand(element.attributes.get(name, ""))
        except ValueError as error:
            self._report.add(element.place, str(error))
            return None


# -- elements ----------------------------------------------------------------------------------------------------------

# Declarations inside the file, above all of entities, are refused. A scene does not need declarations, which can make
# an XML file read other files, or grow without bound. A document type in another file is never read. Some malformed
# files that Mitsuba accepts are read too, with a warning: hyphens within comments, a single &, blanks before the XML
# declaration, and bytes that are not UTF-8.


class Element(NamedTuple):
    """An XML element as the file gives it: its tag, attributes and children, with file and line."""

    tag: str
    attributes: dict[str, str]
    place: Place
    children: list[Element]


class _MalformedError(Exception):
    """The file is not well-formed XML."""

    def __init__(self, place: Place, message: str) -> None:
        self.place, self.message = place, message


class _RefusedError(Exception):
    """Ends parsing at once: the file contains something that must not be read."""

    def __init__(self, place: Place, message: str) -> None:
        self.place, self.message = place, message


_COMMENT = re.compile(rb"<!--.*?(?:-->|\Z)", re.DOTALL)
_LATE_DECLARATION = re.compile(rb"\A(\xef\xbb\xbf)?\s+<\?xml\b[^>]*\?>")
_LONE_AMPERSAND = re.compile(rb"&(?!#?\w+;)")
_OTHER_ENCODING = re.compile(rb"\A<\?xml\b[^>]*\bencoding\s*=\s*[\"'](?!utf-?8[\"'])", re.IGNORECASE)


def parse_elements(file: str, content: bytes, report: Report) -> Element | None:
    """Return the root element in `content`, the XML text of `file`.

    If the file cannot be read as XML, add a problem to `report`, and return None.
    """
    try:
        try:
            return _parsed(file, content, report)
        except _MalformedError as first:
            note = f"{first.place}: {first.message}; it is read nevertheless, as Mitsuba does"
        found = _parsed(file, _mended(content), report)
        report.note(note)
        return found
    except _MalformedError as malformed:
        report.add(malformed.place, malformed.message)
    except _RefusedError as refused:
        report.add(refused.place, refused.message)
    return None


def _mended(content: bytes) -> bytes:
    """Return the content as Mitsuba understands it, with the same line numbers."""
    content = _LATE_DECLARATION.sub(lambda found: b"\n" * found.group().count(b"\n"), content)
    content = _COMMENT.sub(lambda found: b"\n" * found.group().count(b"\n"), content)
    content = _LONE_AMPERSAND.sub(b"&amp;", content)
    return content if _OTHER_ENCODING.match(content) else content.decode("utf-8", "replace").encode()


def _parsed(file: str, content: bytes, report: Report) -> Element:
    parser = expat.ParserCreate()
    parser.buffer_text = True
    top = Element("", {}, Place(file), [])
    open_elements = [top]

    def here() -> Place:
        return Place(file, parser.CurrentLineNumber)

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(open_elements) > MAX_DEPTH:
            raise _RefusedError(here(), f"elements are nested more than {MAX_DEPTH} deep")
        element = Element(tag, attributes, here(), [])
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def end(_tag: str) -> None:
        open_elements.pop()

    def text(data: str) -> None:
        if data.strip():
            report.note(f"{here()}: the text {data.strip()[:40]!r} is ignored: values belong in attributes")

    def doctype(_name: str, _system: str | None, _public: str | None, declares: bool) -> None:
        if declares:
            raise _RefusedError(here(), "declarations of elements and entities are not allowed in a scene file")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = text, doctype
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        message = f"not well-formed XML: {expat.ErrorString(error.code)}"
        raise _MalformedError(Place(file, error.lineno), message) from error
    except (LookupError, ValueError) as error:
        raise _RefusedError(here(), f"the encoding that the file declares cannot be read: {error}") from error
    return top.children[0]
