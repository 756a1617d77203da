"""Loop of passes over one renderer: a fixed schedule of sample counts, cut short by a limit or by Ctrl-C.

The loop reports its progress and saves checkpoints. The order of computation follows from sample counts alone, so a
rerun repeats the bits. The clock only decides where a time limit cuts the schedule.

Checkpoints (saves of the render so far) come every N seconds and take at most half of the time. No checkpoint is made
shortly before the time limit.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

from equaltime.errors import ImageError
from equaltime.film.error import load_quantiles
from equaltime.film.second_nets import Renders, statistics_so_far
from equaltime.film.unseen import Unseen, stated, stated_error
from equaltime.rendering.budget import Limits, Look, Looks, StoppedBy, next_look
from equaltime.statistics.intervals import Interval

__all__ = [
    "ESTIMATE_SECONDS_A_PIXEL",
    "PassRenderer",
    "Passes",
    "Progress",
    "ProgressCallback",
    "Saving",
    "pass_end",
]

_REPORT_INTERVAL = 0.1
# Share of the time for the error shown in the progress: with the final estimate, measuring stays under 1 %.
_ESTIMATE_SHARE = 0.003
ESTIMATE_SECONDS_A_PIXEL = 3e-7
"""Assumed seconds per pixel of the first error estimate, before one was measured."""


@dataclass(frozen=True)
class Progress:
    """Progress of a running render, as its progress callback receives it."""

    samples: int
    """Samples per pixel that are complete in every pixel."""
    target: int | None
    """Samples per pixel at which the render ends, if the user gave a number; else None."""
    seconds: float
    """Seconds since the first sample."""
    fraction: float
    """Fraction of the render that is done, in [0, 1], by the limit that will be met first; 0 while it is unknown."""
    time_left: float | None
    """Estimated seconds to the end of the render; None before the first pass has ended, and while it is unknown."""
    error: Interval | None
    """Relative error at the latest estimate, as a fraction. None before the first estimate, and when the samples have
    doubled since the latest."""
    cluster: str = ""
    """Numbers of processes, units of work and processor seconds so far, in words; empty for a render in one process."""


ProgressCallback = Callable[[Progress], object]


_ROOM = 2.0
"""A checkpoint is skipped if less than this many times the last save's duration remains before the time limit."""


class Saving:
    """Schedule of the checkpoints of a render (saves of the render so far), which also makes them.

    All times are seconds since the first pass began.

    Parameters
    ----------
    save
        Callable that saves the render so far.
    every
        Seconds between the starts of two saves; more if saving would take more than half of the time.
    takes
        Expected seconds of the first save.
    failed
        Called with the reason when saving fails. Further failures are not reported until a save has worked again.
    """

    def __init__(
        self, save: Callable[[], object], every: float, takes: float, failed: Callable[[str], object] | None = None
    ) -> None:
        self.seconds = 0.0
        """Seconds spent in saving."""
        self._save, self._every, self._takes, self._due = save, every, takes, every
        self._failed, self._fails = failed, False

    def left(self, now: float, limit: float | None) -> float | None:
        """Return the seconds until the next save; 0 if a save is due.

        The result is None if the next save would end after ``limit`` or shortly before it.

        ``now`` is the present time, and ``limit`` the time limit, None without one. Both are seconds since the first
        pass began.
        """
        due = max(self._due, now)
        return None if limit is not None and due + _ROOM * self._takes > limit else due - now

    def run(self, clock: Callable[[], float]) -> float:
        """Save the render so far, and return the seconds that this took. ``clock`` returns the present time."""
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


class _Reporter:
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
        cluster = self._passes.cluster()
        self._callback(Progress(samples, limits.spp, seconds, fraction, left, error, cluster))


# A pass takes at most about this many samples of the image (one or two seconds of one core), or 2 a pixel.
_PASS_SAMPLES = 2**21

# The first passes double up to this many samples. Short passes cost more per sample (tests/bench/short_passes.py), and
# a render that is cut this soon has hardly begun.
_FIRST_SAMPLES = 2**18

# Passes of several processes take this many times as long, for each process.
_LONGER = 8

# Exponent between n^-0.5 of independent samples and the best of low-discrepancy ones, to predict the time left.
_LIKELY_LAW = 0.55

# Factor by which work between passes may exceed its expected time: a first estimate of the error takes twice as long as
# others, and pixels that make much of the noise may cost more than others.
_LONGEST = 3.0


class PassRenderer(Renders, Protocol):
    """Interface of a renderer that `Passes` needs; `equaltime._core.Renderer` has it."""

    def advance(
        self,
        samples: int,
        seconds: float | None = None,
        poll: Callable[[], bool] | None = None,
        pause: float | None = None,
    ) -> bool:
        """Bring every pixel to ``samples`` samples; return False if the call ended before that.

        Three events end the call early: ``seconds`` are over, ``poll`` (called often) returns False, or ``pause``
        seconds are over and all begun blocks are finished. A later call continues the pass.
        """

    @property
    def nonfinite(self) -> list[tuple[int, int, int]]:
        """Samples that were NaN or infinite, as (x, y, sample index)."""

    @property
    def faulty(self) -> list[tuple[int, int, int, str]]:
        """Samples that raised floating-point faults, as (x, y, sample index, fault), if faults are looked for."""


def pass_end(samples: int, pixels: int, breadth: int = 1, timed: bool = True) -> int:
    """Return the samples per pixel at the end of a pass that begins at ``samples`` per pixel.

    Passes of a small image end at 2, 4, 8, 16, 20, …, 32, 40, …, 64, 80, …. From 16 on a pass adds a quarter at most.
    So if a limit cuts a pass short, the sample counts of pixels still differ by a quarter at most. ``pixels`` is the
    number of the image's pixels: the more there are, the sooner steps stop growing. Every step is a power of two, so
    that the replicates (halves of the samples) grow alike.

    ``breadth`` is the number of processes that take samples at once. More than one need longer passes, since the film
    travels to the processes and back in each pass. Such passes quadruple the samples if ``timed`` is False (the render
    has no time limit).
    """
    if breadth > 1 and not timed:
        return samples + max(2, 3 * ((1 << samples.bit_length()) // 2))
    share, most = (2, _FIRST_SAMPLES) if samples < 16 else (8, _PASS_SAMPLES)
    most *= 1 if breadth == 1 else _LONGER * breadth
    steps = (1 << samples.bit_length()) // share, (1 << (most // max(pixels, 1)).bit_length()) // 2
    return samples + max(2, min(steps))


class Passes:
    """Loop over the passes of one render. Iterating runs the passes, and yields the samples per pixel after each.

    A bad sample (NaN, infinite or with a floating-point fault) ends the loop only after its pass has finished. Ctrl-C
    (or a `KeyboardInterrupt` raised by the progress callback) ends the loop, and the finished blocks of the pass are
    kept.

    Parameters
    ----------
    renderer
        Renderer that takes the samples.
    pixels
        Number of the image's pixels.
    progress
        Function that is called with the render's `Progress`; None for none.
    clock
        Function that returns the present time, in seconds.
    limits
        Limits of the render; they may be changed between passes.
    samples, begun, looks
        State of a resumed render: samples per pixel already taken, whether the next pass is finished in part, and
        earlier looks (estimates of the error).
    hidden
        Light that samples may have missed, for the error's upper limit; None leaves it out.
    breadth
        Number of processes that take samples at once.
    cluster
        Function that tells what the processes have done so far, in words; `str`, which returns "", for one process.
    """

    def __init__(
        self,
        renderer: PassRenderer,
        pixels: int,
        limits: Limits,
        progress: ProgressCallback | None = None,
        clock: Callable[[], float] = time.perf_counter,
        samples: int = 0,
        begun: bool = False,
        looks: tuple[Look, ...] = (),
        hidden: Unseen | None = None,
        breadth: int = 1,
        cluster: Callable[[], str] = str,
    ) -> None:
        self.limits = limits
        self.stopped_by: StoppedBy | None = None
        """Reason why the loop ended; None while it runs."""
        self.samples = samples
        """Samples that every pixel has."""
        self.begun = begun
        """Whether an earlier loop, or the render that is resumed, has finished a part of the next pass."""
        self.pixels = pixels
        self.rendering = 0.0
        """Seconds spent in passes that have ended, without the work between passes or in their pauses."""
        self.cluster = cluster
        """Returns in words what the processes of a cluster have done so far."""
        self.saving: Saving | None = None
        """Saves checkpoints between passes, and in pauses within long passes; None if no checkpoints are wanted."""
        self._pass_began: float | None = None
        self._pace: float | None = None  # seconds per (sample per pixel) in the last pass: the load may change
        self._renderer, self._clock, self._start = renderer, clock, clock()
        self._ended, self._runs = 0.0, False  # seconds of the loops that ended, and whether one is running
        self._cancelled = False
        self._met_limits: Limits | None = None  # limits that ended the last loop
        self._looks, self._hidden, self._breadth = Looks(looks), hidden, breadth
        self._looking = ESTIMATE_SECONDS_A_PIXEL * pixels  # seconds of the last look, or the expected ones of the first
        self._report = None if progress is None else _Reporter(self, progress)

    @property
    def looks(self) -> Looks:
        """Looks of the render so far: the estimates of its error at which it may stop, in order."""
        return self._looks

    @property
    def seconds(self) -> float:
        """Seconds since the first pass of the latest loop began."""
        return self._clock() - self._start

    @property
    def total_seconds(self) -> float:
        """Seconds of all loops together, each from its start to its end."""
        return self._ended + (self.seconds if self._runs else 0.0)

    def __iter__(self) -> Iterator[int]:
        if self.limits != Limits(spp=self.limits.spp) or self._report is not None:
            load_quantiles()  # the error will be needed on the way
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
                whole, self.begun = not self.begun, not complete
                if wrong := _went_wrong(self._renderer):
                    reason = wrong
                    break
                if not complete:
                    reason = "interrupt" if self._cancelled else "time"
                    break
                if whole:
                    self._pace = took / (end - self.samples)
                self.samples = end
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
        """Bring every pixel to ``end`` samples; return whether that is done, and the seconds without pauses."""
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
        """Return the seconds until the next checkpoint; None if there is none, or if a sample went wrong."""
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
        """End the running loop and keep the finished blocks of its pass; may be called from any thread."""
        self._cancelled = True

    @property
    def time_left(self) -> float | None:
        """Estimated seconds until the nearest limit is met; None if nothing is known yet, or no limit is set."""
        if self._met_limits is self.limits:
            return 0.0
        seconds = self.seconds
        lefts = [] if self.limits.seconds is None else [self.limits.seconds - seconds]
        if self.targets and self._pace is not None:
            into_pass = 0.0 if self._pass_began is None else seconds - self._pass_began
            lefts.append((min(self.targets) - self.samples) * self._pace - into_pass)
        return max(0.0, min(lefts)) if lefts else None

    @property
    def targets(self) -> list[int]:
        """Samples per pixel at which limits will be met.

        The list holds the sample limit, and the predicted count for the error limit. A limit that is not set or not
        predictable is left out.
        """
        return [target for target in (self.limits.spp, self.samples_for(self.limits.error)) if target is not None]

    def samples_for(self, error: float | None) -> int | None:
        """Return the predicted samples per pixel at which the render stops at the ``error``, such as 0.02.

        A render stops at a look alone. If a look finds the error too large, the next look is predicted.

        The result is None if ``error`` is None, or while no estimate of the error has a finite upper limit. It is None
        too while a bright path widens the limit: later samples average the path out, or meet more such paths.
        """
        looks = self._looks
        if error is None or looks.last is None or not math.isfinite(looks.last.high) or looks.made[-1].widened:
            return None
        return looks.end(error, self.samples, _LIKELY_LAW)

    def run(self) -> StoppedBy:
        """Run passes until a limit is met, and return the reason why the loop ended."""
        for _ in self:
            pass
        assert self.stopped_by is not None
        return self.stopped_by

    def _met(self) -> StoppedBy | None:
        """Return the reason to stop now; None if there is none."""
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
        """Tell whether work expected to take ``seconds`` between two passes would end before the time limit."""
        return self.limits.seconds is None or self.seconds + _LONGEST * seconds <= self.limits.seconds

    def error(self) -> Interval:
        """Return the relative error that the render states so far, with its 95 % interval."""
        return stated_error(statistics_so_far(self._renderer), self._hidden, brightest=self._looks.brightest)

    def _look(self) -> None:
        begin = self.seconds
        error, brightest = stated(statistics_so_far(self._renderer), self._hidden, brightest=self._looks.brightest)
        self._looks.look(error, self.samples, brightest)
        self._looking = self.seconds - begin

    def _next_end(self) -> int:
        ends = [pass_end(self.samples, self.pixels, self._breadth, self.limits.seconds is not None)]
        if self.limits.spp is not None:
            ends.append(self.limits.spp)
        if self.limits.error is not None:
            ends.append(next_look(self.samples))
        return min(ends)


def _went_wrong(renderer: PassRenderer) -> Literal["nonfinite", "faulty"] | None:
    if renderer.nonfinite:
        return "nonfinite"
    return "faulty" if renderer.faulty else None
