"""Lamps that are in sight but smaller than a pixel: what a render lacks whose samples have not met them.

In sight are lamps that the camera sees, and those that it sees in mirrors and through glass, which chains of specular
vertices find from the camera's side.

A lamp that fills a thousandth of a pixel is met by one sample of a thousand. Until then the pixel's samples agree that
it is dark, and with low-discrepancy samples both replicates soon agree again, that each has met it once: either way its
variance seems to be nothing. But lamps know where they are. Points of them, seen through the film from their side, say
what share ``a`` of a pixel's samples meet one, and what mean light ``l`` that adds; 4096 points take milliseconds.

Of the ``n`` samples of a replicate, ``x = n a`` should meet the lamp, and some whole number ``k`` of them does. Where
all R replicates agree on it, they agree on what is wrong by ``(k/x - 1) l``. The chance of that is ``p(k)^R``; p is
Poisson's chance, of the three ``k`` nearest ``x`` (samples may be more even, but are less so where a pixel sees a
sliver). A pixel has met no more lamps than it is bright: a dark one knows ``k``. The mean over all ``k`` is what
agreement hides.

Replicates that differ show more than they are wrong by, on average just as much as agreement hides, since their
variance is unbiased. That is taken off: over many pixels the two balance, and what is left is of the few that make
much of the error. Of one of them, that makes the most of it, the worst ``k`` counts and not the mean, if its chance is
2.5 % or more.

A lamp that one replicate has met much too soon shows, but makes its neighbourhood, by which errors are divided, too
bright as well. What the estimate would be more by if such lamps were no brighter than they are is added too. All this
widens the upper limit of the error, and never moves the estimate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics
from equaltime.film.sums import error_contributions, lamps_in_sight, mirrored_lamps

__all__ = ["Lamps"]

Floats = NDArray[np.float64]

_POINTS = 4096
_CHAINS = 2**17
"""Specular chains that look for lamps in mirrors, a tenth of a second of one core; or one a pixel of a large image."""
_LARGEST = 0.25
"""Share of a pixel: what fills more is met by the first samples."""
_SURELY = 3.0
"""Standard deviations, of its points, by which a share is surely below that: few points tell little."""
_LEAST, _MANY = 1e-9, 20.0
"""Samples of a replicate that should meet the lamp: as good as none, and so many that replicates tell."""
_ROUNDING = 0.05
"""Of the light that meetings make, at most: what is known of it comes from few points."""
_RARE = 0.025
"""Chance of what an upper limit need not hold."""
_DOUBTED = 2.0
"""Standard deviations by which light is surely there: what few points or chains tell is less certain."""


@dataclass(frozen=True, eq=False)
class Lamps:
    """Lamps in sight: small ones, of which samples may miss some, and the light of all."""

    pixels: NDArray[np.intp]
    """(N,): those that see small lamps, in the order of ``y * width + x``."""
    light: Floats
    """(N, 3): what small lamps add to the mean of each, in the units of the image."""
    share: Floats
    """(N,): of the samples of each, those that meet one."""
    lit: NDArray[np.intp]
    """(M,): pixels that see lamps of any size, in the same order."""
    surely: Floats
    """(M, 3): the light of lamps that is certainly in the mean of each, however few points or chains found it."""

    @classmethod
    def of(cls, scene: Any, settings: Any, seed: int, threads: int, mirrors: bool) -> Lamps:
        """Return those of the core's scene; in mirrors too, if there are specular surfaces that send light on."""
        found = [lamps_in_sight(scene, settings, seed, _POINTS)]
        if mirrors:
            found.append(mirrored_lamps(scene, settings, seed, threads, _CHAINS))
        lit, each = np.unique(np.concatenate([pixels for pixels, _, _ in found]), return_inverse=True)
        points, moments = np.zeros(len(lit)), np.zeros((len(lit), 2, 3))
        np.add.at(points, each, np.concatenate([number for _, _, number in found]))
        np.add.at(moments, each, np.concatenate([both for _, both, _ in found]))
        with np.errstate(over="ignore", invalid="ignore"):  # what float64 cannot square has no share
            light, squares = moments[:, 0], moments[:, 1].sum(axis=-1)
            # of a lamp of one radiance, exactly its share; of several, nearly that of the brightest
            share = np.square(light).sum(axis=-1) / np.maximum(squares, np.finfo(np.float64).tiny)
        small = (share > 0.0) & (share * (1.0 + _SURELY / np.sqrt(points)) < _LARGEST)
        surely = np.maximum(1.0 - _DOUBTED / np.sqrt(points), 0.0)[:, None] * light
        lit = lit.astype(np.intp)
        return cls(lit[small], light[small], share[small], lit, surely)

    @classmethod
    def none(cls) -> Lamps:
        """Return no lamp at all."""
        return cls.small(np.zeros(0, np.intp), np.zeros((0, 3)), np.zeros(0))

    @classmethod
    def small(cls, pixels: NDArray[np.intp], light: Floats, share: Floats) -> Lamps:
        """Return small lamps alone, of which everything is certain."""
        return cls(pixels, light, share, pixels, light)

    def least(self, height: int, width: int) -> Floats | None:
        """Return the light (H, W, 3) that is surely in the mean of each pixel; None where no lamp is in sight."""
        if not self.lit.size:
            return None
        light = np.zeros((height * width, 3))
        light[self.lit] = self.surely
        return light.reshape(height, width, 3)

    @classmethod
    def from_channels(cls, *parts: NDArray[np.float32]) -> Lamps:
        """Return those that the `channels` of renders of one image tell of: the larger of what they say."""
        if not parts:
            return cls.none()
        planes = reduce(np.fmax, parts).reshape(-1, 4)
        pixels = np.flatnonzero(planes[:, 3] > 0.0)
        return cls.small(pixels, planes[pixels, :3].astype(np.float64), planes[pixels, 3].astype(np.float64))

    def channels(self, height: int, width: int) -> NDArray[np.float32]:
        """Return light and share of small lamps as an image (H, W, 4), for a file."""
        planes = np.zeros((height * width, 4), np.float32)
        planes[self.pixels, :3] = np.minimum(self.light, np.finfo(np.float32).max)
        planes[self.pixels, 3] = self.share
        return planes.reshape(height, width, 4)

    def missed(self, pixels: PixelStatistics) -> float:
        """Return the part of error² that replicates hide by agreeing."""
        replicates = pixels.degrees + 1.0
        lacking, x = self._lacking(pixels, _MANY)
        if not lacking.any():
            return 0.0
        light = self.light[lacking]
        mean, variance = (of.reshape(-1, 3)[self.pixels[lacking]] for of in (pixels.mean, pixels.spread))
        floor = (0.1 * float(pixels.mean.mean())) ** 2
        # the truth is no darker than what lamps add
        denominator = np.square(np.maximum(mean, light)) + floor
        square, seen = ((of / denominator).mean(axis=-1) for of in (np.square(light), variance))
        times, alike = _meetings(x, replicates)
        agreeing = 1.0 - np.minimum(seen * np.square(replicates * x) / square, 1.0)
        more = (alike * np.square(times - 1.0)).sum(axis=-1) / (1.0 - alike.sum(axis=-1)) * square
        hidden, worst = _hidden(times, alike, light, mean, floor)
        whole = float((agreeing * hidden - (1.0 - agreeing) * more).sum() + (agreeing * (worst - hidden)).max())
        return max(whole, 0.0) / pixels.samples.size

    def outshone(self, pixels: PixelStatistics) -> float:
        """Return by how much error² would be estimated higher if no lamp that was met too soon were in the image."""
        replicates = pixels.degrees + 1.0
        lacking, x = self._lacking(pixels, 1.0 / replicates)  # beyond, a single meeting is not too soon
        where, light = self.pixels[lacking], self.light[lacking]
        mean, variance = (of.reshape(-1, 3)[where] for of in (pixels.mean, pixels.spread))
        # what k meetings in one replicate add to the mean they add to its standard error
        met = replicates * x * np.sqrt(variance.sum(axis=-1) / np.square(light).sum(axis=-1))
        too_much = np.maximum(np.floor(met * (1.0 + _ROUNDING)) / (replicates * x) - 1.0, 0.0)[:, None] * light
        wrong = np.minimum(too_much, np.maximum(mean - light, 0.0))
        if not wrong.any():
            return 0.0
        bright = where[wrong.any(axis=-1)]
        image, noise = pixels.mean.copy(), pixels.variance.copy()
        image.reshape(-1, 3)[where] -= wrong
        noise.reshape(-1, 3)[bright] = 0.0
        floors = [(0.1 * float(of.mean())) ** 2 for of in (pixels.mean, image)]
        now = error_contributions(pixels.mean, pixels.variance, pixels.samples, floors[0])[0][0].sum()
        others = error_contributions(image, noise, pixels.samples, floors[1])[0][0].sum()
        theirs = (np.square(wrong) / (np.square(mean - wrong) + floors[1])).mean(axis=-1).sum()
        return max(float(others + theirs - now), 0.0) / pixels.samples.size

    def _lacking(self, pixels: PixelStatistics, most: float) -> tuple[NDArray[np.bool_], Floats]:
        """Tell which have been met less often than ``most`` in each replicate, as is expected, and how often."""
        expected = pixels.samples.ravel()[self.pixels] / (pixels.degrees + 1.0) * self.share
        lacking = (expected > 0.0) & (expected < most)
        return lacking, np.maximum(expected[lacking], _LEAST)


def _meetings(expected: Floats, replicates: float) -> tuple[Floats, Floats]:
    """Return how often lamps may have been met, over what was expected, and the chance that all agree on it, (N, 3)."""
    expected = expected[:, None]
    times = np.maximum(np.ceil(expected - 1.5), 0.0) + np.arange(3.0)
    # over Poisson's chance of the first, which is the same factor for all
    chances = np.cumprod(np.where(np.arange(3) > 0, expected / np.maximum(times, 1.0), 1.0), axis=-1)
    return times / expected, (chances / chances.sum(axis=-1, keepdims=True)) ** replicates


def _hidden(times: Floats, alike: Floats, light: Floats, mean: Floats, floor: float) -> tuple[Floats, Floats]:
    """Return each pixel's part of error² where replicates agree: its mean, and the worst that is not rare, (N,)."""
    times, light, mean = times[..., None], light[:, None], mean[:, None]
    wrong = (times - 1.0) * light
    parts = (np.square(wrong) / (np.square(np.maximum(mean - wrong, light)) + floor)).mean(axis=-1)
    possible = (times == 0.0) | (mean > (1.0 - _ROUNDING) * times * light)
    chances = alike * possible.all(axis=-1)
    chances[:, 0] = np.maximum(chances[:, 0], np.finfo(np.float64).tiny)  # where nothing else is possible
    chances /= chances.sum(axis=-1, keepdims=True)
    return (chances * parts).sum(axis=-1), np.where(chances >= _RARE, parts, 0.0).max(axis=-1)
