"""Reads TOML, equaltime's own spelling of a scene, into the tree of parsed nodes.

The tables of the file are the objects of the scene, with the same keys as in Mitsuba's dictionaries. The scene itself
needs no ``type``. A table ``default`` gives variables their values. A string ``"$name"`` is replaced by the variable's
value, which keeps its type. ``-D name=value`` overrides the file's value. ``include`` names one or more files whose
objects are part of the scene. ``path`` names folders that are searched for files first. A table ``alias`` gives objects
further names.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from equaltime.scene.dict_reader import DictReader
from equaltime.scene.report import Report
from equaltime.scene.search import Includes, Search
from equaltime.scene.tree import Alias, Object, Place
from equaltime.scene.variables import Variables

__all__ = ["line_numbers", "malformed", "nearest", "read_toml"]

_OF_EXPERIMENTS = ("scenes", "strategies")
"""Lists that an experiment has and no scene has."""


def read_toml(
    file: str, content: bytes, defines: Mapping[str, object], report: Report, search: Search
) -> Object | None:
    """Return the root of the tree (parsed nodes) of the scene in `content`, the TOML text of `file`.

    `defines` are the user's values of variables. `search` finds included files. Problems go to `report`. Return None if
    the file has no scene at all.
    """
    parsed = _parsed(file, content, report)
    if parsed is None:
        return None
    text, table = parsed
    if all(isinstance(table.get(key), list) for key in _OF_EXPERIMENTS):
        report.add(Place(file), "an experiment, not a scene: `equaltime cost` runs it")
        return None
    variables = Variables({name: _typed(value) for name, value in defines.items()})
    reader = _TomlReader(text, variables, report, search, (Path(file),), Includes())
    scene = reader.scene(table, Place(file))
    variables.report_unused(Place(file), report, blocks=table)
    return scene


def _parsed(file: str, content: bytes, report: Report) -> tuple[str, dict[str, object]] | None:
    """Return the text of a file and its parsed content; None, with a report, if it is not TOML."""
    try:
        text = content.decode("utf-8-sig")  # some editors begin a file with a byte order mark
        return text, tomllib.loads(text)
    except UnicodeDecodeError as error:
        number = content.count(b"\n", 0, error.start) + 1
        report.add(Place(file, number), f"not UTF-8 text (byte {error.start} of the file)")
    except tomllib.TOMLDecodeError as error:
        number, message = malformed(error, text)
        report.add(Place(file, number), message)
    except RecursionError:
        report.add(Place(file), "not well-formed TOML: nested too deep")
    except ValueError:  # tomllib leaves the limit on digits to Python
        report.add(Place(file), "a number has more digits than can be read")
    return None


class _TomlReader(DictReader):
    """A reader of dictionaries that supports variables and includes, and knows the lines of its file."""

    def __init__(
        self,
        text: str,
        variables: Variables,
        report: Report,
        search: Search,
        files: tuple[Path, ...],
        includes: Includes,
    ) -> None:
        super().__init__(report, search)
        self._variables = variables
        self._lines = line_numbers(text)
        self._files = files
        self._includes = includes

    def scene(self, table: dict[str, object], place: Place) -> Object | None:
        """Return the scene with the contents of `table` and of the included files."""
        for name, value in self._table(table, "default", place, "variables").items():
            self._variables.declare(name, value)
        for folder in self._strings(table, "path", place):
            self._add_folder(folder, self.locate(place.key("path")))
        names = self._table(table, "alias", place, "names") if "type" not in _as_table(table.get("alias")) else {}
        where = self.locate(place.key("include"))
        included = [part for name in self._strings(table, "include", place) if (part := self._included(name, where))]
        if table.setdefault("type", "scene") != "scene":
            self._report.add(
                self.locate(place.key("type")), f"the type of the whole file is 'scene', if any, not {table['type']!r}"
            )
        scene = self.nested(table, place)
        if scene is not None:
            scene.children[:0] = [child for part in included for child in part.children]
            scene.aliases.extend(alias for part in included for alias in part.aliases)
            at = place.key("alias")
            scene.aliases.extend(Alias(self.locate(at.key(name)), str(id), name) for name, id in names.items())
        return scene

    def _table(self, table: dict[str, object], key: str, place: Place, what: str) -> dict[str, object]:
        """Remove the table `key` from `table` and return it."""
        found = table.pop(key, {})
        if isinstance(found, dict):
            return found
        self._report.add(self.locate(place.key(key)), f"'{key}' must be a table of {what}")
        return {}

    def _strings(self, table: dict[str, object], key: str, place: Place) -> list[str]:
        """Remove `key` from `table` and return it if it is a string or several, with variables replaced."""
        found = table.get(key)
        texts = [found] if isinstance(found, str) else found
        if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
            return []
        del table[key]
        try:
            return [self._variables.expand(text) for text in texts]
        except ValueError as error:
            self._report.add(self.locate(place.key(key)), str(error))
            return []

    def _add_folder(self, name: str, place: Place) -> None:
        folder = self._search.find(name, beside=self._files[-1])
        if not folder.is_dir():
            self._report.add(place, f"no such folder: {folder}")
        self._search.add(folder, first=True)

    def _included(self, name: str, place: Place) -> Object | None:
        """Return the scene in the file `name`."""
        path = self._search.find(name, beside=self._files[-1])
        try:
            content = self._includes.read(path, len(self._files))
        except ValueError as error:
            self._report.add(place, str(error))
            return None
        parsed = _parsed(str(path), content, self._report)
        if parsed is None:
            return None
        self._search.add(path.parent)
        files = (*self._files, path)
        inner = _TomlReader(parsed[0], self._variables, self._report, self._search, files, self._includes)
        return inner.scene(parsed[1], Place(str(path)))

    def locate(self, place: Place) -> Place:
        """Return `place` with the line of its key, or else with the line of the part around it."""
        line = self._lines.get(place.path, place.line)
        return Place(place.file, line, place.path)

    def string(self, text: str) -> object:
        """Return `text` with variables replaced; a single variable keeps the type of its value."""
        name = self._variables.single(text)
        return self._variables.expand(text) if name is None else self._variables.value(name)

    def variable(self, text: str) -> str | None:
        """Return the name if `text` is one variable and nothing else."""
        return self._variables.single(text)


def _as_table(value: object) -> Mapping[str, object]:
    return value if isinstance(value, dict) else {}


def _typed(value: object) -> object:
    """Return a command-line definition as its TOML value: ``64`` is a number, ``path`` a string."""
    if not isinstance(value, str):
        return value
    try:
        return tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        return value


# -- lines -------------------------------------------------------------------------------------------------------------

# Finds the lines of keys in a TOML file, which the standard library's parser does not report.

# Possessive quantifiers: with backtracking, a line of blanks would take time cubic in its length.
_HEADER: Final = re.compile(r"\s*+\[\[?\s*+([A-Za-z0-9_.\- \"']++)\]\]?\s*+(#.*)?$")
_ENTRY: Final = re.compile(r"\s*+([A-Za-z0-9_.\- \"']++)=")
_LIST: Final = re.compile(r".*=\s*+\[\s*+(#.*)?$")
_LITERAL: Final = re.compile(
    r"#[^\n]*"  # a comment
    r'|"{3}(?:[^\\]|\\.)*?"{3,5}'  # multi-line strings, which may end in two quotes of their own
    r"|'{3}.*?'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'  # strings on one line
    r"|'[^'\n]*'",
    re.DOTALL,
)
_ERROR_LINE: Final = re.compile(r"\(at (?:line (\d+), column \d+|end of document)\)$")
_QUOTED: Final = '; text stands in quotation marks, as in bsdf = "glass"'


def line_numbers(text: str) -> dict[str, int]:
    """Return a dict from the paths of keys in a TOML `text`, such as ``scenes[1].size``, to their line numbers.

    Only table headers and beginnings of lines are examined, where people put keys and the entries of long lists. For a
    path that is not in the dict, use `nearest`.
    """
    lines: dict[str, int] = {}
    counts: dict[str, int] = {}
    table = within = ""
    for number, line in enumerate(_LITERAL.sub(_begun, text).split("\n"), start=1):
        if within:
            within = _list_entry(line, number, within, lines, counts)
        elif header := _HEADER.match(line):
            table = _dotted(header[1])
            if line.lstrip().startswith("[["):
                lines.setdefault(table, number)
                counts[table] = counts.get(table, -1) + 1
                table = f"{table}[{counts[table]}]"
            lines.setdefault(table, number)
        elif entry := _ENTRY.match(line):
            key = _dotted(entry[1])
            path = f"{table}.{key}" if table else key
            lines.setdefault(path, number)
            within = path if _LIST.match(line) else ""
    return lines


def nearest(lines: Mapping[str, int], path: str) -> int | None:
    """Return the line number of the key path `path`, such as ``scenes[1].size[0]``.

    If `lines` (made by `line_numbers`) does not have the path, return the line of the innermost table or list around
    the key. Return None if no line is known.
    """
    while path:
        if path in lines:
            return lines[path]
        path = path[: max(path.rfind("."), path.rfind("["), 0)]
    return None


def malformed(error: tomllib.TOMLDecodeError, text: str) -> tuple[int, str]:
    """Return the line number and the message for a parser's `error` about a `text` that is not TOML."""
    line = _ERROR_LINE.search(str(error))
    number = int(line[1]) if line and line[1] else text.count("\n") + 1
    said = _ERROR_LINE.sub("", str(error)).strip()
    return number, f"not well-formed TOML: {said}{_QUOTED if said == 'Invalid value' else ''}"


def _begun(literal: re.Match[str]) -> str:
    """Blank a multi-line string except for its opening quotes, because text inside it can look like keys."""
    text = literal[0]
    return text[:3] + re.sub(r"[^\n]", " ", text[3:]) if text.startswith(('"""', "'''")) else text


def _list_entry(line: str, number: int, path: str, lines: dict[str, int], counts: dict[str, int]) -> str:
    """Note the list entry that begins on this line; return ``path``, or an empty string if the list ends."""
    begin = line.lstrip(", \t\r")[:1]
    if begin == "]":
        return ""
    if begin and begin != "#":
        counts[path] = counts.get(path, -1) + 1
        lines.setdefault(f"{path}[{counts[path]}]", number)
    return path


def _dotted(key: str) -> str:
    return ".".join(part.strip().strip("\"'") for part in key.split("."))
