"""A render's own estimate of its error, from independent replicates.

Sample ``i`` of a pixel belongs to replicate ``i mod R``. Replicates use independent randomisations, so the spread of
their means is an honest measure of the error of the image under any sampler; the sample variance inside a replicate
is not (low-discrepancy points are correlated on purpose), and is not used here.

Definition: ``error² = mean over pixels and RGB of Var(I) / (R² + (0.1 m)²)`` with ``Var(I)`` the estimated variance of
the pixel, ``R`` the 7x7 local mean of the image (which gives way to the pixel itself where the picture has structure,
see ``Reference`` in cpp/film/error_parts.cpp) and ``m`` the mean of the image. All arrays are float64 here, indexed
``[y, x, channel]``, in the units of the image.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.film import error_contributions, join_replicates, standard_errors
from equaltime.tails import tail_of_one

__all__ = [
    "UNKNOWN",
    "Estimate",
    "PixelStatistics",
    "Unit",
    "error_parts",
    "expected_width",
    "image_error",
    "load_quantiles",
    "pixel_statistics",
    "standard_error",
]

Floats = NDArray[np.float64]

# What making the reference R from the noisy image itself does to the error, as standard deviations of its logarithm,
# measured against converged images of 16x16 to 96x96 pixels, for how far the error may lie above and below the
# estimate: of how far it moves as R leans all the way from a pixel's mean to the darker of its replicates (above only
# where few pixels make the noise, which is skewed then); times the noise, where R is all the local mean; times both,
# which are large together in the first samples; and at least.
_LEANING_ABOVE, _LEANING_BELOW = 0.35, 0.25
_SMOOTH_ABOVE, _SMOOTH_BELOW = 0.2, 0.15
_BOTH_ABOVE, _LEAST_DOUBT = 0.65, 0.01
_Z95 = 1.960
_MANY = 300.0
# The logarithm of an upper limit over its estimate, beyond which it says nothing, and soon is more than float64 holds.
_MOST_KNOWN = 100.0

Unit = Literal["%", "s", "spp", "MB"]
_SCALES: Mapping[Unit, float] = {"%": 100.0, "s": 1.0, "spp": 1.0, "MB": 1e-6}
"""What a number is multiplied by where it is printed."""


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval."""

    value: float
    """NaN where nothing is known; ``inf`` is a statement, such as a time that never comes."""
    low: float
    high: float
    doubt: str = ""
    """Why the upper limit cannot be trusted; empty where it can (`equaltime.tails`)."""
    unit: Unit = "%"
    """In which it is printed: a fraction as per cent, or seconds, samples per pixel, bytes as megabytes."""

    @property
    def trusted(self) -> bool:
        """Whether the interval may be relied on."""
        return not self.doubt

    @property
    def known(self) -> bool:
        """Whether there is an estimate at all."""
        return math.isfinite(self.value)

    def with_bias(self, bias: Estimate | None) -> Estimate:
        """Return the error of an image that has this noise and a bias, if it has one: their squares add up."""
        if bias is None:
            return self
        value, low, high = (
            math.hypot(*both) for both in ((self.value, bias.value), (self.low, bias.low), (self.high, bias.high))
        )
        return replace(self, value=value, low=low, high=high)

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers for JSON, with the unit, and the doubt if there is one.

        JSON has no infinity. A limit that is None is none. A value that is None is unknown, or infinite where ``never``
        stands beside it.
        """
        numbers = {"value": self.value, "low": self.low, "high": self.high}
        found: dict[str, Any] = {key: number if math.isfinite(number) else None for key, number in numbers.items()}
        never = {"never": True} if math.isinf(self.value) else {}
        return found | never | ({"doubt": self.doubt} if self.doubt else {}) | {"unit": self.unit}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Estimate:
        """Return what `as_dict` made these data of; data without a unit are of a time when all were errors."""
        never = bool(data.get("never"))
        none = {"value": math.inf if never else math.nan, "low": math.inf if never else -math.inf, "high": math.inf}
        value, low, high = (other if data[key] is None else float(data[key]) for key, other in none.items())
        return cls(value, low, high, data.get("doubt") or "", data.get("unit", "%"))

    def __str__(self) -> str:
        if not self.known:
            return "never" if math.isinf(self.value) else "unknown"
        value, low, high = (f"{_SCALES[self.unit] * number:.3g}" for number in (self.value, self.low, self.high))
        return f"{value} {self.unit} [{low}, {high if math.isfinite(self.high) else 'unknown'}]"


UNKNOWN = Estimate(math.nan, 0.0, math.inf)
"""An error of which nothing is known, but that no error is below 0."""


@dataclass(frozen=True)
class PixelStatistics:
    """What is known of every pixel: enough for the image, its standard error and its error."""

    mean: Floats
    """(H, W, 3): the image; 0 where there is no sample."""
    variance: Floats
    """(H, W, 3): estimated variance *of the mean*; NaN where fewer than two replicates have samples."""
    samples: NDArray[np.int64]
    """(H, W): samples taken."""
    degrees: float
    """Degrees of freedom behind each pixel's variance: R - 1 for R replicates."""
    deviation: Floats | None = None
    """(H, W, 3): standard deviation *of one sample*, where that was asked for."""


def pixel_statistics(moments: NDArray[Any]) -> PixelStatistics:
    """Join replicates into one image with its variance.

    With ``n_r`` samples and mean ``M_r`` in replicate r, and ``N = Σ n_r``, the image is ``I = Σ n_r M_r / N``, and

        ``Var(I) ≈ Σ n_r (M_r - I)² / ((K - 1) N)``,  K the number of replicates that have samples.

    Where ``Var(M_r) = v / n_r``, ``E Σ n_r M_r² = N μ² + K v`` and ``E N I² = N μ² + v``: their difference is
    ``E Σ n_r (M_r - I)² = (K - 1) v``, and ``Var(I) = v / N``. So the estimate is unbiased for unequal counts when the
    samples of a replicate are independent, and for equal counts under any sampler (then it is the plain variance of K
    equal means, over K). Counts differ by at most one, so what is left for low-discrepancy samples is O(1/N) of it.

    Parameters
    ----------
    moments
        (R, H, W) structured array with fields ``count``, ``mean`` (3) (and others, which are not used).
    """
    mean, variance, samples = join_replicates(moments)
    return PixelStatistics(mean, variance, samples, float(len(moments) - 1))


def standard_error(pixels: PixelStatistics) -> NDArray[np.float32]:
    """Return the standard error of every pixel, (H, W, 3) float32, ``inf`` where unknown.

    One pixel's replicates say little (R - 1 degrees of freedom), so the variance *of one sample* is averaged over the
    pixels of the 7x7 neighbourhood that lie in the image and have one, and divided by the pixel's own count.
    """
    return standard_errors(pixels.mean, pixels.variance, pixels.samples)


def image_error(
    pixels: PixelStatistics, level: float = 0.95, hidden: Callable[[PixelStatistics, float], float] | None = None
) -> Estimate:
    """Estimate the error of the image by the definition at the top of this file.

    The interval is meant to hold the *realised* error of this very image in 95 % of renders (or another ``level``). It
    is formed on the logarithm from the variance of the estimate, that of the realised error (the square of a Gaussian
    varies by twice its mean's square, and no less than its estimate from two replicates does), and the doubt about the
    reference. Few effective contributions call for Student's t. The doubt is no matter of chance: it does not grow with
    the level, and differs for both sides, since a reference that leans to the dark overestimates more than it misses.

    Unknown (`UNKNOWN`) while a pixel has samples in fewer than two replicates. A black image has
    value 0 and the upper limit ``inf``: nothing was seen, so nothing is known; or 0 if nothing can be hidden. Light
    paths that no sample has found yet are beyond any estimate made from the samples: ``hidden`` (`equaltime.unseen`)
    tells what part of error² black pixels and small lamps may hide at a level, which widens the upper limit. Where
    single pixels make much of the error, so that what was not seen may make more, the estimate says so: its upper limit
    is in doubt.
    """
    seen = _seen_error(pixels, level)
    if hidden is None or not seen.known:
        return seen
    missed = math.sqrt(hidden(pixels, level))
    if seen.value == 0.0 and missed == 0.0:
        return Estimate(0.0, 0.0, 0.0)
    return replace(seen, high=math.hypot(seen.high, missed))


def _seen_error(pixels: PixelStatistics, level: float) -> Estimate:
    """Return the error by what samples have seen."""
    if pixels.variance.size == 0 or not np.isfinite(pixels.variance).all():
        return UNKNOWN
    m = float(pixels.mean.mean())
    if m == 0.0:
        return Estimate(0.0, 0.0, math.inf)
    contributions, moved, leant, smooth = error_parts(pixels, m)
    square = float(contributions.mean())
    if square == 0.0:
        return Estimate(0.0, 0.0, 0.0)
    spread = _spread(contributions, pixels.degrees)
    realised = max(spread, _of_gaussians(pixels.degrees) * float(np.square(contributions).mean()))
    estimated, realised = (v / (contributions.size * square**2) for v in (spread + moved, realised))
    value = math.sqrt(square)
    effective = min(contributions.size * pixels.degrees, 2.0 / estimated)
    tail = tail_of_one(contributions)
    if effective < 1.0:
        return Estimate(value, 0.0, math.inf, tail.doubt)
    deviation = 0.5 * math.sqrt(estimated + realised)
    chance = _quantile(level, effective) * deviation
    above, below = _doubts(deviation, contributions.size, leant, smooth)
    down, up = math.hypot(chance, _Z95 * below), math.hypot(chance, _Z95 * above)
    high = value * math.exp(up) if up < _MOST_KNOWN else math.inf
    return Estimate(value, value * math.exp(-down), high, tail.doubt)


def expected_width(squares: float, pixels: int, degrees: float, leant: float, smooth: float) -> float:
    """Return the logarithm of the upper limit over the error, at 95 %, that `image_error` will find.

    Parameters
    ----------
    squares
        Mean of the squares of pixels' contributions, over the square of their mean.
    leant, smooth
        Of `error_parts`.
    """
    deviation = 0.5 * math.sqrt(2.0 * _of_gaussians(degrees) * squares / pixels)
    return _Z95 * math.hypot(deviation, _doubts(deviation, pixels, leant, smooth)[0])


def _doubts(deviation: float, pixels: int, leant: float, smooth: float) -> tuple[float, float]:
    """Return what the reference leaves to the logarithm of the error, above and below, as standard deviations."""
    # of even noise in two replicates, the deviation is one over the root of the number of pixels
    skewed = min(max(0.5 * (deviation * math.sqrt(pixels) - 1.0), 0.0), 1.0)
    both = _BOTH_ABOVE * leant * smooth
    above = math.hypot(_LEANING_ABOVE * leant * skewed, _SMOOTH_ABOVE * smooth, both, _LEAST_DOUBT)
    return above, math.hypot(_LEANING_BELOW * leant, _SMOOTH_BELOW * smooth, _LEAST_DOUBT)


def _of_gaussians(degrees: float) -> float:
    """Return the variance of the square of a Gaussian, over the mean square of its estimate from so many degrees."""
    return 2.0 / (1.0 + 2.0 / degrees)


def _quantile(level: float, degrees: float) -> float:
    """Return the two-sided quantile of Student's t, or of the normal distribution where they hardly differ."""
    if degrees >= _MANY:
        return NormalDist().inv_cdf(0.5 + 0.5 * level)
    from scipy.special import stdtrit  # here, since not everyone needs it

    return float(stdtrit(degrees, 0.5 + 0.5 * level))


def load_quantiles() -> None:
    """Import what limits of errors may need, which takes a tenth of a second: before a clock runs."""
    import scipy.special  # noqa: F401


def error_parts(pixels: PixelStatistics, m: float) -> tuple[Floats, float, float, float]:
    """Return each pixel's part of error², (H, W), and three things about the denominators.

    The first is the variance per pixel that their noise adds. By the delta method: pixel j moves the local means around
    it, and m, by its own noise; all contributions there share that. Both derivatives have one sign, so the parts add up
    in absolute value. The others are how far R's lean moves the logarithm of the error, and the share of the error,
    weighed by the noise, where R is the local mean.
    """
    contributions, sums = error_contributions(pixels.mean, pixels.variance, pixels.samples, (0.1 * m) ** 2)
    influence = 0.02 * m * sums["slopes"] / pixels.mean.size
    by_means = 2.0 * influence * sums["crossed"] + influence**2 * sums["means_squared"]
    moved = (sums["locals_squared"] + by_means) / contributions.size
    whole = max(3.0 * float(contributions.sum()), np.finfo(np.float64).tiny)
    return contributions, moved, sums["leant"] / whole, sums["smooth"] / whole


def _spread(contributions: Floats, degrees: float) -> float:
    """Return the variance of one contribution.

    Half the mean square difference of adjacent ones: their noise without what the picture itself varies. A handful
    could miss even the variance that Gaussian noise would have, so for these that is the least.
    """
    steps = [np.square(np.diff(contributions, axis=axis)) for axis in (0, 1)]
    pairs = sum(step.size for step in steps)
    spread = 0.5 * float(sum(step.sum() for step in steps)) / pairs if pairs else 0.0
    if contributions.size < 30:
        spread = max(spread, 2.0 / degrees * float(contributions.mean()) ** 2)
    return spread
