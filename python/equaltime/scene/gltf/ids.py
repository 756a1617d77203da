"""Ids of a scene tree's objects, by the names in a glTF file, where several objects may have one name."""

from __future__ import annotations

from collections import Counter
from typing import Final

__all__ = ["Ids"]

_LONGEST: Final = 100
"""Characters of a name that are kept: a long name of many copies would fill the memory."""


class Ids:
    """Maker of ids for a scene's objects: each id is given once."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._asked: Counter[str] = Counter()  # how often each was taken: no number is tried twice

    def take(self, name: str) -> str:
        """Return an id that was not given before: ``name``, with the suffix ``_2``, ``_3`` and so on if needed.

        Characters that cannot be printed become underscores, because neither XML nor terminals can show them.
        """
        name = "".join(letter if letter.isprintable() else "_" for letter in name[:_LONGEST])
        found = name
        while found in self._taken:
            self._asked[name] += 1
            found = f"{name}_{self._asked[name] + 1}"
        self._taken.add(found)
        return found
