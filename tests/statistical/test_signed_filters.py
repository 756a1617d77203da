"""Pixel filters with negative lobes: places drawn by the absolute value, weights with its sign, against the filter.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime import _core
from equaltime._core import parts
from equaltime.film.moments import squared_deviations

from .chi2 import LEVEL, SAMPLES, share, uniforms
from .worlds import affine, build, render

Array = NDArray[np.float64]
CELLS = 25


@dataclass(frozen=True)
class Subject:
    name: str
    first: float
    second: float
    reach: float

    def __str__(self) -> str:
        return f"{self.name} {self.first:.2f} {self.second:.2f}"

    def value(self, x: Array) -> Array:
        """The filter along one axis, not normalised."""
        t = np.abs(x)
        if self.name == "lanczos":
            return np.asarray(np.where(t < self.reach, np.sinc(t) * np.sinc(t / self.reach), 0.0))
        b, c = self.first, self.second
        near = np.polyval([12 - 9 * b - 6 * c, -18 + 12 * b + 6 * c, 0, 6 - 2 * b], t)
        far = np.polyval([-b - 6 * c, 6 * b + 30 * c, -12 * b - 48 * c, 8 * b + 24 * c], t)
        return np.asarray(np.where(t < 1, near, np.where(t < 2, far, 0.0)))

    def masses(self) -> tuple[Array, Array]:
        """Integrals over the cells of the filter, which sum to 1, and of its absolute value."""
        places = self.reach * (2 * (np.arange(CELLS * 2000) + 0.5) / (CELLS * 2000) - 1)
        values = self.value(places) / self.value(places).sum()
        return values.reshape(CELLS, -1).sum(axis=1), np.abs(values).reshape(CELLS, -1).sum(axis=1)

    def sample(self, u: Array) -> tuple[Array, Array]:
        builder = _core.SceneBuilder()
        builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1]), 40.0)
        builder.set_film(1, 1, (0, 0, 1, 1), self.name, self.first, self.second)
        drawn = parts.sample_filter(builder.build(), u)
        return drawn["offset"], drawn["weight"]


MITCHELL = Subject("mitchell", 1 / 3, 1 / 3, 2.0)
CATMULL_ROM = Subject("mitchell", 0.0, 0.5, 2.0)
SUBJECTS = [MITCHELL, CATMULL_ROM, Subject("lanczos", 3.0, 0.0, 3.0), Subject("lanczos", 1.0, 0.0, 1.0)]
EACH = share(LEVEL, len(SUBJECTS))


def p_of(drawn: Subject, stated: Subject) -> float:
    """Return the p-value of the weighted histogram of what one filter draws, against another."""
    offset, weight = drawn.sample(uniforms(SAMPLES, 2, 1))
    index = np.clip(((offset / drawn.reach + 1) * 0.5 * CELLS).astype(int), 0, CELLS - 1)
    sums = np.bincount(index[:, 0] * CELLS + index[:, 1], weights=weight, minlength=CELLS**2)
    mass, absolute = stated.masses()
    # Weights are ±c, where c is the integral of the absolute value: a cell's sum has c times its absolute mass as
    # variance.
    variance = SAMPLES * absolute.sum() ** 2 * np.outer(absolute, absolute).ravel()
    enough = variance > 25.0 * absolute.sum() ** 4
    deviation = (sums - SAMPLES * np.outer(mass, mass).ravel())[enough] / np.sqrt(variance[enough])
    return float(stats.chi2.sf((deviation**2).sum(), enough.sum()))


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_weighted_places_follow_the_filter(subject: Subject) -> None:
    assert p_of(subject, subject) > EACH


@pytest.mark.parametrize("subject", [MITCHELL, CATMULL_ROM], ids=str)
def test_places_of_a_slightly_different_spline_are_rejected(subject: Subject) -> None:
    assert p_of(subject, replace(subject, first=subject.first + 0.02)) < EACH


def test_places_of_another_number_of_lobes_are_rejected() -> None:
    assert p_of(Subject("lanczos", 3.0, 0.0, 3.0), Subject("lanczos", 3.0, 0.0, 3.1)) < EACH


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_weights_differ_in_sign_only_and_their_mean_is_one(subject: Subject) -> None:
    _, weight = subject.sample(uniforms(SAMPLES, 2, 2))
    error = weight.std() / np.sqrt(SAMPLES)
    assert abs(weight.mean() - 1.0) < 4.0 * error + 1e-6
    assert np.abs(weight).std() < 1e-2 * np.abs(weight).mean()
    assert np.abs(weight).mean() == pytest.approx(subject.masses()[1].sum() ** 2, rel=1e-4)


def test_the_error_bar_of_an_even_image_holds_what_the_lobes_cost() -> None:
    """Every sample is ±c: the variance that the film measures is c² - 1."""
    boxed = build(lambda builder: builder.add_constant_environment([1.0] * 3))
    assert render(boxed, 64, sampler="independent")["deviation"].max() == 0.0, "the same without lobes"
    builder = _core.SceneBuilder()
    builder.add_constant_environment([1.0] * 3)
    builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1]), 40.0)
    builder.set_film(8, 8, (0, 0, 8, 8), "mitchell", 1 / 3, 1 / 3)
    film = render(builder.build(), 4096, sampler="independent")[0]
    expected = MITCHELL.masses()[1].sum() ** 4 - 1.0
    variance = squared_deviations(film)[..., 0] / (film["count"] - 1)
    assert variance.mean() == pytest.approx(expected, rel=0.05)
    z = (film["mean"][..., 0] - 1.0) / np.sqrt(expected / 4096)
    together = z.sum() / np.sqrt(z.size)
    assert 2.0 * stats.norm.sf(abs(together)) > EACH
    assert 2.0 * stats.norm.sf(abs(together + np.sqrt(z.size))) < EACH, "the twin: a standard error too bright"


def correlation(values: Array) -> float:
    """Return the correlation of neighbours, in standard deviations of that of independent values."""
    values = (values - values.mean()) / values.std()
    products = [(values[:, 1:] * values[:, :-1]).ravel(), (values[1:] * values[:-1]).ravel()]
    return float(np.concatenate(products).mean() * np.sqrt(sum(map(len, products))))


@pytest.mark.parametrize("subject", [MITCHELL, CATMULL_ROM], ids=str)
def test_pixels_have_samples_of_their_own_and_errors_that_are_independent(subject: Subject) -> None:
    """Also where filters overlap (case T13). A test at 4 sigma."""
    builder = _core.SceneBuilder()
    builder.add_constant_environment([1.0] * 3)
    builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1]), 40.0)
    builder.set_film(128, 128, (0, 0, 128, 128), subject.name, subject.first, subject.second)
    film = render(builder.build(), 16, sampler="independent")[0]["mean"][..., 0]
    assert film.std() > 0.0
    assert abs(correlation(film)) < 4.0
    assert correlation(film + 0.1 * np.roll(film, 1, axis=1)) > 4.0, "the twin: a tenth of a neighbour in each pixel"
