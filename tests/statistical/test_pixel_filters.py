"""Pixel filters: places drawn within a pixel, with their weights, against the filter itself.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import special, stats

from equaltime import _core
from equaltime._core import parts

from .chi2 import LEVEL, SAMPLES, chi_square, share, uniforms
from .worlds import affine

Array = NDArray[np.float64]
CUT = 4.0
"""Standard deviations at which the Gaussian ends."""


def box(x: Array, radius: float) -> Array:
    return np.asarray((np.clip(x, -radius, radius) + radius) / (2 * radius))


def tent(x: Array, radius: float) -> Array:
    t = np.clip(x / radius, -1, 1)
    return np.asarray(0.5 + t - 0.5 * t * np.abs(t))


def gaussian(x: Array, deviation: float) -> Array:
    """Lowered so that it is 0 at the cut."""
    t, floor = np.clip(x / deviation, -CUT, CUT), np.exp(-0.5 * CUT**2)
    running = special.ndtr(t) - special.ndtr(-CUT) - floor * (t + CUT) / np.sqrt(2 * np.pi)
    return np.asarray(running / (2 * special.ndtr(CUT) - 1 - 2 * CUT * floor / np.sqrt(2 * np.pi)))


@dataclass(frozen=True)
class Subject:
    name: str
    parameter: float
    cumulative: Callable[[Array, float], Array]
    """The filter's integral from the left, along one axis."""
    reach: float

    def __str__(self) -> str:
        return f"{self.name} {self.parameter:g}"

    def sample(self, u: Array) -> tuple[Array, Array]:
        drawn = parts.sample_filter(scene_of(self.name, self.parameter), u)
        return drawn["offset"], drawn["weight"]

    def cumulated(self, x: Array) -> Array:
        return self.cumulative(x, self.parameter)


@cache
def scene_of(name: str, parameter: float) -> _core.Scene:
    builder = _core.SceneBuilder()
    builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1]), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), name, parameter)
    return builder.build()


SUBJECTS = [
    Subject("box", 0.5, box, 0.5),
    Subject("box", 1.5, box, 1.5),
    Subject("tent", 1.0, tent, 1.0),
    Subject("tent", 0.3, tent, 0.3),
    Subject("gaussian", 0.5, gaussian, 2.0),
    Subject("gaussian", 1.3, gaussian, 5.2),
]
EACH = share(LEVEL, len(SUBJECTS))
CELLS = 20


def weighted_p(subject: Subject, cumulative: Callable[[Array], Array]) -> float:
    """Return the p-value of the weighted histogram of samples, against the filter of the given integral."""
    offset, weight = subject.sample(uniforms(SAMPLES, 2, 1))
    edges = np.linspace(-subject.reach, subject.reach, CELLS + 1)
    index = np.clip(((offset / subject.reach + 1) * 0.5 * CELLS).astype(int), 0, CELLS - 1)
    label = index[:, 0] * CELLS + index[:, 1]
    sums = np.bincount(label, weights=weight, minlength=CELLS**2)
    mass = np.diff(cumulative(edges))
    # Weights near 1 change the variance of a cell's sum by their mean square.
    inflation = float((weight**2).mean())
    expected = SAMPLES * np.outer(mass, mass).ravel()
    return chi_square(sums / np.sqrt(inflation), expected / np.sqrt(inflation))


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_weighted_places_follow_the_filter(subject: Subject) -> None:
    assert weighted_p(subject, subject.cumulated) > EACH


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_places_of_a_filter_two_percent_too_wide_are_rejected(subject: Subject) -> None:
    assert weighted_p(subject, lambda x: subject.cumulative(x, 1.02 * subject.parameter)) < EACH


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_weights_make_up_exactly_for_the_density_of_the_places(subject: Subject) -> None:
    """The places grow with the number: their density is its derivative, and weight times density is the filter."""
    n = 1 << 20
    u = np.stack([(np.arange(n) + 0.5) / n, np.full(n, 0.5)], axis=1)
    across = subject.sample(np.array([[0.5, 0.5]]))[1]
    offset, weight = subject.sample(u)
    edges = subject.sample(np.stack([np.arange(n) / n, np.full(n, 0.5)], axis=1))[0][:, 0]
    got = np.diff(edges) ** -1 / n * (weight / across)[:-1] * np.sqrt(across)
    middle, step = offset[:-1, 0], 1e-4 * subject.reach
    density = (subject.cumulated(middle + step) - subject.cumulated(middle - step)) / (2 * step)
    inner = np.abs(middle) < 0.9 * subject.reach
    assert np.abs(got / density - 1.0)[inner].max() < 3e-3
    assert np.abs(1.01 * got / density - 1.0)[inner].min() > 3e-3, "the twin"


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_weights_hardly_vary_so_that_an_even_image_is_even(subject: Subject) -> None:
    _, weight = subject.sample(np.random.default_rng(4).random((1 << 16, 2)))
    assert weight.std() < 3e-4 * weight.mean()


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_first_moments_are_those_of_the_filter(subject: Subject) -> None:
    """Three z-tests a subject and one twin, at 0.1 % for all of them."""
    offset, weight = subject.sample(uniforms(SAMPLES, 2, 2))
    edges = np.linspace(-subject.reach, subject.reach, 200_001)
    middle, mass = 0.5 * (edges[1:] + edges[:-1]), np.diff(subject.cumulated(edges))
    variance = float(mass @ middle**2)
    level = share(LEVEL, 3 * len(SUBJECTS))

    def p(values: Array, expected: float) -> float:
        error = values.std() / np.sqrt(SAMPLES)
        return 2 * float(stats.norm.sf(abs(values.mean() - expected) / error)) if error > 0 else 1.0

    assert p(weight, 1.0) > level
    assert p(weight * offset[:, 0], 0.0) > level
    assert p(weight * offset[:, 1] ** 2, variance) > level
    assert p(weight * offset[:, 1] ** 2, 1.02 * variance) < level, "the twin"
