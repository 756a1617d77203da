"""Lamps that are in sight but smaller than a pixel: the light that a render lacks while its samples miss them.

A lamp is in sight if the camera sees it directly, in mirrors or through glass. Lamps in mirrors or behind glass are
found by chains of specular vertices from the camera's side.

A lamp that fills a thousandth of a pixel is met by one sample of a thousand. Until then the pixel's samples agree that
it is dark. With low-discrepancy samples both replicates (halves of the samples) soon agree again, once each has met the
lamp once. In both cases the pixel's variance seems to be zero. But the positions of lamps are known. Points on the
lamps are projected onto the film. They tell the share ``a`` of a pixel's samples that meet a lamp, and the light ``l``
that the lamp adds to the pixel's mean. 4096 points take milliseconds.

A replicate of ``n`` samples is expected to meet the lamp ``x = n a`` times, and meets it ``k`` times, a whole number.
If all R replicates have the same ``k``, their common error is ``(k/x - 1) l``. The probability of this case is
``p(k)^R``. Here p is Poisson's distribution, restricted to the three ``k`` nearest ``x``. Low-discrepancy samples may
be more even than that, but are less even where a pixel sees a thin sliver of a lamp. The brightness of a pixel limits
``k``; in a dark pixel ``k`` is 0. While replicates agree, the square of the error, averaged over all ``k``, stays
hidden.

Replicates with different ``k`` show more error than there is. On average this excess equals the hidden error, since the
estimated variance is unbiased. The excess is subtracted. Over many pixels excess and hidden error balance, and the
remainder is due to the few pixels that make much of the error. For the pixel that contributes most, use the worst ``k``
with a chance of at least 2.5 % instead of the mean over ``k``.

If one replicate has met a lamp much too soon, the variance shows it. But the lamp also makes its neighbourhood too
bright, and errors are divided by this brightness. With the true brightness of such lamps the estimate would be higher.
That rise is added too. The hidden error and the rise widen the upper limit of the error, and never move the estimate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics
from equaltime.film.sums import error_contributions, error_floor, lamps_in_sight, mirrored_lamps

__all__ = ["Lamps"]

Floats = NDArray[np.float64]

_Found = tuple[NDArray[Any], Floats, NDArray[Any]]
"""Pixels, moments and numbers of points, as the core's searches for lamps return them."""

_POINTS = 4096
_CHAINS = 2**15
"""Number of specular chains that search for lamps in mirrors, a fortieth of a second of one core; a large image gets a
chain for four pixels."""
_LARGEST = 0.25
"""Largest share of a pixel that a small lamp fills; the first samples meet a larger one."""
_SURELY = 3.0
"""Standard deviations, from its points, by which a share must be below `_LARGEST`: few points tell little."""
_LEAST, _MANY = 1e-9, 20.0
"""Range of the expected number of times that a replicate meets a lamp. Fewer count as none; with more, the replicates'
variance shows the lamp."""
_ROUNDING = 0.05
"""Largest relative error of the light of meetings: it is estimated from few points."""
_RARE = 0.025
"""Chance below which a case need not be covered by an upper limit."""
_DOUBTED = 2.0
"""Standard deviations subtracted from light that is surely there: few points or chains make it uncertain."""
_MIRRORED: WeakKeyDictionary[Any, dict[int, _Found]] = WeakKeyDictionary()
"""Lamps in mirrors by scene and largest depth. The search takes as long as a few samples a pixel of a small image."""


@dataclass(frozen=True, eq=False)
class Lamps:
    """Lamps that the camera sees, by pixel, to find the light that a render lacks while its samples miss small lamps.

    The fields ``pixels``, ``light`` and ``share`` describe small lamps, which fill less than a quarter of a pixel, so
    that its samples may miss them. The fields ``lit`` and ``surely`` describe lamps of any size.
    """

    pixels: NDArray[np.intp]
    """(N,): pixels that see small lamps, as ``y * width + x``, in ascending order."""
    light: Floats
    """(N, 3): light that small lamps add to the mean of each pixel, in the units of the image."""
    share: Floats
    """(N,): share of each pixel's samples that meet a small lamp."""
    lit: NDArray[np.intp]
    """(M,): pixels that see lamps of any size, as ``y * width + x``, in ascending order."""
    surely: Floats
    """(M, 3): light of lamps that is certainly in the mean of each pixel of ``lit``: the estimate minus 2 standard
    deviations."""

    @classmethod
    def of(cls, scene: Any, settings: Any, seed: int, threads: int, mirrors: bool) -> Lamps:
        """Return the lamps that the camera of the core's scene sees, with their light in each pixel.

        ``settings`` are the core's settings of the render, and ``seed`` draws the points on lamps that are projected
        onto the film. With ``mirrors``, lamps that the camera sees in mirrors or through glass are included. This
        slower search uses ``threads`` threads, runs once for each scene, and does not depend on the seed.
        """
        found = [lamps_in_sight(scene, settings, seed, _POINTS)]
        if mirrors:
            found.append(_in_mirrors(scene, settings, threads))
        return cls._made_of(found)

    @classmethod
    def in_plain_sight(cls, scene: Any, settings: Any) -> Lamps:
        """Return the lamps that the camera of the core's ``scene`` sees directly, not in mirrors or through glass.

        The result covers all pixels of the film: the crop window has no effect. Its pixels are numbered by
        ``y * width + x``, with x, y and width in the whole film. ``settings`` are the core's settings of a render.
        """
        return cls._made_of([lamps_in_sight(scene, settings, 0, _POINTS, whole_film=True)])

    @classmethod
    def _made_of(cls, found: list[_Found]) -> Lamps:
        """Return lamps from pixels, moments and numbers of points, as the core's searches return them."""
        lit, each = np.unique(np.concatenate([pixels for pixels, _, _ in found]), return_inverse=True)
        points, moments = np.zeros(len(lit)), np.zeros((len(lit), 2, 3))
        np.add.at(points, each, np.concatenate([number for _, _, number in found]))
        np.add.at(moments, each, np.concatenate([both for _, both, _ in found]))
        with np.errstate(over="ignore", invalid="ignore"):  # a number whose square overflows has no share
            light, squares = moments[:, 0], moments[:, 1].sum(axis=-1)
            # for a lamp of one radiance, exactly its share; for several, nearly the share of the brightest
            share = np.square(light).sum(axis=-1) / np.maximum(squares, np.finfo(np.float64).tiny)
        small = (share > 0.0) & (share * (1.0 + _SURELY / np.sqrt(points)) < _LARGEST)
        surely = np.maximum(1.0 - _DOUBTED / np.sqrt(points), 0.0)[:, None] * light
        lit = lit.astype(np.intp)
        return cls(lit[small], light[small], share[small], lit, surely)

    @classmethod
    def none(cls) -> Lamps:
        """Return an empty set of lamps, for a scene in which the camera sees none."""
        return cls.small(np.zeros(0, np.intp), np.zeros((0, 3)), np.zeros(0))

    @classmethod
    def small(cls, pixels: NDArray[np.intp], light: Floats, share: Floats) -> Lamps:
        """Return a set of lamps that are all small, and whose light is known exactly.

        ``pixels`` (N,) are the indices ``y * width + x`` of the pixels that see a lamp. ``light`` (N, 3) is the light
        that lamps add to the mean of each of these pixels. ``share`` (N,) is the share of the pixel's samples that meet
        a lamp.
        """
        return cls(pixels, light, share, pixels, light)

    @property
    def mostly_small(self) -> bool:
        """Whether the lamps in sight are mostly smaller than a pixel.

        It is True if lamps fill less than a quarter of the pixel in more than three quarters of the pixels that see a
        lamp. Large lamps have such pixels along their edges, but fewer: at most 44 % of their pixels, in films of
        256x256 of five scenes.
        """
        return 4 * self.pixels.size > 3 * self.lit.size

    def least(self, height: int, width: int) -> Floats | None:
        """Return the light of lamps that is certainly in each pixel's mean, (H, W, 3); None if no lamp is in sight.

        H is ``height`` and W is ``width``, in pixels.
        """
        if not self.lit.size:
            return None
        light = np.zeros((height * width, 3))
        light[self.lit] = self.surely
        return light.reshape(height, width, 3)

    @classmethod
    def from_channels(cls, *parts: NDArray[np.float32]) -> Lamps:
        """Return the small lamps that the files of one or more renders of one image store.

        Each of ``parts`` is an image (H, W, 4) made by `Lamps.channels`: R, G, B of the lamps' light, and the share of
        samples that meet a lamp. If the images differ in a pixel, the larger values count. Without images, the set of
        lamps is empty.
        """
        if not parts:
            return cls.none()
        planes = reduce(np.fmax, parts).reshape(-1, 4)
        pixels = np.flatnonzero(planes[:, 3] > 0.0)
        return cls.small(pixels, planes[pixels, :3].astype(np.float64), planes[pixels, 3].astype(np.float64))

    def channels(self, height: int, width: int) -> NDArray[np.float32]:
        """Return the small lamps as an image (H, W, 4), for a file; H is ``height`` and W is ``width``, in pixels.

        The channels are the light that lamps add to the pixel (R, G, B), and the share of its samples that meet a lamp.
        """
        planes = np.zeros((height * width, 4), np.float32)
        planes[self.pixels, :3] = np.minimum(self.light, np.finfo(np.float32).max)
        planes[self.pixels, 3] = self.share
        return planes.reshape(height, width, 4)

    def missed(self, pixels: PixelStatistics) -> float:
        """Return the error² that variances do not show because all replicates met the small lamps equally often.

        ``pixels`` are the statistics of the image. Replicates are groups of a pixel's samples, whose difference gives
        the pixel's variance. If equally many samples of each replicate meet a lamp, this difference is 0, though the
        pixel may be wrong.
        """
        replicates = pixels.degrees + 1.0
        lacking, x = self._lacking(pixels, _MANY)
        if not lacking.any():
            return 0.0
        light = self.light[lacking]
        mean, variance = (of.reshape(-1, 3)[self.pixels[lacking]] for of in (pixels.mean, pixels.spread))
        floor = error_floor(float(pixels.mean.mean()))
        # the true value is at least the light of the lamps
        denominator = np.square(np.maximum(mean, light)) + floor
        square, seen = ((of / denominator).mean(axis=-1) for of in (np.square(light), variance))
        times, alike = _meetings(x, replicates)
        agreeing = 1.0 - np.minimum(seen * np.square(replicates * x) / square, 1.0)
        more = (alike * np.square(times - 1.0)).sum(axis=-1) / (1.0 - alike.sum(axis=-1)) * square
        hidden, worst = _hidden(times, alike, light, mean, floor)
        whole = float((agreeing * hidden - (1.0 - agreeing) * more).sum() + (agreeing * (worst - hidden)).max())
        return max(whole, 0.0) / pixels.samples.size

    def outshone(self, pixels: PixelStatistics) -> float:
        """Return the rise of the estimated error² if lamps that are too bright in the image had their true brightness.

        ``pixels`` are the statistics of the image. A small lamp is too bright in it if the samples of one replicate
        (group of a pixel's samples) met the lamp much sooner than expected. Errors are divided by the image's
        brightness, so the estimate is then too small.
        """
        replicates = pixels.degrees + 1.0
        lacking, x = self._lacking(pixels, 1.0 / replicates)  # beyond, a single meeting is not too soon
        where, light = self.pixels[lacking], self.light[lacking]
        mean, variance = (of.reshape(-1, 3)[where] for of in (pixels.mean, pixels.spread))
        # k meetings in one replicate add the same to the mean and to its standard error
        met = replicates * x * np.sqrt(variance.sum(axis=-1) / np.square(light).sum(axis=-1))
        too_much = np.maximum(np.floor(met * (1.0 + _ROUNDING)) / (replicates * x) - 1.0, 0.0)[:, None] * light
        wrong = np.minimum(too_much, np.maximum(mean - light, 0.0))
        if not wrong.any():
            return 0.0
        bright = where[wrong.any(axis=-1)]
        image, noise = pixels.mean.copy(), pixels.variance.copy()
        image.reshape(-1, 3)[where] -= wrong
        noise.reshape(-1, 3)[bright] = 0.0
        floors = [error_floor(float(of.mean())) for of in (pixels.mean, image)]
        now = error_contributions(pixels.mean, pixels.variance, pixels.samples, floors[0])[0][0].sum()
        others = error_contributions(image, noise, pixels.samples, floors[1])[0][0].sum()
        theirs = (np.square(wrong) / (np.square(mean - wrong) + floors[1])).mean(axis=-1).sum()
        return max(float(others + theirs - now), 0.0) / pixels.samples.size

    def _lacking(self, pixels: PixelStatistics, most: float) -> tuple[NDArray[np.bool_], Floats]:
        """Return a mask of lamps with fewer than ``most`` expected meetings a replicate, and their expectations."""
        expected = pixels.samples.ravel()[self.pixels] / (pixels.degrees + 1.0) * self.share
        lacking = (expected > 0.0) & (expected < most)
        return lacking, np.maximum(expected[lacking], _LEAST)


def _in_mirrors(scene: Any, settings: Any, threads: int) -> _Found:
    by_depth = _MIRRORED.setdefault(scene, {})
    if settings.max_depth not in by_depth:
        by_depth[settings.max_depth] = mirrored_lamps(scene, settings, 0, threads, _CHAINS)
    return by_depth[settings.max_depth]


def _meetings(expected: Floats, replicates: float) -> tuple[Floats, Floats]:
    """Return possible over expected numbers of meetings, and the chance that all replicates have each, (N, 3)."""
    expected = expected[:, None]
    times = np.maximum(np.ceil(expected - 1.5), 0.0) + np.arange(3.0)
    # divided by Poisson's chance of the first, a factor common to all
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
