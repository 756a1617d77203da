"""Test of whether an error bar can be trusted: whether few pixels of few renders make most of the error.

The mean square error of a render is a mean over pixels. Rare samples can carry much of it, such as small lights that
are found only by chance, or caustics. Then a few renders do not show the spread of the error, and no interval derived
from it can be trusted. Such an error has a heavy tail. Two numbers tell whether the tail is heavy. Both are computed
from the squared errors c of all pixels of all repeats:

- Lyapunov's ratio ``sum |e|³ / (sum e²)^(3/2)``, with e the deviation of c from the mean of its pixel over repeats.
  Variation across the picture is no tail and does not enter. The ratio bounds how far a sum is from normal (Berry 1941,
  Esseen 1942). It falls as one over the root of the number of events: a light that was found N times, by chance but
  with similar brightness, has about ``1 / sqrt(N)``. Where squared errors have a power tail of index below 2, it does
  not fall at all.
- The share of the largest c in the sum of all. With a power tail, still larger values that were not seen make up a
  multiple of that share of the true sum.

If the ratio is small, intervals from the spread over repeats hold. If the ratio is large but the largest share is
small, intervals hold once their upper end is moved out by `UNSEEN` times that share. Otherwise the upper end means
nothing. The lower end still holds, since unseen light can only add to an error. The limits were chosen by simulation,
which tests/statistical/test_intervals.py repeats.

A single render has no repeats, only the difference of its two halves at every pixel. Instead it has neighbours, whose
noise is mostly alike. Only the excess of the largest c over a limit counts (`outstanding`). The limit is the mean of
the rest of the 7x7 neighbourhood, times a factor. The factor is the expected largest square of N normal differences,
with N the number of pixels. A bright path that stands out is part of the error and so is no reason for doubt. But once
the same path has averaged out, the variance does not show it any more, and other such paths may be missing
(`averaged_out`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.film.sums import others_count, others_sum

__all__ = ["MOST_RATIO", "MOST_SHARE", "Tail", "averaged_out", "outstanding", "tail_of"]

Floats = NDArray[np.float64]

MOST_RATIO = 0.1
"""Largest Lyapunov ratio at which intervals are trusted as they are; a hundred rare events of equal size have this
ratio."""
MOST_SHARE = 0.015
"""Largest share of one squared error in the sum at which intervals with a larger ratio are still trusted, once their
upper end is moved out."""
UNSEEN = 20.0
"""Multiple of the largest share by which unseen squared errors may raise the mean square error. The limits hold for
power tails, ``P(c > x) ~ x^-a``, with an index a of at least 1.2. At this index the unseen part is about six times the
largest share on average, and three times as much in bad cases."""
_LARGEST = 2.5
"""Factor on log(number of squares) and on their mean; for squares of normal differences the largest needs about 2."""
_AVERAGED_OUT = 0.5
"""Least share of the present error² that a bright path of an earlier look must still make to be a reason for doubt."""


@dataclass(frozen=True)
class Tail:
    """Two numbers that tell whether few pixels of few repeats make most of the error of repeated renders.

    If so, the spread over repeats does not show how uncertain the error is. Both numbers are NaN for a single repeat.
    """

    ratio: float
    """Lyapunov's ratio ``sum |e|³ / (sum e²)^(3/2)``, with e the deviations of squared errors from the mean of their
    pixel over repeats. It is in [0, 1], and small if many pixels and repeats contribute."""
    share: float
    """Share, in [0, 1], of the largest squared error in the sum over all pixels of all repeats."""

    @property
    def doubt(self) -> str:
        """Reason, in words, why the upper end of an error's interval cannot be trusted.

        The text is empty if the upper end can be trusted, or if there is a single repeat.
        """
        if not self.ratio > MOST_RATIO or self.share <= MOST_SHARE:
            return ""
        return (
            f"heavy tail: one pixel of one render makes {100 * self.share:.3g} % of the squared error (the limit is "
            f"{100 * MOST_SHARE:g} %), and others may make more"
        )

    @property
    def unseen(self) -> float:
        """Upper bound of the mean square error that rare unseen samples may add, as a fraction of the measured one.

        It is 0 if `ratio` is at most `MOST_RATIO`.
        """
        return UNSEEN * self.share if self.ratio > MOST_RATIO else 0.0


def tail_of(errors: ArrayLike) -> Tail:
    """Return two numbers that tell whether few pixels of few repeats make the error: Lyapunov's ratio, largest share.

    ``errors`` (K, pixels) holds the squared errors of all pixels in K repeated renders. Both numbers are NaN for a
    single repeat.
    """
    squares = np.asarray(errors, np.float64)
    if len(squares) < 2:
        return Tail(math.nan, math.nan)
    total = float(squares.sum())
    deviations = np.abs(squares - squares.mean(axis=0))
    most = float(deviations.max(initial=0.0))
    if not total > 0.0 or most <= 1e-12 * total:
        return Tail(0.0, 0.0)
    scaled = deviations / most  # the third powers of bright outliers would overflow otherwise
    return Tail(float((scaled**3).sum() / np.square(scaled).sum() ** 1.5), float(squares.max(initial=0.0)) / total)


def outstanding(squares: Floats) -> float:
    """Return the share of an image's error² that its most outstanding pixel makes, in [0, 1].

    A large share shows that one rare bright path makes the error. ``squares`` (H, W) holds the contribution of each
    pixel to error². Only the excess over the largest contribution that the neighbours' noise would explain counts, so
    the share is 0 where noise is even.
    """
    total = float(squares.sum())
    if not total > 0.0:
        return 0.0
    around = others_sum(squares[..., None])[..., 0] / others_count(*squares.shape)[..., 0]
    return max(float((squares - _LARGEST * math.log(squares.size + 1.0) * around).max()), 0.0) / total


def averaged_out(past: float, samples: float, square: float, share: float) -> str:
    """Return why to distrust an error that fell because a rare bright path averaged out; empty if none did.

    One bright path makes much of the error when it is met. Its part falls as ``1 / samples²``, while other paths of
    that kind may not have been met yet. So the part that it would have now is compared with a single pixel's part.

    Parameters
    ----------
    past
        Largest value of ``share * square * samples²`` at all earlier estimates during the render; 0 at the first.
    samples
        Samples per pixel so far, on average.
    square
        Error² of the image so far.
    share
        Share of ``square`` that the pixel with the largest error adds beyond its neighbours, as `outstanding` returns
        it.
    """
    if not square > 0.0 or past / (samples * samples * square) - share <= _AVERAGED_OUT:
        return ""
    return "a rare bright path that was met has averaged out: others like it may not have been met yet"
