"""How much light BSDFs of several lobes scatter in all: never more than came in, all of it where the model loses none,
and as much as `albedo` and formulas say; reciprocity; extreme arguments.

The mean weight of samples, rejected ones counted as 0, is the albedo of a direction. The z-tests of this file together
have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime._core import parts

from ..statistical.chi2 import LEVEL, share
from ..statistical.leaves import LEAVES, Trial, scene_of
from ..statistical.worlds import direction

Array = NDArray[np.float64]
ANGLES = (0.0, 45.0, 80.0, 89.0)
SIDES = [(name, front) for name, leaf in LEAVES.items() for front in (True, False) if front or leaf.transmits]
EACH = share(LEVEL, len(SIDES) * len(ANGLES))


def albedo(trial: Trial) -> tuple[Array, Array]:
    """Return the mean weight and its standard error, by colour; refraction's compression of radiance is not in it."""
    weight = trial.drawn["weight"] / trial.drawn["radiance_scale"][:, None]
    return weight.mean(axis=0), weight.std(axis=0) / np.sqrt(len(weight)) + 1e-6


@pytest.mark.parametrize("theta", ANGLES)
@pytest.mark.parametrize(("name", "front"), SIDES)
def test_no_more_light_leaves_than_came_and_all_of_it_where_none_is_lost(name: str, front: bool, theta: float) -> None:
    leaf = LEAVES[name]
    mean, error = albedo(Trial(name, direction(theta, 30.0), front, samples=1 << 16))
    slack = float(stats.norm.isf(EACH / 6)) * error + leaf.slack
    assert (mean < leaf.most + slack).all()
    if leaf.lossless:
        assert (mean > 1.0 - slack).all()
        assert (0.98 * mean < 1.0 - slack).all(), "the twin"


@pytest.mark.parametrize(("name", "front"), [s for s in SIDES if not LEAVES[s[0]].transmits])
def test_reflection_is_reciprocal(name: str, front: bool) -> None:
    rng = np.random.default_rng(3)
    wo, wi = rng.standard_normal((2, 5000, 3))
    for w in (wo, wi):
        w[:, 2] = np.abs(w[:, 2]) + 0.01
        w /= np.linalg.norm(w, axis=1, keepdims=True)
    there = parts.eval_bsdf(scene_of(name), 0, wo, wi, front)["f"] / wi[:, 2:]
    back = parts.eval_bsdf(scene_of(name), 0, wi, wo, front)["f"] / wo[:, 2:]
    assert (there > 0).any()
    assert np.abs(there - back).max() < 2e-6 * there.max()
    assert (np.abs(1.001 * there - back) > 1e-5 * there)[there > 0].all(), "the twin"


@pytest.mark.parametrize(("name", "front"), SIDES)
def test_extreme_numbers_and_grazing_directions_give_finite_values(name: str, front: bool) -> None:
    ends = np.array([0.0, 2.0**-32, 2.0**-24, 0.5, 1.0 - 2.0**-24])
    cosines = np.array([1.0, 1e-2, 1e-4, 1e-7, 1e-20, 1e-38])
    u = np.stack(np.meshgrid(ends, ends, ends), axis=-1).reshape(-1, 3)
    for cosine in cosines:
        wo = np.broadcast_to([0.6 * np.sqrt(1 - cosine**2), 0.8 * np.sqrt(1 - cosine**2), cosine], u.shape)
        drawn = parts.sample_bsdf(scene_of(name), 0, wo, u, front)
        assert np.isfinite(drawn["weight"]).all()
        assert np.isfinite(drawn["wi"]).all()
        assert (drawn["weight"] >= 0).all()
        assert (drawn["pdf"][drawn["valid"] & ~drawn["delta"]] > 0).all()
        assert (np.abs(np.linalg.norm(drawn["wi"], axis=1) - 1) < 1e-5)[drawn["valid"]].all()
        for sign in (1.0, -1.0):
            for other in cosines:
                along = wo[0, :2] / np.linalg.norm(wo[0, :2]) if cosine < 1 else np.array([1.0, 0.0])
                for turned in (along, -along, along[::-1]):
                    wi = np.array([[*(turned * np.sqrt(1 - other**2)), sign * other]])
                    value = parts.eval_bsdf(scene_of(name), 0, wo[:1], wi, front)
                    assert np.isfinite(value["f"]).all()
                    assert np.isfinite(value["pdf"]).all()


def test_a_pane_reflects_what_an_endless_series_of_reflections_sums_to() -> None:
    """R + T R T + T R^3 T + …, from Fresnel's equations, in float64."""
    for name, ior in (("pane", 1.5), ("thin film", float(np.float32(0.7)))):
        for theta in (0.0, 30.0, 75.0):
            c = direction(theta)[2]
            across = np.sqrt(complex(ior**2 - 1 + c * c)).real
            r = 1.0 if ior**2 - 1 + c * c < 0 else _interface(c, across, ior)
            series = r + (1 - r) ** 2 * sum(r ** (2 * k + 1) for k in range(200)) if r < 1 else 1.0
            u = np.zeros((1 << 14, 3))
            u[:, 0] = (np.arange(len(u)) + 0.5) / len(u)
            drawn = parts.sample_bsdf(scene_of(name), 0, np.broadcast_to(direction(theta), u.shape), u)
            assert abs((drawn["wi"][:, 2] > 0).mean() - series) <= 1.0 / len(u)
            assert drawn["delta"].all()


def _interface(c: float, across: float, ior: float) -> float:
    s, p = (c - across) / (c + across), (ior**2 * c - across) / (ior**2 * c + across)
    return float(0.5 * (s * s + p * p))
