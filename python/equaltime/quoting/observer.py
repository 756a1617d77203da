"""What a render tells while it is under way: subclass `Observer` and override what you want to hear of."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from equaltime.quoting.pilot import Quote
from equaltime.rendering.progress import Progress

__all__ = ["Observer", "overrides"]


class Observer:
    """Hears of a render as it goes. Every method may be overridden; here each does nothing.

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
        """Return an observer whose methods are these functions."""
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
        """Hear of samples, error and time left, about ten times a second. May raise `KeyboardInterrupt` to stop."""

    def pass_ended(self, image: Callable[[], NDArray[np.float64]]) -> None:
        """Hear that a pass has ended. ``image()`` returns the image so far, (H, W, 3), linear."""

    def quoted(self, quote: Quote) -> None:
        """Hear the price of the error, or the error that the time will buy: once, early.

        A quote comes within 8 samples a pixel or a twentieth of the work, but not of more than ten seconds. For an
        error, up to 4096 pixels are rendered to the end beforehand (`equaltime.quoting.probe`): at most 3 % of the
        work, or 4 samples a pixel if that is more. Those samples are not in the image.
        """

    def unquoted(self, why: str) -> None:
        """Hear why there can be no quote, although an error or a time was asked for: once, instead of `quoted`."""

    def decided(self, why: Sequence[str]) -> None:
        """Hear which effects were left out or kept, and why, in words: once, before the first sample."""

    def unsaved(self, why: str) -> None:
        """Hear why a checkpoint could not be written: once until one has been again. The render goes on."""


def overrides(observer: Observer, method: str) -> bool:
    """Tell whether an observer hears of something: what nobody hears of need not be worked out."""
    return getattr(type(observer), method) is not getattr(Observer, method)
