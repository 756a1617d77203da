"""Tests of whether two renderers have the same expected image.

Both render the same scene with a box filter, many times with independent seeds (64 for a full comparison). Means over
square blocks of pixels are compared, since they are nearly normally distributed. Each block and channel gives a Welch
statistic, which is converted to a normal deviate z. Four tests of the z's share the false-alarm rate:

- *worst*: the largest |z| of all blocks and channels, which sees a mistake in one place;
- *mean*: the mean z of a channel, which sees a small bias with one sign everywhere;
- *squares*: the sum of a channel's z^2, which sees a bias of a fraction of a standard error in many blocks, whatever
  its signs, and standard errors that are too small;
- *shape*: the Anderson-Darling distance of a channel's z's from the normal distribution, the test behind a Q-Q plot.

The tests share one level by Šidák's formula, which is exact for independent tests. The tests here are dependent, so
their false-alarm rate is at most the level. A comparison of many scenes gives each the level `share(level, scenes)`,
fixed before any result is seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "LEVEL",
    "Agreement",
    "BlockMeans",
    "anderson_darling",
    "block_means",
    "compare",
    "compare_pair",
    "equality_test",
    "near_normal",
    "share",
    "sidak",
]

Array = NDArray[np.float64]

LEVEL = 0.001
"""False-alarm rate of a whole set of comparisons: the probability that any of them fails though all images agree."""
ROUNDING = 2e-6
"""Largest relative error that float32 may cause in a mean without noise."""
MOST_SKEWNESS = 0.1
"""Largest skewness of a block's mean over all repeats. By simulation with six repeats of sums of 20 to 130 rare events,
Welch's p-values of 0.001 to 1e-5 are then accurate within a third. With ten events, p-values of 1e-5 occur a thousand
times as often as they should."""
_EVENTS = 40.0
"""Degrees of freedom that nine of ten blocks of a pair of images need. With 10, p-values below 0.001 came in up to a
quarter of the pairs of unbiased renders whose samples rarely meet the lamp; with 40, in 1 of 240 pairs."""
_MISSED = 0.1
"""Probability that a difference of the size that `Agreement.least` tells is not found."""
_SHARE_BELOW, _FEWEST_ALONG = 0.1, 2
"""Share of blocks that may have fewer, and the fewest blocks along each side of an image."""


def sidak(p: float, looks: int) -> float:
    """Return the joint p-value of several tests from their smallest p-value ``p``, by Šidák's formula.

    ``looks`` is the number of tests. If they are independent, the result is the probability that the smallest of their
    p-values is at most ``p`` by chance.
    """
    return -math.expm1(looks * math.log1p(-p)) if p < 1.0 else 1.0


def share(level: float, parts: int) -> float:
    """Return the false-alarm rate to use for each of several tests, so that all together have the rate ``level``.

    ``parts`` is the number of tests. The rate of all together is the probability that at least one of them alarms
    falsely. Both rates are in [0, 1]. Šidák's formula is exact for independent tests.
    """
    return -math.expm1(math.log1p(-level) / parts)


def block_means(image: NDArray[Any], height: int, width: int) -> Array:
    """Return the means of an image (H, W, …) over blocks of pixels, (rows, columns, …).

    A block is ``height`` x ``width`` pixels. Incomplete blocks at the right and bottom edges are dropped.
    """
    rows, columns = image.shape[0] // height, image.shape[1] // width
    cut = image[: rows * height, : columns * width]
    return np.asarray(cut.reshape(rows, height, columns, width, *image.shape[2:]).mean(axis=(1, 3)))


@dataclass(frozen=True, eq=False)
class BlockMeans:
    """Means of an image over square blocks of pixels, and their variances, for a comparison of two images by `compare`.

    The arrays have the shape (rows, columns, channels).
    """

    mean: Array
    variance: Array
    """Variance of ``mean``."""
    degrees: float | Array
    """Degrees of freedom of the variance: one number for all blocks, or one for each; infinite if the variance is
    exact."""

    @classmethod
    def of_seeds(cls, images: Iterable[ArrayLike], block: int = 8) -> BlockMeans:
        """Return the block means of several images (H, W, C) with independent seeds, averaged over the images.

        A block has ``block`` pixels a side. The variances come from the scatter between images. The images are read one
        at a time.
        """
        means = np.stack([_means(image, block) for image in images])
        return cls(means.mean(axis=0), means.var(axis=0, ddof=1) / len(means), len(means) - 1.0)

    @classmethod
    def of_pixels(
        cls, mean: ArrayLike, variance: ArrayLike, block: int = 8, degrees: float | Array = math.inf
    ) -> BlockMeans:
        """Return the block means of one image whose pixels are independent.

        ``mean`` is the image (H, W, C), and ``variance`` (H, W, C) holds the variances of its pixels. A block has
        ``block`` pixels a side. ``degrees`` is the number of degrees of freedom of a block's variance; infinite if it
        is exact.
        """
        return cls(_means(mean, block), _means(variance, block) / block**2, degrees)


def _means(image: ArrayLike, block: int) -> Array:
    return block_means(np.asarray(image, dtype=np.float64), block, block)


@dataclass(frozen=True, eq=False)
class Agreement:
    """Outcome of a comparison of two images by `compare`; small p-values speak against equal expected images."""

    z: Array
    """(rows, columns, channels): excess of the first image over the second as a normal deviate. NaN where neither image
    has noise."""
    looks: Mapping[str, float]
    """P-value of each test, in [0, 1], by the test's name: ``worst``, ``mean``, ``squares`` and perhaps ``shape``; see
    `compare`."""
    unequal: int
    """Number of pairs of block and channel in which neither image has noise, but the images differ. If it is above 0,
    the expected images are not equal."""
    least: float
    """Relative difference, equal in all blocks, that the test ``mean`` finds at the level `LEVEL` in nine of ten
    comparisons; infinite if no block has noise and light."""

    @property
    def p(self) -> float:
        """P-value of all tests together, in [0, 1]; 0 if ``unequal`` is above 0."""
        return 0.0 if self.unequal else sidak(min(self.looks.values()), len(self.looks))

    @property
    def worst_block(self) -> tuple[int, int, int]:
        """Row, column and channel of the block with the largest |z|."""
        row, column, channel = np.unravel_index(np.nanargmax(np.abs(self.z)), self.z.shape)
        return int(row), int(column), int(channel)

    def __str__(self) -> str:
        differ = f"{self.unequal} blocks without noise differ"
        if np.isnan(self.z).all():
            return f"p = {self.p:.3g}: no noise anywhere, {differ}"
        row, column, channel = self.worst_block
        looks = ", ".join(f"{name} {p:.2g}" for name, p in self.looks.items())
        means = ", ".join(f"{c.mean():+.3f} of {c.size}" if c.size else "none" for c in _channels(self.z))
        return (
            f"p = {self.p:.2g} ({looks}); largest z {self.z[self.worst_block]:+.2f} "
            f"in block ({row}, {column}), channel {channel}; mean z {means}; {differ}"
        )


def compare(first: BlockMeans, second: BlockMeans, *, shape: bool = True) -> Agreement:
    """Return the outcome of a block-by-block comparison of the images ``first`` and ``second``.

    A small p-value speaks against equal expected images. Each channel of each block gives a normal deviate z. There are
    four tests:

    - ``worst``: the largest |z| of all;
    - ``mean``: the mean z of a channel;
    - ``squares``: the sum of z² in a channel;
    - ``shape``: the distance of a channel's distribution of z from the normal distribution.

    The test ``shape`` needs variances from many renders; the argument ``shape=False`` leaves it out. Where neither
    image has noise beyond rounding in a block, the images must be equal. Such blocks do not enter the tests; unequal
    ones are counted. Raises ValueError if the shapes differ or a pixel is not finite.
    """
    if first.mean.shape != second.mean.shape:
        raise ValueError(f"blocks of shape {first.mean.shape} cannot be compared with {second.mean.shape}")
    if not (np.isfinite(first.mean).all() and np.isfinite(second.mean).all()):
        raise ValueError("an image has a pixel that is not finite")
    from scipy import stats  # late: slow to import

    difference, total = first.mean - second.mean, first.variance + second.variance
    rounding = ROUNDING * np.maximum(np.abs(first.mean), np.abs(second.mean))
    noisy = np.sqrt(total) > rounding
    shares = first.variance**2 / first.degrees + second.variance**2 / second.degrees
    with np.errstate(divide="ignore", invalid="ignore"):
        degrees = np.minimum(total**2 / shares, 1e9)
        tail = stats.t.sf(np.abs(difference) / np.sqrt(total), degrees)
    z = np.where(noisy, -np.sign(difference) * stats.norm.ppf(np.maximum(tail, 1e-300)), np.nan)
    unequal = int((np.abs(difference) > rounding + 6.0 * np.sqrt(total))[~noisy].sum())
    looks = _look([c for c in _channels(z) if c.size], shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        signal = np.where(noisy, 0.5 * np.abs(first.mean + second.mean) / np.sqrt(total), np.nan)
    return Agreement(z, looks, unequal, _least(signal, len(looks)))


def compare_pair(
    first: tuple[ArrayLike, ArrayLike], second: tuple[ArrayLike, ArrayLike], block: int, degrees: float
) -> Agreement | None:
    """Return the outcome of a comparison of two single images; None if the images are too small for it.

    Each of ``first`` and ``second`` is a pair of arrays (H, W, C): an image and the variances of its pixels. Means over
    blocks are compared, by the tests of `compare` except ``shape``.

    Blocks have ``block`` pixels a side, or 2, 4, ... times as many if few pixels make the difference of the images. In
    smaller blocks without a bright path, both images would seem dark and free of noise. A block with the differences d
    of its pixels has 3 (sum d^2)^2 / sum d^4 degrees of freedom (Satterthwaite 1946), but at most ``degrees``. Nearly
    all blocks must have 40.
    """
    square = np.square(np.asarray(first[0], np.float64) - np.asarray(second[0], np.float64))
    while min(square.shape[:2]) >= _FEWEST_ALONG * block:
        freedom = _freedom(square, block)
        if np.quantile(freedom, _SHARE_BELOW) >= _EVENTS:
            few = np.minimum(freedom, degrees)
            one, other = (BlockMeans.of_pixels(*image, block, few) for image in (first, second))
            return compare(one, other, shape=False)
        block *= 2
    return None


def _freedom(square: Array, block: int) -> Array:
    """Return the degrees of freedom of blocks from squared differences of their pixels; infinite where all are 0."""
    second_moment, fourth_moment = _means(square, block), _means(np.square(square), block)
    found = np.full_like(second_moment, np.inf)
    np.divide(3.0 * block**2 * np.square(second_moment), fourth_moment, out=found, where=fourth_moment > 0.0)
    return found


def equality_test(first: Iterable[ArrayLike], second: Iterable[ArrayLike], block: int = 8) -> float:
    """Return the p-value, in [0, 1], of the hypothesis that two sets of renders have the same expected image.

    The sets ``first`` and ``second`` have at least two renders each, (K, H, W, 3), with independent seeds. Means over
    blocks of ``block`` pixels a side are compared. With few renders the p-value is exact only if block means are
    normally distributed. Give each set eight renders or more for a test at the level of 1 %, and 64 for 0.1 %.
    """
    return compare(BlockMeans.of_seeds(first, block), BlockMeans.of_seeds(second, block)).p


def _least(signal: Array, tests: int) -> float:
    """Return the relative difference of all blocks that one of ``tests`` tests finds by the mean of a channel's z.

    ``signal`` (rows, columns, channels) is the mean of each block in standard errors of the difference.
    """
    channels = [c for c in _channels(signal) if c.size]
    most = max((float(c.mean()) * math.sqrt(c.size) for c in channels), default=0.0)
    if most == 0.0:
        return math.inf
    from scipy import stats  # late: slow to import

    level = share(share(LEVEL, tests), len(channels))
    return float(stats.norm.isf(0.5 * level) + stats.norm.isf(_MISSED)) / most


def _look(channels: list[Array], shape: bool) -> dict[str, float]:
    """Return the p-value of each test of the z's of the channels that have any."""
    if not channels:
        return {"nothing": 1.0}
    parts, blocks = len(channels), sum(c.size for c in channels)
    from scipy import stats  # late: slow to import

    looks = {
        "worst": sidak(_two_sided(max(float(np.abs(c).max()) for c in channels)), blocks),
        "mean": sidak(_two_sided(max(abs(float(c.mean())) * math.sqrt(c.size) for c in channels)), parts),
        "squares": sidak(min(float(stats.chi2.sf(c @ c, c.size)) for c in channels), parts),
    }
    return looks | ({"shape": sidak(min(anderson_darling(c) for c in channels), parts)} if shape else {})


def near_normal(first: ArrayLike, second: ArrayLike, block: int) -> bool:
    """Tell whether the block means of two sets of images are near enough to normal for `equality_test`.

    The sets ``first`` and ``second`` have at least 3 images each, (K, H, W, C). A block has ``block`` pixels a side.
    The answer is False if a block's noise comes from few pixels of few images, or if one set has no noise in a block
    where the other has some. In both cases the spread over images does not show the error of the mean. A set without
    noise in any block counts as exact. Raises ValueError for fewer than 3 images.
    """
    both = [_skewed(np.asarray(images, np.float64), block) for images in (first, second)]
    if any(skewed.any() for _, skewed in both):
        return False
    without = [variance == 0.0 for variance, _ in both]
    return any(none.all() for none in without) or bool((without[0] == without[1]).all())


def _skewed(images: Array, block: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return the variances of block sums over all images, and a mask of too skewed blocks; pixels are independent."""
    count = len(images)
    if count < 3:
        raise ValueError(f"skewness needs 3 images, not {count}")
    deviations = images - images.mean(axis=0)
    variance = _means((deviations**2).sum(axis=0), block) * block**2 * count / (count - 1)
    third = _means((deviations**3).sum(axis=0), block) * block**2 * count**2 / ((count - 1) * (count - 2))
    return variance, np.abs(third) > MOST_SKEWNESS * variance**1.5


def anderson_darling(z: Array) -> float:
    """Return the p-value of the hypothesis that the numbers in `z` (N,) are independent and standard normal.

    The Anderson-Darling test uses the first term of the statistic's limiting distribution, P(A^2 > a) ~ sqrt(3)
    erfc(sqrt(a)). That term belongs to the largest eigenvalue 1/2 among 1/(i (i + 1)) (Anderson & Darling 1952). The
    returned p-value is 5 % too small at p = 0.001, and 15 % too small at p = 0.1.
    """
    ordered = np.sort(z)
    from scipy import special  # late: slow to import

    odd = 2.0 * np.arange(1, z.size + 1) - 1.0
    logs = special.log_ndtr(ordered) + special.log_ndtr(-ordered[::-1])
    statistic = -z.size - float((odd * logs).mean())
    return min(1.0, math.sqrt(3.0) * math.erfc(math.sqrt(max(statistic, 0.0))))


def _two_sided(z: float) -> float:
    return math.erfc(z / math.sqrt(2.0))


def _channels(z: Array) -> list[Array]:
    """Return the finite z's of each channel."""
    return [z[..., c][np.isfinite(z[..., c])] for c in range(z.shape[-1])]
