"""Phase functions and free flights by themselves: what is drawn, against closed forms.

Seeds are fixed. All tests of this file together have a false-alarm rate of 0.1 %, and each has a twin that is a little
wrong and must be rejected.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from equaltime import _core
from equaltime.statistics.agreement import sidak

from .charts import SphereChart
from .chi2 import LEVEL, SAMPLES, Histogram, Masses, share, uniforms
from .worlds import build, direction

Array = NDArray[np.float64]
GS: Final = (0.0, 1e-6, 0.3, -0.6, 0.8)
SHARP: Final = (0.95, -0.99, 0.9999)
FLIGHTS: Final = 6
EACH: Final = share(LEVEL, len(GS) + len(SHARP) + FLIGHTS)
COUNT: Final = 1 << 18


def medium(g: float = 0.0, sigma_t: ArrayLike = (1.0, 1.0, 1.0), albedo: ArrayLike = (1.0, 1.0, 1.0)) -> _core.Scene:
    def add(b: _core.SceneBuilder) -> None:
        b.set_camera_medium(b.add_medium(np.array(sigma_t), np.array(albedo), [(1.0, "hg", {"g": g})]))

    return build(add)


def turned(g: float, count: int) -> Array:
    """Return the cosines of the angles by which light is turned; checks the weights and densities that come along."""
    wo = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    drawn = _core.parts.sample_bsdf(medium(g), 0, wo, uniforms(count, 3, 7))
    assert drawn["valid"].all()
    assert (drawn["weight"] == 1.0).all()
    wi = drawn["wi"]
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1.0, atol=3e-7)
    sine2, side = (wi[:, :2] ** 2).sum(axis=1), np.sign(g) * -wi[:, 2] if g else -wi[:, 2]
    from_peak = np.where(side > 0, sine2 / (1 + np.maximum(side, 0)), 1 - side)  # 1 - cos of the angle from the peak
    density = (1 - g**2) / (4 * np.pi) / ((1 - abs(g)) ** 2 + 2 * abs(g) * from_peak) ** 1.5
    np.testing.assert_allclose(drawn["pdf"], density, rtol=5e-3 if abs(g) > 0.999 else 1e-4)
    cosines: Array = np.where(side > 0, 1 - from_peak, side) * (np.sign(g) or 1.0)
    return cosines


def below(g: float, cosine: Array) -> Array:
    """The distribution of that cosine (Henyey and Greenstein 1941)."""
    if abs(g) < 1e-4:
        return 0.5 * (1 + cosine) + 0.75 * g * (cosine**2 - 1)
    return (1 - g**2) / (2 * g) * (1 / np.sqrt(1 + g**2 - 2 * g * cosine) - 1 / (1 + g))


@pytest.mark.parametrize("g", GS)
def test_directions_are_drawn_with_the_stated_density(g: float) -> None:
    scene, wo = medium(g), direction(0.0)
    chart = SphereChart()
    drawn = _core.parts.sample_bsdf(scene, 0, np.broadcast_to(wo, (SAMPLES, 3)), uniforms(SAMPLES, 3, 1))["wi"]

    def density(wi: Array) -> Array:
        pdf: Array = _core.parts.eval_bsdf(scene, 0, np.broadcast_to(wo, (len(wi), 3)), wi)["pdf"]
        return pdf

    histogram, masses = Histogram.of(chart, drawn, SAMPLES), Masses(chart, density)
    assert histogram.p(masses) > EACH, histogram.looks
    assert histogram.p(masses.changed(lambda pdf, _: 1.02 * pdf)) < EACH, histogram.looks
    tilted = masses.changed(lambda pdf, wi: pdf * (1 + 0.02 * wi[:, 2]), keep_total=True)
    assert histogram.p(tilted) < EACH, histogram.looks


@pytest.mark.parametrize("g", SHARP)
def test_sharp_lobes_follow_their_law(g: float) -> None:
    cosines = turned(g, COUNT)
    assert stats.kstest(below(g, cosines), "uniform").pvalue > EACH
    assert stats.kstest(below(g - np.copysign(0.02 * (1 - abs(g)), g), cosines), "uniform").pvalue < EACH


@pytest.mark.parametrize("g", [0.0, 0.5, -0.9])
def test_the_mean_cosine_is_g(g: float) -> None:
    cosines = turned(g, COUNT)
    assert abs(cosines.mean() - g) < 5 * cosines.std() / np.sqrt(COUNT)


BETAS: Final = {"white": (1.0, 1.0, 1.0), "orange": (0.9, 0.3, 0.0)}
EDGES: Final = np.array([0.0, 0.1, 0.25, 0.5, 1.0, 1.5, 2.0])


def flights(beta: ArrayLike, sigma_t: ArrayLike, albedo: ArrayLike, most: float) -> dict[str, Array]:
    scene = medium(0.0, sigma_t, albedo)
    betas, ends = np.broadcast_to(np.array(beta), (COUNT, 3)), np.full(COUNT, most)
    numbers = np.random.default_rng(3).random((COUNT, 2))
    found: dict[str, Array] = _core.parts.sample_flights(scene, 0, betas, ends, numbers)
    return found


def p_of_flights(found: dict[str, Array], beta: ArrayLike, sigma_t: ArrayLike, albedo: ArrayLike) -> float:
    """Compare what arrives in each stretch, and at the end, with what should: the mean weights, colour by colour."""
    sigma, colors = np.array(sigma_t), np.array(beta) > 0
    left = np.exp(-np.outer(EDGES, sigma))
    expected = np.vstack([np.array(albedo) * (left[:-1] - left[1:]), left[-1:]])
    stretch = np.where(found["collides"], np.searchsorted(EDGES, found["distance"], side="right") - 1, len(EDGES) - 1)
    worst = 0.0
    for i, exact in enumerate(expected):
        weights = np.where((stretch == i)[:, None], found["weight"], 0.0)[:, colors]
        error = weights.std(axis=0) / np.sqrt(COUNT) + 1e-7
        worst = max(worst, float((np.abs(weights.mean(axis=0) - exact[colors]) / error).max()))
    return sidak(2.0 * float(stats.norm.sf(worst)), expected.size)


@pytest.mark.parametrize("name", BETAS)
@pytest.mark.parametrize("sigma_t", [(1.0, 1.0, 1.0), (2.0, 0.5, 0.1), (0.0, 3.0, 1.0)])
def test_flights_bring_what_is_left_of_each_colour(name: str, sigma_t: tuple[float, ...]) -> None:
    beta, albedo = BETAS[name], (0.9, 0.5, 1.0)
    found = flights(beta, sigma_t, albedo, EDGES[-1])
    assert p_of_flights(found, beta, sigma_t, albedo) > EACH
    assert p_of_flights(found, beta, 1.03 * np.array(sigma_t), albedo) < EACH
    grown = (found["weight"] * np.array(beta)).sum(axis=1)
    assert grown.max() <= sum(beta) * (1 + 1e-6), "the sum of the colours never grows"


def test_a_medium_that_only_absorbs_weakens_light_by_beer_and_lambert() -> None:
    sigma_t = np.array([2.0, 0.5, 0.0])
    found = flights((1.0, 1.0, 1.0), sigma_t, (0.0, 0.0, 0.0), 1.5)
    assert not found["collides"].any()
    np.testing.assert_allclose(found["weight"], np.broadcast_to(np.exp(-1.5 * sigma_t), (COUNT, 3)), rtol=1e-6)


def test_flights_without_an_end_collide_unless_nothing_is_in_the_way() -> None:
    found = flights((1.0, 1.0, 1.0), (1.0, 2.0, 3.0), (1.0, 1.0, 1.0), np.inf)
    assert found["collides"].all()
    assert np.isfinite(found["weight"]).all()
    red = flights((1.0, 1.0, 1.0), (0.0, 2.0, 3.0), (1.0, 1.0, 1.0), np.inf)
    escaped = red["weight"][red["collides"] == 0]
    assert 0.32 < len(escaped) / COUNT < 0.35
    np.testing.assert_allclose(escaped, np.broadcast_to([3.0, 0.0, 0.0], escaped.shape), rtol=1e-6)


@pytest.mark.parametrize("depth", [1e-12, 1e-6, 30.0, 1e6])
def test_very_thin_and_very_thick_media_are_sampled_as_they_should(depth: float) -> None:
    found = flights((1.0, 1.0, 1.0), [depth] * 3, (1.0, 1.0, 1.0), 1.0)
    expected = -np.expm1(-depth)
    error = np.sqrt(expected * (1 - expected) / COUNT)
    assert abs(found["collides"].mean() - expected) <= 5 * error
    assert np.isfinite(found["weight"]).all()
