"""Rough conductors against Walter et al.'s formula in float64, and what they reflect of a white sky.

Random arguments have fixed seeds; the z-tests of this file together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import special, stats

from equaltime import _core
from equaltime._core import parts

from ..statistical.charts import HalfVectorChart
from ..statistical.chi2 import LEVEL, Masses, share, uniforms
from ..statistical.worlds import affine, direction

Array = NDArray[np.float64]
ROUNDOFF = 2.0**-24
MIRROR = ([0.0] * 3, [1.0] * 3, [1.0] * 3)
"""A conductor that reflects everything at every angle."""
MODELS = ["ggx", "beckmann"]
ALPHAS = [(a, a) for a in (1.0, 0.3, 0.03, 1e-3, 1e-4, 1e-5)] + [(0.5, 0.02), (1e-3, 1e-5)]


@cache
def scene_of(model: str, alpha_u: float, alpha_v: float) -> _core.Scene:
    builder = _core.SceneBuilder()
    builder.add_bsdf("roughconductor", model, alpha_u, alpha_v, *MIRROR)
    builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1]), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    return builder.build()


def slopes(v: Array, alpha_u: float, alpha_v: float) -> Array:
    """Return the square of roughness times tangent."""
    return np.asarray(((alpha_u * v[..., 0]) ** 2 + (alpha_v * v[..., 1]) ** 2) / v[..., 2] ** 2)


def masking(model: str, v: Array, alpha_u: float, alpha_v: float) -> Array:
    """Smith's G1; for Beckmann the rational fit of Walter et al. (eq. 27), which Mitsuba has too."""
    squared = slopes(v, alpha_u, alpha_v)
    if model == "ggx":
        return np.asarray(2 / (1 + np.sqrt(1 + squared)))
    a = 1 / np.sqrt(np.maximum(squared, 1e-30))
    return np.where(a < 1.6, (3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a), 1.0)


def exact_masking(v: Array, alpha: float) -> Array:
    """Smith's G1 of Beckmann's distribution by its integral."""
    a = 1 / np.sqrt(slopes(v, alpha, alpha))
    return np.asarray(2 / (1 + special.erf(a) + np.exp(-a * a) / (a * np.sqrt(np.pi))))


def value(model: str, wo: Array, wi: Array, alpha_u: float, alpha_v: float) -> Array:
    """f·cosθi of a perfect mirror's microfacets: D·G/(4 cosθo)."""
    m = wo + wi
    m = m / np.linalg.norm(m, axis=-1, keepdims=True)
    stretched = (m[..., 0] / alpha_u) ** 2 + (m[..., 1] / alpha_v) ** 2
    z2, norm = m[..., 2] ** 2, np.pi * alpha_u * alpha_v
    d = 1 / (norm * (stretched + z2) ** 2) if model == "ggx" else np.exp(-stretched / z2) / (norm * z2**2)
    g = masking(model, wo, alpha_u, alpha_v) * masking(model, wi, alpha_u, alpha_v)
    return np.asarray(d * g / (4 * wo[..., 2]))


def pairs(alpha_u: float, alpha_v: float, count: int = 20_000) -> tuple[Array, Array]:
    """Return directions of which one nearly mirrors the other, by slopes of the roughness's order, as float32."""
    rng = np.random.default_rng(5)
    wo = np.stack([*rng.standard_normal((2, count)), np.abs(rng.standard_normal(count)) + 0.02], axis=-1)
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    slope = rng.standard_normal((count, 2)) * [alpha_u, alpha_v]
    m = np.column_stack([slope, np.ones(count)])
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    wi = 2 * (wo * m).sum(axis=1, keepdims=True) * m - wo
    keep = wi[:, 2] > 0
    return wo[keep].astype(np.float32).astype(float), wi[keep].astype(np.float32).astype(float)


@pytest.mark.parametrize("alphas", ALPHAS, ids=str)
@pytest.mark.parametrize("model", MODELS)
def test_values_are_those_of_the_formula_down_to_tiny_roughness(model: str, alphas: tuple[float, float]) -> None:
    """The usual forms of D lose all digits below 2e-4 (case S13)."""
    wo, wi = pairs(*alphas)
    got = parts.eval_bsdf(scene_of(model, *alphas), 0, wo, wi)["f"][:, 0]
    exact = value(model, wo, wi, *(float(np.float32(a)) for a in alphas))
    m = wo + wi
    exponent = (m[:, 0] / m[:, 2] / alphas[0]) ** 2 + (m[:, 1] / m[:, 2] / alphas[1]) ** 2
    tolerance = ROUNDOFF * (24 + (8 * exponent if model == "beckmann" else 0)) * exact
    assert (np.abs(got - exact) <= tolerance).all()
    assert (np.abs(1.0001 * got - exact) > tolerance).mean() > 0.9, "the twin: values off by a hundredth percent"


def test_the_usual_form_of_the_distribution_is_seen_to_lose_its_digits() -> None:
    """The twin in float32: n²(α² - 1) + 1."""
    alpha = np.float32(1e-4)
    wo, wi = pairs(1e-4, 1e-4)
    m = (wo + wi) / np.linalg.norm(wo + wi, axis=1, keepdims=True)
    z = m[:, 2].astype(np.float32)
    with np.errstate(divide="ignore"):
        naive = alpha**2 / (np.float32(np.pi) * (z * z * (alpha * alpha - 1) + 1) ** 2)
    exact = 1 / (np.pi * 1e-8 * (((m[:, :2] / 1e-4) ** 2).sum(axis=1) + m[:, 2] ** 2) ** 2)
    assert np.median(np.abs(naive / exact - 1)) > 0.1


@pytest.mark.parametrize("model", MODELS)
def test_reflection_is_reciprocal(model: str) -> None:
    wo, wi = pairs(0.5, 0.2)
    scene = scene_of(model, 0.5, 0.2)
    there = parts.eval_bsdf(scene, 0, wo, wi)["f"][:, 0] / wi[:, 2]
    back = parts.eval_bsdf(scene, 0, wi, wo)["f"][:, 0] / wo[:, 2]
    assert np.abs(there / back - 1).max() < 16 * ROUNDOFF


def test_beckmanns_masking_is_within_its_stated_error_of_smiths_integral() -> None:
    v = np.stack([direction(t) for t in np.linspace(1, 89.9, 500)])
    assert np.abs(masking("beckmann", v, 0.7, 0.7) / exact_masking(v, 0.7) - 1).max() < 0.0035


@pytest.mark.parametrize("alphas", ALPHAS, ids=str)
@pytest.mark.parametrize("model", MODELS)
def test_no_sample_weighs_more_than_the_light_that_came_in(model: str, alphas: tuple[float, float]) -> None:
    wo = pairs(*alphas)[0]
    weight = parts.sample_bsdf(scene_of(model, *alphas), 0, wo, uniforms(len(wo), 3, 8))["weight"]
    most = 1.0 + 16 * ROUNDOFF if model == "ggx" else 1.0036
    assert weight.max() <= most


SKIES = [
    (m, a, t) for m in MODELS for a in ((1.0, 1.0), (0.3, 0.3), (0.5, 0.05), (0.01, 0.01)) for t in (0.0, 70.0, 88.0)
]
EACH = share(LEVEL, len(SKIES))


@pytest.mark.parametrize(("model", "alphas", "theta"), SKIES, ids=str)
def test_samples_reflect_as_much_of_a_white_sky_as_the_formula(
    model: str, alphas: tuple[float, float], theta: float
) -> None:
    """The mean weight, rejected samples counted as 0, is the albedo of this direction: a z-test and its twin."""
    wo, count = direction(theta, 25.0), 1 << 18
    rounded = [float(np.float32(a)) for a in alphas]
    chart = HalfVectorChart(wo, model, *alphas)
    masses = Masses(chart, lambda wi: value(model, np.broadcast_to(wo, wi.shape), wi, *rounded))
    weight = parts.sample_bsdf(scene_of(model, *alphas), 0, np.broadcast_to(wo, (count, 3)), uniforms(count, 3, 9))
    mean, deviation = weight["weight"][:, 0].mean(), weight["weight"][:, 0].std()
    error = np.sqrt(deviation**2 / count + (masses.doubt**2).sum()) + 4 * ROUNDOFF

    def p(albedo: float) -> float:
        return 2 * float(stats.norm.sf(abs(albedo - masses.total) / error))

    assert p(mean) > EACH
    assert p(1.02 * mean) < EACH, "the twin"
    assert mean < 1.0
