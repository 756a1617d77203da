"""The rough diffuse model: values by Oren and Nayar's formulas in float64, the light that it scatters in all, textures,
and one image by all techniques.

Seeds are fixed. The comparisons of images together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime._core import parts
from equaltime.crosscheck import scattering
from equaltime.scene.model import RoughDiffuse
from equaltime.statistics.agreement import LEVEL, BlockMeans, compare, share

from ..statistical.changed import changed
from ..statistical.worlds import direction, render

Array = NDArray[np.float64]
ORANGE: Final = (0.9, 0.5, 0.1)
WHITE: Final = (1.0, 1.0, 1.0)
ALPHAS: Final = (0.0, 0.05, 0.2, 0.5, 0.9, 3.0, 1e30)
FIT: Final = 0.0011
"""Largest error of the core's albedo, as its header states it."""


def formulas(bsdf: RoughDiffuse, wo: Array, wi: Array) -> Array:
    return scattering.evaluate(bsdf, wo, wi, np.ones(len(wo), np.bool_))[0]


def core_values(bsdf: RoughDiffuse, wo: Array, wi: Array) -> Array:
    builder = _core.SceneBuilder()
    builder.add_bsdf("roughdiffuse", **bsdf.parameters())
    builder.set_perspective(np.eye(4), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    values: Array = parts.eval_bsdf(builder.build(), 0, wo, wi)["f"]
    return values


def error(bsdf: RoughDiffuse, other: RoughDiffuse) -> float:
    """Return how far the core's values are from the formulas of `other`, in units of what float32 may do."""
    rng = np.random.default_rng(1)
    wo, wi = rng.standard_normal((2, 20_000, 3))
    for w in (wo, wi):
        w[:, 2] = np.abs(w[:, 2]) * rng.choice([1.0, 0.01], len(w)) + 1e-4
        w /= np.linalg.norm(w, axis=1, keepdims=True)
    # Where both directions graze, the difference of two numbers near 1 is multiplied by the smaller angle's tangent.
    tolerance = 1e-6 * (1.0 + 1.0 / np.maximum(wo[:, 2], wi[:, 2]))
    off = np.abs(core_values(bsdf, wo, wi) - formulas(other, wo, wi)) / wi[:, 2:]
    return float((off.max(axis=1) / tolerance).max())


@pytest.mark.parametrize("fast", [False, True])
@pytest.mark.parametrize("alpha", ALPHAS)
def test_values_are_those_of_the_formulas(alpha: float, fast: bool) -> None:
    bsdf = RoughDiffuse(reflectance=ORANGE, alpha=alpha, use_fast_approx=fast)
    assert error(bsdf, bsdf) < 1.0
    if 0.0 < alpha < 1e3:
        assert error(bsdf, bsdf.replace(alpha=1.01 * alpha)) > 1.0, "the twin, rougher"
        assert error(bsdf, bsdf.replace(use_fast_approx=not fast)) > 1.0, "the twin, of the other model"


def albedo_of_formulas(bsdf: RoughDiffuse, theta: float) -> Array:
    """Return the light that is scattered in all, by Gauss's quadrature between the kinks of the formulas."""
    x, weights = np.polynomial.legendre.leggauss(48)
    cosines = [np.cos(np.radians(theta)), *np.cos(np.radians([0.0, 30.0, 60.0, 75.0, 84.0, 88.0, 90.0]))]
    z, dz = _between(np.sort(cosines), x, weights)
    phi, dphi = _between(np.array([0.0, 0.5 * np.pi, np.pi]), x, weights)
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1.0 - z**2)
    wi = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    wo = np.broadcast_to(direction(theta), wi.shape)
    total: Array = 2.0 * (np.outer(dz, dphi).ravel()[:, None] * formulas(bsdf, wo, wi)).sum(axis=0)
    return total


def _between(ends: Array, x: Array, weights: Array) -> tuple[Array, Array]:
    half, middle = 0.5 * np.diff(ends)[:, None], 0.5 * (ends[1:] + ends[:-1])[:, None]
    return (middle + half * x).ravel(), (half * weights).ravel()


def albedo_of_core(bsdf: RoughDiffuse, theta: float) -> Array:
    camera = {
        "type": "perspective",
        "fov": 1e-3,
        "to_world": [{"look_at": {"origin": direction(theta).tolist(), "target": [0, 0, 0], "up": [0.1, 1, 0]}}],
        "film": {"type": "hdrfilm", "width": 1, "height": 1},
    }
    plate = {"type": "rectangle", "bsdf": described(bsdf)}
    scene = {"type": "scene", "camera": camera, "plate": plate, "sky": {"type": "constant"}}
    vertex = et.replay(et.load_dict(scene), pixel=(0, 0), sample=0).vertices[0]
    return np.array(vertex["scattering"]["albedo"])


def described(bsdf: RoughDiffuse) -> dict[str, Any]:
    return {"type": "roughdiffuse", **bsdf.parameters(), "reflectance": list(bsdf.parameters()["reflectance"])}


@pytest.mark.parametrize("fast", [False, True])
def test_the_albedo_is_the_integral_to_the_stated_error(fast: bool) -> None:
    for theta in (0.5, 20.0, 45.0, 70.0, 85.0, 89.0):
        for alpha in (0.1, 0.4, 0.9):
            bsdf = RoughDiffuse(reflectance=ORANGE, alpha=alpha, use_fast_approx=fast)
            off = np.abs(albedo_of_core(bsdf, theta) - albedo_of_formulas(bsdf, theta)).max()
            assert off < (1e-5 if fast else FIT), (theta, alpha)


def test_white_surfaces_scatter_from_as_little_to_as_much_light_as_is_stated() -> None:
    for fast, least, most in ((False, 0.67, 1.051), (True, 0.5, 1.016)):
        bsdf = RoughDiffuse(reflectance=WHITE, use_fast_approx=fast)
        alphas = (0.1, 0.2, 0.28, 0.43, 0.5, 1.0, 3.0, 1e3)
        found = {
            alpha: [albedo_of_formulas(bsdf.replace(alpha=alpha), theta)[0] for theta in (0.0, 40.0, 70.0, 89.9)]
            for alpha in alphas
        }
        every = [value for values in found.values() for value in values]
        assert least <= min(every) < least + 0.001
        assert most - 0.002 < max(every) <= most
        assert fast or min(min(found[alpha]) for alpha in alphas if alpha <= 0.5) > 0.94


# ---- images ---------------------------------------------------------------------------------------------------------

SIDE: Final = 16


def room(bsdf: dict[str, Any], depth: int = 5) -> et.Scene:
    """Return a ball on a floor, both of one material, under a window and a sky."""
    camera = {
        "type": "perspective",
        "fov": 40,
        "to_world": [{"look_at": {"origin": (0.5, 1.5, 5), "target": (0, -0.4, 0), "up": (0, 1, 0)}}],
        "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}},
    }
    flat = [{"rotate": {"axis": (1, 0, 0), "angle": -90}}, {"scale": 4}, {"translate": (0, -1, 0)}]
    above = [{"look_at": {"origin": (-2, 3, 2), "target": (0, 0, 0), "up": (0, 1, 0)}}]
    objects = {
        "floor": {"type": "rectangle", "to_world": flat, "bsdf": bsdf},
        "ball": {"type": "sphere", "bsdf": bsdf},
        "window": {"type": "rectangle", "to_world": above, "emitter": {"type": "area", "radiance": [5.0, 6.0, 7.0]}},
        "sky": {"type": "constant", "radiance": [0.4, 0.3, 0.2]},
    }
    integrator = {"type": "path", "max_depth": depth}
    return et.load_dict({"type": "scene", "integrator": integrator, "camera": camera, **objects})


def bits(bsdf: dict[str, Any]) -> bytes:
    return bytes(render(room(bsdf).core, 4))


def test_without_roughness_it_is_diffuse_bit_by_bit() -> None:
    smooth = {"type": "roughdiffuse", "reflectance": [*ORANGE], "alpha": 0.0}
    diffuse = {"type": "diffuse", "reflectance": [*ORANGE]}
    for fast in (False, True):
        assert bits(smooth | {"use_fast_approx": fast}) == bits(diffuse)
    assert bits(smooth | {"alpha": 1e-3}) != bits(diffuse), "the twin"


@pytest.mark.parametrize("name", ["reflectance", "alpha"])
def test_textures_give_its_parameters(name: str) -> None:
    """A pixel that sees squares of one colour has the bits of a surface of that colour."""
    low, high, squares = (
        render(room({"type": "roughdiffuse", "alpha": 0.5, name: value}, depth=2).core, 4)["mean"][0]
        for value in (0.25, 0.75, {"type": "checkerboard", "color0": [0.25] * 3, "color1": [0.75] * 3})
    )
    is_low, is_high = ((squares == one).all(axis=-1) for one in (low, high))
    for square in (is_low & ~is_high, is_high & ~is_low):
        assert square.sum() > SIDE
    assert (is_low | is_high).mean() > 0.7, "the others see both squares"


TECHNIQUES: Final = ("light", "bsdf", "uniform")


def test_all_techniques_have_one_image() -> None:
    each = share(LEVEL, 2 * len(TECHNIQUES))

    @cache
    def means(technique: str, light: float = 1.0) -> BlockMeans:
        first = 100 * (1 + ("mis", *TECHNIQUES).index(technique)) + 50 * (light != 1.0)
        scene = changed(room({"type": "roughdiffuse", "reflectance": [*ORANGE], "alpha": 0.8}), light=light)
        images = (render(scene, 64, seed, technique=technique)["mean"][0] for seed in range(first, first + 48))
        return BlockMeans.of_seeds(images, 8)

    for technique in TECHNIQUES:
        assert compare(means("mis"), means(technique)).p > each, technique
        assert compare(means("mis", light=1.05), means(technique)).p < each, f"the twin of {technique}"
