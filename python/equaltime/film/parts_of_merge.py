"""Variances of a merged render's pixels, from the renders that were merged (parts) and their replicates.

The parts are independent renders of one image. In a pixel, part k has ``n_k`` samples and the mean ``I_k``. If two
replicates of a part have samples, there is an estimate ``V_k`` of the variance of ``I_k``, by the formula of
`pixel_statistics`. With ``N = Σ n_k`` the image is ``I = Σ n_k I_k / N``. Its variance has two estimates:

``within``   ``Σ n_k² V_k / N²``. It is unbiased under any sampler if the replicates of every part have equal counts,
             and is used in no other case. Where ``V_k`` is proportional to ``1 / n_k``, it has ``N² / Σ n_k²`` degrees
             of freedom for two replicates a part (Satterthwaite 1946). That is the number of parts if all are of one
             size.
``between``  ``Σ n_k (I_k - I)² / ((K - 1) N)`` of K parts. It has K - 1 degrees of freedom, and is unbiased under any
             sampler if all ``n_k`` are equal, whatever the replicates are. It is used in no other case.

If the samples of a part's pixel are one net (low-discrepancy point set), ``V_k`` comes from second nets
(`equaltime.film.second_nets`). It is then unbiased for any counts. Both estimates are pooled by their degrees of
freedom. If all parts have the same odd count, their replicates differ in size, and only ``between`` is used. The reason
is that for points of a net the variance of the mean of 2 samples is less than half of the variance of 1. So every
``V_k`` of 3 samples is too large by the same factor. If both parts and replicates differ in size, the variance comes
from the joined replicates, by the formula of `pixel_statistics`.

The sums over parts are stored, not the estimates. The sums are additive (``Σ n_k (I_k - I)²`` by Chan, Golub & LeVeque
1983), so files can be merged again, in any order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.moments import PARTS
from equaltime.film.second_nets import SecondNets, statistics
from equaltime.film.sums import merge_moments

__all__ = ["MergedFilm", "statistics_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MergedFilm:
    """Samples of one or more independent renders (parts), for the mean and the variance of their merged image."""

    moments: NDArray[Any]
    """(R, H, W): count, mean and deviation of the samples of all parts, in each of R replicates (groups of a pixel's
    samples); the type is `equaltime.film.moments.DTYPE`."""
    parts: NDArray[Any]
    """(H, W): sums over the merged renders from which each pixel's variance is computed, of the type
    `equaltime.film.moments.PARTS`."""

    @classmethod
    def of(cls, moments: NDArray[Any], second: SecondNets | None = None) -> MergedFilm:
        """Return the film of a single render, ready to be joined with others.

        ``moments`` (R, H, W) are the render's moments, of the type `equaltime.film.moments.DTYPE`. ``second`` holds its
        second nets, if it has any: further samples of some pixels that correct all variances.
        """
        pixels = statistics(moments, second)
        variance, samples, counts = pixels.variance, pixels.samples, moments["count"]
        parts = np.zeros(samples.shape, PARTS)
        parts["parts"] = samples > 0
        if pixels.factors is None:  # the factors are measured with the actual counts
            parts["uneven"] = counts.min(axis=0) != counts.max(axis=0)
        parts["squares"] = np.square(samples.astype(np.uint64))
        known = (counts > 0).sum(axis=0) > 1
        parts["within"][known] = variance[known] * np.square(samples[known, None].astype(np.float64))
        return cls(moments, parts)

    def joined(self, other: MergedFilm) -> MergedFilm:
        """Return the merged film of this film's renders and those in ``other``; their order does not matter."""
        ours, theirs = self._samples, other._samples
        apart = np.square(self._mean - other._mean)
        parts = np.empty_like(self.parts)
        for name in PARTS.names or ():
            parts[name] = self.parts[name] + other.parts[name]
        parts["between"] += apart * (ours * theirs / np.maximum(ours + theirs, 1.0))[..., None]
        return MergedFilm(merge_moments(self.moments, other.moments), parts)

    @property
    def consistent(self) -> bool:
        """Whether the sums over merged renders are possible for these sample counts; False shows a damaged file."""
        parts, squares = (self.parts[name].astype(np.float64) for name in ("parts", "squares"))
        square = np.square(self._samples)
        known = np.isfinite(self.parts["within"]) & np.isfinite(self.parts["between"])
        # by Cauchy's inequality, up to rounding
        possible = (squares <= 1.000001 * square) & (square <= 1.000001 * parts * squares)
        return bool((possible & ((parts > 0.0) == (square > 0.0)) & known.all(axis=-1)).all())

    def statistics(self) -> PixelStatistics:
        """Return mean, variance and sample count of every pixel of the merged image.

        The field ``degrees`` is the harmonic mean over pixels of the variance's degrees of freedom. This mean decides
        the width of intervals: the relative variance of a pixel's estimated variance is ``2 / degrees``.
        """
        joined = pixel_statistics(self.moments)
        within, between = self._degrees(joined)
        both = within + between
        count = np.maximum(self._samples, 1.0)
        more = np.maximum(self.parts["parts"].astype(np.float64) - 1.0, 1.0)
        squares = within[..., None] * self.parts["within"] / np.square(count)[..., None]
        squares += between[..., None] * self.parts["between"] / (more * count)[..., None]
        pooled = squares / np.maximum(both, 1.0)[..., None]
        variance = np.where(both[..., None] > 0.0, pooled, joined.variance)
        known = np.isfinite(variance).all(axis=-1)
        degrees = np.where(both > 0.0, both, joined.degrees)[known]
        least = float(degrees.min(initial=np.inf))
        harmonic = least / float((least / degrees).mean()) if degrees.size else joined.degrees
        return PixelStatistics(joined.mean, variance, joined.samples, harmonic)

    def _degrees(self, joined: PixelStatistics) -> tuple[Floats, Floats]:
        """Return the degrees of freedom, (H, W), of the estimates within and between parts; 0 where one is not used."""
        parts, squares = self.parts["parts"], self.parts["squares"]
        total = joined.samples.astype(np.uint64)
        equal = parts * squares == np.square(total)  # whole numbers, so that the order of merging does not matter
        alike = np.square(total.astype(np.float64)) / np.maximum(squares.astype(np.float64), 1.0)
        between = np.where(equal & (total > 0), parts.astype(np.float64) - 1.0, 0.0)
        return np.where(self.parts["uneven"] == 0, joined.degrees * alike, 0.0), between

    @property
    def _samples(self) -> Floats:
        return np.asarray(self.moments["count"].sum(axis=0).astype(np.float64))

    @property
    def _mean(self) -> Floats:
        """The mean of all samples, (H, W, 3); where replicates have equal means, exactly that mean."""
        first, counts = self.moments["mean"][0], self.moments["count"].astype(np.float64)
        weights = counts / np.maximum(counts.sum(axis=0), 1.0)
        return np.asarray(first + (weights[..., None] * (self.moments["mean"] - first)).sum(axis=0))


def statistics_of(
    moments: NDArray[Any], parts: NDArray[Any] | None, second: SecondNets | None = None
) -> PixelStatistics:
    """Return mean, variance and sample count of every pixel of a render, merged or not.

    ``moments`` (R, H, W) are the render's moments, of the type `equaltime.film.moments.DTYPE`. ``parts`` (H, W) holds
    the sums over the renders that were merged; None if the render was not merged. ``second`` holds the second nets, if
    any: further samples of some pixels that correct all variances.
    """
    return statistics(moments, second) if parts is None else MergedFilm(moments, parts).statistics()
