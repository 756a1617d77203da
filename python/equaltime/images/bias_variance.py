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

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.images.metrics import Reference, reference_doubt
from equaltime.statistics.intervals import UNKNOWN, Interval, exp, few, jackknife, student
from equaltime.statistics.products import pairs_mean, pairs_variance

__all__ = ["BiasVariance", "relmse_of_parts"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BiasVariance:
    """Squared bias and variance of one render, with intervals.

    The bias is the part of the error that remains with more samples. Both numbers are relative squares: 0.0004 is (2
    %)².
    """

    bias2: Interval
    """Squared bias. Without any bias, its estimate scatters around 0 and may be negative."""
    variance: Interval
    """Variance of one render."""
    shared: float = 0.0
    """Standard error of relMSE due to the reference's noise; the resulting deviation is common to all renders."""


def relmse_of_parts(images: ArrayLike, reference: Reference) -> BiasVariance:
    """Return the bias² and the variance of one render, as relative squares, from K renders and a reference.

    ``images`` are the renders, (K, H, W, 3), which differ only in their seeds. Intervals come from the jackknife over
    renders. The interval of bias² is corrected, because the jackknife counts the noise of pairs of renders twice. That
    interval also includes the reference's noise, which all renders share. Both values are unknown (NaN) if K is 1 or if
    a pixel is not finite.
    """
    stack = np.asarray(images, np.float64)
    repeats = len(stack)
    gram = _gram(stack, reference)
    if repeats < 2 or not np.isfinite(gram).all():
        reason = "one render cannot tell bias from variance" if repeats < 2 else "a pixel is not finite"
        return BiasVariance(UNKNOWN.doubted(reason), UNKNOWN.doubted(reason))

    bias2 = pairs_mean(gram, np.ones(repeats)) - reference.relmse
    variance = _variance(gram)
    spread, degrees = pairs_variance(gram)
    doubt = _shared_doubt(stack.mean(axis=0), reference, max(bias2, 0.0), variance.value / repeats)
    half = student(max(degrees, 1.0)) * math.hypot(math.sqrt(spread), doubt)
    return BiasVariance(few(Interval(bias2, bias2 - half, bias2 + half), repeats), variance, doubt)


def _variance(gram: Floats) -> Interval:
    """Return the variance of one render, with the jackknife's interval of its logarithm: 6 % too wide for 8 renders."""
    repeats = len(gram)

    def log_variance(kept: Floats) -> float:
        variance = float(kept @ np.diag(gram)) / kept.sum() - pairs_mean(gram, kept)
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
