"""Choice of a sample count for an error before the image has a sample, so that the image does not decide its stop.

A pilot is a short render that predicts (`equaltime.quoting.pilot`). With samples of its own, from another seed, it
shows how the error falls. The chosen count is where the upper limit of the predicted error meets the target: 97.5 % of
images have a smaller error at that count, as far as the pilot can know. The count at which a render would stop by its
own error estimates cannot replace this count. Such a render waits until its interval is narrow, and the upper limit of
that count may be a hundred times as large.

A pilot that has met no rare bright path predicts too small a count, and a pilot that has just met its first one
predicts a wide interval. So the pilot doubles its samples until it has half of the image's samples. Each length of the
pilot gives a count, and the larger of the last two counts is taken. The choice follows from counts, and not from a
clock, unless a time is one of the limits.
"""

from __future__ import annotations

import hashlib
import math
import time as clock
from dataclasses import dataclass, replace

from equaltime.errors import ImageError, RenderError
from equaltime.quoting.pilot import Pilot, Quote
from equaltime.rendering.budget import FIRST_LOOK, Limits, Stop
from equaltime.rendering.job import Job
from equaltime.rendering.passes import ProgressCallback
from equaltime.rendering.session import Session
from equaltime.scene.model import MOST_SAMPLES
from equaltime.statistics.intervals import Interval

__all__ = ["Chosen", "fixed_count", "pilot_seed"]

_TIME_SHARE = 0.25
"""Largest share of a time limit that the pilot may take: most of the time belongs to the image."""
_SHARE_OF_COUNT = 0.5
"""Least ratio of the pilot's samples to the image's: too many images meet light that a shorter pilot has not met. A
pilot as long as the image is better in one percent of renders only (measured: scenes with fireflies)."""
_MOST_IN_THE_DARK = 64 * FIRST_LOOK
"""Samples a pixel after which a pilot gives up if it has met too little light to predict a possible count."""


@dataclass(frozen=True)
class Chosen:
    """A sample count that a pilot (short render) chose for an error, and the prediction that led to it."""

    stop: Stop
    """Rule for the end of the image, which is stored with the result: the chosen samples per pixel, and the seed of the
    short render that chose them."""
    quote: Quote | None = None
    """Predicted time and error of the render, without its bias; None with a time limit, or if nothing can be
    predicted."""
    seconds: float = 0.0
    """Seconds that the choice took in this run; 0 if an earlier run made it."""

    def limits(self, asked: Limits) -> Limits:
        """Return the limits of samples and time for rendering the image, instead of the user's limits ``asked``.

        The sample limit is the chosen count, or the limit in ``asked`` if that is less. The time limit is the limit in
        ``asked``, less the seconds that the choice took. There is no error limit.
        """
        counts = [count for count in (self.stop.spp, asked.spp) if count is not None]
        seconds = asked.seconds
        if seconds is not None:  # if the pilot took longer to get ready, the image still gets its time
            seconds -= min(self.seconds, _TIME_SHARE * seconds)
        return Limits(min(counts, default=None), seconds)


def pilot_seed(seed: int) -> int:
    """Return the seed of the pilot (short render that predicts) of a render whose seed is ``seed``.

    The pilot's seed is a hash of ``seed``, so that another render hardly ever has the same seed.
    """
    words = f"equaltime: pilot of a fixed count, seed {seed}"
    return int.from_bytes(hashlib.sha256(words.encode()).digest()[:8], "big")


def fixed_count(job: Job, progress: ProgressCallback | None = None) -> Chosen:
    """Return the samples per pixel, chosen by a pilot, with which the render ``job`` reaches its error limit.

    The pilot is a short render that predicts the error. Its samples are not the image's, so the image does not decide
    its own stop. ``progress`` is called with the pilot's `Progress`.

    A resumed render keeps the count that was chosen for the same error. With a time limit, the pilot may take a quarter
    of the time. No count is chosen if this quarter is too short. No count is chosen either if the pilot fails and the
    render has another limit. The other limits then end the render.

    Raises
    ------
    RenderError
        If the pilot fails and the render has no other limit. The pilot fails if it meets too little light, or if the
        error takes more samples than a render can have.
    SampleError
        If a sample of the pilot is NaN or infinite, or raised a floating-point fault.
    ImageError
        If the resumed render was to stop by its own error estimates, and has more samples than the pilot chooses.
    """
    resumed = job.resumed
    before = None if resumed is None else resumed.stop
    if before is not None and before.rule == "fixed" and before.spp is not None and before.error == job.limits.error:
        return Chosen(before)
    done = 0 if resumed is None else resumed.position[0]
    chosen = _choose(job, progress, done)
    if resumed is not None and before is not None and before.selects and done > (chosen.stop.spp or 0):
        raise ImageError(
            f"{resumed.path}: cannot be resumed with a fixed count: it looked at its own error until it had {done} "
            f"samples a pixel, and a pilot chose {chosen.stop.spp or 'no count'}; render it anew"
        )
    return chosen


def _choose(job: Job, progress: ProgressCallback | None, done: int) -> Chosen:
    limits = job.limits
    assert limits.error is not None
    begin, own = clock.perf_counter(), pilot_seed(job.seed)
    pilot = Job(scene=job.scene, strategy=job.strategy, seed=own, threads=job.threads, cluster=job.cluster)
    session = Session(pilot, progress)
    try:
        found = _foretold(session, limits, limits.error)
    except RenderError:
        if session.error().high != 0.0:
            raise
        found = None, session.passes.samples  # there is no noise: any count is enough
    seconds = clock.perf_counter() - begin
    quote, count = found
    stop = Stop("fixed", limits.error, count, own, session.passes.samples, seconds)
    if quote is not None:
        quote = None if limits.seconds is not None else _of_fixed(quote, limits, stop, done)
    return Chosen(stop, quote, seconds)


def _foretold(session: Session, limits: Limits, error: float) -> tuple[Quote | None, int | None]:
    """Return the last quote of a pilot that is long enough, and the count; no count if another limit is nearer."""
    pilot, begin = Pilot(session, limits, probes=False, hurried=False), clock.perf_counter()
    most = MOST_SAMPLES if limits.spp is None else limits.spp
    counts = list[float]()
    while True:
        seconds = None if limits.seconds is None else _TIME_SHARE * limits.seconds - (clock.perf_counter() - begin)
        if seconds is not None and seconds <= 0.0:
            return None, None
        why = f"it may take more than {MOST_SAMPLES} samples a pixel, which are the most"
        try:
            if (quote := pilot.run(seconds)) is None:
                return None, None
        except RenderError as problem:
            if session.error().high == 0.0:
                raise
            counts, why = [], str(problem)
        else:
            counts.append(quote.law.samples_within(error).high)
            count = max(counts[-2:])
            if len(counts) > 1 and session.passes.samples >= _SHARE_OF_COUNT * min(count, most):
                return quote, round(min(count, MOST_SAMPLES))
        if session.passes.samples >= _MOST_IN_THE_DARK and not max(counts[-2:], default=math.inf) <= MOST_SAMPLES:
            if limits.spp is not None or limits.seconds is not None:
                return None, None
            raise _beyond(session.passes.samples, error, why)
        pilot.due = 2 * session.passes.samples


def _beyond(samples: int, error: float, why: str) -> RenderError:
    return RenderError(
        f"a pilot of {samples} samples a pixel cannot choose a count for an error of {100.0 * error:.3g} %: {why}. "
        "Ask for a larger error, give a number of samples instead, or let the render look at its own error"
    )


def _of_fixed(quote: Quote, limits: Limits, stop: Stop, done: int) -> Quote:
    """Return the quote of a render that ends at the count, or at a given number of samples if that is nearer."""
    assert stop.spp is not None
    end = float(stop.spp if limits.spp is None else min(stop.spp, limits.spp))
    left, error = max(1.0, end - done), quote.law.error_at(end)
    return replace(
        quote,
        spp=Interval(end, end, end),
        seconds=quote.law.seconds_for(Interval(left, left, left)),
        error=error.doubted(quote.error.doubt) if quote.error.doubt else error,
        pilot_seconds=stop.pilot_seconds,
    )
