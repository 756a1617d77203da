"""Parses XML into elements, each with its file and line.

Declarations inside the file, above all of entities, are refused. A scene does not need declarations, which can make an
XML file read other files, or grow without bound. A document type in another file is never read. Text between elements
has no meaning, as in Mitsuba, and gives a warning. Some malformed files that Mitsuba accepts are read too, with a
warning: hyphens within comments, a single ``&``, blanks before the XML declaration, and bytes that are not UTF-8.
"""

from __future__ import annotations

import re
from typing import NamedTuple
from xml.parsers import expat

from equaltime.scene.tree import MAX_DEPTH, Place, Report

__all__ = ["Element", "parse_elements"]


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
            report.note(f"{here()}: the text {data.strip()[:40]!r} is passed over: values belong into attributes")

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
