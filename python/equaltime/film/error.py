"""A render's own estimate of its error, from independent replicates.

The samples of a pixel belong to R replicates. Where these are nets of their own (sample ``i`` is in replicate ``i mod
R``), the spread of their means is an honest measure of the error of the image under any sampler; the sample variance
inside a replicate is not (low-discrepancy points are correlated on purpose), and is not used here. Where replicates are
the halves of one net, `equaltime.film.second_nets` tells by what factor their spread is off.

Definition: ``error² = mean over pixels and RGB of Var(I) / (R² + (0.1 m)²)`` with ``Var(I)`` the estimated variance of
the pixel, ``R`` its reference and ``m`` the mean of the image. The reference should be the truth. A render has only its
own image, in which a pixel that has met a rare bright path is too bright and has a large variance at once: by its own
mean it would excuse itself. So there are three references, all of them between the pixel and its 7x7 local mean
(cpp/film/error_parts.cpp): a lenient one with the pixel, for the lower limit; a cautious one without it, for the upper
limit; and a weighted geometric mean of both denominators, for the value. None is below the light of lamps that are
known to be in the pixel. All arrays are float64 here, indexed ``[y, x, channel]``, in the units of the image.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.film.sums import error_contributions, join_replicates, standard_errors
from equaltime.film.tails import outstanding

__all__ = [
    "UNKNOWN",
    "ErrorParts",
    "Estimate",
    "PixelStatistics",
    "Unit",
    "error_and_brightest",
    "error_parts",
    "expected_half_width",
    "image_error",
    "load_quantiles",
    "pixel_statistics",
    "standard_error",
]

Floats = NDArray[np.float64]

_LEAST_DOUBT = 0.03
"""Least standard deviation of the logarithm of an error. References are made of the noisy image itself: on ordinary
scenes the median of stated over realised errors is 0.97 to 1.06 from 8 samples a pixel on
(tests/bench/stated_errors.py)."""
_Z95 = 1.960
_MANY = 300.0
# The logarithm of an upper limit over its estimate, beyond which it says nothing, and soon is more than float64 holds.
_MOST_KNOWN = 100.0
# Binary exponent of an image's mean beyond which the square of a square is more, or less, than float64 holds.
_MOST_EXPONENT = 200

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
    """Why the upper limit cannot be trusted; empty where it can (`equaltime.film.tails`)."""
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
        """Return the error of an image that has this noise and a bias, if it has one: their squares add up.

        It is in doubt if either is.
        """
        if bias is None:
            return self
        value, low, high = (
            math.hypot(*both) for both in ((self.value, bias.value), (self.low, bias.low), (self.high, bias.high))
        )
        doubt = "; ".join(dict.fromkeys(filter(None, (self.doubt, bias.doubt))))
        return replace(self, value=value, low=low, high=high, doubt=doubt)

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


@dataclass(frozen=True, eq=False)
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
    factors: Floats | None = None
    """(H, W): what the spread of replicates was multiplied by to be the variance; None where it was not."""
    common_doubt: float = 0.0
    """Relative standard deviation of a factor that all variances have in common."""

    @property
    def spread(self) -> Floats:
        """(H, W, 3): the variance of the mean as it would be if replicates were independent."""
        return self.variance if self.factors is None else self.variance / self.factors[..., None]


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
    pixels: PixelStatistics,
    level: float = 0.95,
    hidden: Callable[[PixelStatistics, float], float] | None = None,
    least: Floats | None = None,
) -> Estimate:
    """Estimate the error of the image by the definition at the top of this file.

    The interval is meant to hold the *realised* error of this very image in 95 % of renders (or another ``level``).
    Each limit is formed on the logarithm, around the error by its own reference, from the variance of the estimate and
    that of the realised error (the square of a Gaussian varies by twice its mean's square, and no less than its
    estimate from two replicates does). Few effective contributions call for Student's t.

    Unknown (`UNKNOWN`) while a pixel has samples in fewer than two replicates. A black image has value 0 and the upper
    limit ``inf``: nothing was seen, so nothing is known; or 0 if nothing can be hidden.

    Parameters
    ----------
    hidden
        Tells at a level what part of error² no sample has found: what black pixels and small lamps may hide
        (`equaltime.film.unseen`). The upper limit is wider by that.
    least
        (H, W, 3): light that is surely in a pixel's mean; no reference is below it.
    """
    return error_and_brightest(pixels, level, hidden, least)[0]


def error_and_brightest(
    pixels: PixelStatistics,
    level: float = 0.95,
    hidden: Callable[[PixelStatistics, float], float] | None = None,
    least: Floats | None = None,
) -> tuple[Estimate, float]:
    """Return `image_error`, and the brightest path's share of error² (`equaltime.film.tails.outstanding`)."""
    seen, brightest = _seen_error(pixels, level, least)
    if hidden is None or not seen.known:
        return seen, brightest
    missed = math.sqrt(hidden(pixels, level))
    if seen.value == 0.0 and missed == 0.0:
        return Estimate(0.0, 0.0, 0.0), brightest
    return replace(seen, high=math.hypot(seen.high, missed)), brightest


def _seen_error(pixels: PixelStatistics, level: float, least: Floats | None) -> tuple[Estimate, float]:
    """Return the error by what samples have seen, and the share of its square that the brightest path makes."""
    if pixels.variance.size == 0 or not np.isfinite(pixels.variance).all():
        return UNKNOWN, 0.0
    m = float(pixels.mean.mean())
    if m == 0.0:
        return Estimate(0.0, 0.0, math.inf), 0.0
    if not math.isfinite(m):
        return UNKNOWN, 0.0
    if abs(exponent := math.frexp(m)[1]) > _MOST_EXPONENT:
        scale = math.ldexp(1.0, -exponent)  # an error is relative, and a power of two leaves its bits as they are
        scaled = replace(pixels, mean=pixels.mean * scale, variance=pixels.variance * scale * scale)
        return _seen_error(scaled, level, None if least is None else least * scale)
    parts = error_parts(pixels, m, least)
    value, low, high = (math.sqrt(float(part.mean())) for part in (parts.value, parts.lenient, parts.cautious))
    if value == 0.0:
        return Estimate(0.0, 0.0, 0.0), 0.0
    moved = parts.moved / (parts.value.size * value**4)
    down, up = (_half_width(part, moved, pixels, level) for part in (parts.lenient, parts.cautious))
    limits = (low * math.exp(-down), high * math.exp(up) if up < _MOST_KNOWN else math.inf)
    return Estimate(value, *limits), outstanding(parts.value)


def _half_width(contributions: Floats, moved: float, pixels: PixelStatistics, level: float) -> float:
    """Return half the interval of the logarithm of the error that these contributions make, at a level.

    Infinite where they are too few. ``moved`` is what the noise of references adds to the variance of error², relative
    to its square.
    """
    degrees = pixels.degrees
    square = float(contributions.mean())
    spread = _spread(contributions, degrees)
    realised = max(spread, _of_gaussians(degrees) * float(np.square(contributions).mean()))
    estimated, realised = (v / (contributions.size * square**2) for v in (spread, realised))
    estimated += moved
    effective = min(contributions.size * degrees, 2.0 / estimated)
    if effective < 1.0:
        return math.inf
    least = _Z95 * math.hypot(_LEAST_DOUBT, 0.5 * pixels.common_doubt)
    return math.hypot(_quantile(level, effective) * 0.5 * math.sqrt(estimated + realised), least)


def expected_half_width(squares: float, pixels: int, degrees: float) -> float:
    """Return half the interval of the logarithm of an error at 95 %, as `image_error` will find it.

    Parameters
    ----------
    squares
        Mean of the squares of pixels' contributions, over the square of their mean.
    """
    deviation = 0.5 * math.sqrt(2.0 * _of_gaussians(degrees) * squares / pixels)
    return _Z95 * math.hypot(deviation, _LEAST_DOUBT)


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


@dataclass(frozen=True, eq=False)
class ErrorParts:
    """Each pixel's part of error², (H, W), by three references."""

    value: Floats
    lenient: Floats
    cautious: Floats
    moved: float
    """Variance per pixel that the noise of references adds to ``value``."""


def error_parts(pixels: PixelStatistics, m: float, least: Floats | None = None) -> ErrorParts:
    """Return each pixel's part of error²; ``m`` is the mean of the image, ``least`` as `image_error` takes it.

    The variance that the noise of references adds is found by the delta method: pixel j moves the local means around
    it, and m, by its own noise; all contributions there share that. Both derivatives have one sign, so the parts add up
    in absolute value.
    """
    contributions, sums = error_contributions(pixels.mean, pixels.variance, pixels.samples, (0.1 * m) ** 2, least)
    influence = 0.02 * m * sums["slopes"] / pixels.mean.size
    by_means = 2.0 * influence * sums["crossed"] + influence**2 * sums["means_squared"]
    value, lenient, cautious = contributions
    return ErrorParts(value, lenient, cautious, (sums["locals_squared"] + by_means) / pixels.samples.size)


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
