"""Statistics of K independent renders from the products of their images for all pairs of renders, (K, K).

The product of renders r and s is the mean over pixels of ``a_r b_s``: an image of render r times an image of render s.
The images may be differences from a reference. Products of two different renders are free of noise on average.
`equaltime.statistics.intervals.jackknife` needs each statistic for many subsets of renders, which is quick for (K, K)
numbers.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["covariance", "pairs_mean", "pairs_variance"]

Floats = NDArray[np.float64]


def pairs_mean(products: Floats, kept: Floats) -> float:
    """Return the mean of ``products`` (K, K) over pairs of different renders, which contains no noise on average.

    ``products[r, s]`` is the mean over pixels of image r times image s. ``kept`` (K,) is 1 for renders that count, else
    0. The mean is NaN for fewer than two renders.
    """
    count = float(kept.sum())
    if count < 2.0:
        return math.nan
    return float(kept @ products @ kept - kept @ np.diag(products)) / (count * (count - 1.0))


def covariance(products: Floats, kept: Floats) -> float:
    """Return the covariance of two images a and b from render to render, averaged over pixels.

    ``products`` (K, K) has the mean over pixels of ``a_r b_s`` at [r, s], for renders r and s. If a and b are the same
    image, the result is its variance. ``kept`` (K,) is 1 for renders that count, else 0. The divisor is their number
    less one. The covariance is NaN for fewer than two renders.
    """
    count = float(kept.sum())
    if count < 2.0:
        return math.nan
    same = kept @ np.diag(products)
    return float((same - kept @ products @ kept / count) / (count - 1.0))


def pairs_variance(products: Floats) -> tuple[float, float]:
    """Return the variance of ``pairs_mean(products, ...)`` over all K renders, and the variance's degrees of freedom.

    ``products`` (K, K) are means over pixels of products of two renders. A pair's product is decomposed as mean + a_r +
    a_s + e_rs (Hoeffding 1948). The mean over pairs has the variance 4 var(a) / K + 2 var(e) / (K (K - 1)). The
    jackknife has the first term right, but gives 4 var(e) / (K (K - 2)) for the second. That is more than twice the
    right value, which matters where there is no bias, so that a is 0. With four renders or more, var(e) is estimated
    from the residuals of a_r + a_s. With three, the jackknife's variance is returned, and with fewer, infinity. The
    degrees of freedom are by Satterthwaite (1946). The first term is a difference and therefore noisier than others of
    its size, so its variance is increased.
    """
    repeats = len(products)
    if repeats < 3:
        return math.inf, 1.0
    rows = (products.sum(axis=1) - np.diag(products)) / (repeats - 1)
    mean = float(rows.mean())
    jackknifed = 4.0 * (repeats - 1) / (repeats * (repeats - 2) ** 2) * float(np.square(rows - mean).sum())
    if repeats == 3:
        return jackknifed, 2.0
    others, pairs = repeats * (repeats - 3) / 2, _pair_residual(products)
    by_pairs = 2.0 * pairs / (repeats * (repeats - 1))
    counted = 4.0 * pairs / (repeats * (repeats - 2))
    by_renders = max(jackknifed - counted, 0.0)
    noise = (by_renders + 0.5 * min(by_renders, counted)) ** 2 / (repeats - 1)
    total = by_renders + by_pairs
    return total, total**2 / (noise + by_pairs**2 / others) if total > 0.0 else others


def _pair_residual(products: Floats) -> float:
    """Return var(e) of `pairs_variance`; needs four renders or more."""
    repeats = len(products)
    rows = (products.sum(axis=1) - np.diag(products)) / (repeats - 1)
    own = (rows - rows.mean()) * (repeats - 1) / (repeats - 2)
    left = (products - rows.mean() - own[:, None] - own[None, :])[np.triu_indices(repeats, 1)]
    return float(left @ left) / (repeats * (repeats - 3) / 2)
