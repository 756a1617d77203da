"""The sample counts at which a run is looked at."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["BudgetLadder", "counts"]

# What is left of a budget is used up by one more checkpoint if that has so many times the samples.
_LEAST_STEP = 1.1


def counts() -> Iterator[int]:
    """Yield 2, 4, 6, 8, 12, 16, 24, 32, 48, … without an end: powers of two, and once between."""
    yield 2
    power = 4
    while True:
        yield power
        yield power + power // 2
        power *= 2


class BudgetLadder:
    """Sample counts for a run that shall end with its budget: the next follows from the time of the last.

    All strategies then end at nearly the same time, which is what makes their last images comparable. Counts are even,
    since a render's own error comes from two halves.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._counts = counts()
        self._spp = 0
        self._wall = 0.0
        self._ended = False

    def taken(self, spp: int, wall_s: float) -> None:
        """Note how long so many samples took."""
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
