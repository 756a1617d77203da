"""Reads TOML, equaltime's own spelling of a scene, into the tree.

The tables of the file are the objects of the scene, with the same keys as Mitsuba's dictionaries; the scene itself
needs no ``type``. A table ``default`` gives variables their values: a string ``"$name"`` is replaced by the value with
its type, and ``-D name=value`` overrides it.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Final

from equaltime.scene.dict_reader import DictReader
from equaltime.scene.tree import Object, Place, Report
from equaltime.scene.variables import Variables

__all__ = ["read_toml"]

_HEADER: Final = re.compile(r"\s*\[\[?\s*([A-Za-z0-9_.\- \"']+?)\s*\]\]?\s*(#.*)?$")
_ENTRY: Final = re.compile(r"\s*([A-Za-z0-9_.\- \"']+?)\s*=")
_LINE: Final = re.compile(r"\(at (?:line (\d+), column \d+|end of document)\)$")


def read_toml(file: str, content: bytes, defines: Mapping[str, object], report: Report) -> Object | None:
    """Return the scene in the TOML `content` of `file`; problems go to `report`, None if there is no scene at all."""
    place = Place(file)
    try:
        text = content.decode("utf-8-sig")  # some editors begin a file with a byte order mark
        table = tomllib.loads(text)
    except UnicodeDecodeError as error:
        number = content.count(b"\n", 0, error.start) + 1
        report.add(Place(file, number), f"not UTF-8 text (byte {error.start} of the file)")
        return None
    except tomllib.TOMLDecodeError as error:
        line = _LINE.search(str(error))
        report.add(
            Place(file, int(line[1]) if line and line[1] else text.count("\n") + 1),
            f"not well-formed TOML: {_LINE.sub('', str(error)).strip()}",
        )
        return None
    except RecursionError:
        report.add(place, "not well-formed TOML: nested too deep")
        return None
    except ValueError:  # the one thing that tomllib leaves to Python
        report.add(place, "a number has more digits than can be read")
        return None
    reader = _TomlReader(text, Variables({k: _typed(v) for k, v in defines.items()}), report)
    return reader.scene(table, place)


class _TomlReader(DictReader):
    """A reader of dictionaries that has variables and knows the lines of its file."""

    def __init__(self, text: str, variables: Variables, report: Report) -> None:
        super().__init__(report)
        self._variables = variables
        self._lines = _line_numbers(text)

    def scene(self, table: dict[str, object], place: Place) -> Object | None:
        """Return the scene with the contents of `table`."""
        defaults = table.pop("default", {})
        if not isinstance(defaults, dict):
            self._report.add(self.locate(place.key("default")), "'default' must be a table of variables")
            defaults = {}
        for name, value in defaults.items():
            self._variables.declare(name, value)
        if table.setdefault("type", "scene") != "scene":
            self._report.add(
                self.locate(place.key("type")), f"the type of the whole file is 'scene', if any, not {table['type']!r}"
            )
        scene = self.nested(table, place)
        self._variables.report_unused(place, self._report)
        return scene

    def locate(self, place: Place) -> Place:
        """Return `place` with its line, or with that of what it is in."""
        line = self._lines.get(place.path, place.line)
        return Place(place.file, line, place.path)

    def string(self, text: str) -> object:
        """Return `text` with variables replaced; a single variable keeps the type of its value."""
        name = self._variables.single(text)
        return self._variables.expand(text) if name is None else self._variables.value(name)

    def variable(self, text: str) -> str | None:
        """Return the name of the variable that `text` consists of, if it does."""
        return self._variables.single(text)


def _typed(value: object) -> object:
    """Return a definition from the command line as what it would be in a file: ``64`` a number, ``path`` a string."""
    if not isinstance(value, str):
        return value
    try:
        return tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        return value


def _line_numbers(text: str) -> dict[str, int]:
    """Return the line of each key path that starts one.

    This is no second parser: it looks at table headers and at the beginnings of lines, which is where people put
    keys. A path that it does not know is placed at the line of the table around it.
    """
    lines: dict[str, int] = {}
    counts: dict[str, int] = {}
    table = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            table = _dotted(header[1])
            if line.lstrip().startswith("[["):
                lines.setdefault(table, number)
                counts[table] = counts.get(table, -1) + 1
                table = f"{table}[{counts[table]}]"
            lines.setdefault(table, number)
        elif entry := _ENTRY.match(line):
            key = _dotted(entry[1])
            lines.setdefault(f"{table}.{key}" if table else key, number)
    return lines


def _dotted(key: str) -> str:
    return ".".join(part.strip().strip("\"'") for part in key.split("."))
