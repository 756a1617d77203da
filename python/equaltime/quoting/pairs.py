"""Comparison of a scene with and without some effect (such as lens or media), by renders with the same random numbers.

The difference of two images of one seed is due to the effect, with little of the noise that both share. For K
independent seeds, let d be the differences (image without the effect minus whole image), and w the whole images. Let D
be the denominators of the error's definition. Then:

- the square of the change of the image is ``E d² / D``, freed of noise by taking products of different seeds only;
- the effect's share of the variance is ``Cov(-d, w) / Var(w)``, both summed over pixels after division by D.

Both are functions of the products of images for all pairs of seeds, ``(K, K)``, for which the jackknife is quick.

The few samples of w leave D noisy. A bright path would enlarge d and D alike, and the change would seem too small: by
an eighth with 4 samples a pixel and 6 seeds, and by a third with 1. So for the change, the D of a pair of seeds is made
from the whole images of all *other* seeds. If samples are few, its pixels are averaged with the pixels next to them.
That leaves 2 to 10 % with 1 sample a pixel, and at most 3 % with 2 or more (measured, 5 scenes).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from equaltime.film.sums import nearest_mean
from equaltime.images.metrics import Reference
from equaltime.rendering.core_subject import CoreSubject
from equaltime.scene import Scene
from equaltime.scene.effects.leaving import leave_out
from equaltime.statistics.intervals import Interval, jackknife, ratio_interval, signed_root
from equaltime.statistics.products import covariance, pairs_mean
from equaltime.strategy import Strategy

__all__ = ["Renders", "Versus", "change_of", "change_products", "products", "run_in_turn", "share_of"]

Floats = NDArray[np.float64]
N = TypeVar("N")

_BY_DENOMINATORS, _BY_ONE_SAMPLE = 0.03, 0.1
"""Least half width of the interval of a change, relative to the change: what noisy denominators may add (measured).
The second number, divided by the samples per pixel, replaces the first if it is larger."""


@dataclass(frozen=True, eq=False)
class Renders:
    """K renders of one scene with independent seeds, to be compared with K renders of another scene."""

    images: Floats
    """(K, H, W, 3): images, one for each seed."""
    samples: int
    """Samples per pixel of each render."""
    seconds: Floats
    """(K,): seconds of each render."""
    memory: int
    """Bytes of memory that the scene takes in the core."""


@dataclass(frozen=True, eq=False)
class Versus:
    """Renders without some effects beside renders of the whole scene: what the effects cost and change, at 95 %.

    An effect is a feature of the scene, such as lens or media.
    """

    time: Interval
    """Share of the whole scene's rendering time that the effects (features such as media) take, as a fraction."""
    variance: Interval
    """Share of the whole image's variance that the effects (features such as media) make, as a fraction."""
    change: Interval
    """Relative error of the image due to leaving out the effects (features such as media): 0.02 is 2 %."""
    memory: int
    """Bytes of memory that the effects (features such as media) take in the core."""
    difference: Floats
    """(H, W, 3): the image without the effects (features such as media), minus the whole image."""

    @classmethod
    def of(cls, whole: Renders, less: Renders) -> Versus:
        """Return the differences between renders of the whole scene and renders without some effects (such as media).

        The renders ``whole`` and ``less`` (without the effects) have the same seeds and are compared seed by seed.
        """
        denominator = Reference.of_images(whole.images).denominator
        moved = less.images - whole.images
        return cls(
            time=ratio_interval(less.seconds, whole.seconds).map(lambda ratio: 1.0 - ratio),
            variance=share_of(
                products(-moved, whole.images, denominator), products(whole.images, whole.images, denominator)
            ),
            change=_unknown(moved, denominator)
            or change_of(change_products([moved], whole.images, whole.samples)[0], whole.samples),
            memory=whole.memory - less.memory,
            difference=moved.mean(axis=0),
        )


def run_in_turn(
    scene: Scene,
    strategy: Strategy,
    variants: Mapping[N, Iterable[str]],
    repeats: int,
    samples: int,
    seed: int = 0,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
) -> tuple[Renders, dict[N, Renders]]:
    """Render a scene and its variants in turn by ``strategy``; return the scene's renders, and each variant's.

    ``variants`` maps a key to the names of the effects (features such as media) that the variant leaves out. There are
    ``repeats`` rounds. Each round renders the scene and all variants with one seed, the first with ``seed``, the next
    with ``seed + 1``. The order alternates between rounds, so that a drifting machine affects all alike. ``samples`` is
    the count per pixel. ``threads`` is the number of threads; 0 is one for each processor. ``progress`` is called with
    the finished fraction.

    Raises
    ------
    NonFiniteSample
        If a sample is NaN or infinite.
    """
    cases = [leave_out(scene, strategy, names) for names in ((), *variants.values())]
    subjects = [CoreSubject("", strategy) for _, strategy in cases]
    for subject, (scene, _) in zip(subjects, cases, strict=True):
        subject.prepare(scene, threads)
    found: list[list[tuple[Floats, float]]] = [[] for _ in cases]
    for repeat in range(repeats):
        order = list(enumerate(subjects))
        for done, (number, subject) in enumerate(order if repeat % 2 == 0 else order[::-1], 1):
            (end,) = subject.run(seed + repeat, (samples,))
            found[number].append((end.image.astype(np.float64), end.wall_s))
            if progress is not None:
                progress((repeat + done / len(cases)) / repeats)
    runs = [_joined(results, case[0], samples) for results, case in zip(found, cases, strict=True)]
    return runs[0], dict(zip(variants, runs[1:], strict=True))


def _joined(results: list[tuple[Floats, float]], scene: Scene, samples: int) -> Renders:
    images, seconds = zip(*results, strict=True)
    return Renders(np.stack(images), samples, np.array(seconds), scene.core.memory_bytes)


def products(first: Floats, second: Floats, denominator: Floats) -> Floats:
    """Return the means of ``a_r b_s / D`` over pixels and channels for all pairs of seeds r and s, (K, K).

    ``first`` holds the images a and ``second`` the images b, both (K, H, W, 3); ``denominator`` is D, (H, W, 3).
    Variances and covariances over seeds follow from these means.
    """
    repeats = len(first)
    weights = 1.0 / np.where(denominator > 0.0, denominator, np.inf)
    with np.errstate(over="ignore", invalid="ignore"):  # images that float32 cannot hold give no number
        rows: Floats = (first * weights).reshape(repeats, -1) @ second.reshape(repeats, -1).T
    return rows / denominator.size


def change_products(changes: Sequence[Floats], whole: Floats, samples: int) -> Floats:
    """Return the means of ``d_r d_s / D_rs`` over pixels and channels for all pairs of seeds r and s, (N, K, K).

    ``changes`` holds N arrays of images d, and ``whole`` the whole images, each (K, H, W, 3) with ``samples`` per
    pixel; K is 4 or more. ``D_rs`` is the denominator by the whole images of the seeds other than r and s, and so
    independent of both d. Their pixels are averaged with neighbours, which weigh half up to 4 samples and less beyond.
    """
    neighbours = min(0.5, 2.0 / samples)
    smooth = np.stack([(1.0 - neighbours) * image + neighbours * nearest_mean(image) for image in whole])
    total, squares = smooth.sum(axis=0), np.square(smooth).sum(axis=0)
    found = np.empty((len(changes), len(whole), len(whole)))
    for r, s in itertools.combinations_with_replacement(range(len(whole)), 2):
        pair = sorted({r, s})
        others = len(whole) - len(pair)
        mean = (total - smooth[pair].sum(axis=0)) / others
        square = (squares - np.square(smooth[pair]).sum(axis=0)) / others
        variance = np.maximum(square - np.square(mean), 0.0) / (others - 1)
        denominator = Reference(mean, variance).denominator
        weights = 1.0 / np.where(denominator > 0.0, denominator, np.inf)
        for number, change in enumerate(changes):
            found[number, r, s] = found[number, s, r] = float(np.vdot(change[r] * weights, change[s])) / weights.size
    return found


def _unknown(moved: Floats, denominator: Floats) -> Interval | None:
    """Return an unknown change if light comes to a picture that is black all over; None otherwise."""
    if denominator.any() or not moved.any():
        return None
    return Interval(math.nan, 0.0, math.inf).doubted("the picture to compare with is black")


def change_of(squares: Floats, samples: int) -> Interval:
    """Return the root mean square of the expected image behind K images, without their noise, as an interval.

    ``squares`` (K, K) are the `change_products` of the K images with each other, for all pairs of seeds, with
    ``samples`` per pixel. The interval contains the error that the denominators' noise may add. If the lower end is
    not above 0, the upper end is at least the root mean square of noise and change together. Otherwise rare light that
    few seeds have met would seem to be absent.
    """
    found = jackknife(lambda kept: pairs_mean(squares, kept), len(squares)).map(signed_root)
    high = found.high if found.low > 0.0 else max(found.high, signed_root(float(squares.mean())))
    value, least = max(found.value, 0.0), max(_BY_DENOMINATORS, _BY_ONE_SAMPLE / samples)
    low = max(value - math.hypot(value - found.low, least * value), 0.0)
    return replace(found, low=low, value=value, high=value + math.hypot(high - value, least * value))


def share_of(part: Floats, whole: Floats) -> Interval:
    """Return the share of a part of an image in the variance of the whole image, as a fraction with its interval.

    ``part`` holds the `products` of the part and the whole image for all pairs of seeds, (K, K). ``whole`` holds those
    products of the whole image with itself.
    """

    def share(kept: Floats) -> float:
        variance = covariance(whole, kept)
        return covariance(part, kept) / variance if variance > 0.0 else np.nan

    return jackknife(share, len(whole))
