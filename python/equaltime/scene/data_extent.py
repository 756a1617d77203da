"""The size of a scene of nested data once all sharing is written out; sharing can double the size with each level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from equaltime.scene.tree import FREE_ENTRIES, MAX_DEPTH, USES_OF_EACH

__all__ = ["Extent"]

Container = Mapping[str, object] | Sequence[object]


class Extent:
    """Counts the entries of dictionaries and lists: once for each reading, and once for each distinct container."""

    def __init__(self) -> None:
        self._known: dict[int, Container] = {}  # keeps the containers alive, so that no id is reused
        self._own = self._read = 0

    def take(self, table: Container) -> bool:
        """Count one dictionary or list; tell whether the entries read are still within the limit for sharing."""
        size = 1 + len(table)
        if id(table) not in self._known:
            self._known[id(table)] = table
            self._own += size
        self._read += size
        return self._read <= FREE_ENTRIES + USES_OF_EACH * self._own

    @property
    def complaint(self) -> str:
        """The error for a scene whose limit was exceeded."""
        most = FREE_ENTRIES + USES_OF_EACH * self._own
        return f"its dictionaries and lists are used again and again; the limit for this scene is {most} entries"

    def check(self, table: Container, depth: int) -> None:
        """Count one list at nesting level `depth`; raises ValueError if the depth or the entries exceed their limit."""
        if depth >= MAX_DEPTH:
            raise ValueError(f"lists are nested more than {MAX_DEPTH} deep")
        if not self.take(table):
            raise ValueError(self.complaint)
