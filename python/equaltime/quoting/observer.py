"""Observers of a running render: subclass `Observer` and override the methods of interest.

`QuoteWatch` tells an observer the quote: a prediction of time or error from the render's own first passes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import RenderError
from equaltime.quoting.pilot import Pilot, Quote
from equaltime.rendering.passes import Progress

__all__ = ["ENDED_FIRST", "Observer", "QuoteWatch", "overrides"]

ENDED_FIRST = "the render ended before a pilot could tell anything"
"""Reason that an observer receives for having no quote, if the render ends before its time or error can be
predicted."""


class Observer:
    """Receiver of the events of a render. Every method may be overridden; the methods of this class do nothing.

    Methods are called in the thread that called `equaltime.render`. `of` makes an observer of functions::

        et.render(scene, time=60, observer=et.Observer.of(progress=lambda now: print(now.samples)))
    """

    @staticmethod
    def of(
        *,
        progress: Callable[[Progress], object] | None = None,
        pass_ended: Callable[[Callable[[], NDArray[np.float64]]], object] | None = None,
        quoted: Callable[[Quote], object] | None = None,
        unquoted: Callable[[str], object] | None = None,
        decided: Callable[[Sequence[str]], object] | None = None,
        unsaved: Callable[[str], object] | None = None,
    ) -> Observer:
        """Return an observer that calls these functions; a method without a function does nothing.

        Each function receives the arguments of the method of its name, without ``self``.
        """
        functions = {
            "progress": progress,
            "pass_ended": pass_ended,
            "quoted": quoted,
            "unquoted": unquoted,
            "decided": decided,
            "unsaved": unsaved,
        }
        methods = {name: staticmethod(function) for name, function in functions.items() if function is not None}
        heard: Observer = type("Heard", (Observer,), methods)()
        return heard

    def progress(self, progress: Progress) -> None:
        """Receive the samples, the error and the time left in ``progress``, about ten times a second.

        The method may raise `KeyboardInterrupt` to stop the render.
        """

    def pass_ended(self, image: Callable[[], NDArray[np.float64]]) -> None:
        """Receive the end of a pass over all pixels. ``image()`` returns the image so far, (H, W, 3), in linear RGB."""

    def quoted(self, quote: Quote) -> None:
        """Receive ``quote``, the predicted time to reach the error limit, or the error that the time limit will reach.

        The method is called once, early in the render. The quote comes after 5 % of the work or 10 s, whichever is
        first, but not before 8 samples per pixel. With an error limit, up to 4096 pixels are first rendered to the end.
        This takes at most 3 % of the work, or 4 samples per pixel if that is more. The samples of these pixels are not
        in the image.
        """

    def unquoted(self, why: str) -> None:
        """Receive ``why``, the reason in words for which a render with a limit of time or error has no prediction.

        The method is called once, instead of `quoted`.
        """

    def decided(self, why: Sequence[str]) -> None:
        """Receive ``why``, sentences that say which effects (features such as media) were left out or kept, and why.

        The method is called once, before the first sample.
        """

    def unsaved(self, why: str) -> None:
        """Receive the reason ``why``, in words, for which no checkpoint could be written; the render goes on.

        A checkpoint is a file of the render so far. After a failure, the next failure is reported only if a checkpoint
        was written in between.
        """


def overrides(observer: Observer, method: str) -> bool:
    """Tell whether ``observer`` overrides the method named ``method`` of `Observer`.

    If it does not, the data of that event need not be computed.
    """
    return getattr(type(observer), method) is not getattr(Observer, method)


class QuoteWatch:
    """Link from a pilot (first passes of a render that predict) to an observer, to which it passes on the quote.

    A quote is the predicted time or error. If none can be made, the observer receives the reason.
    """

    def __init__(self, pilot: Pilot, observer: Observer) -> None:
        self._pilot, self._observer, self._done = pilot, observer, False

    def pass_ended(self) -> None:
        """Pass on the quote (prediction of time or error), or the reason for having none, to the observer, if known.

        Call the method after every pass of the render.
        """
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
        """Give the observer, at the end of the render, the reason why there was no quote (prediction of time or error).

        Do nothing if the observer has already received a quote or a reason.
        """
        if not self._done:
            self._done = True
            self._observer.unquoted(ENDED_FIRST)
