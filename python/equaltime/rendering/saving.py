"""Schedule of checkpoints: one every N seconds, at most half of the time, and none shortly before the time limit."""

from __future__ import annotations

from collections.abc import Callable

from equaltime.errors import ImageError

__all__ = ["Saving"]

_ROOM = 2.0
"""A checkpoint is skipped if less than this many times the last save's duration remains before the time limit."""


class Saving:
    """Saves checkpoints and schedules them.

    All times are seconds since the first pass began.

    Parameters
    ----------
    save
        Callable that saves the render so far.
    every
        Seconds between the starts of two checkpoints; more if saving would take more than half of them.
    takes
        Expected seconds of the first save.
    failed
        Called with the reason when saving fails; again only after a save has worked: a full disk may have room later.
    """

    def __init__(
        self, save: Callable[[], object], every: float, takes: float, failed: Callable[[str], object] | None = None
    ) -> None:
        self.seconds = 0.0
        """Seconds spent in saving."""
        self._save, self._every, self._takes, self._due = save, every, takes, every
        self._failed, self._fails = failed, False

    def left(self, now: float, limit: float | None) -> float | None:
        """Return the seconds until the next save, 0 if it is due; None if it would not end before the time limit."""
        due = max(self._due, now)
        return None if limit is not None and due + _ROOM * self._takes > limit else due - now

    def run(self, clock: Callable[[], float]) -> float:
        """Save; return the seconds that saving took."""
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
