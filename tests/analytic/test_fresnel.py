"""Reflectances of smooth interfaces against complex arithmetic in float64.

The core is asked through the weights and choices of its smooth BSDFs. Nothing is random but the arguments.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from ..statistical.worlds import affine

Array = NDArray[np.float64]
ROUNDOFF = 2.0**-24
COSINES = 1.0 - np.linspace(0, 1, 400, endpoint=False) ** 2


def compile_bsdfs(builder: _core.SceneBuilder) -> _core.Scene:
    builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1]), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    return builder.build()


def directions(cosines: Array) -> Array:
    """Return directions as float32 has them; their z is what the core takes for the cosine."""
    wo = np.stack([np.sqrt((1 - cosines) * (1 + cosines)), 0 * cosines, cosines], axis=-1)
    return wo.astype(np.float32).astype(np.float64)


def conductor_reflectance(cosine: Array, index: complex) -> Array:
    """Fresnel's equations as they stand, for a complex index."""
    transmitted = np.sqrt(1 - (1 - cosine**2) / index**2 + 0j)
    s = (cosine - index * transmitted) / (cosine + index * transmitted)
    p = (index * cosine - transmitted) / (index * cosine + transmitted)
    return np.asarray(0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2))


def test_conductors_of_any_index_reflect_by_fresnels_equations() -> None:
    """Indices from 1e-3 to 1e4 (case S18)."""
    rng = np.random.default_rng(1)
    indices = (10.0 ** rng.uniform(-3, 4, (100, 2, 3))).astype(np.float32).astype(np.float64)
    builder = _core.SceneBuilder()
    for eta, k in indices:
        builder.add_bsdf("conductor", eta, k, [1, 1, 1])
    scene, wo = compile_bsdfs(builder), directions(COSINES)
    for bsdf, (eta, k) in enumerate(indices):
        got = parts.sample_bsdf(scene, bsdf, wo, np.zeros_like(wo))["weight"]
        exact = np.stack([conductor_reflectance(wo[:, 2], complex(*c)) for c in zip(eta, k, strict=True)], axis=-1)
        assert ((got >= 0) & (got <= 1)).all()
        assert (np.abs(got - exact) <= 4 * ROUNDOFF * exact).all(), (eta, k)
        assert (np.abs(1.001 * got - exact) > 4 * ROUNDOFF * exact).all(), "the twin"


def test_the_usual_approximation_is_seen_to_be_one() -> None:
    """The twin: 1/2 (Rs + Rp) for large indices, which many renderers have, is wrong for small ones."""
    eta, k, c = 0.2, 1.5, COSINES
    s = ((eta**2 + k**2) - 2 * eta * c + c**2) / ((eta**2 + k**2) + 2 * eta * c + c**2)
    p = ((eta**2 + k**2) * c**2 - 2 * eta * c + 1) / ((eta**2 + k**2) * c**2 + 2 * eta * c + 1)
    assert (np.abs(0.5 * (s + p) - conductor_reflectance(c, complex(eta, k))) > 1e-3).any()


def dielectric_reflectance(scene: _core.Scene, bsdf: int, wo: Array, front: bool) -> Array:
    """Return the probability of reflection: the number below which the sampler reflects, found by bisection."""
    low, high = np.zeros(len(wo)), np.ones(len(wo))
    for _ in range(60):
        middle = 0.5 * (low + high)
        u = np.stack([middle, 0 * middle, 0 * middle], axis=-1)
        reflects = parts.sample_bsdf(scene, bsdf, wo, u, front)["wi"][:, 2] > 0
        low, high = np.where(reflects, middle, low), np.where(reflects, high, middle)
    return low


def exact_dielectric(cosine: Array, eta: float) -> tuple[Array, Array]:
    """Return reflectance, and the square of eta times the cosine of the refracted direction, in extended precision."""
    c, n = cosine.astype(np.longdouble), np.longdouble(eta)
    squared = (n - 1) * (n + 1) + c * c
    t = np.sqrt(np.maximum(squared, 0)) / n
    s = (c - n * t) / (c + n * t)
    p = (n * c - t) / (n * c + t)
    return np.where(squared > 0, 0.5 * (s * s + p * p), 1).astype(float), squared.astype(float)


IORS = [1.5, 1.33, 2.4, 10.0, 1.01, 1.0001, 1.000001, 1 + 2.0**-23]


@pytest.mark.parametrize("ior", [*IORS, *(1 / n for n in IORS)])
@pytest.mark.parametrize("front", [True, False], ids=["outside", "inside"])
def test_dielectrics_reflect_as_often_as_fresnels_equations_say(ior: float, front: bool) -> None:
    """With total reflection, and indices next to 1 (cases S16, S17)."""
    builder = _core.SceneBuilder()
    builder.add_bsdf("dielectric", ior, [1, 1, 1], [1, 1, 1])
    scene, wo = compile_bsdfs(builder), directions(COSINES)
    eta = np.float32(ior) if front else np.float32(1) / np.float32(ior)
    exact, squared = exact_dielectric(wo[:, 2], float(eta))
    got = dielectric_reflectance(scene, 0, wo, front)
    # Next to total reflection the refracted cosine is the root of a difference, which keeps half the digits.
    tolerance = 16 * ROUNDOFF * exact * (1 + 1 / np.sqrt(np.maximum(np.abs(squared), ROUNDOFF))) + 2.0**-58
    assert (np.abs(got - exact) <= tolerance).all()
    assert (np.abs(1.001 * got - exact) > tolerance).mean() > 0.7, "the twin"


@pytest.mark.parametrize("ior", [1.5, 2.4, 1.1])
def test_within_an_ulp_of_total_reflection_nothing_is_lost(ior: float) -> None:
    """R + T = 1 for cosines next to the limit, R = 1 behind it; the usual root is no number there (S17)."""
    n = np.float32(ior)
    limit = np.float32(np.sqrt((np.float64(n) ** 2 - 1) / np.float64(n) ** 2))
    cosines = limit.view(np.int32) + np.arange(-40, 41, dtype=np.int32)
    z = cosines.view(np.float32).astype(float)
    wo = np.stack([np.sqrt(1 - z * z), 0 * z, z], axis=-1)
    builder = _core.SceneBuilder()
    builder.add_bsdf("dielectric", ior, [1, 1, 1], [1, 1, 1])
    scene = compile_bsdfs(builder)
    total = np.float32(1) / n * np.float32(1) / n - 1 + z * z < -8 * ROUNDOFF
    for u in (0.0, 0.5, 1.0 - ROUNDOFF):
        drawn = parts.sample_bsdf(scene, 0, wo, np.full_like(wo, u), False)
        assert drawn["valid"].all()
        assert np.abs(drawn["weight"] / drawn["radiance_scale"][:, None] - 1).max() < 4 * ROUNDOFF
        assert np.abs(np.linalg.norm(drawn["wi"], axis=1) - 1).max() < 4 * ROUNDOFF
        assert (drawn["wi"][total, 2] > 0).all()
    with np.errstate(invalid="ignore"):
        naive = np.sqrt(np.float32(1) - n * n * (np.float32(1) - (z * z).astype(np.float32)))
    assert np.isnan(naive).any(), "the twin"


def test_the_equations_as_they_stand_are_seen_to_lose_their_digits() -> None:
    """The twin in float32: next to 1 the reflectance is a difference of nearly equal cosines."""
    c, n = directions(COSINES)[:, 2].astype(np.float32), np.float32(1.0001)
    t = np.sqrt(1 - (1 - c * c) / (n * n))
    naive = 0.5 * (((c - n * t) / (c + n * t)) ** 2 + ((n * c - t) / (n * c + t)) ** 2)
    exact, squared = exact_dielectric(c.astype(float), float(n))
    assert (np.abs(naive - exact) > 16 * ROUNDOFF * exact * (1 + 1 / np.sqrt(squared)) + 2.0**-58).any()


@pytest.mark.parametrize("front", [True, False], ids=["outside", "inside"])
def test_refracted_directions_are_unit_and_obey_snells_law(front: bool) -> None:
    builder = _core.SceneBuilder()
    builder.add_bsdf("dielectric", 1.5, [0.9, 0.8, 0.7], [0.6, 0.5, 0.4])
    scene, wo = compile_bsdfs(builder), directions(COSINES)
    drawn = parts.sample_bsdf(scene, 0, wo, np.full_like(wo, 1.0 - ROUNDOFF), front)
    through = drawn["wi"][:, 2] < 0
    eta = 1.5 if front else 1 / 1.5
    assert through.all() if front else 0.2 < through.mean() < 0.8
    assert np.abs(np.linalg.norm(drawn["wi"], axis=1) - 1).max() < 4 * ROUNDOFF
    assert np.abs(drawn["wi"][through, :2] * eta + wo[through, :2]).max() < 4 * ROUNDOFF
    assert np.abs(drawn["weight"][through] * eta**2 - [0.6, 0.5, 0.4]).max() < 4 * ROUNDOFF
    assert np.abs(drawn["weight"][~through] - [0.9, 0.8, 0.7]).max(initial=0) < 4 * ROUNDOFF
    assert drawn["delta"].all()


def test_an_index_of_one_lets_everything_pass_straight_on() -> None:
    builder = _core.SceneBuilder()
    builder.add_bsdf("dielectric", 1.0, [1, 1, 1], [1, 1, 1])
    scene, wo = compile_bsdfs(builder), directions(COSINES)
    drawn = parts.sample_bsdf(scene, 0, wo, np.zeros_like(wo))
    assert (drawn["wi"] == -wo).all()
    assert (drawn["weight"] == 1).all()
