"""Distance of an image from the truth, which is known from a reference with noise.

All images are (H, W, 3) linear RGB. Let I be the image, R the reference, m the mean of R over pixels and channels, and
v the variance of R. A mean is over pixels and channels:

- ``relmse``  mean of ((I - R)² - v) / (R² + (0.1 m)²): the square of ``error``;
- ``error``   square root of |relmse|, with the sign of relmse: 0.02 is 2 %;
- ``mse``     mean of (I - R)² - v, in squared units of the image;
- ``mare``    mean of |I - R| / (|R| + 0.1 m);
- ``flip``    HDR-FLIP, see `flip`.

The first three metrics subtract v, and so contain no noise of the reference on average. The reason is that the noises
of I and R are independent: the expectation of (I - R)² over references is (I - T)² + v, with T the truth. Near
convergence, these metrics can be negative. A negative value is kept, because replacing it by 0 would bias the average
over repeats. The noise cannot be subtracted from ``mare`` and ``flip``, which have bounds instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.film.sums import error_floor
from equaltime.film.tails import MOST_RATIO, MOST_SHARE, Tail, outstanding, tail_of
from equaltime.images.flip import flip
from equaltime.statistics.intervals import Z95, Interval, signed_root

__all__ = [
    "METRICS",
    "MOST_RATIO",
    "Metric",
    "Reference",
    "Tail",
    "contributions",
    "divided",
    "measure",
    "reference_doubt",
    "squared_errors",
    "tail_of",
]

Floats = NDArray[np.float64]

Metric = Literal["error", "relmse", "mse", "mare", "flip"]

METRICS: tuple[Metric, ...] = get_args(Metric)


@dataclass(frozen=True, eq=False)
class Reference:
    """An image that stands for the truth when errors are measured, with its noise. All arrays are float64 (H, W, 3)."""

    mean: Floats
    variance: Floats
    """Variance of ``mean``; zeros if the mean is exact or the variance is unknown."""
    halves: tuple[Floats, Floats] | None = None
    """Two independent references with half of the samples each, whose average is ``mean``; None if there are none."""

    @classmethod
    def of_images(cls, images: ArrayLike) -> Reference:
        """Return the reference that is the mean of ``images``, K independent renders (K, H, W, 3) by one strategy.

        K is 2 or more. The variance comes from the scatter between the renders. If K is even, ``halves`` are the means
        of the first and of the last K / 2 renders.
        """
        stack = np.asarray(images, np.float64)
        middle = len(stack) // 2
        halves = None if len(stack) % 2 else (stack[:middle].mean(axis=0), stack[middle:].mean(axis=0))
        return cls(stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(stack), halves)

    @property
    def denominator(self) -> Floats:
        """Denominator of the relative squared error, (H, W, 3).

        Let D = R² + (0.1 m)², where R is the reference, and m the mean of R over pixels and channels. Without noise,
        the denominator is D. If R has the variance v, 1 / D is too large on average, by the factor
        1 + v (4 R² / D - 1) / D to second order. The denominator is then D times this factor.
        """
        square = self.mean**2
        plain: Floats = square + error_floor(self.mean.mean())
        curvature = divided(self.noise, plain) * (4.0 * divided(square, plain) - 1.0)
        return np.asarray(plain * (1.0 + np.maximum(curvature, -0.5)))

    @property
    def noise(self) -> Floats:
        """Variance (H, W, 3) of the reference, to subtract from an image's squared differences.

        If ``variance`` is zero everywhere and ``halves`` are given, the variance is estimated from their difference.
        """
        if self.halves is None or self.variance.any():
            return self.variance
        return (0.5 * (self.halves[0] - self.halves[1])) ** 2

    @property
    def noisy(self) -> bool:
        """Whether the reference has known noise: True if ``noise`` is above zero in any pixel."""
        return bool(self.noise.any())

    @property
    def relmse(self) -> float:
        """Relative mean squared error of the reference itself, due to its noise; one number.

        Without a correction, the measured relMSE of any image would be too large by this amount on average.
        """
        return float(divided(self.noise, self.denominator).mean())

    @property
    def relmse_doubt(self) -> float:
        """Standard error that the reference's noise leaves in a relMSE; one number.

        The reference's variance v is subtracted from squared differences. Let n be the reference's noise, R minus the
        truth. On average n² equals v, but not in each pixel. The result is the standard error of the mean over pixels
        of (n² - v) / D. Here D is the denominator of relMSE, and pixels are assumed to be independent. Half the
        difference of the two ``halves`` has the same distribution as n. Its square minus v therefore shows the spread
        of n² - v, without an assumption on the distribution or the correlation of channels. Without ``halves``, or if v
        itself comes from them, the noise is assumed to be normal with fully correlated channels.
        """
        if self.halves is not None and self.variance.any():
            parts = divided((0.5 * (self.halves[0] - self.halves[1])) ** 2 - self.noise, self.denominator)
            return math.sqrt(float(np.square(parts.sum(axis=2)).sum())) / parts.size
        parts = divided(self.noise, self.denominator)
        degrees = 2.0 if self.halves is None else 4.0  # v from one difference varies as n² does
        return math.sqrt(degrees * float(np.square(parts.sum(axis=2)).sum())) / parts.size

    @property
    def has_heavy_tail(self) -> bool:
        """Whether one pixel makes so much of the reference's own squared error that `relmse` cannot be trusted.

        The limit is the one of strategies, `equaltime.film.tails.MOST_SHARE`. As in a single render, only the excess
        over the noise of the neighbours counts (`equaltime.film.tails.outstanding`).
        """
        return outstanding(divided(self.noise, self.denominator).mean(axis=2)) > MOST_SHARE


def measure(image: ArrayLike, reference: Reference, metrics: Iterable[Metric] = METRICS) -> dict[str, Interval]:
    """Return the distance of an image (H, W, 3) from the truth in several ``metrics``, as a dict by the metric's name.

    The metrics are the relative mean squared error ``relmse``, its root ``error`` (0.02 is 2 %), the mean squared error
    ``mse``, the mean absolute relative error ``mare``, and HDR-FLIP ``flip``. The first three subtract the reference's
    noise, so they may be negative.

    Each interval holds the distance of this very image, and its width is due to the reference's noise. The limits of
    error, relmse and mse are at 95 %. The limits of mare and flip hold on average over references. Limits are infinite,
    and not trusted, if the reference's noise is not known.

    All metrics are NaN for an image with a pixel that is not finite. Against a black reference, relative metrics are 0
    for a black image, and infinite for any other image.

    Raises
    ------
    ValueError
        If the shapes differ or are not (H, W, 3), or if the reference has a pixel that is not finite.
    """
    pixels = np.asarray(image, np.float64)
    _check(pixels, reference)
    if not np.isfinite(pixels).all():
        return dict.fromkeys(metrics, _without_limits(math.nan))
    functions: dict[str, Callable[[Floats, Reference], Interval]] = {
        "error": lambda i, r: _square(i, r, relative=True).map(signed_root),
        "relmse": lambda i, r: _square(i, r, relative=True),
        "mse": lambda i, r: _square(i, r, relative=False),
        "mare": _absolute,
        "flip": _flip,
    }
    return {name: functions[name](pixels, reference) for name in metrics}


def contributions(image: ArrayLike, reference: Reference) -> Floats:
    """Return a map of the error of ``image``: the relative squared error of each pixel, (H, W).

    The variance of ``reference`` is subtracted from squared differences. A pixel's value is the mean over its channels,
    and may be negative. The mean over pixels is relMSE.
    """
    pixels = np.asarray(image, np.float64)
    _check(pixels, reference)
    parts: Floats = divided((pixels - reference.mean) ** 2 - reference.noise, reference.denominator).mean(axis=2)
    return parts


def _square(pixels: Floats, reference: Reference, relative: bool) -> Interval:
    denominator = reference.denominator if relative else np.ones_like(pixels)
    value = float(divided((pixels - reference.mean) ** 2 - reference.noise, denominator).mean())
    if not reference.noisy:
        return _without_limits(value)
    half = Z95 * reference_doubt(pixels, reference, relative)
    return Interval(value, value - half, value + half)


def reference_doubt(pixels: Floats, reference: Reference, relative: bool = True) -> float:
    """Return the standard error that the noise of ``reference`` causes in an image's relMSE, one number.

    ``pixels`` (H, W, 3) is the image. If ``relative`` is False, the result is for the MSE instead of relMSE.

    Let I be the image, R the reference, n its noise and T the truth. The delta method is used: the noise changes the
    squared differences, their denominators, and the reference's mean in the denominators. It needs I - T, which is
    unknown and replaced by I - R. Since I - R contains n, the result also counts the variation of n², and is rather too
    large. The excess is small if the reference is better than the image.

    Pixels are assumed to be independent. The reference's ``halves`` R1 and R2 show the correlation of a pixel's
    channels, since (R1 - R2) / 2 has the distribution of n. Without halves, channels are assumed to be fully
    correlated.
    """
    difference = pixels - reference.mean
    slope = -2.0 * difference
    if relative:
        denominator, m = reference.denominator, float(reference.mean.mean())
        by_denominator = -divided(divided(difference**2, denominator), denominator)
        slope = divided(slope, denominator) + 2.0 * reference.mean * by_denominator + 0.02 * m * by_denominator.mean()
    if reference.halves is not None:
        moved = slope * (0.5 * (reference.halves[0] - reference.halves[1]))
    else:
        moved = np.abs(slope) * np.sqrt(reference.noise)
    return math.sqrt(float((moved.sum(axis=2) ** 2).sum())) / pixels.size


def _absolute(pixels: Floats, reference: Reference) -> Interval:
    """Bound by the triangle inequality: | |I - R| - |I - T| | is at most |n|."""
    denominator = np.abs(reference.mean) + 0.1 * abs(float(reference.mean.mean()))
    value = float(divided(np.abs(pixels - reference.mean), denominator).mean())
    if not reference.noisy:
        return _without_limits(value)
    noise = np.sqrt(reference.noise)  # no less than the mean of |n| whatever its distribution
    if reference.halves is not None:
        noise = 0.5 * np.abs(reference.halves[0] - reference.halves[1])
    return _bounded(value, float(divided(noise, denominator).mean()))


def _flip(pixels: Floats, reference: Reference) -> Interval:
    """Bound by FLIP between the reference and its halves, which differ as the reference does from the truth."""
    value = flip(pixels, reference.mean)
    if reference.halves is None:
        return _without_limits(value)
    return _bounded(value, max(flip(half, reference.mean) for half in reference.halves))


def _without_limits(value: float) -> Interval:
    """Return a metric of which the reference tells no limits."""
    return Interval(value, -math.inf, math.inf).doubted("the noise of the reference is not known")


def _bounded(value: float, doubt: float) -> Interval:
    return Interval(value, max(value - doubt, 0.0), value + doubt)


def divided(numerator: Floats, denominator: Floats) -> Floats:
    """Return ``numerator / denominator``, element by element, with 0 / 0 = 0.

    The case 0 / 0 occurs in black pixels of a black reference.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio: Floats = np.where(numerator == 0.0, 0.0, numerator / denominator)
    return ratio


def _check(pixels: Floats, reference: Reference) -> None:
    shape = reference.mean.shape
    if pixels.shape != shape or pixels.ndim != 3 or shape[-1] != 3:
        raise ValueError(f"an image of shape {pixels.shape} cannot be measured against one of shape {shape}")
    if not np.isfinite(reference.mean).all():
        raise ValueError("the reference has a pixel that is not finite")


def squared_errors(images: Iterable[ArrayLike], reference: Reference) -> NDArray[np.float64]:
    """Return the relative squared error of every pixel of K images (H, W, 3), as an array (K, H * W).

    A pixel's value is the mean over R, G and B. The reference's variance is not subtracted. The result is for tests of
    heavy tails, which look for single pixels with large errors in single images.
    """
    denominator = np.maximum(reference.denominator, np.finfo(np.float64).tiny)
    squares = (np.square(np.asarray(image, np.float64) - reference.mean) / denominator for image in images)
    return np.stack([square.mean(axis=2).ravel() for square in squares])
