"""Variance of pixels whose samples are one net (low-discrepancy point set), from a second net in some pixels.

In large pictures a pixel's samples are one net (`equaltime.rendering.core.nets`): two nets of half the size would have
5 to 20 % more squared error (tests/bench/sampler_noise.py). But then the replicates are the halves of one net
(`Sharing` in cpp/equaltime/film/film.h), which are not independent. The difference of the halves shows where the noise
is, and its size except for a factor. The true variance is between half of the variance from the halves and all of it,
depending on the scene and the count.

So some pixels, drawn at random, have a second net with its own random numbers. Its samples are not in the image. In
these pixels two variances are known: ``V``, from the halves of a net, and the true variance, from the difference of the
nets' means ``I₁`` and ``I₂``. The ratio of the true variance to ``V`` is

    ``F = Σ w (I₁ - I₂)² / Σ w (V₁ + V₂)``.

The weights ``w`` are close to the weights of the image's error (`equaltime.film.error`): a geometric mean of ``1 / (R²
+ (0.1 m)²)`` with the pixel for R and with its neighbours. ``F V`` is then the variance of every pixel. A net does not
reduce the noise of rare bright samples. So if F is below 1, the factor is valid only up to a limit of a pixel's part of
error²: larger parts make a fifth of error² by the halves. What exceeds the limit stays as it is, both in the image and
where F is measured.

The halves are unequal unless the count N is a power of two: of 18 samples, the second half has 2. A bright sample x
among independent samples adds ``x² / N²`` to the variance of their mean. In a second half of n samples, it adds ``(N -
n) / n`` times as much to the difference of the halves, and one pixel may make most of the image's error. So the ``V``
of a pixel is at most twice the variance of the mean of independent samples, which follows from the deviations of all
its samples. If N is a power of two, a single bright sample shows its true part and stays below that bound.

F is a ratio of sums over many pixels, so the delta method gives its standard deviation (Cochran 1977, 6.3). F is one
number for all pixels, so the variances of all pixels are off together, which widens the interval of the image's error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.sums import others_count, others_sum, sample_deviations

__all__ = ["FEWEST", "Renders", "SecondNets", "second_nets", "statistics", "statistics_so_far"]

Floats = NDArray[np.float64]

_MOST_OVER_INDEPENDENT = 2.0
"""Largest variance that the halves of a net may show, over the variance of as many independent samples. With Gaussian
noise the mean variance loses a quarter by this bound, and the measured factor restores it. A bound of 1 would take
half, and the factor would then enlarge the parts of bright samples."""

_BRIGHT = 0.2
"""Share of error² by the halves of nets that the largest parts make. They are taken for parts of bright samples, and
the factor does not reduce what exceeds the smallest of them."""

FEWEST = 64
"""Fewest pixels with a second net (independent further samples) for which variances are corrected; with fewer, the
difference of a pixel's replicates is used as it is."""


@dataclass(frozen=True, eq=False)
class SecondNets:
    """Second nets: independent further samples of some pixels, which correct the estimated variances of all pixels.

    The samples are not in the image. They are needed where a pixel's samples form a single low-discrepancy point set
    (net), whose two halves are not independent and so do not give the size of the variance.
    """

    moments: NDArray[Any]
    """(R, h, w): count, mean and deviation of the second nets' samples, of the type `equaltime.film.moments.DTYPE`."""
    pixels: NDArray[np.int64]
    """(h, w): index ``y * width + x`` in the image of the pixel that each second net belongs to; -1 where there is no
    net."""

    def copy(self) -> SecondNets:
        """Return a copy whose moments have memory of their own, and so stay when the renderer takes more samples."""
        return SecondNets(self.moments.copy(), self.pixels)

    def statistics(self, moments: NDArray[Any]) -> PixelStatistics:
        """Return the statistics of an image from its film, with variances that are corrected by a measured factor.

        The factor is the true variance over the variance from the halves of a net. It is measured in the pixels that
        have a second net, from the difference of the two nets' means. A pixel does not count if its two nets have
        different sample counts, as after a pass that was cut short. If fewer than `FEWEST` pixels count, the
        variances follow from the film's replicates alone. ``moments`` (R, H, W) are the film's, of the type
        `equaltime.film.moments.DTYPE`.
        """
        image = _by_halves(moments)
        floor = np.square(0.1 * image.mean.mean())
        with np.errstate(over="ignore", invalid="ignore"):  # a number whose square overflows is not measured
            around = np.square(others_sum(image.mean) / others_count(*image.samples.shape)) + floor
            measured = self._measured(image, around, floor)
            if measured is None:
                return pixel_statistics(moments)
            part = (_weights(image.mean, around, floor) * image.variance).mean(axis=-1)
        factor, bright, doubt = _factor(*measured)
        factors = np.full_like(part, factor)
        above = part > bright
        factors[above] = (factor * bright + part[above] - bright) / part[above]
        return replace(image, variance=image.variance * factors[..., None], factors=factors, common_doubt=doubt)

    def _measured(self, image: PixelStatistics, around: Floats, floor: float) -> tuple[Floats, Floats] | None:
        """Return parts of error² by the difference of two nets, (N,), and by the halves of each net, (2, N).

        The result is None if fewer than `FEWEST` pixels are known.
        """
        there = self.pixels >= 0
        places, second = self.pixels[there], _by_halves(self.moments)
        first, other = (
            (image.mean.reshape(-1, 3)[places], image.variance.reshape(-1, 3)[places]),
            (second.mean[there], second.variance[there]),
        )
        whole = image.samples.ravel()[places] == second.samples[there]
        known = whole & np.isfinite(first[1]).all(axis=-1) & np.isfinite(other[1]).all(axis=-1)
        if known.sum() < FEWEST:
            return None
        weights = _weights(0.5 * (first[0] + other[0]), around.reshape(-1, 3)[places], floor)
        true = (weights * np.square(first[0] - other[0])).mean(axis=-1)[known]
        halves = np.stack([(weights * variance).mean(axis=-1)[known] for _, variance in (first, other)])
        if not (np.isfinite(true).all() and true.sum() > 0.0 and halves.sum() > 0.0):
            return None
        return true, halves


def _factor(true: Floats, halves: Floats) -> tuple[float, float, float]:
    """Return the factor of variances, the part of error² up to which it is valid, and the factor's relative doubt.

    ``true`` (N,) holds parts of error² by the difference of two nets, and ``halves`` (2, N) by the halves of each net.
    """
    stated, bright = halves.sum(axis=0), math.inf
    whole = float(true.sum())
    if whole < stated.sum():
        descending = -np.sort(-halves, axis=None)
        bright = float(descending[np.searchsorted(descending.cumsum(), _BRIGHT * descending.sum())])
        ordinary = np.minimum(halves, bright).sum(axis=0)
        true, stated = true - (stated - ordinary), ordinary
    factor = max(float(true.sum() / stated.sum()), 0.0)
    return factor, bright, float(np.sqrt(np.square(true - factor * stated).sum())) / whole


def _weights(own: Floats, around: Floats, floor: float) -> Floats:
    """Return the factors from variances to parts of error², (..., 3), by each pixel's mean and its neighbours'.

    They are the geometric mean of both reciprocal denominators, in which the neighbours weigh a quarter. ``around`` is
    the neighbours' denominator.
    """
    by = np.square(own) + floor
    return np.asarray(np.divide(np.sqrt(np.sqrt(by / around)), by, where=by > 0.0, out=np.zeros_like(by)))


def statistics(moments: NDArray[Any], second: SecondNets | None) -> PixelStatistics:
    """Return mean, variance and sample count of every pixel of a film.

    ``moments`` (R, H, W) are the film's moments, of the type `equaltime.film.moments.DTYPE`. ``second`` holds the
    film's second nets, if any: further samples of some pixels that correct all variances.
    """
    return pixel_statistics(moments) if second is None else second.statistics(moments)


def _by_halves(moments: NDArray[Any]) -> PixelStatistics:
    """Return mean, variance and sample count of pixels whose two replicates are the halves of one net.

    The difference of the halves gives the variance, which is at most twice the variance of independent samples.
    """
    pixels = pixel_statistics(moments)
    with np.errstate(over="ignore"):  # then there is no bound
        independent = np.square(sample_deviations(moments)) / np.maximum(pixels.samples, 1)[..., None]
    return replace(pixels, variance=np.minimum(pixels.variance, _MOST_OVER_INDEPENDENT * independent))


class Renders(Protocol):
    """Interface to the samples that a renderer of the core has taken so far."""

    @property
    def moments(self) -> NDArray[Any]:
        """Count, mean and deviation of each pixel's samples in each replicate (group of samples), (R, H, W).

        The type is `equaltime.film.moments.DTYPE`.
        """

    @property
    def second_moments(self) -> NDArray[Any]:
        """Moments (R, h, w) of second nets, further samples of some pixels that correct variances; empty without any.

        The type is `equaltime.film.moments.DTYPE`.
        """

    @property
    def second_pixels(self) -> NDArray[np.int64]:
        """Index ``y * width + x`` of the pixel that each second net belongs to, (h, w); -1 where there is no net."""


def second_nets(renderer: Renders) -> SecondNets | None:
    """Return a renderer's second nets, further samples of some pixels that correct variances; None if there are none.

    Their moments share the renderer's memory, and so change when the renderer takes more samples.
    """
    moments = renderer.second_moments
    return SecondNets(moments, renderer.second_pixels) if moments.size else None


def statistics_so_far(renderer: Renders) -> PixelStatistics:
    """Return mean, variance and sample count of every pixel from the samples that a renderer has taken so far.

    Variances are corrected by the renderer's second nets (further samples of some pixels), if it has any.
    """
    return statistics(renderer.moments, second_nets(renderer))
