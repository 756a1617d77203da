"""Law of a render: how its error falls as samples are added, and how much time samples take, to predict both."""

from __future__ import annotations

import glob
import itertools
import math
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from statistics import NormalDist, linear_regression, variance
from typing import Any, Literal, NamedTuple

from equaltime.rendering.budget import Looks, next_look
from equaltime.statistics.intervals import Interval
from equaltime.strict_json import fields_to_json

__all__ = ["Law", "Pace", "Probed", "Processors", "fit", "from_start", "pace", "without_start"]

# Standard deviation of the logarithm of the speed, from the pilot to the end, before the pilot's passes have shown how
# their speed varies; and the number of passes that this prior counts as. Machines with other users vary by 0.1
# (measured).
_DOUBT, _KNOWN_PASSES = 0.1, 2

# The first hundredths of a second are slower, until caches are filled and woken threads are spread over the processors.
# In seconds: the loss on a machine without other users, the additional loss times the share of it that others have, and
# the time in which the loss decays (tests/bench/short_passes.py).
_LOSS, _LOSS_OF_TAKEN, _START = 0.004, 0.022, 0.05


class Processors(NamedTuple):
    """Processor time of this process: the seconds that its threads ran, and the seconds that they waited to run.

    The difference of two such times tells the share of the processors that the process had. Times are counted from the
    start of each thread; idle threads do not count as waiting. The processor time of a sample hardly depends on other
    processes, but the available share of the processors varies within tenths of a second. So the share is better
    estimated over a longer time.
    """

    ran: float
    """Seconds that threads ran, summed over threads."""
    waited: float
    """Seconds that threads waited for a processor while other processes or threads ran, summed over threads."""

    @classmethod
    def now(cls) -> Processors:
        """Return the seconds that threads ran and waited until now, counted by Linux; 0 on other systems."""
        ran = waited = 0
        for task in glob.iglob("/proc/self/task/*/schedstat"):
            with suppress(OSError):  # the thread has ended
                times = Path(task).read_text().split()
                ran, waited = ran + int(times[0]), waited + int(times[1])
        return cls(1e-9 * ran, 1e-9 * waited)

    def had_since(self, before: Processors) -> float:
        """Return the part of the processor time wanted since ``before`` that this process got, in [0, 1].

        It is the time that threads ran, divided by the time that they ran or waited; 1 if the times are unknown.
        """
        ran, waited = self.ran - before.ran, self.waited - before.waited
        return ran / (ran + waited) if ran > 0.0 and waited > 0.0 else 1.0


class Pace(NamedTuple):
    """Speed of sampling once a render has started, and the additional time that the start takes, to predict times."""

    seconds_per_sample: float
    """Seconds for one sample of every pixel."""
    doubt: float
    """Standard deviation of the logarithm of the mean speed up to the end of the render."""
    lost: float
    """Largest additional time, in seconds, that the slow start of a render takes."""


def pace(seconds: Mapping[int, float], had: float = 1.0) -> Pace:
    """Return the speed of sampling, to predict the time of later samples.

    ``seconds`` maps counts of samples per pixel to the seconds since the first sample. The speed is measured over the
    last two doublings of the count, or over all counts if there are fewer. ``had`` is the share of the processors that
    was available during the samples, in [0, 1].
    """
    last, lost = max(seconds), _LOSS + _LOSS_OF_TAKEN * (1.0 - had)
    first = max((n for n in seconds if 4 * n <= last), default=min(seconds))
    even = without_start(seconds[last], lost) - without_start(seconds[first], lost)
    steps = itertools.pairwise(sorted(seconds.items()))
    speeds = [math.log((after - before) / (n - m)) for (m, before), (n, after) in steps if after > before]
    apart = (len(speeds) - 1) * variance(speeds) if len(speeds) > 1 else 0.0
    doubt = math.sqrt((_KNOWN_PASSES * _DOUBT**2 + apart) / (_KNOWN_PASSES + max(len(speeds) - 1, 0)))
    return Pace(even / (last - first), doubt, lost)


def from_start(even: float, lost: float) -> float:
    """Return the seconds that some work takes at the start of a render, where samples are slower.

    ``even`` is the time of the work in seconds without the slower start. ``lost`` is the largest time that the start
    adds, in seconds.
    """
    return even + lost * (1.0 - math.exp(-even / _START))


def without_start(seconds: float, lost: float) -> float:
    """Return the seconds that some work would take without the slower start of a render.

    ``seconds`` is the time of the work with the start. ``lost`` is the largest time that the start adds, in seconds.
    The result is approximately the inverse of `from_start`.
    """
    return seconds - lost * (1.0 - math.exp(-seconds / _START))


_Z95 = 1.960

_NORMAL = NormalDist()

# Prior of the exponent before the pilot, by sampler: mean and standard deviation. Independent samples have exactly ½,
# except for the finite sample of the pilot. Low-discrepancy samples have between 0.45, where many bounces and rare
# paths make the noise, and 0.9, where the picture is smooth (measured, a dozen scenes).
_EXPONENTS = {"independent": (0.5, 0.005), "stratified": (0.55, 0.08), "sobol": (0.58, 0.13), "lattice": (0.6, 0.13)}

# Exponents between two counts at which the error is measured; those below ½ come from errors that were too low at the
# first count, since few of its samples had met rare light.
_LEAST_EXPONENT, _MOST_EXPONENT = 0.3, 1.0

# Least and largest exponent beyond all measured counts. The expected error² of independent samples is exactly inverse
# to their number. The exponent 0.45 is the least that low-discrepancy samples have shown, as for _EXPONENTS.
_LASTING = {"independent": (0.5, 0.5), "stratified": (0.45, 1.0), "sobol": (0.45, 1.0), "lattice": (0.45, 1.0)}

# Standard deviation of the exponent beyond the pilot from that within it (measured).
_BEND = {"independent": 0.005, "stratified": 0.06, "sobol": 0.06, "lattice": 0.06}

# Drift of estimates against the law while the noise falls, as a standard deviation of log(error). Where the error falls
# fast, low-discrepancy samples are better at powers of two than between: log(error) differs by _UNEVEN times the excess
# of the exponent over _SLOW.
_DRIFT, _UNEVEN, _SLOW = 0.07, 0.8, 0.6

# Where few paths make the noise, intervals are wide. They narrow as more such paths come, or widen as rarer ones do.
# First line: least exponent of narrowing over the width, and its maximum. Second line: standard deviation of the
# widening exponent over the width, its maximum, and the most widening as a logarithm.
_FEW, _MOST_NARROWING = 0.25, 0.5

_RARE, _MOST_RARE, _MOST_WIDENING = 0.5, 0.3, 0.7

_MOST_SAMPLES = 2.0**40

_DRAWS = 63
"""Number of simulated renders of a quote: its interval is between the second and the last but one of their stops."""


class Probed(NamedTuple):
    """Predicted error of a whole image at one sample count, from a probe: some of its pixels rendered to that count."""

    samples: int
    """Samples per pixel."""
    error: float
    """Predicted relative error of the image, as a fraction."""
    doubt: float
    """Standard deviation of log(error) due to the choice of pixels, estimated by the scatter of the pixels that were
    drawn."""
    width: float
    """Logarithm of (upper limit / error), both as the image will state them at that count."""


@dataclass(frozen=True)
class Law:
    """Law of a render: ``error(n) = error · (n / samples)^-exponent``, ``seconds(n) = n · seconds_per_sample``.

    Here n is the number of samples per pixel. The law predicts the error after a time, and the samples or the time
    until an error. The slow start of a render adds up to ``seconds_lost`` to the seconds. If ``before`` has points,
    errors at counts below ``samples`` are interpolated between these points instead.

    Three fields state uncertainties as standard deviations: ``exponent_doubt`` of ``exponent``, ``speed_doubt`` of
    log(samples per second), and ``doubt`` of log(error). Logarithms are natural.
    """

    samples: int
    """Samples per pixel up to which the error was measured: by a short render (pilot), or by some pixels rendered to
    the end (probe)."""
    error: float
    """Estimated relative error of the image at ``samples``, as a fraction."""
    width: float
    """Natural logarithm of (upper limit / error) at ``samples``: half the width of the 95 % interval of log(error)."""
    narrowing: float
    """Exponent by which the interval narrows: its half width after n samples per pixel is
    ``width · (n / samples)^-narrowing``."""
    exponent: float
    """Exponent by which the error falls with the sample count; 0.5 for independent samples."""
    exponent_doubt: float
    """Standard deviation of ``exponent``."""
    seconds_per_sample: float
    """Seconds for one sample of every pixel."""
    speed_doubt: float
    """Standard deviation of log(mean speed), with the speed in samples per second up to the end of the render."""
    seconds_lost: float = 0.0
    """Largest time, in seconds, that the slow start of a render adds to the render's time."""
    before: tuple[tuple[int, float], ...] = ()
    """Errors measured at counts below ``samples``: pairs (samples per pixel, relative error) in ascending order. It is
    empty if no probe was made, that is, if no pixels were rendered to the end to predict the error."""
    doubt: float = 0.0
    """Standard deviation of log(error) at ``samples`` because the probe rendered only some of the pixels. It is 0 if no
    probe was made: all pixels were then measured."""

    def through(self, probed: Sequence[Probed], sampler: str) -> Law:
        """Return this law, fitted to a pilot, corrected by a probe of the same image: some pixels rendered to the end.

        ``probed`` lists the errors that the probe predicts. The error of the new law is a weighted geometric mean of
        the probe's last error and the pilot's prediction. ``sampler`` is the name of the strategy's sampler.
        """
        last = probed[-1]
        own, foretold = self._error(last.samples, self.exponent), self._doubt_at(last.samples)
        weight = foretold**2 / (foretold**2 + last.doubt**2) if math.isfinite(last.doubt) else 0.0
        value = own * math.pow(last.error / own, weight)
        before = [(self.samples, self.error), *((found.samples, found.error) for found in probed[:-1])]
        start, error = next((n, e) for n, e in reversed(before) if 2 * n <= last.samples or n == self.samples)
        exponent = math.log(error / value) / math.log(last.samples / start)
        slowest, fastest = _LASTING[sampler]
        return replace(
            self,
            samples=last.samples,
            error=value,
            width=last.width,
            narrowing=math.log(self.width / last.width) / math.log(last.samples / self.samples),
            exponent=min(max(exponent, slowest), fastest),
            exponent_doubt=_BEND[sampler],
            before=tuple(before),
            doubt=math.sqrt(weight) * last.doubt,
        )

    def error_at(self, samples: float) -> Interval:
        """Return the predicted relative error of the image after ``samples`` samples per pixel.

        The 95 % interval is wide enough to include the upper limit of the error that the render itself will then state.
        """
        doubt = math.hypot(self._doubt_at(samples), self._width(samples) / _Z95)
        return _interval(self._error(samples, self.exponent), doubt)

    def _doubt_at(self, samples: float) -> float:
        """Return the standard deviation of log(error), as it will be estimated after ``samples``."""
        kept = min(1.0, self.samples / samples)
        chance = math.hypot((1.0 - kept) * self._chance(self.samples), self._fresh(samples))
        growth = self._beyond(samples)
        return math.hypot(chance, self.exponent_doubt * growth, self._probes_doubt(samples))

    def samples_until(self, error: float) -> Interval:
        """Return the samples per pixel at which a render that stops by its own error estimates reaches ``error``.

        The prediction simulates renders with random errors of the pilot, random exponents and random later samples.
        Half of these renders stop before the returned value, and 95 % within its interval.
        """
        stops = sorted(self._stop(error, draw) for draw in _draws())
        return Interval(stops[_DRAWS // 2], stops[1], stops[-2])

    def samples_within(self, error: float) -> Interval:
        """Return the samples per pixel at which the predicted error falls to ``error``, a fraction, with an interval.

        Value, low and high are the counts at which value, low and high of the predicted error fall to ``error``. At the
        count ``high`` the true error is at most ``error`` in 97.5 % of renders, whatever the renders estimate
        themselves.
        """
        value, low, high = (self._first_within(error, end) for end in ("value", "low", "high"))
        return Interval(value, low, high)

    def _first_within(self, error: float, end: Literal["value", "low", "high"]) -> float:
        """Return the least even count, up to 2^40, at which an end of the error's interval is at most ``error``."""

        def reached(half: int) -> bool:
            return bool(getattr(self.error_at(2.0 * half), end) <= error)

        halves = range(1, round(0.5 * _MOST_SAMPLES))
        return 2.0 * (bisect_left(halves, True, key=reached) + 1)

    def samples_left(self, share: Interval) -> Interval:
        """Return the fraction of the samples that would still be needed for the same error if the noise were smaller.

        With the smaller noise, error² would be ``share`` times its present value. The interval includes the interval of
        ``share`` and the uncertainty of the exponent. The fraction is 0 if ``share`` is not positive.
        """
        if not share.value > 0.0:
            return Interval(0.0, 0.0, math.inf)
        power = 0.5 / self.exponent
        value = share.value**power
        by_exponent = _Z95 * power * math.log(share.value) * self.exponent_doubt / self.exponent
        below, above = (
            math.hypot(power * math.log(end / share.value), by_exponent) if end > 0.0 else math.inf
            for end in (share.low, share.high)
        )
        return Interval(value, value * math.exp(-below), value * math.exp(above))

    def samples_in(self, seconds: float) -> Interval:
        """Return the samples per pixel that a render takes in ``seconds`` seconds, with an interval."""
        even = without_start(seconds, self.seconds_lost)
        return _interval(max(1.0, even / self.seconds_per_sample), self.speed_doubt)

    def seconds_for(self, samples: Interval) -> Interval:
        """Return the seconds that ``samples`` per pixel take; the interval includes the interval of ``samples``."""
        above, below = (
            math.exp(math.hypot(math.log(ratio), _Z95 * self.speed_doubt))
            for ratio in (samples.high / samples.value, samples.value / samples.low)
        )
        value = from_start(samples.value * self.seconds_per_sample, self.seconds_lost)
        return Interval(value, value / below, value * above)

    def looks_until(self, error: float) -> list[int]:
        """Return the samples per pixel at which a render is expected to estimate its error, up to its stop.

        The render stops when its estimates reach ``error``.
        """
        return list(self._looks(error, (0.0, 0.0, 0.0, 0.0)))

    def _stop(self, error: float, draw: tuple[float, ...]) -> float:
        """Return the count at which one simulated render stops."""
        return float(list(self._looks(error, draw))[-1])

    def _looks(self, error: float, draw: tuple[float, ...]) -> Iterator[int]:
        """Yield the counts at which one simulated render looks."""
        looks, samples = Looks(), 0
        while samples < _MOST_SAMPLES and not looks.met(error):
            samples = next_look(samples)
            looks.look(self._seen(samples, draw), samples)
            yield samples

    def _seen(self, samples: int, draw: tuple[float, ...]) -> Interval:
        """Return the error at a look; the pilot's samples are part of it, and their chance wears off."""
        of_pilot, of_exponent, of_others, of_width = draw
        kept = min(1.0, self.samples / samples)
        of_pixels = (1.0 - kept) * self._chance(self.samples) - self._probes_doubt(samples)
        chance = self._fresh(samples) * of_others - of_pixels * of_pilot
        exponent = self.exponent + self.exponent_doubt * of_exponent
        value = self._error(samples, exponent) * math.exp(min(chance, 700.0))
        pilot = self.before[0][0] if self.before else self.samples  # a probe's few pixels do not show rare light
        rare = min(_RARE * self.width, _MOST_RARE) * of_width * max(math.log(samples / pilot), 0.0)
        width = self._width(samples) * math.exp(min(rare, _MOST_WIDENING))
        factor = math.exp(min(width, 700.0))
        return Interval(value, value / factor, value * factor)

    def _error(self, samples: float, exponent: float) -> float:
        """Return the error, interpolated between known points, or beyond them by a power of the samples."""
        points = [(n, math.log(error) - self._between(n)) for n, error in (*self.before, (self.samples, self.error))]
        last, fallen = points[-1]
        for (n, error), (after, less) in itertools.pairwise(points):
            if samples < after:
                last, fallen, exponent = n, error, (error - less) / math.log(after / n)
                if samples < n:  # before the pilot a slope between close counts says nothing
                    exponent = min(max(exponent, _LEAST_EXPONENT), _MOST_EXPONENT)
                break
        return math.exp(min(fallen - exponent * math.log(samples / last) + self._between(samples), 700.0))

    def _between(self, samples: float) -> float:
        """Return log of the error over that at powers of two: 0 if ``samples`` is a power of two."""
        return 0.0 if math.frexp(samples)[0] == 0.5 else _UNEVEN * max(0.0, self.exponent - _SLOW)

    def _beyond(self, samples: float) -> float:
        """Return the logarithm of the samples over those at which the error is known; negative for fewer."""
        growth = math.log(samples / self.samples)
        return max(growth, 0.0) if self.before else growth

    def _probes_doubt(self, samples: float) -> float:
        """Return the part of a probe's doubt that applies after ``samples``: 0 before the probe began."""
        if not self.before:
            return 0.0
        begin = self.before[0][0]
        return self.doubt * min(max(math.log(samples / begin) / math.log(self.samples / begin), 0.0), 1.0)

    def _width(self, samples: float) -> float:
        narrowing = self.narrowing
        if self.before and samples > self.samples:  # rarer paths widened it on the way, and others narrow it again
            narrowing = max(narrowing, _least_narrowing(self.width))
        return self.width * math.pow(samples / self.samples, -narrowing)

    def _chance(self, samples: float) -> float:
        """Return the standard deviation of log(estimate): half the variance behind the whole interval."""
        return self._width(samples) / (_Z95 * math.sqrt(2.0))

    def _fresh(self, samples: float) -> float:
        """Return the standard deviation of log(error) due to samples taken after the pilot."""
        kept = min(1.0, self.samples / samples)
        drift = _DRIFT + 0.5 * _UNEVEN * max(0.0, self.exponent - _SLOW)
        return math.hypot(self._chance(samples) * math.sqrt(1.0 - kept * kept), drift * (1.0 - kept))

    def as_dict(self) -> dict[str, Any]:
        """Return the law's fields by name as JSON data, without ``width``, ``narrowing`` and ``doubt``."""
        before = [{"samples": samples, "error": error} for samples, error in self.before]
        return {**fields_to_json(self, without=("width", "narrowing", "doubt")), "before": before}


def fit(errors: Mapping[int, Interval], seconds: Mapping[int, float], sampler: str, had: float = 1.0) -> Law:
    """Return the law (error and time by the number of samples) that fits the measured errors and seconds of a render.

    ``errors`` and ``seconds`` map counts of samples per pixel to the error and to the seconds since the first sample.
    The exponent of the error is measured over the last three doublings of the count. The law's exponent averages it
    with the usual exponent of ``sampler``, the sampler's name, by their uncertainties. The speed is measured over the
    last two doublings. ``had`` is the share of the processors that was available, in [0, 1].
    """
    last = max(errors)
    near = [n for n in sorted(errors) if 8 * n >= last and errors[n].value > 0.0 and math.isfinite(errors[n].high)]
    widths = {n: math.log(errors[n].high / errors[n].value) for n in near}
    exponent, spread = _EXPONENTS[sampler]
    narrowing = 0.0
    if len(near) > 1:
        seen = -_slope({n: math.log(errors[n].value) for n in near})
        narrowing = min(max(-_slope({n: math.log(max(widths[n], 1e-9)) for n in near}), 0.0), _MOST_NARROWING)
        narrowing = max(narrowing, _least_narrowing(widths[last]))
        # The measured exponent is uncertain by the errors at both ends, and, since the law bends, beyond them too.
        chance = math.hypot(widths[near[0]], widths[last]) / (_Z95 * math.sqrt(2.0) * math.log(last / near[0]))
        weight = spread**2 / (spread**2 + chance**2 + _BEND[sampler] ** 2)
        exponent += weight * (min(max(seen, _LEAST_EXPONENT), _MOST_EXPONENT) - exponent)
        spread *= math.sqrt(1.0 - weight)
    return Law(last, errors[last].value, widths[last], narrowing, exponent, spread, *pace(seconds, had))


def _least_narrowing(width: float) -> float:
    return min(_FEW * width, _MOST_NARROWING)


def _slope(logs: Mapping[int, float]) -> float:
    """Return the slope of the line through logarithms, against the logarithms of their samples, by least squares."""
    return linear_regression([math.log(n) for n in logs], list(logs.values())).slope


@cache
def _draws() -> tuple[tuple[float, ...], ...]:
    """Return normal deviates in four dimensions, evenly spread (a lattice of rank 1: Roberts 2018)."""
    root = 1.1673039782614187  # root of x⁵ = x + 1
    steps = [root**-k for k in (1, 2, 3, 4)]
    return tuple(
        tuple(_NORMAL.inv_cdf((0.5 + number * step) % 1.0) for step in steps) for number in range(1, _DRAWS + 1)
    )


def _interval(value: float, log_doubt: float) -> Interval:
    factor = math.exp(min(_Z95 * log_doubt, 700.0))
    return Interval(value, value / factor, value * factor)
