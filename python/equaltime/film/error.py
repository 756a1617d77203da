"""A render's own estimate of its error, from independent replicates.

The samples of a pixel belong to R replicates. A net is a low-discrepancy point set. Replicates may be separate nets,
with sample ``i`` in replicate ``i mod R``. Then the spread of their means is an honest measure of the image's error
under any sampler. The sample variance inside a replicate is no such measure, since low-discrepancy points are
correlated on purpose. It is not used here. If replicates are the halves of one net, the spread of their means is off by
a factor, which `equaltime.film.second_nets` measures.

Definition: ``error² = mean over pixels and RGB of Var(I) / (R² + (0.1 m)²)`` with ``Var(I)`` the estimated variance of
the pixel, ``R`` its reference and ``m`` the mean of the image. The reference should be the truth. A render has only its
own image, in which a pixel that has met a rare bright path is too bright and has a large variance at once. Divided by
its own mean, such a pixel would hide its error. So there are references between the pixel's value and a local mean
(cpp/equaltime/analysis/error_parts.cpp). The local mean is made of the four halves of the 7x7 neighbourhood. Each half
has a weight: the likelihood that it has the same mean as the eight pixels next to the pixel. So a lit pixel before
black ground is not compared with the ground, nor a dark pixel with the light beside it.

The estimate uses a weighted geometric mean of two denominators, one with the pixel in its local mean and one without
it. The lenient reference is for the lower limit: its local mean includes the pixel, and is not below that of the
brightest half. The cautious reference is for the upper limit, and excludes the pixel. No reference is below the light
of lamps that are known to be in the pixel. All arrays are float64 here, indexed ``[y, x, channel]``, in the units of
the image.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.sums import error_contributions, error_floor, join_replicates, standard_errors
from equaltime.film.tails import outstanding
from equaltime.statistics.intervals import Interval

__all__ = [
    "UNKNOWN_ERROR",
    "ErrorParts",
    "PixelStatistics",
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
"""Least standard deviation of log(error). References are made from the noisy image itself: on ordinary scenes the
median of stated over realised errors is 0.97 to 1.06 from 12 samples a pixel on (tests/bench/stated_errors.py)."""
_Z95 = 1.960
_MANY = 300.0
# Largest log of an upper limit over its estimate. A larger one says nothing, and float64 soon overflows.
_MOST_KNOWN = 100.0
# Binary exponent of an image's mean beyond which its fourth power overflows or underflows float64.
_MOST_EXPONENT = 200

UNKNOWN_ERROR = Interval(math.nan, 0.0, math.inf)
"""Interval of an error about which nothing is known: value NaN, limits 0 and infinity."""


@dataclass(frozen=True, eq=False)
class PixelStatistics:
    """Mean, variance and sample count of every pixel of an image.

    The image's standard error and its relative error are computed from these arrays. The variances come from R
    replicates: disjoint groups of a pixel's samples, usually two, whose means differ by noise alone.
    """

    mean: Floats
    """(H, W, 3): the image; 0 where there is no sample."""
    variance: Floats
    """(H, W, 3): estimated variance *of the mean*; NaN where fewer than two replicates (groups of samples) have
    samples."""
    samples: NDArray[np.int64]
    """(H, W): samples taken."""
    degrees: float
    """Degrees of freedom of each pixel's variance: R - 1 for R replicates; for a merged render, a mean over pixels."""
    deviation: Floats | None = None
    """(H, W, 3): standard deviation *of one sample*; None if it was not computed."""
    factors: Floats | None = None
    """(H, W): correction factor that ``variance`` contains, from second nets: further samples of some pixels
    (`equaltime.film.second_nets`). None if the variances are not corrected."""
    common_doubt: float = 0.0
    """Relative standard deviation of the correction factor from second nets, which is common to all pixels; 0 without
    ``factors``."""

    @property
    def spread(self) -> Floats:
        """Variance of each pixel's mean, (H, W, 3), without the correction ``factors``.

        This is the variance that the difference of replicates (groups of a pixel's samples) gives if replicates are
        independent.
        """
        return self.variance if self.factors is None else self.variance / self.factors[..., None]


def pixel_statistics(moments: NDArray[Any]) -> PixelStatistics:
    """Return each pixel's mean, the variance of that mean, and its sample count, from the means of R replicates.

    Replicates are disjoint groups of a pixel's samples, usually two. With ``n_r`` samples and mean ``M_r`` in replicate
    r, and ``N = Σ n_r``, the image is ``I = Σ n_r M_r / N``, and

        ``Var(I) ≈ Σ n_r (M_r - I)² / ((K - 1) N)``,  K the number of replicates that have samples.

    Where ``Var(M_r) = v / n_r``, ``E Σ n_r M_r² = N μ² + K v`` and ``E N I² = N μ² + v``: the difference of these two
    is ``E Σ n_r (M_r - I)² = (K - 1) v``, and ``Var(I) = v / N``. So the estimate is unbiased for unequal counts when
    the samples of a replicate are independent. It is also unbiased for equal counts under any sampler: it is then the
    sample variance of K means, divided by K. If each replicate is a net (low-discrepancy point set) of its own, counts
    differ by at most one, so the remaining bias of low-discrepancy samples is O(1/N) of the estimate.

    Parameters
    ----------
    moments
        (R, H, W) structured array with fields ``count`` and ``mean`` (3); other fields are ignored.
    """
    mean, variance, samples = join_replicates(moments)
    return PixelStatistics(mean, variance, samples, float(len(moments) - 1))


def standard_error(pixels: PixelStatistics) -> NDArray[np.float32]:
    """Return the standard error of every pixel of an image, (H, W, 3) float32, ``inf`` where unknown.

    ``pixels`` are the statistics of the image. The standard error is the standard deviation of the pixel's mean. A
    pixel's own variance comes from few replicates (groups of its samples), and so is poorly known. So the variance *of
    one sample* is averaged over the 7x7 neighbourhood, as far as it lies in the image and variances are known. That
    average is divided by the pixel's own sample count.
    """
    return standard_errors(pixels.mean, pixels.variance, pixels.samples)


def image_error(
    pixels: PixelStatistics,
    level: float = 0.95,
    hidden: Callable[[PixelStatistics, float], float] | None = None,
    least: Floats | None = None,
) -> Interval:
    """Return the relative error of an image (0.02 is 2 %) with its interval: the root of a mean of relative variances.

    The squared error is ``mean over pixels and RGB of Var(I) / (R² + (0.1 m)²)``. Here I is the pixel, R its reference
    brightness, between the pixel and its local mean, and m the mean of the image. The interval is meant to hold the
    *realised* error of this very image in a share ``level`` of renders.

    Each limit uses a reference of its own. For the lower limit, R includes the pixel and leans to the brightest half of
    its neighbourhood. For the upper limit, R excludes the pixel. The limit is the error by that reference, divided or
    multiplied by a factor. The factor comes from the variance of the estimate and from the variance of the realised
    error. (The variance of a squared Gaussian is twice the square of its mean. It is no less than the variance of its
    estimate from two replicates.) The quantile is Student's t, for the effective number of contributions.

    The error is `UNKNOWN_ERROR` as long as a pixel has samples in fewer than two replicates (groups of its samples). A
    black image has value 0 and the upper limit ``inf``, because no light was seen. If ``hidden`` shows that no light
    can be missing, the upper limit is 0.

    Parameters
    ----------
    pixels
        Mean, variance and sample count of every pixel.
    level
        Confidence level of the interval, in (0, 1).
    hidden
        Callable of (pixels, level) that returns the error² due to light that no sample has found. Black pixels and
        small lamps may hide such light (`equaltime.film.unseen`). That amount is added to the square of the upper
        limit.
    least
        (H, W, 3): light that is certainly in a pixel's mean; no reference is below this light.
    """
    return error_and_brightest(pixels, level, hidden, least)[0]


def error_and_brightest(
    pixels: PixelStatistics,
    level: float = 0.95,
    hidden: Callable[[PixelStatistics, float], float] | None = None,
    least: Floats | None = None,
) -> tuple[Interval, float]:
    """Return the relative error of an image with its interval, and the share of error² that one bright path makes.

    The error is the result of `image_error`. The share, in [0, 1], tells whether the error depends on a single rare
    path. It is the share of the most outstanding pixel, by `equaltime.film.tails.outstanding`; 0 if the error is
    unknown.

    Parameters
    ----------
    pixels
        Mean, variance and sample count of every pixel.
    level
        Confidence level of the interval, in (0, 1).
    hidden
        Callable of (pixels, level) that returns the error² due to light that no sample has found, which is added to the
        square of the upper limit; None adds nothing.
    least
        (H, W, 3): light that is certainly in each pixel's mean; None if no such light is known.
    """
    seen, brightest = _seen_error(pixels, level, least)
    if hidden is None or not seen.known:
        return seen, brightest
    missed = math.sqrt(hidden(pixels, level))
    if seen.value == 0.0 and missed == 0.0:
        return Interval(0.0, 0.0, 0.0), brightest
    return replace(seen, high=math.hypot(seen.high, missed)), brightest


def _seen_error(pixels: PixelStatistics, level: float, least: Floats | None) -> tuple[Interval, float]:
    """Return the error from light that samples have seen, and the brightest path's share of its square."""
    if pixels.variance.size == 0 or not np.isfinite(pixels.variance).all():
        return UNKNOWN_ERROR, 0.0
    m = float(pixels.mean.mean())
    if m == 0.0:
        return Interval(0.0, 0.0, math.inf), 0.0
    if not math.isfinite(m):
        return UNKNOWN_ERROR, 0.0
    if abs(exponent := math.frexp(m)[1]) > _MOST_EXPONENT:
        scale = math.ldexp(1.0, -exponent)  # errors are relative, and scaling by a power of two keeps their bits
        scaled = replace(pixels, mean=pixels.mean * scale, variance=pixels.variance * scale * scale)
        return _seen_error(scaled, level, None if least is None else least * scale)
    parts = error_parts(pixels, m, least)
    value, low, high = (math.sqrt(float(part.mean())) for part in (parts.value, parts.lenient, parts.cautious))
    if value == 0.0:
        return Interval(0.0, 0.0, 0.0), 0.0
    moved = parts.moved / (parts.value.size * value**4)
    down, up = (_half_width(part, moved, pixels, level) for part in (parts.lenient, parts.cautious))
    limits = (low * math.exp(-down), high * math.exp(up) if up < _MOST_KNOWN else math.inf)
    return Interval(value, *limits), outstanding(parts.value)


def _half_width(contributions: Floats, moved: float, pixels: PixelStatistics, level: float) -> float:
    """Return half the width of the interval of log(error) for these contributions, at a level.

    It is infinite if the contributions are too few. ``moved`` is the variance that the noise of references adds to
    error², relative to the square of error².
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
    """Return the half width that the 95 % interval of a planned render's log(error) will have.

    The limits of the error are about ``exp(±half width)`` times its value. Use the function to predict an interval
    before the render.

    Parameters
    ----------
    squares
        Mean of the squared contributions of pixels to error², divided by the square of the mean contribution.
    pixels
        Number of pixels.
    degrees
        Degrees of freedom of each pixel's variance.
    """
    deviation = 0.5 * math.sqrt(2.0 * _of_gaussians(degrees) * squares / pixels)
    return _Z95 * math.hypot(deviation, _LEAST_DOUBT)


def _of_gaussians(degrees: float) -> float:
    """Return the variance of a squared Gaussian over the mean square of its estimate with these degrees of freedom."""
    return 2.0 / (1.0 + 2.0 / degrees)


def _quantile(level: float, degrees: float) -> float:
    """Return the two-sided quantile of Student's t, or of the normal distribution from 300 degrees of freedom on."""
    if degrees >= _MANY:
        return NormalDist().inv_cdf(0.5 + 0.5 * level)
    from scipy.special import stdtrit  # here, because not every render needs scipy

    return float(stdtrit(degrees, 0.5 + 0.5 * level))


def load_quantiles() -> None:
    """Import SciPy's quantiles, which limits of errors may need, before a render is timed; the import takes 0.1 s."""
    import scipy.special  # noqa: F401


@dataclass(frozen=True, eq=False)
class ErrorParts:
    """Each pixel's contribution to error², (H, W), relative to three reference brightnesses R of the pixel.

    A contribution is the variance of the pixel's mean divided by ``R² + (0.1 m)²``, with m the mean of the image. The
    three arrays differ in R. With ``value``, error² is estimated. In ``lenient``, for the lower limit of the error, R
    includes the pixel itself and leans to the brightest half of its neighbourhood. In ``cautious``, for the upper
    limit, R excludes the pixel.
    """

    value: Floats
    lenient: Floats
    cautious: Floats
    moved: float
    """Variance of ``value``, per pixel, that is due to the noise of the references R."""


def error_parts(pixels: PixelStatistics, m: float, least: Floats | None = None) -> ErrorParts:
    """Return each pixel's contribution to error², relative to three reference brightnesses of the pixel.

    The mean of the contributions over pixels is error². ``pixels`` are the statistics of the image, and ``m`` is the
    mean of the image over pixels and channels. ``least`` (H, W, 3) is light that is certainly in each pixel; no
    reference is below it. The noise of the references adds variance (`ErrorParts.moved`), by the delta method. The
    noise of pixel j moves the mean of the image and the local means around j, and so several contributions at once. The
    derivatives with respect to both kinds of means have the same sign, so their absolute values are added.
    """
    contributions, sums = error_contributions(pixels.mean, pixels.variance, pixels.samples, error_floor(m), least)
    influence = 0.02 * m * sums["slopes"] / pixels.mean.size
    by_means = 2.0 * influence * sums["crossed"] + influence**2 * sums["means_squared"]
    value, lenient, cautious = contributions
    return ErrorParts(value, lenient, cautious, (sums["locals_squared"] + by_means) / pixels.samples.size)


def _spread(contributions: Floats, degrees: float) -> float:
    """Return the variance of one contribution, as half the mean square difference of adjacent ones.

    Differences of neighbours leave out most variation of the picture itself. Fewer than 30 contributions could show
    less than even the variance of Gaussian noise, so that variance is their lower limit.
    """
    steps = [np.square(np.diff(contributions, axis=axis)) for axis in (0, 1)]
    pairs = sum(step.size for step in steps)
    spread = 0.5 * float(sum(step.sum() for step in steps)) / pairs if pairs else 0.0
    if contributions.size < 30:
        spread = max(spread, 2.0 / degrees * float(contributions.mean()) ** 2)
    return spread
