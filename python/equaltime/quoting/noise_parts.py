"""Shares of a render's noise by kind of light, with intervals that hold where rare bright paths make the noise.

Squared errors should be divided by the squares of the true image, which is unknown. If they are divided by the mean of
the split images themselves, pixels that a rare bright path has met hide that path. Such light would seem to make a few
per cent of an error of which it makes a fifth (measured, at edges of a lamp). If they are divided by an independent
image that has met no such path, these pixels count for too much. So shares are computed twice: with an independent
image of 32 times the samples, and with the mean of all images. The stated share is the middle of the two shares, and
its interval holds both intervals. A doubt is stated if few bright paths make the noise, so that intervals cannot be
trusted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import pixel_statistics
from equaltime.film.tails import tail_of
from equaltime.images.metrics import Reference
from equaltime.quoting.light_parts import LightParts, measure_parts_by
from equaltime.rendering.core import make_renderer
from equaltime.scene import Scene
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["REFERENCE", "NoiseParts", "measure_noise_parts"]

Floats = NDArray[np.float64]

REFERENCE: Final = 32
"""Samples of the independent reference over the samples of each image."""


@dataclass(frozen=True, eq=False)
class NoiseParts:
    """Shares of error² of kinds of light, each by both references: the middle, with an interval that holds both."""

    by_reference: tuple[LightParts, LightParts]
    """Covariances over the squares of the independent reference, and over the squares of the mean of all images."""
    doubt: str
    """Reason, in words, why the intervals cannot be trusted: few bright paths make the noise. Empty if they can be
    trusted."""

    def share(self, kind: str, chosen: Callable[[str], bool]) -> Interval:
        """Return the share of several parts of one kind together; see `LightParts.share`."""
        return self._between(lambda parts: parts.share(kind, chosen))

    def shares(self, kind: str) -> dict[str, Interval]:
        """Return the share of each part of one kind; see `LightParts.shares`."""
        first, second = (parts.shares(kind) for parts in self.by_reference)
        return {what: _middle(share, second[what]) for what, share in first.items() if what in second}

    def apart(self, depth: int) -> tuple[Interval, Interval]:
        """Return the variances of longer paths' light and of all other light; see `LightParts.apart`."""
        return self._between(lambda parts: parts.apart(depth)[0]), self._between(lambda parts: parts.apart(depth)[1])

    def common(self, depth: int) -> Interval:
        """Return twice the covariance of longer paths' light and all other light; see `LightParts.common`."""
        return self._between(lambda parts: parts.common(depth))

    def truncated(self) -> dict[int, Interval]:
        """Return the relative error due to cutting paths at each depth; see `LightParts.truncated`."""
        first, second = (parts.truncated() for parts in self.by_reference)
        return {depth: _middle(error, second[depth]) for depth, error in first.items()}

    def _between(self, share: Callable[[LightParts], Interval]) -> Interval:
        first, second = map(share, self.by_reference)
        return _middle(first, second)


def measure_noise_parts(
    scene: Scene,
    strategy: Strategy,
    repeats: int,
    samples: int,
    seed: int = 0,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
) -> NoiseParts:
    """Render the scene ``repeats`` times with independent seeds, and return the shares of its light in error².

    The reference takes the seed after theirs. The arguments are as for `light_parts.measure_parts_by`.
    """
    doubts: list[str] = []
    references = partial(_references, scene, strategy, seed + repeats, threads, samples, doubts)
    first, second = measure_parts_by(scene, strategy, repeats, samples, seed, threads, progress, references)
    return NoiseParts((first, second), next(filter(None, doubts), ""))


def _references(
    scene: Scene, strategy: Strategy, seed: int, threads: int, samples: int, doubts: list[str], whole: Floats
) -> Iterator[Reference]:
    """Yield a reference without noise in common with the images, and the mean of all images; note doubts."""
    renderer = make_renderer(scene, strategy, seed, threads)
    renderer.advance(REFERENCE * samples)
    independent = pixel_statistics(renderer.moments).mean
    weight = REFERENCE / (REFERENCE + len(whole))
    for mean in (independent, weight * independent + (1.0 - weight) * whole.mean(axis=0)):
        reference = Reference(mean, np.zeros_like(mean))
        squares = np.square(whole - whole.mean(axis=0)) / np.maximum(reference.denominator, np.finfo(np.float64).tiny)
        doubts.append(tail_of(squares.mean(axis=-1)).doubt)
        yield reference


def _middle(first: Interval, second: Interval) -> Interval:
    """Return the middle of two shares, with an interval that holds both of theirs."""
    doubts = [share.note or "no noise was seen" for share in (first, second) if not share.trusted]
    low, high = min(first.low, second.low), max(first.high, second.high)
    middle = Interval(0.5 * (first.value + second.value), low, high)
    return middle.doubted(doubts[0]) if doubts else middle
