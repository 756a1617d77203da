"""Adaptive sampling: after an equal pilot, every pixel's samples grow at a rate of its own.

**Unbiased by construction.** The mean of a pixel's samples is unbiased if their number does not depend on them. With
the metric ``error`` it does not: the number is a function of the pilot samples of *other* pixels alone, and pixels use
independent random numbers. Neighbours enter by the 5x5 around the pixel without the pixel itself. Three numbers that
belong to the whole image would let the pixel in by the back door. For its mean a pixel on a black tile of a chessboard
takes that of the white ones; for whether it is worth while, the gain within these; and for the mean of all weights,
which keeps the total, that of those whose neighbourhoods do not reach into its tile. No sample is discarded, and no
later one changes a rate. A crop is an image by itself, with another mean: here alone it has not the bits of the whole.

**What is best.** A pixel's part of error² (`equaltime.film.error`) is ``v / (n D)``, v the variance of one sample,
n their number, D the denominator; if a sample takes c rays, the sum is smallest for a given number of rays where n
grows as ``sqrt(v / (D c))``. Rays are counted, since a clock would make every rerun another image. For sqrt(v) the
neighbours' standard deviations of single samples are averaged, the nearer ones by more: not the differences of their
replicates, which are one number where those are eight, and not their squares, of which one rare bright sample would
send all the others to where nothing else is.

**Whether it is worth while.** Even points make less of the noise than single samples show, and a pilot of few events
knows little. So the pilot judges the counts before they are used, by numbers that did not choose them: a pixel's counts
follow from its neighbours, and its noise from the difference of its own replicates. Over tiles of one colour this gives
the gain in error² times rays (`Gain`). If it is above its standard error, pixels of the other colour get their rates,
and otherwise all alike. Where a caustic's rare paths make most of the noise, the gain is one of the mean over many
images: most of them meet none of these paths, and have spent their samples elsewhere.

The other metrics are there to be compared with: they look at the pixel itself, so they are biased, and named so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.neighbourhoods import RADIUS, neighbours
from equaltime.film.sums import box_sum, nearest_mean, sample_deviations

__all__ = ["METRICS", "PILOT", "Gain", "pilot_statistics"]

Floats = NDArray[np.float64]

PILOT = 8
"""Samples that every pixel gets before anything is decided."""
_TILE = 16
"""Side of a tile, in pixels."""
_LEAST = 0.1
"""The rate that every pixel has however quiet its neighbours were, since a pilot sees little."""
_MOST = 0.5
"""Of the image's samples: what one tile may add to them, which does not see its own weights in the mean."""
_JUDGED = 64
"""Samples a pixel at which the gain is judged. It is one number, so that a longer render begins with the bits of a
shorter one; more samples gain more, as they leave the pilot behind."""


def error_rates(pilot: PixelStatistics, rays: Floats) -> Floats:
    """Return rates (H, W) of mean about 1 from the pilot of other pixels, as said above."""
    height, width = pilot.samples.shape
    if min(height, width) < 2 * _TILE:
        return np.ones((height, width))
    deviation = np.sqrt(pilot.variance * PILOT) if pilot.deviation is None else pilot.deviation
    variance, local = np.square(nearest_mean(deviation)), nearest_mean(pilot.mean)
    cost = np.sqrt(np.maximum(nearest_mean(rays[..., None])[..., 0], 1.0))
    rows, columns = (np.arange(length) // _TILE for length in (height, width))
    colours = (rows[:, None] + columns[None, :]) % 2
    rates = np.empty((height, width))
    for colour in (0, 1):
        dark = 0.1 * float(pilot.mean[colours != colour].mean())
        weights = _weights(variance, local, dark) / cost
        inner = np.logical_and.outer(*(_within_tile(length) for length in (height, width))) & (colours != colour)
        noise = np.square(_weights(pilot.variance, pilot.mean, dark))
        if not Gain.of(noise[inner], rays[inner], _relative(weights[inner], float(weights[inner].mean()))).sure:
            rates[colours == colour] = 1.0
            continue
        for tile, elsewhere in _tiles(weights):
            if colours[tile][0, 0] == colour:
                rates[tile] = _relative(weights[tile], elsewhere)
    return np.asarray(np.minimum(rates, _MOST * height * width / _TILE**2))


def _within_tile(length: int) -> NDArray[np.bool_]:
    """Tell for each row or column whether the neighbourhoods of its pixels stay within its tiles."""
    place = np.arange(length) % _TILE
    return np.asarray((place >= RADIUS) & (place < _TILE - RADIUS))


@dataclass(frozen=True)
class Gain:
    """The logarithm of error² times rays with even counts over that with counts by rates, and its standard error."""

    value: float
    error: float

    @classmethod
    def of(cls, noise: Floats, rays: Floats, rates: Floats, samples: int = _JUDGED) -> Gain:
        """Judge rates by what pixels have of error² and of rays in an even pilot; no rate may follow from its pixel's.

        All pixels count alike for the standard error, as if they were independent (the influence function).
        """
        counts = PILOT / samples + rates * (1.0 - PILOT / samples)
        even, uneven = (noise, rays), (noise / counts, rays * counts)
        if not all(part.sum() > 0.0 for part in even):
            return cls(0.0, math.inf)
        value = sum(math.log(part.sum()) for part in even) - sum(math.log(part.sum()) for part in uneven)
        influence = sum(part / part.sum() for part in even) - sum(part / part.sum() for part in uneven)
        return cls(value, float(np.sqrt(np.square(influence).sum())))

    @property
    def sure(self) -> bool:
        """Whether the gain is above 0 by more than its standard error."""
        return self.value > self.error


def pilot_statistics(moments: NDArray[Any]) -> PixelStatistics:
    """Return what is known of every pixel after the pilot, with the deviation of its samples."""
    return replace(pixel_statistics(moments), deviation=sample_deviations(moments))


def _tiles(weights: Floats) -> Iterator[tuple[tuple[slice, slice], float]]:
    """Give every tile with the mean weight of the pixels whose 7x7 neighbourhoods do not reach into it.

    Sums from all four sides that end before the tile: a difference of sums would leave a rounding error of its own.
    """
    height, width = weights.shape
    padded = np.zeros((height + 1, width + 1))
    padded[1:, 1:] = weights
    from_left = padded.cumsum(axis=1)[1:]
    from_right = np.pad(weights[:, ::-1].cumsum(axis=1)[:, ::-1], ((0, 0), (0, 1)))
    from_top = from_left[:, -1].cumsum()
    from_top, from_bottom = np.concatenate([[0.0], from_top]), np.append(from_left[::-1, -1].cumsum()[::-1], 0.0)
    for y in range(0, height, _TILE):
        top, bottom = max(y - RADIUS, 0), min(y + _TILE + RADIUS, height)
        left_sums, right_sums = from_left[top:bottom].sum(axis=0), from_right[top:bottom].sum(axis=0)
        for x in range(0, width, _TILE):
            left, right = max(x - RADIUS, 0), min(x + _TILE + RADIUS, width)
            total = from_top[top] + from_bottom[bottom] + left_sums[left] + right_sums[right]
            pixels = height * width - (bottom - top) * (right - left)
            yield (slice(y, y + _TILE), slice(x, x + _TILE)), float(total) / pixels


def history_rates(pilot: PixelStatistics, _: Floats) -> Floats:
    """Return rates in proportion to the pixel's own relative standard error."""
    weights = _weights(pilot.variance, pilot.mean, 0.1 * float(pilot.mean.mean()))
    return _relative(weights, float(weights.mean()))


def neighbours_rates(pilot: PixelStatistics, _: Floats) -> Floats:
    """Return rates in proportion to how far values scatter over the 7x7 around the pixel, which noise and edges do."""
    around = neighbours(*pilot.samples.shape)
    local = box_sum(pilot.mean) / around
    scatter = np.maximum(box_sum(np.square(pilot.mean)) / around - np.square(local), 0.0)
    weights = _weights(scatter, local, 0.1 * float(pilot.mean.mean()))
    return _relative(weights, float(weights.mean()))


def cutoff_rates(pilot: PixelStatistics, _: Floats) -> Floats:
    """Return rates 0 where the pixel's own error seems below half the image's, and alike elsewhere: the common rule."""
    weights = _weights(pilot.variance, pilot.mean, 0.1 * float(pilot.mean.mean()))
    goes_on = weights > 0.5 * float(np.sqrt(np.square(weights).mean()))
    return goes_on / max(float(goes_on.mean()), 1e-3)


METRICS: Mapping[str, Callable[[PixelStatistics, Floats], Floats]] = {
    "error": error_rates,
    "history": history_rates,
    "neighbours": neighbours_rates,
    "cutoff": cutoff_rates,
}


def _weights(variance: Floats, value: Floats, dark: float) -> Floats:
    """Return the square root of the mean over RGB of ``variance / (value² + dark²)``, (H, W); 0 in a black image."""
    floor = max(dark, np.finfo(np.float64).tiny ** 0.25)
    red, green, blue = np.moveaxis(variance / (np.square(value) + floor**2), -1, 0)
    return np.asarray(np.sqrt((red + green + blue) / 3.0))  # a mean over so short an axis takes three times as long


def _relative(weights: Floats, mean: float) -> Floats:
    """Return rates in proportion to the weights, on top of a least: 1 for a weight that is the mean."""
    return _LEAST + (1.0 - _LEAST) * weights / mean if 0.0 < mean < np.inf else np.ones_like(weights)
