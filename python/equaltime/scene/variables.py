"""Variables in scene files: ``$name`` stands for a value that the file declares or the user defines."""

from __future__ import annotations

import re
from collections.abc import Container, Mapping
from typing import Final

from equaltime.scene.report import Report
from equaltime.scene.tree import Place
from equaltime.words import nearest, suggestion

__all__ = ["Variables"]

_VARIABLE = re.compile(r"\\?\$(\w*)")

MOST_TEXT: Final = 1 << 23
"""Largest number of characters that variables may insert into a scene. A variable whose value uses another variable
twice doubles the number each time."""


class Variables:
    """The values of a scene file's variables, which replace ``$name``; the user's definitions override the file's."""

    def __init__(self, defines: Mapping[str, object]) -> None:
        self._defines = dict(defines)
        self._values = dict(defines)
        self._used: set[str] = set()
        self._text = 0

    def declare(self, name: str, default: object) -> None:
        """Set the value of the variable `name`, unless the variable already has one.

        A definition by the user or an earlier declaration is kept.
        """
        self._values.setdefault(name, default)

    def single(self, text: str) -> str | None:
        """Return the variable's name if `text` is exactly one variable, such as ``$name``, else None."""
        match = _VARIABLE.fullmatch(text)
        return match[1] if match and match[0].startswith("$") and self._longest(match[1]) == match[1] else None

    def _longest(self, word: str) -> str:
        """Return the longest known name with which `word` begins, as in Mitsuba; `word` itself if there is none."""
        return next((word[:end] for end in range(len(word), 0, -1) if word[:end] in self._values), word)

    def value(self, name: str) -> object:
        """Return the value of the variable `name`; raises ValueError if the variable has no value."""
        self._used.add(name)
        if name not in self._values:
            near = nearest(name, self._values)
            hint = f", or did you mean ${near}?" if near else ""
            raise ValueError(f"the variable ${name} has no value: give it one with -D {name}=...{hint}")
        return self._values[name]

    def expand(self, text: str) -> str:
        r"""Return `text` with all variables replaced by their values, and ``\$`` by a dollar sign.

        Raises ValueError for a variable without a value, and if all values together exceed `MOST_TEXT` characters.
        """
        if "$" not in text:
            return text

        def replacement(match: re.Match[str]) -> str:
            if match[0].startswith("\\"):
                return match[0][1:]
            name = self._longest(match[1])
            value = self.value(name)
            word = str(value).lower() if isinstance(value, bool) else str(value)
            if self._text + len(word) > MOST_TEXT:
                raise ValueError(f"the variables of the scene stand for more than {MOST_TEXT} characters")
            self._text += len(word)
            return word + match[1][len(name) :]

        return _VARIABLE.sub(replacement, text)

    def report_unused(self, place: Place, report: Report, blocks: Container[str] = ()) -> None:
        """Add a problem to `report`, at `place`, for each definition by the user that the file never uses.

        ``blocks`` are names of the file's blocks, for which a user may take a definition.
        """
        for name in sorted(set(self._defines) - self._used):
            block = f": [{name}] is a block of the file, to be edited there" if name in blocks else ""
            hint = block or suggestion(name, self._used)
            report.add(place, f"nothing in the scene uses the definition '{name}'{hint}")
