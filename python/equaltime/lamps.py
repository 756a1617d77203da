"""Lamps that are in sight but smaller than a pixel: what a render lacks whose samples have not met them.

A lamp that fills a thousandth of a pixel is met by one sample of a thousand. Until then the pixel's samples agree that
it is dark, and with low-discrepancy samples both replicates soon agree again, that each has met it once: either way its
variance seems to be nothing. But lamps know where they are. Points of them, seen through the film from their side, say
what share ``a`` of a pixel's samples meet one, and what mean light ``l`` that adds; 4096 points take milliseconds.

Of the ``n`` samples of a replicate, ``x = n a`` should meet the lamp. If these are as even as can be, ``x`` rounded
down or up do, by chance. Where that is the same number in all R replicates they agree, on what is wrong by ``l²`` if
none meets it, and by ``(1/x - 1)² l²`` if each meets it once too soon. The mean of that over all cases of agreement is

    ``((1 - x)^R + x^R (1/x - 1)²) / ((1 - x)^R + x^R) l²``

up to ``x = 1/2``, and ``(l/2x)²`` at most beyond. That is added where the pixels of lamps around do not show as much by
themselves; it widens the upper limit of the error, and never moves the estimate. Being a mean, it is less than the
worst luck where one lamp makes the error: with ``x`` from 0.3 to 0.6 up to 18 % of the limits at 97.5 % are too low.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.error_estimate import PixelStatistics
from equaltime.film import box_sum, lamps_in_sight
from equaltime.neighbourhoods import neighbours, window_around

__all__ = ["Lamps"]

Floats = NDArray[np.float64]

_POINTS = 4096
_LEAST_POINTS = 32
"""Fewer of a pixel do not tell a small lamp from a part of a large one."""
_LARGEST = 0.25
"""Share of a pixel: what fills more is met by the first samples."""
_MANY = 20.0
"""Samples of a replicate that meet the lamp: then replicates tell."""


@dataclass(frozen=True, eq=False)
class Lamps:
    """Small lamps in sight."""

    pixels: NDArray[np.intp]
    """(N,): those that see any, in the order of ``y * width + x``."""
    light: Floats
    """(N, 3): what lamps add to the mean of each, in the units of the image."""
    share: Floats
    """(N,): of the samples of each, those that meet one."""

    @classmethod
    def of(cls, scene: Any, settings: Any, seed: int) -> Lamps:
        """Return those of the core's scene."""
        pixels, moments, points = lamps_in_sight(scene, settings, seed, _POINTS)
        with np.errstate(over="ignore", invalid="ignore"):  # what float64 cannot square has no share
            light, squares = moments[:, 0], moments[:, 1].sum(axis=-1)
            # of a lamp of one radiance, exactly its share; of several, nearly that of the brightest
            share = np.square(light).sum(axis=-1) / np.maximum(squares, np.finfo(np.float64).tiny)
        small = (points >= _LEAST_POINTS) & (share > 0.0) & (share < _LARGEST)
        return cls(pixels[small].astype(np.intp), light[small], share[small])

    @classmethod
    def none(cls) -> Lamps:
        """Return no lamp at all."""
        return cls(np.zeros(0, np.intp), np.zeros((0, 3)), np.zeros(0))

    @classmethod
    def from_channels(cls, *parts: NDArray[np.float32]) -> Lamps:
        """Return those that the `channels` of renders of one image tell of: the larger of what they say."""
        if not parts:
            return cls.none()
        planes = reduce(np.fmax, parts).reshape(-1, 4)
        pixels = np.flatnonzero(planes[:, 3] > 0.0)
        return cls(pixels, planes[pixels, :3].astype(np.float64), planes[pixels, 3].astype(np.float64))

    def channels(self, height: int, width: int) -> NDArray[np.float32]:
        """Return light and share as an image (H, W, 4), for a file."""
        planes = np.zeros((height * width, 4), np.float32)
        planes[self.pixels, :3] = np.minimum(self.light, np.finfo(np.float32).max)
        planes[self.pixels, 3] = self.share
        return planes.reshape(height, width, 4)

    def __call__(self, pixels: PixelStatistics) -> float:
        """Return the part of error² that samples do not show, on average."""
        replicates = pixels.degrees + 1.0
        expected = pixels.samples.ravel()[self.pixels] / replicates * self.share
        lacking = (expected > 0.0) & (expected < _MANY)
        if not lacking.any():
            return 0.0
        where, expected, light = self.pixels[lacking], expected[lacking], self.light[lacking]
        mean, variance = (of.reshape(-1, 3)[where] for of in (pixels.mean, pixels.variance))
        # the truth is no darker than what lamps add
        denominator = np.square(np.maximum(mean, light)) + (0.1 * float(pixels.mean.mean())) ** 2
        square, seen = ((of / denominator).mean(axis=-1) for of in (np.square(light), variance))
        whole = square * _times(expected, replicates)
        return self._not_shown(where, whole - seen, pixels.samples.shape) / pixels.samples.size

    @staticmethod
    def _not_shown(where: NDArray[np.intp], more: Floats, shape: tuple[int, ...]) -> float:
        """Return the sum of what some pixels lack beyond what they show, averaged over neighbourhoods."""
        mask = np.zeros(shape, np.bool_)
        mask.flat[where] = True
        near = window_around(mask)
        image = np.zeros((*mask[near].shape, 1))
        image[mask[near], 0] = more
        return float(np.maximum(box_sum(image / neighbours(*shape)[near]), 0.0).sum())


def _times(expected: Floats, replicates: float) -> Floats:
    """Return by which multiple of its square the light of a lamp is wrong where replicates agree, on average."""
    few = np.minimum(expected, 0.5)
    none, each = (1.0 - few) ** replicates, few**replicates
    return np.where(expected < 0.5, (none + each * np.square(1.0 / few - 1.0)) / (none + each), 0.25 / expected**2)
