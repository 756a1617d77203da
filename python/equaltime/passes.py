"""The loop of passes over one renderer: a fixed schedule of sample counts, cut short by a clock or by Ctrl-C.

What is computed in which order follows from counts alone, so that a rerun repeats the bits; the clock only chooses
where the schedule stops.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from equaltime.error_estimate import Estimate, image_error, pixel_statistics
from equaltime.result import StoppedBy

__all__ = ["Limits", "PassRenderer", "Progress", "ProgressCallback", "run_passes", "schedule"]

# A pass takes at most about this many samples of the image (one or two seconds of one core), or 2 a pixel.
_PASS_SAMPLES = 2**21
_REPORT_INTERVAL = 0.1
# Share of the time that may go into the error that the progress shows.
_ESTIMATE_SHARE = 0.02


class PassRenderer(Protocol):
    """What the loop needs of `equaltime._core.Renderer`."""

    def advance(self, samples: int, seconds: float | None = None, poll: Callable[[], bool] | None = None) -> bool:
        """Bring every pixel to ``samples`` samples; False if a limit ended the pass before."""

    @property
    def moments(self) -> NDArray[Any]:
        """(R, H, W) structured array of counts and means."""

    @property
    def nonfinite(self) -> list[tuple[int, int, int]]:
        """(x, y, sample index) of samples that were NaN or infinite."""


@dataclass(frozen=True)
class Limits:
    """When to stop, whichever comes first; None is no limit."""

    spp: int | None
    seconds: float | None


@dataclass(frozen=True)
class Progress:
    """Where a render stands."""

    samples: int
    """Samples that every pixel has."""
    target: int | None
    """Samples per pixel asked for, if any."""
    seconds: float
    """Since the first sample."""
    fraction: float
    """Done of what was asked for, 0 … 1, by the limit that is nearer."""
    time_left: float | None
    """Estimated seconds to the end; None before the first pass has ended."""
    error: Estimate | None
    """Error of the image as of a recent pass; None before there is one, and once the samples have doubled since."""


ProgressCallback = Callable[[Progress], object]


def schedule(pixels: int, spp: int | None) -> Iterator[int]:
    """Yield the sample counts at which passes end: 2, 4, … 16, 20, … 32, 40, … 64, 80, … up to ``spp``.

    A pass adds a quarter at most, so that a limit which cuts one leaves the image nearly even, until steps level off
    at what is a short pass for the image. Every step but the last is even: both replicates grow alike.
    """
    longest = max(2, _PASS_SAMPLES // max(pixels, 1) // 2 * 2)
    samples = 0
    while spp is None or samples < spp:
        step = max(2, min(2 ** (samples.bit_length() - 3), longest)) if samples >= 16 else 2
        samples = samples + step if spp is None else min(samples + step, spp)
        yield samples


def run_passes(
    renderer: PassRenderer,
    pixels: int,
    limits: Limits,
    progress: ProgressCallback | None = None,
    clock: Callable[[], float] = time.perf_counter,
) -> StoppedBy:
    """Run passes until a limit is met; say which.

    A pass is always finished before a non-finite sample ends the loop. Ctrl-C (or a `KeyboardInterrupt` that the
    progress callback raises) ends it at the blocks done.
    """
    report = None if progress is None else _Reporter(renderer, limits, progress, clock)
    start = clock()
    try:
        for samples in schedule(pixels, limits.spp):
            left = None if limits.seconds is None else limits.seconds - (clock() - start)
            if left is not None and left <= 0.0:
                return "time"
            complete = renderer.advance(samples, left, None if report is None else report.tick)
            if renderer.nonfinite:
                return "nonfinite"
            if not complete:
                return "time"
            if report is not None:
                report.pass_ended(samples)
    except KeyboardInterrupt:
        return "interrupt"
    return "spp"


class _Reporter:
    """Calls the progress callback: at the end of every pass, and now and then within."""

    def __init__(
        self, renderer: PassRenderer, limits: Limits, callback: ProgressCallback, clock: Callable[[], float]
    ) -> None:
        self._renderer, self._limits, self._callback, self._clock = renderer, limits, callback, clock
        self._start = self._reported = clock()
        self._samples = 0
        self._sampled_at = 0.0
        self._estimating = 0.0
        self._last_estimate = 0.0
        self._error: Estimate | None = None
        self._estimated_at = 0

    def tick(self) -> bool:
        """Report if some time has passed; always go on."""
        if self._clock() - self._reported >= _REPORT_INTERVAL:
            self._report()
        return True

    def pass_ended(self, samples: int) -> None:
        """Report that every pixel has ``samples`` samples, with a new error if that is cheap by now."""
        self._samples, self._sampled_at = samples, self._clock() - self._start
        if self._estimating + self._last_estimate <= _ESTIMATE_SHARE * self._sampled_at:
            before = self._clock()
            self._error, self._estimated_at = image_error(pixel_statistics(self._renderer.moments)), samples
            self._last_estimate = self._clock() - before
            self._estimating += self._last_estimate
        self._report()

    def _report(self) -> None:
        self._reported = self._clock()
        seconds = self._reported - self._start
        fractions, lefts = [0.0], []
        if self._limits.spp is not None:
            done = self._samples / self._limits.spp
            fractions.append(done)
            if done > 0.0:
                lefts.append(max(0.0, self._sampled_at / done - seconds))
        if self._limits.seconds is not None:
            fractions.append(min(1.0, seconds / self._limits.seconds))
            lefts.append(max(0.0, self._limits.seconds - seconds))
        self._callback(
            Progress(
                samples=self._samples,
                target=self._limits.spp,
                seconds=seconds,
                fraction=max(fractions),
                time_left=min(lefts) if lefts else None,
                error=self._error if self._samples < 2 * self._estimated_at else None,
            )
        )
