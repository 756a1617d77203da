"""Finds the lines of keys in a TOML file, which the standard library's parser does not report."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Final

__all__ = ["line_numbers", "malformed", "nearest"]

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
    return number, f"not well-formed TOML: {_ERROR_LINE.sub('', str(error)).strip()}"


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
