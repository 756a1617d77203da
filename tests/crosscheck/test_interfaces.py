"""Plastics and glass by the cross-check's float64 models, by value, against the core's: eval and density.

Directions are random; each model has its tolerance, with its reason.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts
from equaltime.crosscheck import interfaces
from equaltime.scene.model import Plastic, RoughDielectric, RoughPlastic, ThinDielectric

from ..statistical.worlds import build

Array = NDArray[np.float64]
COLORS: dict[str, Any] = {"diffuse_reflectance": (0.8, 0.5, 0.1), "specular_reflectance": (0.9, 1.0, 0.7)}
COUNT = 4000


def directions(seed: int, below: bool = False) -> tuple[Array, Array]:
    """Return wo above the surface and wi, on either side if asked for, as float32 has them."""
    v = np.random.default_rng(seed).standard_normal((2, COUNT, 3))
    v /= np.linalg.norm(v, axis=2, keepdims=True)
    v[:, :, 2] = np.abs(v[:, :, 2])
    if below:
        v[1, ::2, 2] *= -1
    steep = (np.abs(v[:, :, 2]) > 0.02).all(axis=0)
    wo, wi = v[:, steep].astype(np.float32).astype(np.float64)
    return wo, wi


def core(call: str, arguments: tuple[Any, ...], wo: Array, wi: Array, front: bool = True) -> tuple[Array, Array]:
    def add(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf(call, *arguments)
        b.add_rectangle(np.eye(4), flip_normals=False, front=bsdf, back=bsdf, radiance=None)

    found = parts.eval_bsdf(build(add), 0, wo, wi, front)
    return found["f"], found["pdf"]


def agree(ours: tuple[Array, Array], core: tuple[Array, Array], rtol: float) -> None:
    for a, b in zip(ours, core, strict=True):
        np.testing.assert_allclose(a, b, rtol=rtol, atol=1e-7 * float(np.abs(b).max()))
        assert np.abs(a * 1.02 - b).max() > rtol * np.abs(b).max(), "the twin"


@pytest.mark.parametrize("nonlinear", [False, True])
def test_smooth_plastic(nonlinear: bool) -> None:
    """The mean transmittance, by which the mirror has its share, is a fit here and a sum there: 0.1 % apart."""
    bsdf = Plastic(int_ior=1.49, ext_ior=1.0, nonlinear=nonlinear, **COLORS)
    wo, wi = directions(1)
    arguments = (1.49, COLORS["diffuse_reflectance"], COLORS["specular_reflectance"], nonlinear)
    agree(interfaces.plastic(bsdf, wo, wi), core("plastic", arguments, wo, wi), 2e-3)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("alpha", [0.1, 0.5])
def test_rough_plastic(distribution: Any, alpha: float) -> None:
    """The core integrates the interface with fewer points, to about 3e-4; what a body sends back magnifies that."""
    bsdf = RoughPlastic(int_ior=1.49, ext_ior=1.0, distribution=distribution, alpha=alpha, nonlinear=True, **COLORS)
    wo, wi = directions(2)
    arguments = (distribution, alpha, 1.49, COLORS["diffuse_reflectance"], COLORS["specular_reflectance"], True)
    agree(interfaces.rough_plastic(bsdf, wo, wi), core("roughplastic", arguments, wo, wi), 4e-3)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("alphas", [(0.3, 0.3), (0.2, 0.6)])
@pytest.mark.parametrize("front", [True, False])
def test_rough_glass(distribution: Any, alphas: tuple[float, float], front: bool) -> None:
    """Half-vectors of refraction are differences, and Beckmann's tails exponentials: both magnify rounding."""
    u, v = alphas
    bsdf = RoughDielectric(int_ior=1.5, ext_ior=1.0, distribution=distribution, alpha_u=u, alpha_v=v)
    wo, wi = directions(3, below=True)
    found = core("roughdielectric", (distribution, u, v, 1.5, (1.0,) * 3, (1.0,) * 3), wo, wi, front)
    agree(interfaces.rough_dielectric(bsdf, wo, wi, front), found, 2e-3)


def test_rough_glass_obeys_reciprocity_but_for_the_compression_of_radiance() -> None:
    bsdf = RoughDielectric(int_ior=1.5, ext_ior=1.0, distribution="ggx", alpha=0.4)
    wo, wi = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in directions(4))
    there, _ = interfaces.rough_dielectric(bsdf, wo, wi)
    back, _ = interfaces.rough_dielectric(bsdf, wi, wo)
    np.testing.assert_allclose(there / wi[:, 2:], back / wo[:, 2:], rtol=1e-7)
    through, _ = interfaces.rough_dielectric(bsdf, wo, -wi, True)
    from_inside, _ = interfaces.rough_dielectric(bsdf, wi, -wo, False)
    np.testing.assert_allclose(through / wi[:, 2:] * 1.5**2, from_inside / wo[:, 2:], rtol=1e-7)


@pytest.mark.parametrize("front", [True, False])
@pytest.mark.parametrize("degrees", [10.0, 60.0])
def test_rough_glass_makes_no_light(degrees: float, front: bool) -> None:
    bsdf = RoughDielectric(int_ior=1.5, ext_ior=1.0, distribution="ggx", alpha=0.3)
    n = 600
    z, phi = np.meshgrid(2 * (np.arange(n) + 0.5) / n - 1, 2 * np.pi * (np.arange(n) + 0.5) / n)
    r = np.sqrt(1 - z**2)
    wi = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).reshape(-1, 3)
    wo = np.broadcast_to([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))], wi.shape)
    value, pdf = interfaces.rough_dielectric(bsdf, wo, wi, front)
    eta2 = 1.5**2 if front else 1.5**-2  # radiance is compressed: what is transmitted is as many times less power
    power = (value[:, 0] * np.where(wi[:, 2] < 0, eta2, 1.0)).sum() * 4 * np.pi / n**2
    assert 0.7 < power <= 1.0 + 1e-3
    assert 0.8 < pdf.sum() * 4 * np.pi / n**2 <= 1.0 + 1e-3


def test_a_pane_reflects_what_its_series_sums_up_to() -> None:
    """By float32's rounding alone: the albedo of the core's sheet, from the samples that mirror."""
    bsdf = ThinDielectric(int_ior=1.5, ext_ior=1.0)
    wo, _ = directions(5)

    def add(b: _core.SceneBuilder) -> None:
        pane = b.add_bsdf("thindielectric", 1.5, (1.0,) * 3, (1.0,) * 3)
        b.add_rectangle(np.eye(4), flip_normals=False, front=pane, back=pane, radiance=None)

    scene, expected = build(add), interfaces.thin_reflectance(bsdf, wo)
    for off, mirrors in ((-1e-5, True), (1e-5, False)):
        u = np.stack([expected + off, np.full(len(wo), 0.5), np.full(len(wo), 0.5)], axis=1)
        above = parts.sample_bsdf(scene, 0, wo, u)["wi"][:, 2] > 0
        assert (above == mirrors).mean() > 0.999
