"""Sample counts of a run's checkpoints."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["BudgetLadder", "counts"]

# The rest of a budget is spent on one more checkpoint if it has at least this many times the last one's samples.
_LEAST_STEP = 1.1


def counts() -> Iterator[int]:
    """Yield 2, 4, 6, 8, 12, 16, 24, 32, 48, … without end: powers of two, and one count between each two from 4 on."""
    yield 2
    power = 4
    while True:
        yield power
        yield power + power // 2
        power *= 2


class BudgetLadder:
    """Sample counts for a run that ends with its budget: each count follows from the time of the last.

    All strategies then end at nearly the same time, which makes their last images comparable. Counts are even, because
    a render's own error estimate comes from two halves.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._counts = counts()
        self._spp = 0
        self._wall = 0.0
        self._ended = False

    def taken(self, spp: int, wall_s: float) -> None:
        """Record that ``spp`` samples per pixel took ``wall_s`` seconds."""
        self._spp, self._wall = spp, wall_s

    def __iter__(self) -> Iterator[int]:
        return self

    def __next__(self) -> int:
        if self._ended or self._wall >= self._seconds:
            raise StopIteration
        spp = next(count for count in self._counts if count > self._spp)
        if self._spp == 0 or self._wall * spp <= self._seconds * self._spp:
            return spp
        self._ended = True
        last = int(self._spp * self._seconds / self._wall) // 2 * 2
        if last < _LEAST_STEP * self._spp:
            raise StopIteration
        return last
