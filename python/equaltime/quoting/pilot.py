"""The pilot of a render (a short render that predicts, or the render's own first passes), and the quote it gives.

A pilot of all pixels gives the error at its end, the exponent by which it falls (`equaltime.quoting.law`) and the time
of a sample. For low-discrepancy samples the exponent beyond the pilot differs from the exponent within the pilot, with
a standard deviation of 0.06. Over a factor of twenty that makes an uncertainty of 0.3 in the logarithm of the samples,
and half of such quotes would be within 20 %. So more than half of the pilot's samples go to a probe: a few hundred
pixels that are rendered up to the final sample count (`equaltime.quoting.probe`). Their errors are estimated at the
sample counts at which the render will estimate its own. Pilot and probe together take at most max(8 samples a pixel,
min(5 % of the work, 10 s)). A pilot that is not part of a render takes fewer samples, at least 2 a pixel, if 8 take
more than 10 s. Intervals are at 95 %. They include the pixels that were not drawn, the chance of later samples, and the
speed of the machine. Heavy tails (few pixels that make most of the error) add uncertainty, and the quote says so if the
pilot has met them.

The peak of memory is reached when the error is estimated, the file is written, or some pixels are probed.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from equaltime.errors import RenderError
from equaltime.film.adaptive import PILOT
from equaltime.film.error import load_quantiles
from equaltime.quoting.law import Law, Probed, Processors, fit
from equaltime.quoting.noise_places import NoisePlaces
from equaltime.quoting.probe import Probe
from equaltime.rendering.budget import FIRST_LOOK, Limits, noise_within
from equaltime.rendering.origin import Origin
from equaltime.rendering.passes import ESTIMATE_SECONDS_A_PIXEL
from equaltime.rendering.session import Session
from equaltime.rendering.stated import stated
from equaltime.scene.model import MOST_SAMPLES
from equaltime.statistics.intervals import UNKNOWN, Interval, Unit
from equaltime.strategy import Strategy
from equaltime.strict_json import fields_to_json
from equaltime.words import Shown, figure, percent

if TYPE_CHECKING:
    from equaltime.quoting.noise_light import NoiseLight

__all__ = ["FEWEST", "TARGETS", "USUAL_SECONDS", "Pilot", "Quote", "peak_bytes"]

# Bytes per pixel: expected, least and most. Measured on four scenes, as films of 512x512 to 1024x1024 pixels less those
# of 16x16, plain and adaptive, saved as EXR with their moments. A render with an error target that quotes its price has
# a probe; one that does not quote has none.
_A_PIXEL = (330.0, 260.0, 410.0)

_A_PIXEL_IF_PROBED = (500.0, 260.0, 560.0)

# Bytes of code loaded on the way: quantiles, and the image writers.
_LOADED = (25e6, 10e6, 40e6)


def peak_bytes(before: int, pixels: int, probed: bool) -> Interval:
    """Return the predicted peak memory, in bytes, of a process that renders an image and saves it.

    Parameters
    ----------
    before
        Resident bytes of the process with the scene loaded, without any film.
    pixels
        Number of the image's pixels.
    probed
        Whether a probe (some pixels rendered to the end to predict the error) may be made.
    """
    each = _A_PIXEL_IF_PROBED if probed else _A_PIXEL
    value, low, high = (before + loaded + pixels * each_pixel for loaded, each_pixel in zip(_LOADED, each, strict=True))
    return Interval(value, low, high)


TARGETS = (0.20, 0.10, 0.05, 0.02, 0.01)
"""Relative errors for which every quote (prediction of a render) states the time to reach them."""

_PILOT_SHARE = 0.05

USUAL_SECONDS = 10.0
"""Longest time of the renders behind a quote (prediction), in seconds, unless their least samples take longer. Users do
not want to wait minutes for the quote of an hour."""

FEWEST = 2
"""Least samples per pixel of a short render behind a quote (prediction): one for each of two halves, whose difference
gives the error."""

_FIRST = 4
"""Least samples a pixel of a pilot that has a probe, without adaptive sampling; other pilots have 8 or more."""

_SHARE_OF_ALL_PIXELS = 0.4
"""Fraction of the sample allowance that the pilot uses; the rest is for a probe (`equaltime.quoting.probe`)."""

_PROBE_SHARE = 0.9
"""Fraction of the remaining sample allowance that the probe plans to use; the rest is reserve."""

_LEAST_DRAWS, _MOST_DRAWS = 16, 4096


@dataclass(frozen=True, repr=False)
class Quote(Shown):
    """Quote: the predicted time, samples per pixel, error and memory of a render, from a short render (pilot)."""

    seconds: Interval
    """Seconds from the first sample to the final film; of a resumed render, this run alone."""
    spp: Interval
    """Predicted samples per pixel at the end."""
    error: Interval
    """Predicted relative error of the image at the end, as a fraction. The error is marked as doubtful if few pixels
    make most of the error of the short render behind the prediction."""
    memory: Interval
    """Peak bytes of the process, including scene and libraries, from the first sample until the image is saved."""
    law: Law
    """Fitted law of the render: its noise and its time by the number of samples per pixel. The noise is the error
    without the bias."""
    prices: Mapping[float, Interval] = field(hash=False)
    """Seconds to reach each relative error of `TARGETS`, by that error; of a resumed render, all runs together. Errors
    that the short render behind the quote reached already are left out, and errors that the bias alone exceeds."""
    pilot_seconds: float
    """Seconds that the prediction took, including the search for places and light that make the noise."""
    origin: Origin
    """Origin of the quoted render: scene, strategy and seed that the prediction refers to."""
    places: NoisePlaces | None = None
    """Places of the noise: shares of error² of regions and pixels. None if a running render was quoted from its first
    passes."""
    light: NoiseLight | None = None
    """Light that makes the noise, by kind; None if it was not asked for, or if there was no time to find it."""
    bias: Interval | None = None
    """Part of the error due to the effects (features such as media) that the render leaves out; None if it leaves out
    none."""
    interrupted: bool = False
    """Whether Ctrl-C ended the short render behind the quote, which then predicts from fewer samples."""

    def __post_init__(self) -> None:
        """Give each prediction the unit in which it is printed."""
        units: Mapping[str, Unit] = {"seconds": "s", "spp": "spp", "error": "%", "memory": "MB"}
        for name, unit in units.items():
            object.__setattr__(self, name, getattr(self, name).in_unit(unit))

    def __str__(self) -> str:
        number = stated(self.origin)
        spent = f"{self.seconds:s}, {self.spp:spp}, {self.memory:MB} of memory"
        lines = [f"{number.noun} {self.error:%}{number.of_paths} after {spent}"]
        if self.error.doubt:
            lines.append(f"in doubt: {self.error.doubt}")
        below = (f"surely below {percent(error)} after {seconds:s}" for error, seconds in self.prices.items())
        return "\n".join([*lines, *below])

    def as_dict(self) -> dict[str, Any]:
        """Return the quote as JSON data: the fields by name, and the strategy and depth of the quoted render."""
        absent = [name for name in ("places", "light", "bias", "interrupted") if not getattr(self, name)]
        return {
            **fields_to_json(self, without=("prices", "origin", *absent)),
            "prices": [{"error": target, "seconds": price.as_dict()} for target, price in self.prices.items()],
            **{key: self.origin.record[key] for key in ("max_depth", "scene_max_depth", "strategy", "biased")},
            **({"without": list(self.origin.without)} if self.origin.without else {}),
        }


class Pilot:
    """First passes of a render, or a short render, from which time and error are predicted (a quote).

    Parameters
    ----------
    session
        Render whose passes are used: the predicted render itself, or a short render of the same scene.
    limits
        Limits of the predicted render, at least one; the quote is for the limit that ends it.
    share
        Fraction of the usual number of samples (the allowance) that pilot and probe may take, in (0, 1].
    probes
        Whether to make a probe: some pixels rendered to the end, whose samples are not in the image.
    hurried
        True if a user waits for the quote: the pilot then takes at most about ten seconds. False if the pilot chooses a
        fixed sample count (`equaltime.quoting.fixed_count`). Such a pilot may take longer, depends on a clock only if a
        time is one of the limits, and predicts no times to other errors.
    fewest
        Least samples per pixel of the pilot, if 8 take more than ten seconds and the pilot is hurried.
    """

    def __init__(
        self,
        session: Session,
        limits: Limits,
        share: float = 1.0,
        probes: bool = True,
        hurried: bool = True,
        fewest: int = FIRST_LOOK,
    ) -> None:
        self._session, self._limits, self._share, self._probes = session, limits, share, probes
        self._hurried, self._fewest = hurried, fewest
        self._errors: dict[int, Interval] = {}
        self._seconds: dict[int, float] = {}
        self._usual = _FIRST if probes and session.job.strategy.adaptive == "none" else FIRST_LOOK
        self.due = self._usual
        """Samples per pixel at which the next quote may be possible."""
        self._work = self._probed = self._seconds_probed = 0.0
        self._room = float(FIRST_LOOK)
        self._estimating = ESTIMATE_SECONDS_A_PIXEL * session.passes.pixels
        load_quantiles()
        self._began, self._had = Processors.now(), 1.0
        self._before = session.samples_begun
        if not session.passes.begun:  # else only the rest of a pass is timed, and its end is the first count to know
            self._seconds[session.passes.samples] = 0.0
            if self._before:  # the render resumes another
                self._note(session.passes.samples)

    @property
    def strategy(self) -> Strategy:
        """Strategy of the render that the pilot predicts."""
        return self._session.job.strategy

    @property
    def taken(self) -> float:
        """Number of samples, over all pixels, that the pilot and its probe have taken so far.

        A probe is some pixels that are rendered to the end.
        """
        passes = self._session.passes
        return (passes.samples - self._before) * passes.pixels + self._probed

    @property
    def left(self) -> float:
        """Number of samples, over all pixels, that the pilot and its probe may still take.

        A probe is some pixels that are rendered to the end.
        """
        return max(0.0, self._room * self._session.passes.pixels - self.taken)

    def run(self, seconds: float | None = None) -> Quote | None:
        """Run the passes of a short render, and return the quote (prediction of time and error) once there is one.

        ``seconds`` limits the time; the result is None if the time ends first. After Ctrl-C, a hurried pilot quotes
        from the samples so far.

        Raises
        ------
        RenderError
            If a quote is due and no sample saw light, or if the limits take more samples than a render can have.
        SampleError
            If a sample is NaN or infinite, or raised a floating-point fault.
        KeyboardInterrupt
            After Ctrl-C, if the pilot is not hurried or has seen too little for a quote.
        """
        try:
            return self._run(seconds)
        except KeyboardInterrupt:
            if not (self._hurried and any(error.known and error.high < math.inf for error in self._errors.values())):
                raise
            return replace(self._quote(self._law()), interrupted=True)

    def _run(self, seconds: float | None) -> Quote | None:
        passes, begin = self._session.passes, clock.perf_counter()
        while True:
            left = None if seconds is None else max(0.0, seconds - (clock.perf_counter() - begin))
            passes.limits = Limits(spp=self.due, seconds=left)
            for _ in passes:
                if (found := self.pass_ended()) is not None:
                    return found
            if passes.stopped_by == "interrupt":
                raise KeyboardInterrupt
            self._session.check()
            if passes.stopped_by == "time" or passes.samples >= self.due:  # no time was left to look at the error
                return None

    def pass_ended(self) -> Quote | None:
        """Return the quote (prediction of time and error) if enough is known after this pass, else None.

        Call the method after every pass. The error is estimated after 2, 4, 8, … samples per pixel, half way between
        these counts, and where a quote may be due. The estimate is left out if there is no time for it.

        Raises
        ------
        RenderError
            If a quote is due and no sample saw light, or if the limits take more samples than a render can have.
        """
        passes = self._session.passes
        samples, due = passes.samples, passes.samples >= self.due or self._is_slow
        self._seconds[samples] = passes.rendering
        if not (due or _is_noted(samples)) or not passes.has_time_for(self._estimating):
            return None
        self._note(samples)
        if not due or len(self._seconds) < 2:  # no speed is known until a pass was rendered from its beginning
            return None
        if samples < FIRST_LOOK and not self._errors[samples].high < math.inf:
            self.due = FIRST_LOOK
            return None
        return self._quote_due(samples)

    @property
    def _is_slow(self) -> bool:
        """Whether the pilot has the fewest samples that it may have, and twice as many take too long."""
        passes = self._session.passes
        return self._hurried and passes.samples >= self._fewest and 2.0 * passes.rendering > USUAL_SECONDS

    def _note(self, samples: int) -> None:
        begin = clock.perf_counter()
        self._errors[samples] = self._session.error(lasting=True)
        self._estimating = clock.perf_counter() - begin

    def _quote_due(self, samples: int) -> Quote | None:
        law = self._law()
        end, _ = self._end(law)
        if end.low > MOST_SAMPLES:
            at_least = f"it takes {figure(end.low)} samples a pixel or more"
            raise RenderError(f"the target is beyond reach: {at_least}, and {MOST_SAMPLES} are the most")
        self._work = end.value
        most = USUAL_SECONDS / law.seconds_per_sample if self._hurried else math.inf
        least = max(self._fewest, min(FIRST_LOOK, most))
        self._room = max(least, min(_PILOT_SHARE * self._work, most))
        enough = self._share * (_SHARE_OF_ALL_PIXELS if self._probes else 1.0) * self._room
        self.due = min(2 * math.floor(0.5 * enough), 2 * samples)  # few samples may predict wrongly
        return self._quote(self._probe(law)) if self.due <= samples else None

    def _law(self) -> Law:
        last = self._errors[max(self._errors)]
        if last.known and last.high == 0.0:
            why = "its few samples are already exact" if self._session.image().any() else "the image is surely black"
            raise RenderError(f"the pilot saw no noise: {why}")
        if not (last.known and last.value > 0.0 and math.isfinite(last.high)):
            raise RenderError("the pilot saw no light, or too little (or few pixels) to say how fast the error falls")
        self._had = Processors.now().had_since(self._began)
        return fit(self._errors, self._seconds, self._session.job.strategy.sampler, self._had)

    def _probe(self, pilot: Law) -> Law:
        """Return the law through the results of a probe, which renders some pixels as far as the render will go."""
        law, probed, sampler = pilot, list[Probed](), self._session.job.strategy.sampler
        begin, spare, passes = clock.perf_counter(), self._share * self.left, self._session.passes
        if self.strategy.adaptive != "none" and passes.samples < FIRST_LOOK:  # uneven counts follow from that many
            return law
        draws = min(_MOST_DRAWS, math.floor(_PROBE_SHARE * spare / self._work))
        if draws < _LEAST_DRAWS or not self._probes:
            return law
        if not passes.has_time_for(min(spare, draws * self._work) / passes.pixels * law.seconds_per_sample):
            return law
        probe = Probe.of(self._session, round(self._work), draws)
        most = probe.most_samples(spare)
        while (samples := min(self._next(law), most)) > law.samples and (found := probe.advance(samples)) is not None:
            probed.append(found)
            law = pilot.through(probed, sampler)
        self._probed, self._seconds_probed = probe.taken, clock.perf_counter() - begin
        both = Processors.now().had_since(self._began)
        return replace(law, seconds_per_sample=law.seconds_per_sample * self._had / both)

    def _next(self, law: Law) -> int:
        """Return the samples per pixel of the probe's next step: the next look, or the nearest limit; even."""
        limits, ends = self._limits, list[float]()
        if limits.error is not None:
            ends.append(next((n for n in law.looks_until(limits.error) if n > law.samples), 0))
        if limits.seconds is not None:
            ends.append(self._before + law.samples_in(limits.seconds).value)
        if limits.spp is not None:
            ends.append(limits.spp)
        return 2 * round(0.5 * min(ends))

    def _quote(self, law: Law) -> Quote:
        session = self._session
        spp, seconds = self._end(law)
        last = self._errors[max(self._errors)]
        foretold = self._foretold(law, spp.value)
        if last.doubt:
            foretold = foretold.doubted(last.doubt)
        if session.passes.samples < self._usual:  # few samples do not show how fast the error falls
            foretold = foretold.doubted(f"a pilot of {session.passes.samples} samples a pixel may be far off")
        if spp.value < FEWEST:
            foretold = replace(UNKNOWN, note=f"an error takes {FEWEST} samples a pixel")
        ended = spp.low == spp.high == session.passes.samples  # the pilot is all of the render
        error = session.error() if ended else foretold
        return Quote(
            seconds=seconds,
            spp=self._in_the_film(spp),
            error=error.with_bias(session.job.bias),
            memory=peak_bytes(session.bytes_before, session.passes.pixels, self._limits.error is not None),
            law=law,
            prices=dict(self._prices(law, last.value)) if self._hurried else {},
            pilot_seconds=session.passes.rendering + self._seconds_probed,
            origin=session.origin,
            bias=session.job.bias,
        )

    def _prices(self, law: Law, reached: float) -> Iterator[tuple[float, Interval]]:
        """Yield errors of `TARGETS` with the seconds to reach them, if their noise is below the noise ``reached``."""
        for target in TARGETS:
            noise = noise_within(target, self._session.job.bias)
            if noise is not None and noise < reached:
                yield target, self._seconds_for(law, law.samples_until(noise), 0, noise)

    def _in_the_film(self, ordered: Interval) -> Interval:
        """Return the mean samples per pixel of a film that is rendered to the ordered counts.

        Adaptive counts miss the order by a few percent, since a pixel's share does not depend on its own samples.
        """
        session = self._session
        if session.passes.samples < PILOT:  # the shares are not chosen yet
            return ordered
        counts = np.array([ordered.value, ordered.low, ordered.high])
        share = float(session.rates(math.inf).mean())
        value, low, high = np.where(counts > PILOT, PILOT + share * (counts - PILOT), counts).tolist()
        if value == ordered.value:
            return ordered
        return replace(ordered, value=value, low=float(math.floor(low)), high=float(math.ceil(high)))

    def _foretold(self, law: Law, spp: float) -> Interval:
        """Return the error at the end; if an error is the only limit, it bounds the value and the upper limit."""
        error, limits = law.error_at(spp), self._limits
        most = math.inf if limits.error is None or limits.spp or limits.seconds else limits.error
        value, high = min(error.value, most), min(error.high, most)
        return replace(error, value=value, high=high)

    def _end(self, law: Law) -> tuple[Interval, Interval]:
        """Return the samples per pixel and the seconds at which the nearest of the limits ends the render."""
        limits, before, spps = self._limits, self._before, list[Interval]()
        if limits.error is not None:
            spp = law.samples_until(limits.error) if self._hurried else law.samples_within(limits.error)
            spps.append(_at_least(self._session.passes.samples, spp))
        if limits.spp is not None:
            spps.append(_exactly(limits.spp))
        seconds = [self._seconds_for(law, spp, before, limits.error) for spp in spps]
        if limits.seconds is not None:
            spps.append(_more(law.samples_in(limits.seconds), before))
            seconds.append(_exactly(limits.seconds))
        return _least(spps), _least(seconds)

    def _seconds_for(self, law: Law, spp: Interval, before: float, error: float | None) -> Interval:
        """Return the time from ``before`` samples per pixel on, with the looks at the error, if one is asked for."""
        looks = 0 if error is None else sum(before < n <= spp.value for n in law.looks_until(error))
        return _more(law.seconds_for(_at_least(1, _more(spp, -before))), looks * self._estimating)


def _least(ends: Sequence[Interval]) -> Interval:
    """Return the end of a render with these limits, any of which may be the first to be met."""
    value, low, high = (min(each) for each in zip(*((end.value, end.low, end.high) for end in ends), strict=True))
    return Interval(value, low, high)


def _at_least(number: float, estimate: Interval) -> Interval:
    value, low, high = (max(number, each) for each in (estimate.value, estimate.low, estimate.high))
    return replace(estimate, value=value, low=low, high=high)


def _more(estimate: Interval, number: float) -> Interval:
    return replace(estimate, value=estimate.value + number, low=estimate.low + number, high=estimate.high + number)


def _exactly(number: float) -> Interval:
    return Interval(number, number, number)


def _is_noted(samples: int) -> bool:
    return samples.bit_count() == 1 or (samples % 3 == 0 and (samples // 3).bit_count() == 1)
