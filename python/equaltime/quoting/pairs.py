"""Comparison of a scene with and without some effect (such as lens or media), by renders with the same random numbers.

The difference of two images of one seed is due to the effect, with little of the noise that both share. For K
independent seeds, let d be the differences (image without the effect minus whole image), and w the whole images. Let D
be the denominators of the error's definition. Then:

- the square of the change of the image is ``E d² / D``, freed of noise by taking products of different seeds only;
- the effect's share of the variance is ``Cov(-d, w) / Var(w)``, both summed over pixels after division by D.

Both are functions of the products of images for all pairs of seeds, ``(K, K)``, for which the jackknife is quick.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from equaltime.images.metrics import Reference
from equaltime.rendering.core_subject import CoreSubject
from equaltime.scene import Scene
from equaltime.scene.effects.leaving import leave_out
from equaltime.statistics.intervals import Interval, jackknife, ratio_interval, signed_root
from equaltime.statistics.products import covariance, pairs_mean
from equaltime.strategy import Strategy

__all__ = ["Renders", "Versus", "change_of", "products", "run_in_turn", "share_of"]

Floats = NDArray[np.float64]
N = TypeVar("N")


@dataclass(frozen=True, eq=False)
class Renders:
    """K renders of one scene with independent seeds, to be compared with K renders of another scene."""

    images: Floats
    """(K, H, W, 3): images, one for each seed."""
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
            change=_unknown(moved, denominator) or change_of(products(moved, moved, denominator)),
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
    runs = [_joined(results, case[0]) for results, case in zip(found, cases, strict=True)]
    return runs[0], dict(zip(variants, runs[1:], strict=True))


def _joined(results: list[tuple[Floats, float]], scene: Scene) -> Renders:
    images, seconds = zip(*results, strict=True)
    return Renders(np.stack(images), np.array(seconds), scene.core.memory_bytes)


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


def _unknown(moved: Floats, denominator: Floats) -> Interval | None:
    """Return an unknown change if light comes to a picture that is black all over; None otherwise."""
    if denominator.any() or not moved.any():
        return None
    return Interval(math.nan, 0.0, math.inf).doubted("the picture to compare with is black")


def change_of(squares: Floats) -> Interval:
    """Return the root mean square of the expected image behind K images, without their noise, as an interval.

    ``squares`` (K, K) are the `products` of the K images with each other, for all pairs of seeds. If the lower end is
    not above 0, the upper end is at least the root mean square of noise and change together. Otherwise rare light that
    few seeds have met would seem to be absent.
    """
    found = jackknife(lambda kept: pairs_mean(squares, kept), len(squares)).map(signed_root)
    high = found.high if found.low > 0.0 else max(found.high, signed_root(float(squares.mean())))
    return replace(found, low=max(found.low, 0.0), value=max(found.value, 0.0), high=high)


def share_of(part: Floats, whole: Floats) -> Interval:
    """Return the share of a part of an image in the variance of the whole image, as a fraction with its interval.

    ``part`` holds the `products` of the part and the whole image for all pairs of seeds, (K, K). ``whole`` holds those
    products of the whole image with itself.
    """

    def share(kept: Floats) -> float:
        variance = covariance(whole, kept)
        return covariance(part, kept) / variance if variance > 0.0 else np.nan

    return jackknife(share, len(whole))
