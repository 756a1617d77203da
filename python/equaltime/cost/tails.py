"""Whether repeats can tell how far they spread: the tail index of what makes up an error.

Where rare samples carry much of the variance (small lights that are only found by chance, caustics), squared errors
have a tail so heavy that a few runs do not show it. A distribution with tail index a has finite moments up to order a:
below 2 the spread of squared errors has no meaning, and no interval that is made from it can be trusted; below 1 the
variance of the image itself may be infinite.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["LEAST_INDEX", "Tail", "block_errors", "moment_index", "tail_index"]

Floats = NDArray[np.float64]

LEAST_INDEX = 2.0
FEWEST_REPEATS = 4
FEWEST_VALUES = 200
"""From k values the inverse of the index has a standard error of about 1 / sqrt(k): with fewer, Gaussian noise would
often not be told from a tail. They are there in 8 images of 32x32 pixels."""
# Of the variance that a block's error is compared with; a ratio of variances has a tail with half the index.
_DEGREES = 24
_TOP, _WIDE_TOP = 0.05, 0.1
_ONE_SIDED = 1.645


@dataclass(frozen=True)
class Tail:
    """The tail index of squared errors; NaN if there are too few of them to tell."""

    index: float
    least: float
    """Lower limit of the index: it is above this with 95 % confidence."""

    @property
    def doubt(self) -> str:
        """Why intervals cannot be trusted; nothing if they can, or nothing can be seen."""
        if math.isnan(self.index) or self.least >= LEAST_INDEX:
            return ""
        what = "a few pixels carry much of the error, and repeats cannot show how far it spreads"
        if self.index < 1.0:
            what = "even the variance may be infinite"
        elif self.index >= LEAST_INDEX:
            what = f"it may be below {LEAST_INDEX:g}, where repeats cannot show how far the error spreads"
        return f"heavy tail (index {self.index:.2g}): {what}"


def moment_index(values: ArrayLike, count: int) -> Tail:
    """Return the tail index of positive values from the largest ``count``; ``inf`` for a tail lighter than a power.

    By the moment estimator (Dekkers, Einmahl & de Haan 1989), which adds to Hill's (1975) what makes it right for
    tails that are no power: Hill's alone finds an index near 2 in squares of normal deviates. It estimates the inverse
    g of the index; its variance is (1 + g²) / count where the index is finite.
    """
    largest = np.sort(np.asarray(values, np.float64))[-count - 1 :]
    if not largest[0] > 0.0:
        raise ValueError("the tail must be positive")
    logs = np.log(largest[1:] / largest[0])
    first, second = float(logs.mean()), float(np.square(logs).mean())
    if second <= first**2 * (1.0 + 1e-12):
        return Tail(math.inf, math.inf)
    inverse = first + 1.0 - 0.5 / (1.0 - first**2 / second)
    most = inverse + _ONE_SIDED * math.sqrt((1.0 + max(inverse, 0.0) ** 2) / count)
    return Tail(*(1.0 / g if g > 0.0 else math.inf for g in (inverse, most)))


def block_errors(images: Iterable[ArrayLike], block: int | None = None) -> Floats:
    """Return each image's squared deviation from the mean image, relative, as means over square blocks of pixels.

    Parameters
    ----------
    images
        (H, W, 3) each, with independent seeds. What is left over at the ends is dropped.
    block
        Width in pixels: small, that one pixel may stand out; so large, that ordinary noise does not even if the other
        repeats of a block say little of it. If not given, 2 for eight images, and up to 4 for fewer.

    Returns
    -------
        (K, blocks).

    """
    stack = np.stack([np.asarray(image, np.float64) for image in images])
    if block is None:
        block = max(2, math.ceil(math.sqrt(_DEGREES / max(len(stack) - 2, 1))))
    mean = stack.mean(axis=0)
    # by the median, or an outlier would divide itself away
    denominator = np.median(stack, axis=0) ** 2 + (0.1 * mean.mean()) ** 2
    parts = (stack - mean) ** 2 / np.where(denominator > 0.0, denominator, 1.0)
    rows, columns = stack.shape[1] // block, stack.shape[2] // block
    cut = parts[:, : rows * block, : columns * block]
    errors: Floats = cut.reshape(len(stack), rows, block, columns, block, -1).mean(axis=(2, 4, 5))
    return errors.reshape(len(stack), -1)


def tail_index(errors: ArrayLike) -> Tail:
    """Return the tail index of squared errors from `block_errors` (K, blocks); NaN if there are too few to tell.

    What varies from place to place by the picture is no tail, so every block's error is seen as its excess over that of
    the other repeats there: the squared distance from *their* mean over *their* variance, or an outlier would hide
    behind itself. Where samples are rare but bounded, that ratio has a tail that the errors have not: of the index
    found so and that of the errors as they are, the larger counts. The moment estimator looks at the top 5 % of all, or
    up to 10 % while these are under 200.
    """
    parts = np.asarray(errors, np.float64)
    repeats = len(parts)
    if repeats < FEWEST_REPEATS:
        return Tail(math.nan, math.nan)
    own = parts * (repeats / (repeats - 1.0))
    others = (parts.sum(axis=0) - own) / (repeats - 2.0)
    seen = others > 1e-9 * own
    excess = own[seen] / others[seen] - 1.0
    count = round(max(_TOP * excess.size, min(_WIDE_TOP * excess.size, FEWEST_VALUES)))
    if count < FEWEST_VALUES or np.count_nonzero(excess > 0.0) <= count:
        return Tail(math.nan, math.nan)
    return max(moment_index(excess, count), moment_index(parts[seen], count), key=lambda tail: tail.least)
