"""Progress of a running render."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from equaltime.statistics.intervals import Interval

if TYPE_CHECKING:
    from equaltime.rendering.passes import Passes

__all__ = ["ESTIMATE_SECONDS_A_PIXEL", "Progress", "ProgressCallback", "Reporter"]

_REPORT_INTERVAL = 0.1
# Share of the time for the error shown in the progress: with the final estimate, measuring stays under 1 %.
_ESTIMATE_SHARE = 0.003
ESTIMATE_SECONDS_A_PIXEL = 3e-7
"""Assumed seconds per pixel of the first error estimate, before one was measured."""


@dataclass(frozen=True)
class Progress:
    """Progress of a render: samples, seconds, the fraction done, the time left and the error."""

    samples: int
    """Samples that every pixel has."""
    target: int | None
    """Samples per pixel asked for, if any."""
    seconds: float
    """Seconds since the first sample."""
    fraction: float
    """Fraction done, in [0, 1], by the limit that is nearer."""
    time_left: float | None
    """Estimated seconds to the end; None before the first pass has ended."""
    error: Interval | None
    """Error of the image as of a recent pass; None before an estimate, or once the samples have doubled since."""


ProgressCallback = Callable[[Progress], object]


class Reporter:
    """Caller of the progress callback: at the end of every pass, and every 0.1 s within passes."""

    def __init__(self, passes: Passes, callback: ProgressCallback) -> None:
        self._passes, self._callback = passes, callback
        self._reported = 0.0
        self._estimating, self._last_estimate = 0.0, ESTIMATE_SECONDS_A_PIXEL * passes.pixels
        self._error: Interval | None = None
        self._estimated_at = 0

    def tick(self) -> bool:
        """Call the callback if 0.1 s have passed since the last call; return True, so that the pass goes on."""
        if self._passes.seconds - self._reported >= _REPORT_INTERVAL:
            self._report()
        return True

    def pass_ended(self) -> None:
        """Call the callback at the end of a pass.

        The error is estimated anew if such estimates take at most 0.3 % of the time.
        """
        begin = self._passes.seconds
        if self._estimating + self._last_estimate <= _ESTIMATE_SHARE * begin:
            self._error = self._passes.error()
            self._estimated_at = self._passes.samples
            self._last_estimate = self._passes.seconds - begin
            self._estimating += self._last_estimate
        self._report()

    def _report(self) -> None:
        samples, limits, seconds = self._passes.samples, self._passes.limits, self._passes.seconds
        self._reported = seconds
        error = self._error if samples < 2 * self._estimated_at else None
        fractions = [0.0, *(samples / target for target in self._passes.targets)]
        if limits.seconds is not None:
            fractions.append(seconds / limits.seconds)
        fraction, left = min(1.0, max(fractions)), self._passes.time_left
        self._callback(Progress(samples, limits.spp, seconds, fraction, left, error))
