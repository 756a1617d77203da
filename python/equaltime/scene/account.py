"""The account of a scene file: a list of its statements that have no effect on the picture, one line per message.

A reader uses each statement, property or parameter of its file, refuses it with an error, or counts it in the account.
At the end, the reader counts everything that it has not used. No statement is therefore dropped silently.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

__all__ = ["MOST_KINDS", "Account"]

MOST_KINDS: Final = 30
"""Largest number of kinds that are reported by name; a broken file may have more, and the rest share one line."""


class Account:
    """The unused statements of one file, counted by message, with the file and line of each message's first one.

    Iteration yields the lines to report, as text.
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
