"""Lamps that are in sight but smaller than a pixel: what a render lacks whose samples have not met them.

A lamp that fills a thousandth of a pixel is met by one sample of a thousand. Until then the pixel's samples agree that
it is dark, and with low-discrepancy samples both replicates soon agree again, that each has met it once: either way its
variance seems to be nothing. But lamps know where they are. Points of them, seen through the film from their side, say
what share ``a`` of a pixel's samples meet one, and what mean light ``l`` that adds; 4096 points take milliseconds.

Of the ``n`` samples of a replicate, ``x = n a`` should meet the lamp. If these are as even as can be, ``x`` rounded
down or up do, by chance. Where that is the same number in all R replicates they agree, and error² lacks ``l²`` times

- 1, if none meets it though ``x`` is not so small any more;
- ``(1/x - 1)²``, if each meets it once though ``x < 1/2``: too bright, since that should take ``1/x`` replicates;
- ``(d/x)²`` beyond, with ``d < 1`` what rounding makes of ``x``: less and less.

The worst of these that is not too rare for the level of a limit (one of chance ``x`` has the chance ``x^R`` in all) is
added, where the pixels of lamps around do not show as much by themselves. Several lamps are unlikely to have the worst
of luck together: what is beyond the mean of each adds up by squares. It widens the upper limit of the error, and never
moves the estimate.
"""

from __future__ import annotations

import math
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

    def __call__(self, pixels: PixelStatistics, level: float) -> float:
        """Return the part of error² that may be missing, below which it is with the confidence of an upper limit."""
        replicates = pixels.degrees + 1.0
        expected = pixels.samples.ravel()[self.pixels] / replicates * self.share
        lacking = (expected > 0.0) & (expected < _MANY)
        if not lacking.any():
            return 0.0
        where, expected, light = self.pixels[lacking], expected[lacking], self.light[lacking]
        mean, variance = (of.reshape(-1, 3)[where] for of in (pixels.mean, pixels.variance))
        rare = (0.5 * (1.0 - level)) ** (1.0 / replicates)
        by_mean, by_worst = _times(expected, rare)
        # what the truth is if the image is wrong by the worst: brighter, or darker but no darker than the lamp alone
        off = np.where(expected < rare, 1.0, -np.sqrt(by_worst))[:, None] * light
        floor = (0.1 * float(pixels.mean.mean())) ** 2
        denominator = np.square(np.maximum(mean + off, light)) + floor
        square, seen = ((of / denominator).mean(axis=-1) for of in (np.square(light), variance))
        by_mean, by_worst = square * by_mean, square * by_worst
        beyond = math.sqrt(float(np.square(by_worst - by_mean).sum()))
        whole = by_mean * (1.0 + beyond / max(float(by_mean.sum()), np.finfo(np.float64).tiny))
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


def _times(expected: Floats, rare: float) -> tuple[Floats, Floats]:
    """Return by which multiple of its square the light of a lamp is wrong unseen: its mean, and at worst.

    ``rare`` is how often a replicate meets the lamp that is hardly met by all of them.
    """
    missed = np.maximum(1.0 - expected, 0.0) / expected
    worst = np.where(expected < rare, 1.0, np.maximum(missed, np.minimum(1.0, (1.0 - rare) / expected)) ** 2)
    mean = np.where(expected < 0.5, 2.0 * np.square(1.0 - expected), 0.125 / expected**2)
    return np.minimum(mean, worst), worst
