"""Whether an error bar can be trusted: how much single pixels of single renders make of an error.

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

One render has no repeats, only the difference of its two halves at every pixel; what it has instead is neighbours,
whose noise is mostly alike. Of its largest c only the part counts that lies beyond what the others in the 7x7
neighbourhood have, times the largest of so many squares of normal differences (`outstanding`). That is no reason to
doubt its error, of which the bright path is a part. But when the same path has averaged out since, no variance shows
it, and others like it may be missing (`averaged_out`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.film.neighbourhoods import others_count
from equaltime.film.sums import others_sum

__all__ = ["MOST_RATIO", "Tail", "averaged_out", "outstanding", "tail_of"]

Floats = NDArray[np.float64]

MOST_RATIO = 0.1
"""Of Lyapunov; a hundred rare events of one size have it."""
MOST_SHARE = 0.015
UNSEEN = 20.0
"""Index 1.2 of squared errors, the least with which these limits hold, leaves about six times the largest share unseen
on average, and three times as much in bad cases."""
_LARGEST = 2.5
"""Times the logarithm of their number, and their mean: the largest of squares of normal differences is about 2."""
_AVERAGED_OUT = 0.5
"""Share of the present error² that a bright path of an earlier look would still make, to be a reason for doubt."""


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


def tail_of(errors: ArrayLike) -> Tail:
    """Return what the largest of squared errors (K repeats, pixels) make of all."""
    squares = np.asarray(errors, np.float64)
    if len(squares) < 2:
        return Tail(math.nan, math.nan)
    total = float(squares.sum())
    deviations = np.abs(squares - squares.mean(axis=0))
    most = float(deviations.max(initial=0.0))
    if not total > 0.0 or most <= 1e-12 * total:
        return Tail(0.0, 0.0)
    scaled = deviations / most  # or third powers of bright outliers would not be finite
    return Tail(float((scaled**3).sum() / np.square(scaled).sum() ** 1.5), float(squares.max(initial=0.0)) / total)


def outstanding(squares: Floats) -> float:
    """Return the share of the largest in the sum of squared errors (H, W) of one render; 0 where noise is even."""
    total = float(squares.sum())
    if not total > 0.0:
        return 0.0
    around = others_sum(squares[..., None])[..., 0] / others_count(*squares.shape)[..., 0]
    return max(float((squares - _LARGEST * math.log(squares.size + 1.0) * around).max()), 0.0) / total


def averaged_out(past: float, samples: float, square: float, share: float) -> str:
    """Return why an error is in doubt that no longer shows a bright path of an earlier look; empty if it does.

    Parameters
    ----------
    past
        Largest product of `outstanding`, error² and the square of the samples a pixel, of the looks before. What one
        path makes of error² falls with the square of the samples.
    samples, square, share
        Samples a pixel, error² and `outstanding` now.
    """
    if not square > 0.0 or past / (samples * samples * square) - share <= _AVERAGED_OUT:
        return ""
    return "a rare bright path that was met has averaged out: others like it may not have been met yet"
