"""The account of a file: what it says that does not reach the picture, told in one line for each kind.

A reader uses each statement, property or parameter of its file, refuses it with its place, or enters it here. It ends
by entering everything that it has not consumed, so that nothing is lost in silence, whatever the format brings next.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

__all__ = ["MOST_KINDS", "Account"]

MOST_KINDS: Final = 30
"""Kinds that are told by name. A file with more is broken all over; the rest share one line."""


class Account:
    """Counts, by kind, the statements of one file that are not used, and keeps the first place of each kind."""

    def __init__(self) -> None:
        self._entries: dict[str, tuple[str, int]] = {}
        self._untold = 0

    def tell(self, kind: str, place: object) -> None:
        """Enter one more statement of this `kind`, a sentence without its place, at `place`."""
        first, count = self._entries.get(kind, (str(place), 0))
        if count == 0 and len(self._entries) >= MOST_KINDS:
            self._untold += 1
        else:
            self._entries[kind] = first, count + 1

    def __iter__(self) -> Iterator[str]:
        """Iterate over the lines to tell, in the order of being found: ``a.mtl:3: 'Ks' is not used (first of 12)``."""
        for kind, (first, count) in self._entries.items():
            yield f"{first}: {kind}" + (f" (first of {count})" if count > 1 else "")
        if self._untold:
            yield f"and {self._untold} more statements of other kinds are not used"
