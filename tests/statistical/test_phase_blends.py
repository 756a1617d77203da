"""Rayleigh's phase function, tables, and sums of several: what is drawn, and that light is found by it in every way.

Seeds are fixed. All tests of this file together have a false-alarm rate of 0.1 %, and each has a twin that is a little
wrong and must be rejected.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime import _core
from equaltime.statistics.agreement import sidak

from .charts import SphereChart
from .chi2 import LEVEL, SAMPLES, Histogram, Masses, share, uniforms
from .worlds import Estimate, build, direction, estimate

Array = NDArray[np.float64]
Lobes = list[tuple[float, str, dict[str, Any]]]


def hg(weight: float, g: float) -> tuple[float, str, dict[str, Any]]:
    return weight, "hg", {"g": g}


def air(weight: float) -> tuple[float, str, dict[str, Any]]:
    return weight, "rayleigh", {}


LAWS: Final[dict[str, Lobes]] = {
    "even": [(1.0, "isotropic", {})],
    "air": [air(1.0)],
    "air and dust": [air(0.4), hg(0.6, 0.7)],
    "forwards and backwards": [hg(0.7, 0.8), hg(0.2, -0.5), hg(0.1, 0.0)],
    "a table": [(1.0, "tabphase", {"values": [1.0, 0.25, 0.5, 0.125, 0.25, 4.0]})],
    "a table and dust": [(0.5, "tabphase", {"values": [2.0, 1.0]}), hg(0.5, 0.7)],
    "eight": [air(0.05), *(hg(0.1 + 0.01 * i, 0.2 * i - 0.6) for i in range(7))],
}
TECHNIQUES: Final = ("uniform", "bsdf", "mis", "mixture")
EACH: Final = share(LEVEL, 2 * len(LAWS) + len(TECHNIQUES) + 1)


def haze(lobes: Lobes, b: _core.SceneBuilder, sigma_t: float = 1.0) -> int:
    return b.add_medium([sigma_t] * 3, [1.0] * 3, lobes)


def medium(lobes: Lobes) -> _core.Scene:
    return build(lambda b: b.set_camera_medium(haze(lobes, b)))


def density(lobes: Lobes, cosine: Array) -> Array:
    """The sum of all laws, by the cosine of the angle between the directions before and after."""
    total = sum(weight for weight, _, _ in lobes)
    return np.asarray(sum(weight / total * density_of(law, cosine, **given) for weight, law, given in lobes))


def density_of(law: str, cosine: Array, g: float = 0.0, values: Sequence[float] = ()) -> Array:
    """The density of one law per solid angle."""
    if law == "tabphase":
        nodes = np.linspace(-1, 1, len(values))
        return np.asarray(np.interp(cosine, nodes, values) / (2 * np.pi * np.trapezoid(values, nodes)))
    if law == "rayleigh":
        return np.asarray(3 / (16 * np.pi) * (1 + cosine**2))
    return np.asarray((1 - g * g) / (4 * np.pi) / (1 + g * g - 2 * g * cosine) ** 1.5)


@pytest.mark.parametrize("name", LAWS)
def test_values_are_the_sum_of_the_laws(name: str) -> None:
    cosine = np.linspace(-1, 1, 101)
    wi = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, -cosine], axis=1)  # wo, along z, is where light came from
    found = _core.parts.eval_bsdf(medium(LAWS[name]), 0, np.broadcast_to([0.0, 0, 1], wi.shape), wi)
    exact = density(LAWS[name], cosine)
    np.testing.assert_allclose(found["pdf"], exact, rtol=2e-6)
    np.testing.assert_array_equal(found["f"], np.repeat(found["pdf"][:, None], 3, axis=1))
    assert (np.abs(1.001 * found["pdf"] - exact) > 2e-6 * exact).all(), "the twin"


@pytest.mark.parametrize("name", LAWS)
def test_directions_are_drawn_with_the_stated_density(name: str) -> None:
    scene, wo = medium(LAWS[name]), direction(0.0)
    chart = SphereChart()
    sample = _core.parts.sample_bsdf(scene, 0, np.broadcast_to(wo, (SAMPLES, 3)), uniforms(SAMPLES, 3, 1))
    assert sample["valid"].all()
    assert (sample["weight"] == 1.0).all()
    np.testing.assert_allclose(np.linalg.norm(sample["wi"], axis=1), 1.0, atol=3e-7)

    def pdf(wi: Array) -> Array:
        value: Array = _core.parts.eval_bsdf(scene, 0, np.broadcast_to(wo, (len(wi), 3)), wi)["pdf"]
        return value

    np.testing.assert_array_equal(sample["pdf"], pdf(sample["wi"]))
    histogram, masses = Histogram.of(chart, sample["wi"], SAMPLES), Masses(chart, pdf)
    assert histogram.p(masses) > EACH, histogram.looks
    assert histogram.p(masses.changed(lambda value, _: 1.02 * value)) < EACH, histogram.looks
    tilted = masses.changed(lambda value, wi: value * (1 + 0.02 * wi[:, 2]), keep_total=True)
    assert histogram.p(tilted) < EACH, histogram.looks


@pytest.mark.parametrize("name", LAWS)
def test_cosines_follow_the_laws(name: str) -> None:
    """Against the closed form of their distribution, whatever the core says of its density."""
    wo = np.broadcast_to([0.0, 0.0, 1.0], (SAMPLES, 3))
    drawn = -_core.parts.sample_bsdf(medium(LAWS[name]), 0, wo, uniforms(SAMPLES, 3, 5))["wi"][:, 2]

    def below(lobes: Lobes) -> Array:
        edges = np.linspace(-1, 1, 20001)
        middle = 0.5 * (edges[1:] + edges[:-1])
        steps = np.concatenate([[0.0], np.cumsum(2 * np.pi * density(lobes, middle) * np.diff(edges))])
        return np.asarray(np.interp(drawn, edges, steps / steps[-1]))

    assert stats.kstest(below(LAWS[name]), "uniform").pvalue > EACH
    wrong = [*((0.97 * weight, law, given) for weight, law, given in LAWS[name]), hg(0.03, -0.9)]
    assert stats.kstest(below(wrong), "uniform").pvalue < EACH


def test_nothing_is_drawn_where_a_table_is_zero() -> None:
    table = medium([(1.0, "tabphase", {"values": [0.0, 1.0, 0.0, 0.0, 2.0]})])
    wo = np.broadcast_to([0.0, 0.0, 1.0], (SAMPLES, 3))
    drawn = _core.parts.sample_bsdf(table, 0, wo, uniforms(SAMPLES, 3, 5))
    cosine = -drawn["wi"][:, 2]
    assert ((cosine <= 0) | (cosine >= 0.5)).all()
    assert (drawn["pdf"] > 0).mean() > 1 - 1e-4, "float32 may round a cosine onto a zero"


def glow(technique: str, lobes: Lobes, spp: int = 1 << 15) -> Estimate:
    """What a haze sends back to a camera in it, lit once by a ball that is not in view."""

    def add(b: _core.SceneBuilder) -> None:
        b.set_camera_medium(haze(lobes, b, 0.3))
        b.add_sphere([1.5, 0.5, 2.0], 0.7, flip_normals=False, front=None, back=None, radiance=[4.0, 4.0, 4.0])
        b.add_sphere([0.0, 0.0, 0.0], 20.0, flip_normals=False, front=None, back=None, radiance=None)

    return estimate(build(add, fov=0.01), spp, technique=technique, max_depth=2)


def p_of(a: Estimate, b: Estimate) -> float:
    z = np.abs(a.mean - b.mean) / np.hypot(a.error, b.error)
    return sidak(2.0 * float(stats.norm.sf(z.max())), 3)


@pytest.fixture(scope="module")
def lit() -> Estimate:
    return glow("light", LAWS["air and dust"])


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_the_same_light_is_found_by_every_technique(technique: str, lit: Estimate) -> None:
    assert p_of(glow(technique, LAWS["air and dust"]), lit) > EACH


def test_a_lamp_through_haze_is_that_of_quadrature(lit: Estimate) -> None:
    assert lit.p(in_closed_form(LAWS["air and dust"])) > EACH
    assert lit.p(in_closed_form([air(0.45), hg(0.55, 0.7)])) < EACH, "the twin: five percent in place of dust"


def in_closed_form(lobes: Lobes) -> Array:
    """Integrate along the ray and over the directions to the ball, whose light the haze weakens to its surface."""
    sigma, center, radius, radiance = 0.3, np.array([1.5, 0.5, 2.0]), 0.7, 4.0
    nodes, weights = np.polynomial.legendre.leggauss(64)
    phi = (np.arange(64) + 0.5) * 2 * np.pi / 64
    total = 0.0
    for node, weight in zip(*np.polynomial.legendre.leggauss(256), strict=True):
        t = 10 * (node + 1)  # along the ray, from 0 to 20
        distance = np.linalg.norm(center - [0, 0, t])
        axis = (center - [0, 0, t]) / distance
        across = np.cross(axis, [0.0, 1.0, 0.0])
        across /= np.linalg.norm(across)
        least = np.sqrt(1 - (radius / distance) ** 2)  # cosine of the ball's rim
        cosine = least + (1 - least) * 0.5 * (nodes + 1)
        sine = np.sqrt(1 - cosine**2)
        z = cosine[:, None] * axis[2] + sine[:, None] * (
            np.cos(phi) * across[2] + np.sin(phi) * np.cross(axis, across)[2]
        )
        near = distance * cosine - np.sqrt(np.maximum(radius**2 - (distance * sine) ** 2, 0))
        found = (density(lobes, z) * (np.exp(-sigma * near) * weights)[:, None]).sum() * (1 - least) * np.pi / 64
        total += 10 * weight * sigma * np.exp(-sigma * t) * radiance * found
    return np.full(3, total)
