"""Adaptive sampling: after a pilot with equal sample counts, each pixel is sampled at its own rate.

**Unbiased by construction.** The mean of a pixel's samples is unbiased if their number does not depend on them. With
the metric ``error`` the number is a function of the pilot samples of *other* pixels alone, and pixels use independent
random numbers. Neighbours enter by the 5x5 around the pixel without the pixel itself. Three image-wide numbers would
make a pixel's count depend on its own samples, so each is computed without that pixel. Tiles are coloured like a
chessboard. A pixel on a black tile takes the image's mean from the white tiles. It takes the gain, which decides
whether rates are used at all, from pixels within white tiles. It takes the mean of all weights, which keeps the total
sample count, from pixels whose neighbourhoods do not reach into its tile. No sample is discarded, and no later sample
changes a rate. With adaptive sampling a crop does not reproduce the bits of the full image, because its image-wide
means differ.

**Best rates.** A pixel contributes ``v / (n D)`` to error² (`equaltime.film.error`), with v the variance of one sample,
n the number of samples and D the denominator. If a sample takes c rays, the sum is smallest for a given number of rays
where n grows as ``sqrt(v / (D c))``. The cost is a number of rays and not a measured time, so that a rerun gives the
same image. The estimate of sqrt(v) is the average of the neighbours' standard deviations of single samples, with larger
weights for nearer neighbours. Differences of replicates are not used for v, since they give one number per pixel
instead of eight. Squared deviations are not averaged either: one rare bright sample would draw all other samples to its
neighbourhood, even if there is no other noise there.

**Whether rates pay.** Low-discrepancy points reduce the noise more than single samples show, and a pilot with few
bright paths tells little. So the pilot judges the counts before they are used. The test is independent of the choice: a
pixel's count follows from its neighbours, and its noise from the difference of its own replicates. Over tiles of one
colour this gives the gain in error² times rays (`Gain`). If the gain is above its standard error, pixels of the other
colour get their own rates. Otherwise they all get the same rate. Where a caustic's rare paths make most of the noise,
rates reduce the error only on average over many images. In most images the pilot meets none of these paths, and the
rates send the samples elsewhere.

The other metrics exist for comparison. They use the pixel's own samples, so they are biased, and their results say so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.sums import RADIUS, box_sum, nearest_mean, neighbours, sample_deviations

__all__ = ["METRICS", "PILOT", "Gain", "pilot_statistics"]

Floats = NDArray[np.float64]

PILOT = 8
"""Samples per pixel in the pilot, the short render with equal sample counts from which sampling rates are chosen."""
_TILE = 16
"""Side of a tile, in pixels."""
_LEAST = 0.3
"""Least rate of a pixel, however quiet its neighbours were.

A pilot misses rare bright samples, such as caustics or the rim of a lamp. The error of one grows with the inverse of
its pixel's rate. The variances of long renders give error² times rays, relative to even counts: .89, .86, .97 and .91
with this rate, and .99, .91, .97 and .89 with 0.1. The four scenes are Veach's plates, the Cornell box with a box
filter, a terrain and a windmill."""
_MOST = 0.5
"""Largest share of the image's samples that one tile may receive. The limit is needed because a tile's own weights are
excluded from the mean that normalises them."""
_JUDGED = 64
"""Samples a pixel at which the gain is judged. It is a constant, so that a longer render begins with the bits of a
shorter one. More samples gain more, as the pilot's part shrinks."""


def error_rates(pilot: PixelStatistics, rays: Floats) -> Floats:
    """Return the sampling rate of each pixel, (H, W): its sample count relative to the image's mean count.

    This is the unbiased metric ``error`` of adaptive sampling: noisy pixels get more samples. ``pilot`` holds the
    statistics of a short render with equal sample counts. A pixel's rate depends on the pilot's samples of other pixels
    alone. ``rays`` (H, W) is the number of rays that the pilot traced in each pixel. Where the pilot shows no gain from
    uneven counts, or if the image is smaller than 32 pixels along a side, rates are equal.
    """
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
    """Predicted gain of uneven sampling rates over equal rates, for the decision whether adaptive sampling pays.

    ``value`` is the natural logarithm of the factor by which uneven rates reduce error² times rays; above 0 they pay.
    ``error`` is the standard error of ``value``.
    """

    value: float
    error: float

    @classmethod
    def of(cls, noise: Floats, rays: Floats, rates: Floats, samples: int = _JUDGED) -> Gain:
        """Return the gain of uneven sampling rates over equal rates, predicted from a pilot.

        A pilot is a short render with equal sample counts. The arrays have one element for each pixel that is used.
        ``noise`` is the pixel's contribution to error² in the pilot, and ``rays`` is the number of rays that the pilot
        traced in the pixel. ``rates`` is the pixel's sample count relative to the mean count. No pixel's rate may
        depend on the pixel's own samples. ``samples`` is the mean number of samples per pixel for which the gain is
        predicted. The standard error comes from the influence function, with all pixels taken as independent.
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
        """Whether uneven rates pay: True if the predicted gain is above 0 by more than its standard error."""
        return self.value > self.error


def pilot_statistics(moments: NDArray[Any]) -> PixelStatistics:
    """Return mean, variance and sample count of every pixel of a pilot, a short render that decides sampling rates.

    ``moments`` (R, H, W) holds count, mean and deviation of each pixel's samples, in R replicates (groups of samples).
    The field ``deviation`` of the result is set too: the standard deviation of one sample, (H, W, 3).
    """
    return replace(pixel_statistics(moments), deviation=sample_deviations(moments))


def _tiles(weights: Floats) -> Iterator[tuple[tuple[slice, slice], float]]:
    """Yield every tile with the mean weight of the pixels whose 7x7 neighbourhoods do not reach into it.

    Sums from all four sides end before the tile: a difference of sums would depend on the tile through its rounding
    error.
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
    """Return sampling rates (H, W) that grow linearly with each pixel's own relative standard error in the pilot.

    A rate is a sample count relative to the mean count, and a pilot is a short render with equal counts. A pixel's own
    samples decide its rate, so the image is biased. The metric exists for comparison. The second argument is not used.
    """
    weights = _weights(pilot.variance, pilot.mean, 0.1 * float(pilot.mean.mean()))
    return _relative(weights, float(weights.mean()))


def neighbours_rates(pilot: PixelStatistics, _: Floats) -> Floats:
    """Return sampling rates (H, W) that grow linearly with the relative standard deviation of the 7x7 pixels around.

    A rate is a sample count relative to the mean count. The standard deviation is the scatter of the 49 pixel means of
    the pilot, a short render with equal counts, so both noise and edges raise it. A pixel's own samples contribute to
    its rate, so the image is biased. The metric exists for comparison. The second argument is not used.
    """
    around = neighbours(*pilot.samples.shape)
    local = box_sum(pilot.mean) / around
    scatter = np.maximum(box_sum(np.square(pilot.mean)) / around - np.square(local), 0.0)
    weights = _weights(scatter, local, 0.1 * float(pilot.mean.mean()))
    return _relative(weights, float(weights.mean()))


def cutoff_rates(pilot: PixelStatistics, _: Floats) -> Floats:
    """Return sampling rates (H, W) that stop sampling pixels which seem converged, as many renderers do.

    A rate is a sample count relative to the mean count. It is 0 for pixels with less than half of the image's error (a
    root mean square) in the pilot, a short render with equal counts. All other pixels have equal rates. A pixel's own
    samples decide its rate, so the image is biased. The metric exists for comparison. The second argument is not used.
    """
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
    """Return rates in proportion to the weights, on top of a least rate: 1 for a weight equal to the mean."""
    return _LEAST + (1.0 - _LEAST) * weights / mean if 0.0 < mean < np.inf else np.ones_like(weights)
