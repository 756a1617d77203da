"""Whether repeats can tell how far they spread: how much single pixels of single renders make of an error.

The mean square error of a render is a mean over pixels. Where rare samples carry much of it (small lights that are only
found by chance, caustics), a few renders do not show how far it spreads, and no interval that comes of that spread can
be trusted. Two numbers tell, both made of the squared errors c of all pixels of all repeats:

- Lyapunov's ratio ``sum |e|³ / (sum e²)^(3/2)``, with e the deviation of c from the mean of its pixel over repeats.
  What varies from place to place by the picture is no tail, and has no part in it. It bounds how far a sum is from
  normal (Berry 1941, Esseen 1942), and falls as one over the root of the number of things that happened: a light that
  was found N times, by chance but with like brightness, has about ``1 / sqrt(N)``. Where squared errors have a power
  tail of index below 2, it does not fall at all.
- The share of the largest c in the sum of all. With a power tail, what is larger still and was not seen makes a
  multiple of that share of the true sum.

If the ratio is small, intervals from the spread over repeats hold. If it is not but the largest share is small, they
hold once their upper end is moved out by `UNSEEN` times that share. Else the upper end means nothing; the lower one
still holds, since what was not seen can only add to an error. The limits were chosen by simulation, which
tests/statistical/test_intervals.py repeats.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.cost.metrics import Reference

__all__ = ["Tail", "squared_errors", "tail_of"]

Floats = NDArray[np.float64]

MOST_RATIO = 0.1
"""Of Lyapunov; a hundred rare events of one size have it."""
MOST_SHARE = 0.015
UNSEEN = 20.0
"""Index 1.2 of squared errors, the least with which these limits hold, leaves about six times the largest share unseen
on average, and three times as much in bad cases."""


@dataclass(frozen=True)
class Tail:
    """What the largest squared errors make of all; NaN if a single repeat cannot tell."""

    ratio: float
    """Lyapunov's."""
    share: float
    """Of the largest."""

    @property
    def doubt(self) -> str:
        """Why upper ends of intervals cannot be trusted; nothing if they can, or nothing can be seen."""
        if not self.ratio > MOST_RATIO or self.share <= MOST_SHARE:
            return ""
        return f"heavy tail: one pixel of one render makes {100 * self.share:.3g} % of the error, and others may more"

    @property
    def unseen(self) -> float:
        """By how much larger than it seems the mean square error may be for what was not seen."""
        return UNSEEN * self.share if self.ratio > MOST_RATIO else 0.0


def squared_errors(images: Iterable[ArrayLike], reference: Reference) -> Floats:
    """Return the relative squared error of each pixel of each image (H, W, 3): (K, pixels)."""
    denominator = np.maximum(reference.denominator, np.finfo(np.float64).tiny)
    squares = (np.square(np.asarray(image, np.float64) - reference.mean) / denominator for image in images)
    return np.stack([square.mean(axis=2).ravel() for square in squares])


def tail_of(errors: ArrayLike) -> Tail:
    """Return what the largest of squared errors (K repeats, pixels) make of all."""
    squares = np.asarray(errors, np.float64)
    total = float(squares.sum())
    if len(squares) < 2:
        return Tail(math.nan, math.nan)
    deviations = np.abs(squares - squares.mean(axis=0))
    largest = float(deviations.max(initial=0.0))
    if not total > 0.0 or largest <= 1e-12 * total:
        return Tail(0.0, 0.0)
    scaled = deviations / largest  # or third powers of bright outliers would not be finite
    return Tail(float((scaled**3).sum() / np.square(scaled).sum() ** 1.5), float(squares.max()) / total)
