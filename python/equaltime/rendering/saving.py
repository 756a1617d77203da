"""When what is done so far is saved: every so many seconds, but neither half of the time nor when it is almost over."""

from __future__ import annotations

from collections.abc import Callable

from equaltime.errors import ImageError

__all__ = ["Saving"]

_ROOM = 2.0
"""Times what saving took last: what must be left before the time limit."""


class Saving:
    """Saves what is done so far, and knows when that is due.

    All times are seconds since the first pass began.

    Parameters
    ----------
    save
        Does it.
    every
        Seconds from one state that is saved to the next; more where saving would take more than half of them.
    takes
        Seconds that saving is taken to take before it was done once.
    failed
        Called with why saving failed, once until it has been done again: a full disk may have room the next time.
    """

    def __init__(
        self, save: Callable[[], object], every: float, takes: float, failed: Callable[[str], object] | None = None
    ) -> None:
        self.seconds = 0.0
        """Spent in saving."""
        self._save, self._every, self._takes, self._due = save, every, takes, every
        self._failed, self._fails = failed, False

    def left(self, now: float, limit: float | None) -> float | None:
        """Return the seconds until it is due, 0 if it is; None if it would not be done before the time limit."""
        due = max(self._due, now)
        return None if limit is not None and due + _ROOM * self._takes > limit else due - now

    def run(self, clock: Callable[[], float]) -> float:
        """Save; return the seconds that it took."""
        begin = clock()
        self._try()
        end = clock()
        self._takes = end - begin
        self._due = max(begin + self._every, end + self._takes)
        self.seconds += self._takes
        return self._takes

    def _try(self) -> None:
        failed_before = self._fails
        try:
            self._save()
            self._fails = False
        except ImageError as problem:
            self._fails = True
            if self._failed is not None and not failed_before:
                self._failed(str(problem))
