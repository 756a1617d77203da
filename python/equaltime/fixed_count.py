"""A sample count for an error that is chosen before the image has a sample: the stop that selects no images.

A pilot with samples of its own (`equaltime.pilot`, another seed) tells how the error falls. The count is where the
upper limit of the error that it foretells is at the order: 97.5 % of images have a smaller error there, as far as the
pilot can know. The count at which a *looking* render would have stopped says less: such a render waits until its own
interval is narrow, and its upper limit may be a hundred times as much.

A pilot that met few bright paths foretells a wide interval. To render on with the pilot is then cheaper than the count
that so wide an interval asks for, so that its samples double until the interval is narrow, or the pilot is as long as a
quarter of the count. Where the error is in doubt because of light that few paths find, the pilot is to be as long as
the count: light that it misses with ``k`` times the samples of the image spoils at most ``k^k / (k + 1)^(k + 1)`` of
the images, a quarter for ``k = 1``, and no more than a tenth where such light comes in parts (measured). All of this
follows from counts, and not from a clock, unless a time is one of the limits.
"""

from __future__ import annotations

import hashlib
import math
import time as clock
from dataclasses import dataclass, replace

from equaltime.budget import FIRST_LOOK, Limits
from equaltime.checkpoint import Checkpoint
from equaltime.error_estimate import Estimate
from equaltime.errors import ImageError, RenderError
from equaltime.pilot import Pilot, Quote
from equaltime.progress import ProgressCallback
from equaltime.scene import Scene
from equaltime.scene.model import MOST_SAMPLES
from equaltime.session import Session
from equaltime.stopping import Stop
from equaltime.strategy import Strategy

__all__ = ["Chosen", "fixed_count", "pilot_seed"]

_TIME_SHARE = 0.25
"""Share of a time limit that the pilot may take, since most of the time is to be the image's."""
_WIDE = 4.0
"""Upper end of the count over the law's own: beyond, a longer pilot costs less than the samples that it may save."""
_LONGEST = 0.25
"""Samples of the pilot over those of the image, where the pilot goes on because it foretells a wide interval."""
_LONGEST_IN_DOUBT = 1.0
"""The same where the error is in doubt, whatever the interval."""
_MOST_IN_THE_DARK = 64 * FIRST_LOOK
"""Samples a pixel of a pilot that has met too little light to foretell anything: then it gives up."""


@dataclass(frozen=True)
class Chosen:
    """A count that a pilot chose."""

    stop: Stop
    quote: Quote | None = None
    """The price and the error of the render, without its bias; None where the pilot does not tell."""
    seconds: float = 0.0
    """What choosing took in this run."""

    def limits(self, asked: Limits) -> Limits:
        """Return what ends the image, where this was asked for: the count, or what is nearer."""
        counts = [count for count in (self.stop.spp, asked.spp) if count is not None]
        seconds = None if asked.seconds is None else max(0.0, asked.seconds - self.seconds)
        return Limits(min(counts, default=None), seconds)


def pilot_seed(seed: int) -> int:
    """Return the seed of the pilot of a render with this seed: a hash, so that no other render has it by chance."""
    words = f"equaltime: pilot of a fixed count, seed {seed}"
    return int.from_bytes(hashlib.sha256(words.encode()).digest()[:8], "big")


def fixed_count(
    scene: Scene,
    strategy: Strategy,
    limits: Limits,
    seed: int,
    threads: int,
    progress: ProgressCallback | None = None,
    resumed: Checkpoint | None = None,
) -> Chosen:
    """Return the samples a pixel that a render with this seed is to have for the error of the limits.

    A render that is taken up keeps the count that was chosen for the same error. Where a time is limited too, the pilot
    may take a quarter of it; if that is too short, no count is chosen, and the time alone is to end the render.

    Raises
    ------
    RenderError
        If the pilot met too little light, or if the error takes more samples than a render can have.
    SampleError
        If a sample of the pilot went wrong.
    ImageError
        If the render that is taken up looked at its own error, and has more samples than the pilot chooses.
    """
    before = None if resumed is None else resumed.stop
    if before is not None and before.rule == "fixed" and before.spp is not None and before.error == limits.error:
        return Chosen(before)
    done = 0 if resumed is None else resumed.position[0]
    chosen = _choose(scene, strategy, limits, seed, threads, progress, done)
    if resumed is not None and before is not None and before.selects and done > (chosen.stop.spp or 0):
        raise ImageError(
            f"{resumed.path}: cannot be taken up with a fixed count: it looked at its own error until it had {done} "
            f"samples a pixel, and a pilot chose {chosen.stop.spp or 'no count'}; render it anew"
        )
    return chosen


def _choose(
    scene: Scene,
    strategy: Strategy,
    limits: Limits,
    seed: int,
    threads: int,
    progress: ProgressCallback | None,
    done: int,
) -> Chosen:
    assert limits.error is not None
    begin, own = clock.perf_counter(), pilot_seed(seed)
    session = Session(scene, strategy, own, threads, Limits(), progress)
    try:
        quote = _narrow_quote(session, limits, limits.error)
        count = None if quote is None else _count(quote, limits)
    except RenderError:
        if session.error().high != 0.0:
            raise
        quote, count = None, session.passes.samples  # there is no noise: any count is enough
    seconds = clock.perf_counter() - begin
    stop = Stop("fixed", limits.error, count, own, seconds)
    if quote is not None:
        quote = None if limits.seconds is not None else _of_fixed(quote, limits, stop, done)
    return Chosen(stop, quote, seconds)


def _narrow_quote(session: Session, limits: Limits, error: float) -> Quote | None:
    """Return the quote of a pilot that is long enough; None if the time is over before."""
    pilot, begin = Pilot(session, limits, hurried=False), clock.perf_counter()
    most = math.inf if limits.spp is None else float(limits.spp)
    found: Quote | None = None
    while True:
        seconds = None if limits.seconds is None else _TIME_SHARE * limits.seconds - (clock.perf_counter() - begin)
        if seconds is not None and seconds <= 0.0:
            return found
        try:
            longer = pilot.run(seconds)
        except RenderError:
            if session.error().high < math.inf:
                raise
            if session.passes.samples >= _MOST_IN_THE_DARK:
                raise _too_dark(session.passes.samples, error) from None
        else:
            if longer is None:
                return found
            found = longer
            if _long_enough(found, error, session.passes.samples, most):
                return found
        pilot.due = 2 * session.passes.samples


def _long_enough(quote: Quote, error: float, samples: int, most: float) -> bool:
    """Tell whether a pilot of so many samples a pixel says enough; it need not be longer than the image can be."""
    count = quote.law.samples_within(error)
    if quote.error.doubt:
        return samples >= min(_LONGEST_IN_DOUBT * count.high, most)
    return count.high <= _WIDE * count.value or samples >= min(_LONGEST * count.high, most)


def _too_dark(samples: int, error: float) -> RenderError:
    return RenderError(
        f"a pilot of {samples} samples a pixel met too little light (or has too few pixels) to choose a count for an "
        f"error of {100.0 * error:.3g} %: give a number of samples instead, or let the render look at its own error"
    )


def _count(quote: Quote, limits: Limits) -> int:
    """Return the count by a quote, which is cut to the most that a render can have where another limit is nearer."""
    assert limits.error is not None
    high = quote.law.samples_within(limits.error).high
    if high > MOST_SAMPLES and limits.spp is None and limits.seconds is None:
        raise RenderError(
            f"an error of {100.0 * limits.error:.3g} % may take more than {MOST_SAMPLES} samples a pixel, which are "
            "the most: ask for a larger error, or give a number of samples or a time too"
        )
    return MOST_SAMPLES if high > MOST_SAMPLES else round(high)


def _of_fixed(quote: Quote, limits: Limits, stop: Stop, done: int) -> Quote:
    """Return the quote of a render that ends at the count, or at a given number of samples if that is nearer."""
    assert stop.spp is not None
    end = float(stop.spp if limits.spp is None else min(stop.spp, limits.spp))
    left = max(1.0, end - done)
    return replace(
        quote,
        spp=Estimate(end, end, end, unit="spp"),
        seconds=quote.law.seconds_for(Estimate(left, left, left, unit="spp")),
        error=replace(quote.law.error_at(end), doubt=quote.error.doubt),
        pilot_seconds=stop.pilot_seconds,
    )
