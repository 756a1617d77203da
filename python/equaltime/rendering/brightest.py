"""The brightest of a pixel's first samples: the sample that makes a bright dot in an image."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equaltime.rendering.core import make_renderer
from equaltime.scene import Scene
from equaltime.scene.effects.leaving import LUMINANCE
from equaltime.strategy import Strategy
from equaltime.words import figure

__all__ = ["Brightest", "brightest_sample"]

_STANDS_OUT = 10.0
"""Smallest luminance of a bright sample, in means of the pixel's other samples: ordinary noise stays below it."""

_ROUNDING = 1e-5
"""Largest relative difference of equally bright samples: a path's product of float32 factors stays below it."""


@dataclass(frozen=True)
class Brightest:
    """Brightest sample of a pixel, beside the mean of the pixel's other samples, to explain a bright dot in an image.

    Luminance is in the units of the image, and includes the weight of the pixel's filter.
    """

    sample: int
    """Number of the brightest sample in its pixel, from 0. A sample that is NaN or infinite counts as the brightest."""
    samples: int
    """Number of samples that were searched, from sample 0 on: the search ends at a sample that is NaN or infinite."""
    luminance: float
    """Luminance of the brightest sample; NaN if one of its channels is NaN or infinite."""
    mean_of_others: float
    """Mean luminance of the other samples; NaN if there are none."""
    as_bright: int = 1
    """Number of samples with this luminance, up to rounding; the brightest itself counts."""
    black: int = 0
    """Number of samples with a luminance of 0."""

    @property
    def stands_out(self) -> bool:
        """Whether the sample may make a bright dot: at least `_STANDS_OUT` times the mean of the others, or not finite.

        A single sample has no others, so it never stands out.
        """
        return math.isnan(self.luminance) or (
            self.luminance > 0.0 and self.luminance >= _STANDS_OUT * self.mean_of_others
        )

    def __str__(self) -> str:
        which = f"sample {self.sample} (counted from 0) of the first {self.samples}"
        if math.isnan(self.luminance):
            return f"{which} is not a finite number; later samples were not looked at"
        light = f"luminance {self.luminance:.4g}"
        if self.samples == 1:
            return f"only sample 0 was looked at: {light}"
        if self.luminance == 0.0 == self.mean_of_others:
            return f"the first {self.samples} samples are all black; sample {self.sample} is one of them"
        if self.as_bright == self.samples:
            return f"the first {self.samples} samples are equally bright ({light}); sample {self.sample} is one of them"
        said = f"{which} is {'the' if self.as_bright == 1 else f'one of the {self.as_bright}'} brightest"
        if self.as_bright + self.black == self.samples:
            return f"{said}: {light}; the other{f' {self.black}' if self.black > 1 else ''} {_are(self.black)} black"
        if self.as_bright > 1 or self.black > self.samples / 2:  # the mean of the others depends on their number alone
            return f"{said}: {light}; {self.black} {_are(self.black)} black"
        if not 0.0 < self.mean_of_others < self.luminance:  # negative weights of the filter
            return f"{said}: {light}, and the mean of the others is {self.mean_of_others:.4g}"
        times = figure(float(f"{self.luminance / self.mean_of_others:.2g}"))
        return f"{said}: {times} times the mean of the others ({light})"


def _are(number: int) -> str:
    return "is" if number == 1 else "are"


def brightest_sample(scene: Scene, strategy: Strategy, samples: int, seed: int) -> Brightest:
    """Return the brightest of the first ``samples`` samples of a scene whose crop is a single pixel.

    A render with this strategy and seed takes these samples too. A thousand samples of a simple scene take 0.1 s.
    """
    even = strategy.model_copy(update={"adaptive": "none"})  # the same samples, whatever their number
    renderer = make_renderer(scene, even, seed, threads=1, second_net=0)
    found = np.zeros(samples)
    for index in range(samples):
        renderer.advance(index + 1)
        if renderer.nonfinite:
            rest = float(found[:index].mean()) if index else math.nan
            return Brightest(index, index + 1, math.nan, rest)
        moments = renderer.moments  # the film itself: once emptied, it holds a single sample
        found[index] = moments["mean"].sum(axis=(0, 1, 2)) @ np.array(LUMINANCE)
        moments[...] = 0
    best = int(found.argmax())
    others = np.delete(found, best)
    return Brightest(
        best,
        samples,
        luminance=float(found[best]),
        mean_of_others=float(others.mean()) if samples > 1 else math.nan,
        as_bright=int(np.isclose(found, found[best], rtol=_ROUNDING, atol=0.0).sum()),
        black=int((found == 0.0).sum()),
    )
