"""Quotes a render from its own first passes."""

from __future__ import annotations

from equaltime.errors import RenderError
from equaltime.quoting.observer import Observer
from equaltime.quoting.pilot import Pilot

__all__ = ["QuoteWatch"]


class QuoteWatch:
    """Gives an observer the quote as soon as there is one, or the reason why there is none."""

    def __init__(self, pilot: Pilot, observer: Observer) -> None:
        self._pilot, self._observer, self._done = pilot, observer, False

    def pass_ended(self) -> None:
        """Give the quote if enough is known now."""
        if self._done:
            return
        try:
            found = self._pilot.pass_ended()
        except RenderError as problem:
            self._done = True
            self._observer.unquoted(str(problem))
            return
        if found is not None:
            self._done = True
            self._observer.quoted(found)

    def ended(self) -> None:
        """Report the end of the render, after which there will be no quote."""
        if not self._done:
            self._done = True
            self._observer.unquoted("the render ended before a pilot could tell anything")
