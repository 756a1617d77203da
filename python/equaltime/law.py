"""The law by which a render's error falls with its samples, and its samples cost time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from statistics import NormalDist

from equaltime.budget import Looks
from equaltime.error_estimate import Estimate

__all__ = ["Law", "fit"]

_Z95 = 1.960
# What is taken to be known of the exponent before the pilot, by sampler: mean and standard deviation. Independent
# samples have ½ exactly, but for the finite sample of the pilot; the others are assumed, between ½ and the ¾ of edges.
_EXPONENTS = {"independent": (0.5, 0.005), "stratified": (0.52, 0.03), "sobol": (0.54, 0.04)}
# Of the logarithm of the speed, from the pilot to the end, on a machine whose load stays the same: assumed.
_SPEED_DOUBT = 0.03
_MOST_SAMPLES = 2.0**40


@dataclass(frozen=True)
class Law:
    """``error(n) = error · (n / samples)^-exponent``, and ``seconds(n) = n · seconds_per_sample``.

    Doubts are standard deviations, of logarithms where the name says so.
    """

    samples: int
    """A pixel, where the pilot ended."""
    error: float
    """Of the pilot's image."""
    log_error_doubt: float
    exponent: float
    exponent_doubt: float
    seconds_per_sample: float
    """A sample of every pixel."""

    def error_at(self, samples: float) -> Estimate:
        """Return the error after ``samples`` a pixel."""
        growth = math.log(samples / self.samples)
        doubt = math.hypot(self.log_error_doubt, self.exponent_doubt * growth)
        return _interval(self.error * math.exp(-self.exponent * growth), doubt)

    def samples_until(self, error: float) -> Estimate:
        """Return the samples a pixel at which a render that is asked for ``error`` stops, by its own looks."""
        looks, samples = Looks(), 0
        while samples < _MOST_SAMPLES:
            samples = looks.next
            if looks.look(partial(self._seen, samples), samples, error):
                break
        doubt = math.hypot(self.log_error_doubt, self.exponent_doubt * math.log(samples / self.samples))
        return _interval(float(samples), doubt / self.exponent)

    def samples_in(self, seconds: float) -> Estimate:
        """Return how many samples a pixel so much time is enough for."""
        return _interval(max(1.0, seconds / self.seconds_per_sample), _SPEED_DOUBT)

    def seconds_for(self, samples: Estimate) -> Estimate:
        """Return the time that so many samples a pixel take."""
        doubt = math.log(samples.high / samples.value) / _Z95
        return _interval(samples.value * self.seconds_per_sample, math.hypot(doubt, _SPEED_DOUBT))

    def _seen(self, samples: int, level: float) -> Estimate:
        """Return what a look is likely to see: its doubt grows with the level and falls with the error."""
        value = self.error_at(samples).value
        doubt = self.log_error_doubt * min(1.0, value / self.error) ** 0.75
        factor = math.exp(min(NormalDist().inv_cdf(0.5 + 0.5 * level) * doubt, 700.0))
        return Estimate(value, value / factor, value * factor)

    def as_dict(self) -> dict[str, float]:
        """Return the law as JSON data."""
        return {
            "samples": self.samples,
            "error": self.error,
            "exponent": self.exponent,
            "exponent_doubt": self.exponent_doubt,
            "seconds_per_sample": self.seconds_per_sample,
        }


def fit(errors: Mapping[int, Estimate], seconds: Mapping[int, float], sampler: str) -> Law:
    """Fit the law to the errors, and the seconds since the first sample, at some counts of samples a pixel.

    The exponent is that of the last two octaves, weighed against what is known of the sampler.
    """
    last = max(errors)
    first = min((n for n in errors if 4 * n >= last), default=last)
    doubt = math.log(errors[last].high / errors[last].value) / _Z95
    exponent, spread = _EXPONENTS[sampler]
    if first < last:
        growth = math.log(last / first)
        seen = math.log(errors[first].value / errors[last].value) / growth
        # What is seen is in doubt by the errors at both ends, and, since the law bends, for what lies beyond them too.
        weight = spread**2 / (2.0 * spread**2 + (2.0 * doubt / growth) ** 2)
        exponent += weight * (min(max(seen, 0.3), 1.0) - exponent)
        spread *= math.sqrt(1.0 - weight)
    rate = (seconds[last] - seconds.get(first, 0.0)) / (last - first) if first < last else seconds[last] / last
    return Law(last, errors[last].value, doubt, exponent, spread, rate)


def _interval(value: float, log_doubt: float) -> Estimate:
    factor = math.exp(min(_Z95 * log_doubt, 700.0))
    return Estimate(value, value / factor, value * factor)
