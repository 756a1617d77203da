"""Shares of an image's noise by kind of light: by path length, technique, BSDF, surface and light source.

The core adds up every contribution to a path by its origin (`_core.split_light`). There are five kinds of origin: the
length of the path, the technique that found the light, the light source, and the BSDF and the surface on which the
light of the source falls. This BSDF is the last one of a path from the camera. The surface is a shape or a material
(`equaltime.quoting.surface_groups`). Each kind splits the image into parts. The share of a part in the variance is
``Cov(part, whole) / Var(whole)``, where whole stands for the whole image. The shares of all parts of one kind sum to 1.
A part that cancels noise of other parts has a negative share.

Covariances are taken between whole images over independent seeds, so they hold for the strategy's sampler. They are
summed over pixels, each divided by the pixel's denominator in the error's definition. So they are shares of error².
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import accumulate
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.images.float32 import beyond_float32
from equaltime.images.metrics import Reference
from equaltime.quoting.pairs import change_of, change_products, products, share_of
from equaltime.quoting.surface_groups import SurfaceGroups, described
from equaltime.rendering.core import split_light
from equaltime.scene import Scene
from equaltime.scene.inert import is_inert, shown
from equaltime.scene.model import Directional, Point, Spot
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["KINDS_OF_PARTS", "LightParts", "measure_parts", "measure_parts_by", "name_and_place", "short_names"]

Floats = NDArray[np.float64]

KINDS_OF_PARTS: Final = ("length", "way", "bsdf", "surface", "light")
_FILE: Final = re.compile(r"\((?:.*/)?([^/]*\.\w+(?::\d+)?)\)", re.DOTALL)
"""Place in brackets: a path with an extension, and perhaps a line."""
LONGEST: Final = 16
"""Path length in segments at which the split of light ends: paths of this length and all longer paths are one part."""


@dataclass(frozen=True, eq=False)
class LightParts:
    """Covariances of parts of an image's light, from renders with K seeds; each part's share of error² follows.

    A part is the light of one path length, of one light source, scattered last by one BSDF or surface, or found by one
    technique. The fields hold sums over pixels of products of two images, for each pair of seeds.
    """

    names: tuple[tuple[str, str], ...]
    """Kind and name of each part."""
    with_whole: Floats
    """(parts, K, K): sums over pixels of products of each part's image with the whole image, for each pair of seeds."""
    whole: Floats
    """(K, K): sums over pixels of products of two whole images, for each pair of seeds."""
    tails: Floats
    """(LONGEST, K, K): sums over pixels of products of two images of the light of paths longer than 1, 2, … segments.
    """
    cuts: Floats
    """(LONGEST - 1, K, K): as ``tails``, with denominators that are independent of both images (`change_products`). The
    relative error due to cutting paths follows from these products."""
    samples: int
    """Samples per pixel of each image."""

    def shares(self, kind: str) -> dict[str, Interval]:
        """Return the share of error² of each part of one kind, by the part's name; parts without light are left out.

        Kinds are ``length`` (of the path), ``way`` (technique that found the light), ``bsdf`` and ``surface`` (the last
        ones), and ``light`` (source). The shares of a kind sum to 1; a single share may be negative.
        """
        parts = [(what, p) for (k, what), p in zip(self.names, self.with_whole, strict=True) if k == kind]
        return {what: share_of(part, self.whole) for what, part in parts if part.any()}

    def share(self, kind: str, chosen: Callable[[str], bool]) -> Interval:
        """Return the share of error² of several parts of one kind together.

        Kinds are ``length``, ``way`` (technique), ``bsdf``, ``surface`` and ``light`` (source). ``chosen`` returns True
        for the names of the wanted parts.
        """
        numbers = [i for i, (k, what) in enumerate(self.names) if k == kind and chosen(what)]
        return share_of(self.with_whole[numbers].sum(axis=0), self.whole)

    def apart(self, depth: int) -> tuple[Interval, Interval]:
        """Return the variances of two images that sum to the whole image, as shares of the whole image's variance.

        The first image has the light of paths longer than ``depth`` segments, the second the light of all other paths.
        """
        longer, crossed = self._longer(depth)
        return share_of(longer, self.whole), share_of(self.whole - 2.0 * crossed + longer, self.whole)

    def common(self, depth: int) -> Interval:
        """Return twice the covariance of two images that sum to the whole image, as a share of its variance.

        The images have the light of paths longer than ``depth`` segments, and of all other paths. The result is 1 minus
        the sum of the two shares that `apart` returns.
        """
        longer, crossed = self._longer(depth)
        return share_of(2.0 * (crossed - longer), self.whole)

    def _longer(self, depth: int) -> tuple[Floats, Floats]:
        """Return the products of longer paths' light with itself, and with the whole; depth is below LONGEST."""
        numbers = [i for i, (kind, what) in enumerate(self.names) if kind == "length" and int(what.split()[0]) > depth]
        return self.tails[depth - 1], self.with_whole[numbers].sum(axis=0)

    def truncated(self) -> dict[int, Interval]:
        """Return the relative error due to cutting paths at a depth, by that depth in segments, as a dict.

        Depths beyond which there is no light are left out.
        """
        return {depth: change_of(tail, self.samples) for depth, tail in enumerate(self.cuts, 1) if tail.any()}


def measure_parts(
    scene: Scene,
    strategy: Strategy,
    repeats: int,
    samples: int,
    seed: int = 0,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
) -> LightParts:
    """Render the scene ``repeats`` times with independent seeds, and return the covariances of the parts of its light.

    A part is the light of one path length, of one source, scattered last by one BSDF or surface, or found by one
    technique. The parts of each kind sum to the image. ``strategy`` is used with ``samples`` per pixel; the first seed
    is ``seed``, and each repeat takes the next one. ``threads`` is the number of threads; 0 is one for each processor.
    ``progress`` is called with the finished fraction.
    """
    return next(measure_parts_by(scene, strategy, repeats, samples, seed, threads, progress))


def measure_parts_by(
    scene: Scene,
    strategy: Strategy,
    repeats: int,
    samples: int,
    seed: int = 0,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
    references: Callable[[Floats], Iterable[Reference]] = lambda whole: [Reference.of_images(whole)],
) -> Iterator[LightParts]:
    """Yield the covariances of the parts of a scene's light for each of several references, all from the same images.

    Squared errors are divided by the squares of a reference. ``references`` is a function that takes the whole images
    (K, H, W, 3) and returns the references. K is ``repeats``. The other arguments are as for `measure_parts`.

    Raises
    ------
    BrightImage
        If float32 cannot hold an image.
    """
    names, width, height = list[tuple[str, str]](), 0, 0
    groups = SurfaceGroups.of(scene)
    stack: NDArray[np.float32] = np.empty(0, np.float32)  # (parts, K, H, W, 3): the peak of memory
    for repeat in range(repeats):
        names, parts = split_light(scene, strategy, seed + repeat, threads, samples, surface_groups=groups.of_shape)
        if repeat == 0:
            height, width, count, _ = parts.shape
            stack = np.empty((count, repeats, height, width, 3), np.float32)
        stack[:, repeat] = np.moveaxis(parts, 2, 0)
        if progress is not None:
            progress((repeat + 1) / repeats)
    lengths = [i for i, (kind, _) in enumerate(names) if kind == "length"]
    whole = stack[lengths].sum(axis=0, dtype=np.float64)
    where = ": ".join(filter(None, (str(scene.source or ""), f"a pilot of {width}x{height} pixels")))
    for image in whole:
        if (beyond := beyond_float32(image, (0, 0), where)) is not None:
            raise beyond
    tails = np.cumsum(stack[lengths][::-1], axis=0, dtype=np.float64)[::-1]
    nothing = np.zeros((1, repeats, repeats))
    cuts = change_products(list(tails[1:]), whole, samples)
    for reference in references(whole):
        denominator = reference.denominator
        yield LightParts(
            names=tuple(_named(names, groups, scene)),
            with_whole=np.stack([products(part.astype(np.float64), whole, denominator) for part in stack]),
            whole=products(whole, whole, denominator),
            tails=np.concatenate([[products(tail, tail, denominator) for tail in tails[1:]], nothing]),
            cuts=cuts,
            samples=samples,
        )


def name_and_place(what: str) -> tuple[str, str]:
    """Split the name of a part of the kind ``light`` or ``surface`` into its element's name and its place in a file.

    ``what`` is such as ``light 0: sun (/tmp/scene.toml:12)``, which gives ``sun`` and ``scene.toml:12``. The place is
    empty if no file describes the element. Names and folders may have brackets, which are taken to be in pairs.
    """
    _, colon, said = what.partition(": ")
    if not colon:
        return ("sky" if what == "environment" else what), ""
    depths = accumulate((character == ")") - (character == "(") for character in reversed(said))
    opening = len(said) - 1 - next((i for i, depth in enumerate(depths) if depth == 0), 0)
    place = _FILE.fullmatch(said, opening)
    return (said[:opening].rstrip(), place[1]) if place else (said, "")


def short_names(parts: Iterable[str]) -> dict[str, str]:
    """Return the names of the elements of ``parts``, names of the kind ``light`` or ``surface``, by part.

    An element whose name another one has, too, gets its number: ``ball (shape 3)``.
    """
    names = {what: name_and_place(what)[0] for what in parts}
    counts = Counter(names.values())
    return {what: name if counts[name] == 1 else f"{name} ({what.partition(': ')[0]})" for what, name in names.items()}


def _named(names: Iterable[tuple[str, str]], groups: SurfaceGroups, scene: Scene) -> Iterable[tuple[str, str]]:
    """Name the scene's elements of each light and group of surfaces."""
    model = scene.model
    shapes = [model.shapes[number] for number in shown(model)]
    kinds = (Point, Spot, Directional)  # in the core's order
    points = [e for kind in kinds for e in model.emitters if isinstance(e, kind) and not is_inert(e, scene.assets)]
    for kind, what in names:
        word, _, number = what.partition(" ")
        if kind == "light" and word in ("shape", "light"):
            node = shapes[int(number)] if word == "shape" else points[int(number)]
            what = f"{word} {number}: {described(node, int(number), scene)}"
        elif kind == "surface" and what.isdigit():
            what = groups.names[int(what)]
        elif kind == "length" and number == "" and int(word) == LONGEST:
            what = f"{LONGEST} and more"
        yield kind, what
