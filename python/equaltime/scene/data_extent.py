"""How much a scene of nested data is when all that it shares is written out: sharing can double it with each level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from equaltime.scene.tree import FREE_ENTRIES, MAX_DEPTH, USES_OF_EACH

__all__ = ["Extent"]

Container = Mapping[str, object] | Sequence[object]


class Extent:
    """Counts the entries of dictionaries and lists as they are read, and those that there really are."""

    def __init__(self) -> None:
        self._known: dict[int, Container] = {}  # holds them, so that no other gets their identity
        self._own = self._read = 0

    def take(self, table: Container) -> bool:
        """Count one dictionary or list; tell whether there is still no more than sharing may make."""
        size = 1 + len(table)
        if id(table) not in self._known:
            self._known[id(table)] = table
            self._own += size
        self._read += size
        return self._read <= FREE_ENTRIES + USES_OF_EACH * self._own

    @property
    def complaint(self) -> str:
        """What is wrong with a scene of which too much was read."""
        most = FREE_ENTRIES + USES_OF_EACH * self._own
        return f"its dictionaries and lists are used again and again; the limit for this scene is {most} entries"

    def check(self, table: Container, depth: int) -> None:
        """Count one list that is nested so deep in others; raises ValueError where that is too much."""
        if depth >= MAX_DEPTH:
            raise ValueError(f"lists are nested more than {MAX_DEPTH} deep")
        if not self.take(table):
            raise ValueError(self.complaint)
