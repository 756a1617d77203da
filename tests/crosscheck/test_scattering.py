"""Plastics, rough diffuse surfaces, glass and the principled model as the cross-check traces them.

Both their samples and whole images are tested.

Seeds are fixed. The tests of samples have a false-alarm rate of 1e-4 each; all image comparisons together have 0.1 %,
shared equally.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime.crosscheck import scattering
from equaltime.scene.model import Bsdf, Plastic, Principled, RoughDielectric, RoughDiffuse, RoughPlastic, ThinDielectric

from .test_against_core import FLOOR, LAMP, SKY, TURNED, scene, twosided

Array = NDArray[np.float64]
LEVEL = 1e-4
BODY: dict[str, Any] = {"diffuse_reflectance": (0.8, 0.5, 0.1), "specular_reflectance": (0.9, 1.0, 0.7)}
GLASSY: dict[str, Any] = {"base_color": (0.8, 0.4, 0.1), "roughness": 0.6, "spec_trans": 0.7, "eta": 1.5}
COATED: dict[str, Any] = {
    **{"base_color": (0.8, 0.4, 0.1), "roughness": 0.5, "anisotropic": 0.4, "metallic": 0.3, "spec_tint": 0.4},
    **{"sheen": 0.5, "flatness": 0.3, "clearcoat": 1.0, "clearcoat_gloss": 0.1},
}
MODELS: dict[str, tuple[Bsdf, bool]] = {
    "rough diffuse": (RoughDiffuse(reflectance=(0.8, 0.5, 0.1), alpha=0.5), True),
    "rough plastic": (RoughPlastic(distribution="ggx", alpha=0.3, **BODY), True),
    "rough glass": (RoughDielectric(distribution="ggx", alpha_u=0.3, alpha_v=0.5, int_ior=1.5), True),
    "rough glass from inside": (RoughDielectric(distribution="beckmann", alpha=0.4, int_ior=1.5), False),
    "principled": (Principled(**COATED), True),
    "principled glass": (Principled(**GLASSY), True),
    "principled glass from inside": (Principled(**GLASSY), False),
}


def directions() -> tuple[Array, float]:
    """Return directions that each stand for the same solid angle, and that angle."""
    n = 500
    z, phi = np.meshgrid(2.0 * (np.arange(n) + 0.5) / n - 1.0, 2.0 * math.pi * (np.arange(n) + 0.5) / n)
    r = np.sqrt(1.0 - z**2)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).reshape(-1, 3), 4.0 * math.pi / n**2


def p_value(samples: Array, expected: float) -> float:
    error = samples.std(ddof=1) / math.sqrt(samples.size)
    return float(2.0 * stats.norm.sf(abs(samples.mean() - expected) / error))


@pytest.mark.parametrize("name", MODELS)
def test_samples_have_the_density_and_the_weights_that_are_stated(name: str) -> None:
    bsdf, front = MODELS[name]
    wo, n = np.array([0.42, 0.56, math.sqrt(1.0 - 0.42**2 - 0.56**2)]), 100_000
    scattered = scattering.sample(bsdf, np.tile(wo, (n, 1)), np.full(n, front), np.random.default_rng(3))
    wi, angle = directions()
    value, pdf = scattering.evaluate(bsdf, np.broadcast_to(wo, wi.shape), wi, np.full(len(wi), front))
    drawn = scattered.weight[:, 1] * np.exp(scattered.wi[:, 0])  # a test function that is not even
    integral = float((value[:, 1] * np.exp(wi[:, 0])).sum()) * angle
    assert p_value(drawn, integral) > LEVEL
    assert p_value(drawn, 1.03 * integral) < LEVEL, "the twin"
    found = scattered.weight.any(axis=1)  # the others were drawn where there is nothing
    there = value.any(axis=1)
    for look in (lambda v: np.ones(len(v)), lambda v: v[:, 0], lambda v: (v[:, 2] < 0.0) + 0.0):
        mean = float((look(wi) * pdf)[there].sum()) * angle
        spread = look(scattered.wi) * found
        assert spread.std() == 0.0 or p_value(spread, mean) > LEVEL


def test_the_mirror_over_a_body_and_the_pane_take_all_that_is_not_the_rest() -> None:
    """In a white furnace all weights are what is sent back: 1 for a pane, and for white plastic on the average."""
    wo = np.tile([0.6, 0.0, 0.8], (100_000, 1))
    front = np.ones(len(wo), np.bool_)
    pane = scattering.sample(ThinDielectric(), wo, front, np.random.default_rng(1))
    assert (pane.weight == 1.0).all()
    assert 0.05 < (pane.wi[:, 2] > 0.0).mean() < 0.15
    white = Plastic(diffuse_reflectance=(1.0, 1.0, 1.0), nonlinear=True)
    found = scattering.sample(white, wo, front, np.random.default_rng(2)).weight[:, 0]
    assert found.mean() == pytest.approx(1.0, abs=5e-3), "but for the fits of what is reflected inside"
    assert np.isinf(scattering.sample(white, wo, front, np.random.default_rng(2)).pdf).any()


BALL = {"type": "sphere", "center": [-1, 0, 0], "radius": 0.9}
CUBE = {"type": "cube", "to_world": [{"scale": 0.55}, *TURNED, {"translate": (1, 0, 0)}]}


def plastics(change: float = 1.0) -> et.Scene:
    rough = {
        "type": "roughplastic",
        "distribution": "ggx",
        "alpha": 0.3,
        "diffuse_reflectance": [0.8 * change, 0.3, 0.1],
    }
    smooth = {"type": "plastic", "diffuse_reflectance": [0.6 * change, 0.5, 0.9], "nonlinear": True}
    return scene(FLOOR, LAMP, SKY, BALL | {"bsdf": rough}, CUBE | {"bsdf": twosided(smooth)})


def plasters(change: float = 1.0) -> et.Scene:
    full, fast = (
        {"type": "roughdiffuse", "reflectance": [0.8 * change, 0.3, 0.1], "alpha": 0.6, "use_fast_approx": is_fast}
        for is_fast in (False, True)
    )
    return scene(FLOOR, LAMP, SKY, BALL | {"bsdf": full}, CUBE | {"bsdf": twosided(fast)})


def glasses(change: float = 1.0) -> et.Scene:
    rough = {
        "type": "roughdielectric",
        "distribution": "ggx",
        "alpha": 0.4,
        "specular_transmittance": [change, 0.9, 0.8],
    }
    pane = {"type": "rectangle", "to_world": [{"scale": 0.8}, *TURNED, {"translate": (1, 0, 1)}]}
    return scene(FLOOR, LAMP, SKY, BALL | {"bsdf": rough}, pane | {"bsdf": {"type": "thindielectric"}}, depth=5)


def principled(change: float = 1.0) -> et.Scene:
    coated = {"type": "principled", **COATED, "base_color": [0.8 * change, 0.4, 0.1]}
    glass = {"type": "principled", **GLASSY, "base_color": [0.8 * change, 0.4, 0.1]}
    return scene(FLOOR, LAMP, SKY, BALL | {"bsdf": coated}, CUBE | {"bsdf": glass}, depth=5)


SCENES: dict[str, Callable[..., et.Scene]] = {
    **{"plastics": plastics, "plasters": plasters, "glasses": glasses, "principled": principled}
}
EACH = 0.001 / len(SCENES)


@pytest.mark.filterwarnings("ignore:overflow encountered in divide")
@pytest.mark.parametrize("name", SCENES)
def test_core_and_embreex_have_the_same_image(name: str, agreement: Callable[..., float]) -> None:
    assert agreement(SCENES[name](), spp=256) > EACH


@pytest.mark.filterwarnings("ignore:overflow encountered in divide")
@pytest.mark.parametrize("name", SCENES)
def test_another_colour_of_one_channel_is_found(name: str, agreement: Callable[..., float]) -> None:
    """The power twin: that the tests above pass means something."""
    assert agreement(SCENES[name](), spp=128, core=SCENES[name](0.75)) < EACH
