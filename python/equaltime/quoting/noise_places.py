"""Position of the error on the picture: the share of error² that each group of pixels makes.

Each pixel's contribution to error², as in `equaltime.film.error`, comes from two replicates (halves of its samples). By
chance alone the largest hundredth of these contributions makes a twelfth of the sum, even of noise that is the same
everywhere. So no pixel is chosen by its own noise. The noisiest pixels are those with noisy neighbours. A rectangle
that holds half of error² is chosen by every other pixel (as on a chessboard) and measured by the pixels between. Noise
of different pixels is independent, so the choice does not enlarge shares. Noise in an area narrower than the
neighbourhood of a pixel, 5x5, is blurred. Shares are then smaller than for the truly noisiest pixels. Single pixels far
above their neighbours are listed separately.

Intervals, at 95 %, come from the ratio F of two sums of squares, over the pixels inside and outside the group. They
refer to error² as the render itself sees it. Light that no sample has found does not enter. Light that few samples have
found moves shares by more than the intervals say. Of 100 pilots of 8 spp, intervals held the truth 87 to 92 times where
noise is even (a room behind an opening). They held it 39 to 86 times in a Cornell box, because of the edges of its
lamp. In that box, the noisiest 10 % of the pixels have a mean share of 24 %, where the true share is 21 %. So every
share is in doubt, and quotes state it in words without an interval.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, error_parts
from equaltime.film.sums import nearest_mean, others_count, others_sum
from equaltime.rendering.session import Session
from equaltime.statistics.intervals import Interval
from equaltime.strict_json import fields_to_json
from equaltime.words import percent

__all__ = ["FRACTIONS", "NoisePlaces", "NoiseRectangle", "noise_places", "places_of"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

FRACTIONS = (0.01, 0.1)
"""Fractions of an image's pixels: the share of error² that the noisiest 1 % and 10 % of the pixels make is stated."""
OUTSTANDING = 25.0
"""Factor by which error² of a pixel that stands out exceeds the mean of the other pixels in its 7x7 neighbourhood. The
factor is five standard errors: with even noise, one pixel in a hundred thousand stands out."""
DOUBT = "light that few samples have found moves the share by more than its interval says"
_CELLS = 16
# Factor from (sum of parts)² over the sum of their squares to the degrees of freedom of the sum (Satterthwaite 1946): 3
# if the differences of two replicates are normal, 2 if they are as skewed as possible.
_DEGREES = 2.0


@dataclass(frozen=True)
class NoiseRectangle:
    """Smallest rectangle of cells that holds half of error²: the region where the noise is.

    The picture is divided into 16x16 cells.
    """

    x: tuple[int, int]
    """First and last column on the whole film, from 0 on the left."""
    y: tuple[int, int]
    """First and last row on the whole film, from 0 at the top."""
    area: float
    """Area as a fraction of the picture, in [0, 1]."""
    share: Interval
    """Share of error² in the rectangle, about half, measured by pixels that had no influence on its choice."""

    @property
    def stands_out(self) -> bool:
        """Whether the rectangle is noisier than the picture as a whole.

        True if the lower limit of its share of error² is above its fraction of the picture's area.
        """
        return self.share.low > self.area

    def __str__(self) -> str:
        across, down = (f"{first} to {last}" for first, last in (self.x, self.y))
        return f"x {across}, y {down}: {percent(self.area)} of the picture, {percent(self.share.value)} of error²"


@dataclass(frozen=True)
class NoisePlaces:
    """Places that make the noise: shares of error² of the noisiest pixels, of a noisy rectangle, and of single pixels.

    Shares are in [0, 1]. Every interval is marked as doubtful: light that few samples have found moves a share by more
    than its interval.
    """

    noisiest: Mapping[float, Interval] = field(hash=False)
    """Share of error² of the noisiest 1 % and 10 % of the pixels, by that fraction (`FRACTIONS`). The noise of its
    neighbours decides whether a pixel is among them."""
    rectangle: NoiseRectangle
    """Smallest rectangle that holds half of error²."""
    single: Interval
    """Share of error² of pixels far above their neighbours (`OUTSTANDING`), because of rare bright paths."""
    single_pixels: tuple[tuple[int, int], ...]
    """(x, y) of the pixels of ``single`` on the whole film, the pixel with the largest error² first."""

    def as_dict(self) -> dict[str, Any]:
        """Return the shares, the rectangle and the single pixels as JSON data."""
        return {
            "noisiest": [{"pixels": part, "share": share.as_dict()} for part, share in self.noisiest.items()],
            "rectangle": {**fields_to_json(self.rectangle), "stands_out": self.rectangle.stands_out},
            "single_pixels": {"share": self.single.as_dict(), "at": [[*pixel] for pixel in self.single_pixels]},
        }


def noise_places(pixels: PixelStatistics, corner: tuple[int, int] = (0, 0), least: Floats | None = None) -> NoisePlaces:
    """Return the shares of a render's error² that regions and pixels of the picture make.

    Parameters
    ----------
    pixels
        Statistics of the render. Every pixel needs samples in both halves of its samples, and the image must not be
        black.
    corner
        Column and row of the render's first pixel on the whole film.
    least
        Light that is certainly in each pixel, (H, W, 3): small lamps that the camera sees. This light keeps the
        denominators of error² from being too small; None if there is none.
    """
    height, width = pixels.samples.shape
    parts = error_parts(pixels, float(pixels.mean.mean()), least).value
    noise = nearest_mean(np.sqrt(parts)[..., None])[..., 0]  # roots, so that no bright pixel chooses all around it
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
    return NoisePlaces(noisiest, _rectangle(parts, corner), share_within(parts.ravel(), outstanding.ravel()), found)


def places_of(session: Session) -> NoisePlaces:
    """Return the shares of error² that regions and pixels make in the picture of a running render so far.

    ``session`` is the render.
    """
    pixels, window = session.statistics(), session.origin.window
    return noise_places(pixels, (window.x, window.y), session.lamps.least(*pixels.samples.shape))


def share_within(parts: Floats, chosen: Mask) -> Interval:
    """Return the share of error² that chosen pixels make, as a fraction with its 95 % interval.

    ``parts`` holds each pixel's contribution to error², and ``chosen`` is a mask of the same shape. The share is NaN if
    all contributions are 0.
    """
    total, square = float(parts.sum()), float(np.square(parts).sum())
    if not square > 0.0:
        return Interval(math.nan, 0.0, 1.0)
    share = float(parts[chosen].sum()) / total
    if not 0.0 < share < 1.0:  # one side has no noise: the rule of three, for equal parts
        most = min(1.0, 3.0 * square / total**2)
        found = Interval(share, 0.0, most) if share <= 0.0 else Interval(1.0, 1.0 - most, 1.0)
        return found.doubted(DOUBT)
    odds = share / (1.0 - share)
    degrees = [
        _DEGREES * float(side.sum()) ** 2 / float(np.square(side).sum()) for side in (parts[chosen], parts[~chosen])
    ]
    from scipy.special import fdtri  # here, because not every render needs scipy

    low, high = (odds / float(fdtri(*degrees, p)) for p in (0.975, 0.025))
    return Interval(share, low / (1.0 + low), high / (1.0 + high)).doubted(DOUBT)


def _rectangle(parts: Floats, corner: tuple[int, int]) -> NoiseRectangle:
    height, width = parts.shape
    black = np.indices(parts.shape).sum(axis=0) % 2 == 0
    deciding = np.where(black, parts, 0.0)
    if not deciding.sum() > 0.0:  # such as for a single pixel or a row of pixels
        deciding = parts
    (top, bottom), (left, right) = _least_half(deciding)
    within = np.zeros(parts.shape, np.bool_)
    within[top:bottom, left:right] = True
    between = ~black if parts[~black].sum() > 0.0 else np.ones_like(black)
    return NoiseRectangle(
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
    areas -= held / (2.0 * sums[-1, -1])  # of equal areas, prefer the one that holds more
    rows, columns = np.unravel_index(int(areas.argmin()), areas.shape)
    return (
        (int(edges[0][first[rows]]), int(edges[0][end[rows]])),
        (int(edges[1][start[columns]]), int(edges[1][stop[columns]])),
    )
