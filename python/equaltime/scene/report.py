"""Reports about the files of a scene: problems, warnings, and the account of statements that have no effect.

A reader uses each statement, property or parameter of its file, refuses it with an error, or counts it in an account.
At the end, the reader counts everything that it has not used. No statement is therefore dropped silently.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from equaltime.errors import Problem, SceneError
from equaltime.scene.tree import Place

__all__ = ["MOST_KINDS", "MOST_TOLD", "Account", "Report", "told_once"]

MOST_TOLD = 100
"""Largest number of problems, and of warnings, reported for one scene, since a broken file may have thousands."""

MOST_LETTERS = 1000
"""Longest text of one problem, in characters; files are quoted, and may have very long names and values."""

MOST_KINDS: Final = 30
"""Largest number of kinds that are reported by name; a broken file may have more, and the rest share one line."""


class Report:
    """The problems (errors) and warnings found in a scene, collected so that all are reported together."""

    def __init__(self) -> None:
        self._problems: dict[tuple[Place, str], None] = {}  # in order of discovery, without duplicates
        self._notes: dict[str, None] = {}
        self._untold = 0

    def add(self, place: Place, message: str) -> None:
        """Add a problem at `place` (file and line, or path of keys).

        Raises SceneError at once if the number of problems reaches `MOST_TOLD`.
        """
        self._problems[place, message] = None
        if len(self._problems) >= MOST_TOLD:
            last = Problem(place.file, f"{MOST_TOLD} problems are listed; the rest of the scene was not checked")
            raise SceneError((*self._ordered(), last))

    def note(self, message: str) -> None:
        """Add a warning for the user; warnings beyond `MOST_TOLD` are counted but not kept."""
        if len(self._notes) < MOST_TOLD:
            self._notes[_quoted(message)] = None
        else:
            self._untold += 1

    @property
    def notes(self) -> tuple[str, ...]:
        """The warnings added by `note`, in order, and a last one with the number of warnings left out, if any."""
        more = [f"and {self._untold} more warnings"] if self._untold else []
        return (*self._notes, *more)

    def raise_if_any(self) -> None:
        """Raise SceneError with all problems found so far, ordered by line, if there are any."""
        if self._problems:
            raise SceneError(self._ordered())

    def _ordered(self) -> tuple[Problem, ...]:
        ordered = sorted((one for one in self._problems if not self._deeper(*one)), key=lambda one: one[0].line or 0)
        return tuple(Problem(_quoted(str(place)), _quoted(message)) for place, message in ordered)

    def _deeper(self, place: Place, message: str) -> bool:
        """Tell whether the same message is told of something within ``place``, which is the better place."""
        return any(
            other.file == place.file and said == message and other.path.startswith(f"{place.path}.")
            for other, said in self._problems
        )


class Account:
    """Counts of the statements in a file that are not used, by message, to be listed to the user.

    The place of the first statement is kept for each message. Iteration yields the lines to report, as text.
    """

    def __init__(self) -> None:
        self._entries: dict[str, tuple[str, int]] = {}
        self._untold = 0

    def tell(self, kind: str, place: object) -> None:
        """Count one more unused statement at `place` (file and line); `kind` is the message, without the place."""
        first, count = self._entries.get(kind, (str(place), 0))
        if count == 0 and len(self._entries) >= MOST_KINDS:
            self._untold += 1
        else:
            self._entries[kind] = first, count + 1

    def __iter__(self) -> Iterator[str]:
        """Iterate over the lines to report, in order of discovery: ``a.mtl:3: 'Ks' is not used (first of 12)``."""
        for kind, (first, count) in self._entries.items():
            yield f"{first}: {kind}" + (f" (first of {count})" if count > 1 else "")
        if self._untold:
            yield f"and {self._untold} more statements of other kinds are not used"


def told_once(place: Place, message: str) -> tuple[Place, str]:
    """Return `place` (file and line) and `message` for a problem, so that the file is not named twice.

    If the message begins with the file of `place`, as in ``file:3: text``, the file is removed from the message, and
    the line number moves into the place.
    """
    found = re.fullmatch(rf"{re.escape(place.file)}(?::(\d+))?: (.*)", message, re.DOTALL)
    if found is None or place != Place(place.file):
        return place, message
    return Place(place.file, int(found[1]) if found[1] else None), found[2]


def _quoted(text: str) -> str:
    """Return `text` for a message; if it has more than `MOST_LETTERS` characters, its middle is left out."""
    if len(text) <= MOST_LETTERS:
        return text
    half = MOST_LETTERS // 2
    return f"{text[:half]} [... {len(text) - 2 * half} letters ...] {text[-half:]}"
