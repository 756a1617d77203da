"""The loop of passes over one renderer: a fixed schedule of sample counts, cut short by a limit or by Ctrl-C.

What is computed in which order follows from counts alone, so that a rerun repeats the bits; the clock only chooses
where the schedule stops.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import Literal, Protocol

from equaltime.film.error import Estimate, load_quantiles
from equaltime.film.second_nets import Renders, statistics_so_far
from equaltime.film.unseen import Unseen, stated, stated_error
from equaltime.rendering.budget import Limits, Look, Looks, next_look
from equaltime.rendering.progress import ESTIMATE_SECONDS_A_PIXEL, ProgressCallback, Reporter
from equaltime.rendering.saving import Saving
from equaltime.rendering.stopping import StoppedBy

__all__ = ["PassRenderer", "Passes", "pass_end"]

# A pass takes at most about this many samples of the image (one or two seconds of one core), or 2 a pixel.
_PASS_SAMPLES = 2**21
# The first ones double up to this many: short ones cost more a sample (tests/bench/short_passes.py), and what is cut
# that soon was hardly begun.
_FIRST_SAMPLES = 2**18
# Between the law of independent samples, n^-0.5, and what low-discrepancy ones reach at best: for the time left.
_LIKELY_LAW = 0.55
# What is done between passes may take so many times what it is expected to: a first estimate of the error takes twice
# as long as others, and pixels that make much of the noise may cost more than others.
_LONGEST = 3.0


class PassRenderer(Renders, Protocol):
    """What the loop needs of `equaltime._core.Renderer`."""

    def advance(
        self,
        samples: int,
        seconds: float | None = None,
        poll: Callable[[], bool] | None = None,
        pause: float | None = None,
    ) -> bool:
        """Bring every pixel to ``samples`` samples; False if a limit, or a pause, ended the pass before."""

    @property
    def nonfinite(self) -> list[tuple[int, int, int]]:
        """(x, y, sample index) of samples that were NaN or infinite."""

    @property
    def faulty(self) -> list[tuple[int, int, int, str]]:
        """(x, y, sample index, what) of samples that raised floating-point faults, if these are looked for."""


def pass_end(samples: int, pixels: int) -> int:
    """Return where a pass ends that begins at ``samples`` a pixel.

    Passes of a small image end at 2, 4, 8, 16, 20, … 32, 40, … 64, 80, … From 16 on a pass adds a quarter at most, so
    that a limit which cuts one leaves the image nearly even, until steps level off at what is a short pass for the
    image. Every step is a power of two: both replicates grow alike.
    """
    share, most = (2, _FIRST_SAMPLES) if samples < 16 else (8, _PASS_SAMPLES)
    steps = (1 << samples.bit_length()) // share, (1 << (most // max(pixels, 1)).bit_length()) // 2
    return samples + max(2, min(steps))


class Passes:
    """The passes of one render: iterating runs them, and gives the samples a pixel at the end of each.

    A pass is always finished before a sample that went wrong ends the loop. Ctrl-C (or a `KeyboardInterrupt` that the
    progress callback raises) ends it at the blocks done.

    Parameters
    ----------
    pixels
        Of the image.
    limits
        When to stop; may be changed between passes.
    samples, looks
        Of a render that is taken up: samples that every pixel has, and what it saw when it looked at its error.
    hidden
        What black pixels may hide, for the error.
    """

    def __init__(
        self,
        renderer: PassRenderer,
        pixels: int,
        limits: Limits,
        progress: ProgressCallback | None = None,
        clock: Callable[[], float] = time.perf_counter,
        samples: int = 0,
        looks: tuple[Look, ...] = (),
        hidden: Unseen | None = None,
    ) -> None:
        self.limits = limits
        self.stopped_by: StoppedBy | None = None
        """What ended the loop; None while it runs."""
        self.samples = samples
        """Samples that every pixel has."""
        self.pixels = pixels
        self.rendering = 0.0
        """Seconds spent in passes that have ended, without what is done between them, or in their pauses."""
        self.saving: Saving | None = None
        """What saves what is done so far, if that is wanted: between passes, and in pauses within long ones."""
        self._pass_began: float | None = None
        self._pace: float | None = None  # seconds a sample a pixel, of the last pass: the load may have changed
        self._renderer, self._clock, self._start = renderer, clock, clock()
        self._ended, self._runs = 0.0, False  # seconds of the loops that ended, and whether one is under way
        self._cancelled = False
        self._met_limits: Limits | None = None  # those by which the last loop ended
        self._looks, self._hidden = Looks(looks), hidden
        self._looking = ESTIMATE_SECONDS_A_PIXEL * pixels  # what the last look took, or the first is taken to
        self._report = None if progress is None else Reporter(self, progress)

    @property
    def looks(self) -> Looks:
        """The looks at the error, if the limits ask for any."""
        return self._looks

    @property
    def seconds(self) -> float:
        """Since the first pass of the loop began."""
        return self._clock() - self._start

    @property
    def total_seconds(self) -> float:
        """Of all loops, up to their ends."""
        return self._ended + (self.seconds if self._runs else 0.0)

    def __iter__(self) -> Iterator[int]:
        if self.limits != Limits(spp=self.limits.spp) or self._report is not None:
            load_quantiles()  # somebody will ask for the error on the way
        self._start, self.stopped_by, self._cancelled = self._clock(), None, False
        self._pass_began, self._runs, self._met_limits = None, True, None
        try:
            yield from self._passes()
        finally:
            self._ended, self._runs = self.total_seconds, False

    def _passes(self) -> Iterator[int]:
        try:
            while (reason := self._met()) is None:
                end = self._next_end()
                complete, took = self._pass(end)
                self.rendering += took
                if wrong := _went_wrong(self._renderer):
                    reason = wrong
                    break
                if not complete:
                    reason = "interrupt" if self._cancelled else "time"
                    break
                self.samples, self._pace = end, took / (end - self.samples)
                if self._report is not None:
                    self._report.pass_ended()
                if self._until_saving() == 0.0:
                    self._save()
                yield end
        except KeyboardInterrupt:
            reason = "interrupt"
        self.stopped_by = reason
        self._met_limits = self.limits if reason in ("spp", "time", "error") else None

    def _pass(self, end: int) -> tuple[bool, float]:
        """Bring every pixel to ``end`` samples; return whether they have them, and the seconds without the pauses."""
        self._pass_began = self.seconds
        while True:
            limit, pause = self.limits.seconds, self._until_saving()
            left = None if limit is None else limit - self.seconds
            complete = self._renderer.advance(end, left, self._tick, pause)
            if complete or pause is None or not self._tick():
                took, self._pass_began = self.seconds - self._pass_began, None
                return complete, took
            if self._until_saving() is not None:
                self._pass_began += self._save()

    def _until_saving(self) -> float | None:
        """Return the seconds until what is done is to be saved; None if it is not, or if a sample went wrong."""
        if self.saving is None or _went_wrong(self._renderer):
            return None
        return self.saving.left(self.seconds, self.limits.seconds)

    def _save(self) -> float:
        assert self.saving is not None
        return self.saving.run(lambda: self.seconds)

    def _tick(self) -> bool:
        if self._report is not None:
            self._report.tick()
        return not self._cancelled

    def cancel(self) -> None:
        """End the loop at the blocks done; may be called from any thread, and counts for the loop that runs."""
        self._cancelled = True

    @property
    def time_left(self) -> float | None:
        """Estimated seconds in passes to the nearest limit; None where nothing is known yet, or no limit is set."""
        if self._met_limits is self.limits:
            return 0.0
        seconds = self.seconds
        lefts = [] if self.limits.seconds is None else [self.limits.seconds - seconds]
        if self.targets and self._pace is not None:
            into_pass = 0.0 if self._pass_began is None else seconds - self._pass_began
            lefts.append((min(self.targets) - self.samples) * self._pace - into_pass)
        return max(0.0, min(lefts)) if lefts else None

    @property
    def targets(self) -> list[float]:
        """Samples a pixel that the limits ask for, or will likely take."""
        return [target for target in (self.limits.spp, self.samples_for(self.limits.error)) if target is not None]

    def samples_for(self, error: float | None) -> float | None:
        """Return how many samples a pixel an error target will likely take, once it was looked at."""
        looks = self._looks
        if error is None or looks.last is None or not math.isfinite(looks.last.high):
            return None
        growth = math.pow(looks.made[-1].believed / error, 1.0 / _LIKELY_LAW)
        return max(looks.made[-1].samples * growth, self.samples + 1.0)

    def run(self) -> StoppedBy:
        """Run passes until a limit is met; say which."""
        for _ in self:
            pass
        assert self.stopped_by is not None
        return self.stopped_by

    def _met(self) -> StoppedBy | None:
        """Return the limit that is met, if one is."""
        if self._cancelled:
            return "interrupt"
        limits = self.limits
        if limits.error is not None:
            if self._looks.due(self.samples) and self.has_time_for(self._looking):
                self._look()
            if self._looks.met(limits.error):
                return "error"
        if limits.spp is not None and self.samples >= limits.spp:
            return "spp"
        return "time" if limits.seconds is not None and self.seconds >= limits.seconds else None

    def has_time_for(self, seconds: float) -> bool:
        """Tell whether what is expected to take so many seconds, between two passes, will end before the time limit."""
        return self.limits.seconds is None or self.seconds + _LONGEST * seconds <= self.limits.seconds

    def error(self) -> Estimate:
        """Return the error that the render states of what is done so far."""
        return stated_error(statistics_so_far(self._renderer), self._hidden, brightest=self._looks.brightest)

    def _look(self) -> None:
        begin = self.seconds
        error, brightest = stated(statistics_so_far(self._renderer), self._hidden, brightest=self._looks.brightest)
        self._looks.look(error, self.samples, brightest)
        self._looking = self.seconds - begin

    def _next_end(self) -> int:
        ends = [pass_end(self.samples, self.pixels)]
        if self.limits.spp is not None:
            ends.append(self.limits.spp)
        if self.limits.error is not None:
            ends.append(next_look(self.samples))
        return min(ends)


def _went_wrong(renderer: PassRenderer) -> Literal["nonfinite", "faulty"] | None:
    if renderer.nonfinite:
        return "nonfinite"
    return "faulty" if renderer.faulty else None
