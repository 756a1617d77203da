"""A render's own estimate of its error, from independent replicates.

Sample ``i`` of a pixel belongs to replicate ``i mod R``. Replicates use independent randomisations, so the spread of
their means is an honest measure of the error of the image under any sampler; the sample variance inside a replicate
is not (low-discrepancy points are correlated on purpose), and is not used here.

Definition: ``error² = mean over pixels and RGB of Var(I) / (R² + (0.1 m)²)`` with ``Var(I)`` the estimated variance of
the pixel, ``R`` the 7x7 local mean of the image (which gives way to the pixel itself where the picture has structure,
see `_reference`) and ``m`` the mean of the image. All arrays are float64 here, indexed ``[y, x, channel]``, in the
units of the image.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film import box_sum, join_replicates
from equaltime.neighbourhoods import RADIUS, Band, neighbours, over_bands
from equaltime.tails import tail_of_one

__all__ = ["Estimate", "PixelStatistics", "error_parts", "image_error", "pixel_statistics", "standard_error"]

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


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval; ``inf`` where nothing can be known."""

    value: float
    low: float
    high: float
    doubt: str = ""
    """Why the upper limit cannot be trusted; empty where it can (`equaltime.tails`)."""

    @property
    def trusted(self) -> bool:
        """Whether the interval may be relied on."""
        return not self.doubt

    @property
    def known(self) -> bool:
        """Whether there is an estimate at all."""
        return math.isfinite(self.value)

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers for JSON, which has no infinity: unknown is ``None``; and the doubt, if there is one."""
        numbers = {"value": self.value, "low": self.low, "high": self.high}
        known = {key: number if math.isfinite(number) else None for key, number in numbers.items()}
        return known | ({"doubt": self.doubt} if self.doubt else {})

    def __str__(self) -> str:
        if not self.known:
            return "unknown"
        high = f"{100 * self.high:.3g}" if math.isfinite(self.high) else "unknown"
        return f"{100 * self.value:.3g} % [{100 * self.low:.3g}, {high}]"


UNKNOWN = Estimate(math.inf, 0.0, math.inf)


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
    result = np.empty(pixels.mean.shape, np.float32)

    def pool(band: Band) -> None:
        with np.errstate(over="ignore"):  # beyond 3e38 a float32 is infinite
            result[band.rows] = np.sqrt(_pooled_variance(pixels, band.wide)[band.inner])

    over_bands(len(result), RADIUS, pool)
    return result


def _pooled_variance(pixels: PixelStatistics, rows: slice) -> Floats:
    """Return the square of `standard_error` for some rows; those within 3 of a cut are not valid."""
    variance, counts = pixels.variance[rows], pixels.samples[rows, :, None].astype(np.float64)
    known = np.isfinite(variance[..., :1])
    if known.all() and (counts == counts.flat[0]).all():  # as nearly always: the rest is several times as slow
        return np.asarray(box_sum(variance) / neighbours(*counts.shape[:2]))
    per_sample = box_sum(np.where(known, variance, 0.0) * counts)
    pooled = per_sample / np.maximum(box_sum(known.astype(np.float64)) * counts, 1.0)
    return np.where(known, pooled, np.inf)


def image_error(
    pixels: PixelStatistics, level: float = 0.95, hidden: Callable[[PixelStatistics, float], float] | None = None
) -> Estimate:
    """Estimate the error of the image by the definition at the top of this file.

    The interval is meant to hold the *realised* error of this very image in 95 % of renders (or another ``level``). It
    is formed on the logarithm from the variance of the estimate, that of the realised error (the square of a Gaussian
    varies by twice its mean's square, and no less than its estimate from two replicates does), and the doubt about the
    reference. Few effective contributions call for Student's t. The doubt is no matter of chance: it does not grow with
    the level, and differs for both sides, since a reference that leans to the dark overestimates more than it misses.

    Unknown (value and upper limit ``inf``) while a pixel has samples in fewer than two replicates. A black image has
    value 0 and the upper limit ``inf``: nothing was seen, so nothing is known. Light paths that no sample has found yet
    are beyond any estimate made from the samples: ``hidden`` (`equaltime.unseen`) tells what part of error² black
    pixels may hide at a level, which widens the upper limit. Where single pixels make much of the error, so
    that what was not seen may make more, the estimate says so: its upper limit is in doubt.
    """
    seen = _seen_error(pixels, level)
    if hidden is None or not math.isfinite(seen.high):
        return seen
    return replace(seen, high=math.hypot(seen.high, math.sqrt(hidden(pixels, level))))


def _seen_error(pixels: PixelStatistics, level: float) -> Estimate:
    """Return the error by what samples have seen."""
    if pixels.variance.size == 0 or not np.isfinite(pixels.variance).all():
        return UNKNOWN
    sizes = neighbours(*pixels.samples.shape)
    m = float(pixels.mean.mean())
    if m == 0.0:
        return Estimate(0.0, 0.0, math.inf)
    contributions, moved, leant, smooth = error_parts(pixels, sizes, m)
    square = float(contributions.mean())
    if square == 0.0:
        return Estimate(0.0, 0.0, 0.0)
    spread = _spread(contributions, pixels.degrees)
    realised = max(spread, 2.0 / (1.0 + 2.0 / pixels.degrees) * float(np.square(contributions).mean()))
    estimated, realised = (v / (contributions.size * square**2) for v in (spread + moved, realised))
    value = math.sqrt(square)
    effective = min(contributions.size * pixels.degrees, 2.0 / estimated)
    tail = tail_of_one(contributions)
    if effective < 1.0:
        return Estimate(value, 0.0, math.inf, tail.doubt)
    deviation = 0.5 * math.sqrt(estimated + realised)
    chance = _quantile(level, effective) * deviation
    # of even noise in two replicates, the deviation is one over the root of the number of pixels
    skewed = min(max(0.5 * (deviation * math.sqrt(contributions.size) - 1.0), 0.0), 1.0)
    both = _BOTH_ABOVE * leant * smooth
    above = math.hypot(_LEANING_ABOVE * leant * skewed, _SMOOTH_ABOVE * smooth, both, _LEAST_DOUBT)
    below = math.hypot(_LEANING_BELOW * leant, _SMOOTH_BELOW * smooth, _LEAST_DOUBT)
    low, high = math.exp(-math.hypot(chance, _Z95 * below)), math.exp(math.hypot(chance, _Z95 * above))
    return Estimate(value, value * low, value * high, tail.doubt)


def _quantile(level: float, degrees: float) -> float:
    """Return the two-sided quantile of Student's t, or of the normal distribution where they hardly differ."""
    if degrees >= _MANY:
        return NormalDist().inv_cdf(0.5 + 0.5 * level)
    from scipy.special import stdtrit  # here, since it takes a tenth of a second to load

    return float(stdtrit(degrees, 0.5 + 0.5 * level))


def error_parts(pixels: PixelStatistics, sizes: Floats, m: float) -> tuple[Floats, float, float, float]:
    """Return each pixel's part of error², (H, W), and three things about the denominators.

    The first is the variance per pixel that their noise adds. By the delta method: pixel j moves the local means around
    it, and m, by its own noise; all contributions there share that. Both derivatives have one sign, so the parts add up
    in absolute value. The others are how far R's lean moves the logarithm of the error, and the share of the error,
    weighed by the noise, where R is the local mean.
    """
    contributions = np.empty(pixels.samples.shape)
    even = bool((pixels.samples == pixels.samples.flat[0]).all())

    def contribute(band: Band) -> tuple[float, ...]:
        variance, counts = pixels.variance[band.wide], sizes[band.wide]
        noise = box_sum(variance)
        reference, shared, leaning = _reference(pixels.mean[band.wide], variance, noise, counts)
        square = np.square(reference)
        square += (0.1 * m) ** 2
        parts = variance / square
        contributions[band.rows] = _channel_mean(parts[band.inner])
        noisy = np.minimum(parts * np.sqrt(parts), parts)  # structure that rests on the local mean is below the noise
        smooth = _dot(noisy[band.inner], shared[band.inner])
        slope = np.divide(parts, square, out=square)
        slopes = float(slope[band.inner].sum())
        slope *= reference
        leant = _dot(slope[band.inner], leaning[band.inner])
        pooled = noise / counts if even else _pooled_variance(pixels, band.wide)
        error = np.sqrt(pooled[band.inner])
        shared *= slope
        shared /= 0.5 * counts
        by_local = _channel_mean(box_sum(shared)[band.inner] * error)
        by_mean = _channel_mean(error)
        products = ((by_local, by_local), (by_local, by_mean), (by_mean, by_mean))
        return slopes, smooth, leant, *(_dot(a, b) for a, b in products)

    sums = over_bands(len(contributions), 3 * RADIUS, contribute)
    slopes, smooth, leant, locals_squared, crossed, errors_squared = (sum(column) for column in zip(*sums, strict=True))
    influence = 0.02 * m * slopes / pixels.mean.size
    total = locals_squared + 2.0 * influence * crossed + influence**2 * errors_squared
    whole = max(3.0 * float(contributions.sum()), np.finfo(np.float64).tiny)
    return contributions, total / contributions.size, leant / whole, smooth / whole


def _dot(a: Floats, b: Floats) -> float:
    """Return the sum of products; not by BLAS, whose threads would wait for those of the bands."""
    return float(np.einsum("i,i->", a.reshape(-1), b.reshape(-1)))


def _channel_mean(values: Floats) -> Floats:
    """Return the mean over the last axis, of three, several times as fast as NumPy does."""
    return np.asarray((values[..., 0] + values[..., 1] + values[..., 2]) / 3.0)


def _reference(mean: Floats, variance: Floats, noise: Floats, sizes: Floats) -> tuple[Floats, Floats, Floats]:
    """Return R for the denominators, the share of the local mean in it, and its lean, below.

    R weighs the pixel against the 7x7 local mean by how much of the local scatter is more than the noise, as Lee's
    filter does (Lee 1980): at an edge the local mean is wrong by much, and the pixel by little once it has converged.
    Noise is skewed: a pixel that has met a rare bright path has a large variance and is itself too bright, and would
    excuse itself. So R leans from the pixel towards the darker of two replicates (which is its standard error below
    it), half way. ``noise`` is the sum of the variance over the neighbourhood.
    """
    local = box_sum(mean)
    local /= sizes
    apart = mean - local
    scatter = box_sum(np.square(apart))
    rest = np.divide(noise, scatter, out=np.ones_like(noise), where=scatter > 0.0)  # what the weight leaves to 1
    np.minimum(rest, 1.0, out=rest)
    weight = 1.0 - rest
    apart *= weight
    local += apart
    lean = np.sqrt(variance)
    lean *= weight
    local -= 0.5 * lean
    return np.maximum(local, 0.0, out=local), rest, lean


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
