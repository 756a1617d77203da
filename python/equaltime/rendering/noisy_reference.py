"""Error of an image against a reference that is itself a noisy render, and the interval due to the noise.

With I the image, R the reference and v the variance of R, ``((I - R)² - v) / D`` averages to the image's relMSE
(`equaltime.images.metrics`) if D is free of noise. Two conditions must hold where R has few samples:

- v is the pixel's own variance, from the replicates of the reference. It is noisy, but right on average. The ``stderr``
  channel is an average over 7x7 pixels: beside a lamp it is the lamp's noise, while D belongs to a dark pixel. If a
  file has only that channel, its variance is distributed within the neighbourhood in proportion to (I - R)².
- D comes from a filtered estimate of the truth. The reference alone is not enough: where it missed by chance a light
  that the image met, its D is near 0. So image and reference are averaged with the weights that minimise the noise of
  the mean. The image's weight is ``w = v / (I - R)²``, by means over the 7x7 neighbourhood. The mean is filtered as by
  Lee (1980), which keeps structure that is stronger than the noise.

The interval combines two uncertainties. The first is found by the delta method: how the noise of each pixel moves the
result. The second stands for noise that v does not show, since rare light was in neither replicate. This second
uncertainty is the scatter of means over 4x4 blocks, times a factor. The scatter contains all effects of chance on the
squares of this image and of R. The factor is the fraction of the scatter that R may have contributed. If R makes a
share q of the squared differences, and its noise lies where they are large, the factor is ``2 sqrt(q) / (1 + q)``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics
from equaltime.film.parts_of_merge import statistics_of
from equaltime.film.sums import box_sum, error_floor, neighbours
from equaltime.images.image_files import Picture
from equaltime.images.metrics import divided
from equaltime.rendering.render_file import SavedFilm
from equaltime.statistics import agreement
from equaltime.statistics.intervals import Z95, Interval, student

__all__ = ["FEWEST_BLOCKS", "Difference", "Noise", "block_means", "log_ratio"]

Floats = NDArray[np.float64]

_BLOCK = 4
FEWEST_BLOCKS = 16
"""Least number of blocks of 4x4 pixels for a trusted ratio of errors: the scatter of fewer blocks is too uncertain."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Variances of the pixels of a noisy image, which are subtracted when the image serves as a reference."""

    variance: Floats
    """(H, W, 3): variance of each pixel and channel."""
    pooled: bool
    """Whether each variance is a mean over the 7x7 neighbourhood."""

    @classmethod
    def of_render(cls, picture: Picture, film: SavedFilm) -> Noise | None:
        """Return the variances of a picture's pixels, from its samples, or else from its standard errors.

        ``picture`` and ``film`` (the samples) come from one file. The result is None if the file has neither samples
        nor finite standard errors.
        """
        moments, parts, second = film
        if moments is None:
            return cls.of(picture, None)
        return cls.of(
            picture,
            statistics_of(moments, None if parts is not None and parts.shape != moments.shape[1:] else parts, second),
        )

    @classmethod
    def of(cls, picture: Picture, pixels: PixelStatistics | None) -> Noise | None:
        """Return the variances of a picture's pixels, from the statistics ``pixels`` if they belong to the same image.

        Otherwise the variances come from the picture's standard errors, which are means over 7x7 pixels if equaltime
        wrote them. The result is None if the picture has no standard errors, or if some are not finite.
        """
        theirs = pixels is not None and np.array_equal(pixels.mean.astype(np.float32), picture.image)
        if pixels is not None and theirs and np.isfinite(pixels.variance).all():
            return cls(pixels.variance, False)
        errors = picture.standard_error
        if errors is None or not np.isfinite(errors).all() or (errors < 0.0).any():
            return None
        return cls(np.square(errors.astype(np.float64)), bool(picture.record))

    def shared_out(self, square: Floats) -> Floats:
        """Return the variance of each single pixel, (H, W, 3).

        Variances that are means over 7x7 pixels are divided among the pixels in proportion to ``square``, the squared
        differences between image and reference (H, W, 3). Other variances are returned unchanged.
        """
        return divided(self.variance * square, _local(square)) if self.pooled else self.variance


@dataclass(frozen=True, eq=False)
class _Filtered:
    """An image in which noise is averaged over the neighbourhood and structure is kept."""

    value: Floats
    shared: Floats
    """Weight of the local mean in each value, in [0, 1]."""
    square: Floats
    """Denominator of relative squares, value² + (0.1 m)²."""

    @classmethod
    def of(cls, image: Floats, variance: Floats) -> _Filtered:
        """Filter as Lee (1980): by the share of the local scatter that the noise explains."""
        local = _local(image)
        scatter = _local(np.square(image - local))
        explained = np.divide(_local(variance), scatter, out=np.ones_like(scatter), where=scatter > 0.0)
        shared = np.minimum(explained, 1.0)
        value = np.maximum(local + (image - local) * (1.0 - shared), 0.0)
        return cls(value, shared, np.square(value) + error_floor(float(image.mean())))


@dataclass(frozen=True, eq=False)
class Difference:
    """Squared differences between an image and a noisy reference, whose mean is free of the reference's noise.

    All arrays are float64 (H, W, 3).
    """

    squares: Floats
    """Squared differences less the reference's variance, divided by the squares of the estimated truth; their mean is
    relMSE. Without that division their mean is MSE."""
    slopes: Floats
    """Derivative of the sum of ``squares`` with respect to the reference's value, in each pixel and channel."""
    variance: Floats
    """Variance of the reference in each pixel and channel."""
    share: float
    """Upper limit, in [0, 1], of the share of the reference's noise in the squared differences."""

    @classmethod
    def of(cls, image: Floats, reference: Floats, noise: Noise, relative: bool = True) -> Difference:
        """Return the squared differences between an image and a reference whose noise is ``noise``.

        If ``relative``, squares are divided by the squares of the truth, as estimated from both (relMSE). Otherwise
        they are not divided (MSE).
        """
        difference = image - reference
        square = np.square(difference)
        variance = noise.shared_out(square)
        slopes = -2.0 * difference
        if not relative:
            return cls(square - variance, slopes, variance, _share(image, reference, variance))
        by_channels = (_local(values.mean(axis=2, keepdims=True)) for values in (variance, square))
        weight = np.clip(divided(*by_channels), 0.0, 1.0)
        mean = (1.0 - weight) * reference + weight * image
        truth = _Filtered.of(mean, weight * (1.0 - weight) * square)
        by_denominator = -divided(divided(square, truth.square), truth.square)
        by_truth = 2.0 * truth.value * by_denominator
        count = neighbours(*image.shape[:2])
        slopes = divided(slopes, truth.square) + (1.0 - truth.shared) * by_truth
        slopes += box_sum(np.ascontiguousarray(truth.shared * by_truth / count))
        slopes += 0.02 * float(mean.mean()) * float(by_denominator.mean())
        return cls(divided(square - variance, truth.square), slopes, variance, _share(image, reference, variance))

    @property
    def value(self) -> float:
        """Mean of the squares, with the reference's noise subtracted.

        It is the relMSE, or the MSE if squares are not relative.
        """
        return float(self.squares.mean())

    @property
    def measured(self) -> Interval:
        """RelMSE, or MSE, with its 95 % interval; the value is NaN if the interval reaches down to 0.

        The upper limit is formed on the logarithm, as the sum of a few large squares is skewed. If the value is NaN,
        the upper limit is the mean of the squares, at least 0, plus e - 1 times the half-width. Both formulas agree
        where they meet.
        """
        value, half = self.value, _half_width(self.squares, self.slopes, self.variance, self.share)
        if not value > half:
            return Interval(math.nan, 0.0, max(value, 0.0) + (math.e - 1.0) * half)
        return Interval(value, value - half, value * math.exp(half / value))


def log_ratio(first: Difference, second: Difference) -> tuple[float, float]:
    """Return the logarithm of ``first.value / second.value``, and half the width of its 95 % interval.

    The ratio tells which of two images is nearer to one reference. The two values (relMSE or MSE) must be positive. The
    interval takes into account that the reference's noise moves both values.
    """
    squares, slopes = (
        getattr(first, name) / first.value - getattr(second, name) / second.value for name in ("squares", "slopes")
    )
    half = _half_width(squares, slopes, first.variance, max(first.share, second.share))
    return math.log(first.value / second.value), half


def _half_width(squares: Floats, slopes: Floats, variance: Floats, share: float) -> float:
    """Return half the width of the 95 % interval of the mean of squares; see the top of this file.

    Student's t has the degrees of freedom of sums to which few pixels, or few blocks, contribute most. The correlation
    of a pixel's channels is not known and taken to be full.
    """
    moved = np.square((np.abs(slopes) * np.sqrt(variance)).sum(axis=2))
    by_pixels = math.sqrt(float(moved.sum())) / squares.size * student(_degrees(moved))
    blocks = block_means(squares.mean(axis=2))
    if blocks.size < 2:
        return math.inf
    spread = np.square(blocks - blocks.mean())
    scatter = math.sqrt(float(spread.sum()) / (blocks.size - 1) / blocks.size)
    scatter *= student(min(_degrees(spread), blocks.size - 1.0))
    return math.hypot(by_pixels, 2.0 * math.sqrt(share) / (1.0 + share) * scatter)


def block_means(values: Floats) -> Floats:
    """Return the means of (H, W) values over blocks of 4x4 pixels, (blocks,).

    If a side of the image is below 16, each pixel is a block.
    """
    block = _BLOCK if min(values.shape) >= 4 * _BLOCK else 1
    return agreement.block_means(values, block, block).ravel()


def _share(image: Floats, reference: Floats, variance: Floats) -> float:
    """Return the upper limit, at 95 %, of the share of the reference's noise in the squared differences.

    Both are relative to the mean of image and reference, so that one bright pixel cannot dominate them. The noise of a
    pixel is known from few replicates, so its sum is uncertain where few pixels dominate it.
    """
    mean = 0.5 * (image + reference)
    square = np.square(mean) + error_floor(float(mean.mean()))
    noise = divided(variance, square).mean(axis=2)
    total, all_of_it = float(noise.sum()), float(divided(np.square(image - reference), square).mean(axis=2).sum())
    if not total > 0.0:
        return 0.0
    upper = total * math.exp(Z95 * math.sqrt(float(np.square(noise).sum())) / total)
    return min(upper / all_of_it, 1.0) if all_of_it > 0.0 else 1.0


def _degrees(squares: Floats) -> float:
    """Return the degrees of freedom of a sum of squares of normal deviates whose variances differ (Welch 1938).

    They are ``(Σ s)² / Σ s²`` of the variances; the square of one normal deviate has three times the mean square.
    """
    largest = float(squares.max(initial=0.0))
    scaled = squares / largest if largest > 0.0 else np.ones_like(squares)
    return max(3.0 * float(scaled.sum()) ** 2 / float(np.square(scaled).sum()), 1.0)


def _local(values: Floats) -> Floats:
    """Return the means over the 7x7 neighbourhoods."""
    means: Floats = box_sum(np.ascontiguousarray(values)) / neighbours(*values.shape[:2])
    return means
