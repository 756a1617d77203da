"""Where on the picture the error is: which part of error² comes from which pixels.

Each pixel's part of error², as `equaltime.film.error` has it, rests on two replicates: by chance alone the largest
hundredth of them makes a twelfth of the sum, even of noise that is the same everywhere. So no pixel is chosen by its
own noise: the noisiest pixels are those whose neighbours are noisy, and the rectangle is chosen by every other pixel
(as on a chessboard) and measured by those between. Noise of different pixels is independent, so that shares are not
made larger by the choice. What is narrower than the neighbourhood of a pixel, 5x5, is blurred by it: shares are then
smaller than of the pixels that are truly the noisiest. Single pixels far above their neighbours are told apart.

Intervals, at 95 %, are those of the ratio F of two sums of squares, over the pixels within and without. They are of
error² as the render itself sees it. Light that no sample has found has no part in any of this, and light that few have
found moves shares by more than they say: of 100 pilots of 8 spp they held 87 to 92 times where noise is even (a room
behind an opening), but 39 to 86 times in a Cornell box, by the edges of its lamp (of 10 % of the pixels 24 % are told
on average, where 21 % are true). So every share is in doubt, and quotes give it in words without an interval.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import Estimate, PixelStatistics, error_parts
from equaltime.film.neighbourhoods import others_count
from equaltime.film.sums import nearest_mean, others_sum
from equaltime.rendering.session import Session

__all__ = ["FRACTIONS", "Places", "Rectangle", "noise_places", "places_of"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

FRACTIONS = (0.01, 0.1)
"""Of the pixels, whose share of error² is told."""
OUTSTANDING = 25.0
"""Times the mean of the others in its 7x7 neighbourhood: five standard errors. Of even noise, one pixel in a hundred
thousand has it."""
DOUBT = "light that few samples have found moves the share by more than its interval says"
_CELLS = 16
# Times the square of a sum of parts over the sum of their squares, the degrees of freedom of the sum (Satterthwaite
# 1946): 3 where the differences of two replicates are normal, 2 where they are as skewed as can be.
_DEGREES = 2.0


@dataclass(frozen=True)
class Rectangle:
    """The least rectangle, of a grid of 16x16 over the picture, that holds half of error²."""

    x: tuple[int, int]
    """First and last column, of the whole film, from 0 on the left."""
    y: tuple[int, int]
    """First and last row, from 0 at the top."""
    area: float
    """Fraction of the picture."""
    share: Estimate
    """Of error², measured by pixels that had no say in the choice."""

    @property
    def stands_out(self) -> bool:
        """Whether it is noisier than the rest of the picture, by its interval."""
        return self.share.low > self.area


@dataclass(frozen=True)
class Places:
    """Which part of error² comes from which pixels; shares are fractions of error², in doubt."""

    noisiest: Mapping[float, Estimate] = field(hash=False)
    """Of the pixels with the noisiest neighbours: by the fraction of all pixels that they are (`FRACTIONS`)."""
    rectangle: Rectangle
    single: Estimate
    """Of single pixels that have `OUTSTANDING` times the error² of their neighbours: rare bright paths."""
    single_pixels: tuple[tuple[int, int], ...]
    """(x, y) of these on the whole film, the worst first."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON data."""
        held = self.rectangle
        return {
            "noisiest": [{"pixels": part, "share": share.as_dict()} for part, share in self.noisiest.items()],
            "rectangle": {
                "x": [*held.x],
                "y": [*held.y],
                "area": held.area,
                "share": held.share.as_dict(),
                "stands_out": held.stands_out,
            },
            "single_pixels": {"share": self.single.as_dict(), "at": [[*pixel] for pixel in self.single_pixels]},
        }


def noise_places(pixels: PixelStatistics, corner: tuple[int, int] = (0, 0), least: Floats | None = None) -> Places:
    """Tell where the error of a render is.

    Parameters
    ----------
    pixels
        Of the render, with samples in two replicates everywhere, that saw some light.
    corner
        Column and row on the whole film of the first pixel, if the render is a part of it.
    least
        Light that is surely in the pixels, as `equaltime.film.error.image_error` takes it.
    """
    height, width = pixels.samples.shape
    parts = error_parts(pixels, float(pixels.mean.mean()), least).value
    noise = nearest_mean(np.sqrt(parts)[..., None])[..., 0]  # roots, lest one bright pixel choose all around it
    order = np.argsort(-noise, axis=None, kind="stable")
    noisiest = {}
    for fraction in FRACTIONS:
        chosen = np.zeros(parts.size, np.bool_)
        chosen[order[: max(1, round(fraction * parts.size))]] = True
        noisiest[fraction] = share_within(parts.ravel(), chosen)
    around = others_sum(parts[..., None])[..., 0] / others_count(height, width)[..., 0]
    outstanding = parts > OUTSTANDING * around
    rows, columns = np.nonzero(outstanding)
    worst = np.argsort(-parts[rows, columns], kind="stable")
    found = tuple((corner[0] + int(columns[i]), corner[1] + int(rows[i])) for i in worst)
    return Places(noisiest, _rectangle(parts, corner), share_within(parts.ravel(), outstanding.ravel()), found)


def places_of(session: Session) -> Places:
    """Tell where on the picture the error of a session's render is, as far as it is done."""
    pixels, window = session.statistics(), session.origin.window
    return noise_places(pixels, (window.x, window.y), session.lamps.least(*pixels.samples.shape))


def share_within(parts: Floats, chosen: Mask) -> Estimate:
    """Return the share of some pixels in error², of each pixel's part of it."""
    total, square = float(parts.sum()), float(np.square(parts).sum())
    if not square > 0.0:
        return Estimate(math.nan, 0.0, 1.0)
    share = float(parts[chosen].sum()) / total
    if not 0.0 < share < 1.0:  # nothing was met of what is outside, or within: the rule of three, of equal parts
        most = min(1.0, 3.0 * square / total**2)
        return Estimate(share, 0.0, most, DOUBT) if share <= 0.0 else Estimate(1.0, 1.0 - most, 1.0, DOUBT)
    odds = share / (1.0 - share)
    degrees = [
        _DEGREES * float(side.sum()) ** 2 / float(np.square(side).sum()) for side in (parts[chosen], parts[~chosen])
    ]
    from scipy.special import fdtri  # here, since not everyone needs it

    low, high = (odds / float(fdtri(*degrees, p)) for p in (0.975, 0.025))
    return Estimate(share, low / (1.0 + low), high / (1.0 + high), DOUBT)


def _rectangle(parts: Floats, corner: tuple[int, int]) -> Rectangle:
    height, width = parts.shape
    black = np.indices(parts.shape).sum(axis=0) % 2 == 0
    deciding = np.where(black, parts, 0.0)
    if not deciding.sum() > 0.0:  # as of one pixel by itself, or in a row of them
        deciding = parts
    (top, bottom), (left, right) = _least_half(deciding)
    within = np.zeros(parts.shape, np.bool_)
    within[top:bottom, left:right] = True
    between = ~black if parts[~black].sum() > 0.0 else np.ones_like(black)
    return Rectangle(
        x=(corner[0] + left, corner[0] + right - 1),
        y=(corner[1] + top, corner[1] + bottom - 1),
        area=(bottom - top) * (right - left) / (height * width),
        share=share_within(parts[between], within[between]),
    )


def _least_half(parts: Floats) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return first and end of rows and of columns of the least rectangle of cells with half the sum, or more."""
    edges = [np.unique(np.linspace(0, length, _CELLS + 1).round().astype(int)) for length in parts.shape]
    cells = np.add.reduceat(np.add.reduceat(parts, edges[0][:-1], axis=0), edges[1][:-1], axis=1)
    sums = np.pad(cells.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    (first, end), (start, stop) = (np.triu_indices(len(edge), 1) for edge in edges)  # of rows, of columns
    held = sums[end][:, stop] - sums[first][:, stop] - sums[end][:, start] + sums[first][:, start]
    areas = np.outer(edges[0][end] - edges[0][first], edges[1][stop] - edges[1][start]).astype(np.float64)
    areas[held < 0.5 * sums[-1, -1]] = np.inf
    areas -= held / (2.0 * sums[-1, -1])  # of equal ones, that which holds more
    rows, columns = np.unravel_index(int(areas.argmin()), areas.shape)
    return (
        (int(edges[0][first[rows]]), int(edges[0][end[rows]])),
        (int(edges[1][start[columns]]), int(edges[1][stop[columns]])),
    )
