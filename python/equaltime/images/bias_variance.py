"""Bias and variance of an estimator, measured separately from renders with independent seeds.

Let D_r = I_r - R be the difference of render r from the reference image R, and v the variance of R. The brackets <x>
divide x by the denominator of relMSE (`equaltime.images.metrics`), and take the mean over pixels and channels:

- bias² = mean over pairs r ≠ s of <D_r D_s> - <v>. Independent renders share only the bias and R's noise.
- variance = mean over r of <D_r²> - mean over pairs of <D_r D_s>. This is the sample variance of one render.

Both estimates are unbiased, and their sum is the expected relMSE of one render. For K renders, only the K x K matrix
<D_r D_s> is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.images.metrics import Reference, reference_doubt
from equaltime.statistics.intervals import UNKNOWN, Interval, exp, few, jackknife, student

__all__ = ["BiasVariance", "reduced", "relmse_of_parts"]

Floats = NDArray[np.float64]


def reduced(values: NDArray[Any], longest: int) -> Floats:
    """Return the image ``values`` (H, W, …) reduced until no side exceeds ``longest`` pixels.

    Each new pixel is the mean of a block of pixels. Rows and columns at the end that fill no block are dropped. A
    small image is returned unchanged.
    """
    factor = math.ceil(max(values.shape[:2]) / longest)
    if factor == 1:
        return values
    down, across = (min(factor, size) for size in values.shape[:2])
    rows, columns = values.shape[0] // down, values.shape[1] // across
    blocks = values[: rows * down, : columns * across].reshape(rows, down, columns, across, *values.shape[2:])
    return np.asarray(blocks.mean(axis=(1, 3)))


@dataclass(frozen=True)
class BiasVariance:
    """Squared bias and variance of one render, with intervals. Both are relative squares: 0.0004 is (2 %)²."""

    bias2: Interval
    """Squared bias. Without any bias, its estimate scatters around 0 and may be negative."""
    variance: Interval
    """Variance of one render."""
    shared: float = 0.0
    """Standard error of relMSE due to the reference's noise; the resulting deviation is common to all renders."""


def relmse_of_parts(images: ArrayLike, reference: Reference) -> BiasVariance:
    """Return the bias² and the variance of one render, from K renders (K, H, W, 3) that differ only in their seeds.

    Intervals come from the jackknife over renders. The interval of bias² is corrected, because the jackknife counts the
    noise of pairs twice (see `_pairs_variance`). That interval also includes the reference's noise, which all renders
    share. Both values are unknown if K is 1 or if a pixel is not finite.
    """
    stack = np.asarray(images, np.float64)
    repeats = len(stack)
    gram = _gram(stack, reference)
    if repeats < 2 or not np.isfinite(gram).all():
        reason = "one render cannot tell bias from variance" if repeats < 2 else "a pixel is not finite"
        return BiasVariance(UNKNOWN.doubted(reason), UNKNOWN.doubted(reason))

    bias2 = _pairs_mean(gram, np.ones(repeats)) - reference.relmse
    variance = _variance(gram)
    spread, degrees = _pairs_variance(gram)
    doubt = _shared_doubt(stack.mean(axis=0), reference, max(bias2, 0.0), variance.value / repeats)
    half = student(max(degrees, 1.0)) * math.hypot(math.sqrt(spread), doubt)
    return BiasVariance(few(Interval(bias2, bias2 - half, bias2 + half), repeats), variance, doubt)


def _variance(gram: Floats) -> Interval:
    """Return the variance of one render, with the jackknife's interval of its logarithm: 6 % too wide for 8 renders."""
    repeats = len(gram)

    def log_variance(kept: Floats) -> float:
        variance = float(kept @ np.diag(gram)) / kept.sum() - _pairs_mean(gram, kept)
        return math.log(variance) if variance > 0.0 else math.nan

    if np.ptp(gram) <= 1e-12 * abs(gram).max():
        return few(Interval(0.0, 0.0, 0.0), repeats)
    return jackknife(log_variance, repeats).map(exp)


def _shared_doubt(mean: Floats, reference: Reference, bias2: float, variance: float) -> float:
    """Return the standard error that the reference's noise n causes in bias².

    The varying part is ``-2 b n + n² - v`` with b the bias. The mean image also has noise, of relative square
    ``variance``. The product of that noise with n differs from render to render, and so is in their spread.
    """
    if not reference.noisy:
        return 0.0
    share = bias2 / (bias2 + variance) if bias2 > 0.0 else 0.0
    return math.sqrt(share * reference_doubt(mean, reference) ** 2 + reference.relmse_doubt**2)


def _gram(stack: Floats, reference: Reference) -> Floats:
    root = np.sqrt(np.maximum(reference.denominator, np.finfo(np.float64).tiny))
    differences = ((stack - reference.mean) / root).reshape(len(stack), -1)
    gram: Floats = differences @ differences.T / differences.shape[1]
    return gram


def _pairs_mean(gram: Floats, kept: Floats) -> float:
    """Return the mean of the matrix over pairs of different kept renders (weights 0 or 1)."""
    count = float(kept.sum())
    if count < 2.0:
        return math.nan
    return float(kept @ gram @ kept - kept @ np.diag(gram)) / (count * (count - 1.0))


def _pairs_variance(gram: Floats) -> tuple[float, float]:
    """Return the variance of the mean over pairs, and its degrees of freedom.

    A pair's product is decomposed as mean + a_r + a_s + e_rs (Hoeffding 1948). The mean over pairs has the variance 4
    var(a) / K + 2 var(e) / (K (K - 1)). The jackknife has the first term right, but gives 4 var(e) / (K (K - 2)) for
    the second. That is more than twice too much, which matters where there is no bias and so no a. With four renders or
    more var(e) is known from the residuals of a_r + a_s; with fewer the jackknife stands. The degrees are by
    Satterthwaite (1946); the first term, a difference, is noisier than its size says.
    """
    repeats = len(gram)
    if repeats < 3:
        return math.inf, 1.0
    rows = (gram.sum(axis=1) - np.diag(gram)) / (repeats - 1)
    mean = float(rows.mean())
    jackknifed = 4.0 * (repeats - 1) / (repeats * (repeats - 2) ** 2) * float(np.square(rows - mean).sum())
    if repeats == 3:
        return jackknifed, 2.0
    others, pairs = repeats * (repeats - 3) / 2, _pair_residual(gram)
    by_pairs = 2.0 * pairs / (repeats * (repeats - 1))
    counted = 4.0 * pairs / (repeats * (repeats - 2))
    by_renders = max(jackknifed - counted, 0.0)
    noise = (by_renders + 0.5 * min(by_renders, counted)) ** 2 / (repeats - 1)
    total = by_renders + by_pairs
    return total, total**2 / (noise + by_pairs**2 / others) if total > 0.0 else others


def _pair_residual(gram: Floats) -> float:
    """Return var(e) of `_pairs_variance`; needs four renders or more."""
    repeats = len(gram)
    rows = (gram.sum(axis=1) - np.diag(gram)) / (repeats - 1)
    own = (rows - rows.mean()) * (repeats - 1) / (repeats - 2)
    left = (gram - rows.mean() - own[:, None] - own[None, :])[np.triu_indices(repeats, 1)]
    return float(left @ left) / (repeats * (repeats - 3) / 2)
