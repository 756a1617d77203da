"""What environments light, and what lies in them unseen: closed forms for whole renders.

Seeds are fixed. The z-tests of this file together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from ..statistical.charts import HalfVectorChart
from ..statistical.chi2 import LEVEL, Masses, share
from ..statistical.worlds import affine, build, estimate, looking, render, turned
from .test_microfacets import MIRROR, value

Array = NDArray[np.float64]
TECHNIQUES = ["uniform", "bsdf", "light", "mis", "mixture"]
EACH = share(LEVEL, 60)
RHO, SKY = np.array([0.8, 0.5, 0.2]), np.array([1.0, 2.0, 0.5])
HUGE = np.diag([1e3, 1e3, 1.0, 1.0])


def add_sky(builder: _core.SceneBuilder) -> None:
    builder.add_constant_environment(SKY)


def add_ball(builder: _core.SceneBuilder) -> None:
    diffuse = builder.add_bsdf("diffuse", RHO)
    builder.add_sphere([0, 0, 0], 1.0, flip_normals=False, front=diffuse, back=None, radiance=None)


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_a_diffuse_ball_reflects_its_share_of_an_even_sky(technique: str) -> None:
    camera = looking([0, -5, 1], [0, 0, 0])
    got = estimate(build(add_sky, add_ball, camera=camera, fov=10.0, size=(16, 16)), 1024, technique=technique)
    assert got.p(RHO * SKY) > EACH, got
    assert got.p(1.02 * RHO * SKY) < EACH, "the twin"


def texels(bright: float) -> Array:
    pixels = np.random.default_rng(3).uniform(0.2, 1.0, (9, 12, 3))
    pixels[2, 7] = bright
    return pixels.astype(np.float32).astype(float)


def irradiance_from_above(pixels: Array) -> Array:
    """Return the integral over the upper half of radiance times cosine, rows of texels being linear in between.

    Round the pole, interpolation keeps a row's mean.
    """
    rows = pixels.mean(axis=1)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total, step = np.zeros(3), np.pi / (len(rows) - 1)
    for i in range((len(rows) - 1) // 2):
        down = 0.5 * (nodes + 1)
        theta = (i + down) * step
        kernel = 0.5 * step * weights * np.cos(theta) * np.sin(theta) * 2 * np.pi
        total += (kernel * (1 - down)).sum() * rows[i] + (kernel * down).sum() * rows[i + 1]
    return total


@pytest.mark.parametrize("bright", [1.0, 1e3, 1e6, 1e12])
@pytest.mark.parametrize("technique", ["light", "mis"])
def test_ground_under_a_sky_of_texels_gets_their_exact_sum(technique: str, bright: float) -> None:
    pixels, rotation = texels(bright), turned([1, 0.3, -0.2], 60)

    def add(builder: _core.SceneBuilder) -> None:
        builder.add_image_environment(pixels.astype(np.float32), 0.5, affine(*rotation.T))
        diffuse = builder.add_bsdf("diffuse", RHO)
        ground = affine(*(1e3 * rotation[:, [2, 0, 1]]).T)
        builder.add_rectangle(ground, flip_normals=False, front=diffuse, back=None, radiance=None)

    camera = looking(rotation @ [0.1, 3, 0.2], [0, 0, 0])
    got = estimate(build(add, camera=camera, size=(16, 16)), 256, technique=technique)
    exact = RHO / np.pi * 0.5 * irradiance_from_above(pixels)
    assert got.p(exact) > EACH, (got, exact)
    assert got.p(1.05 * exact) < EACH, "the twin"


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("model", ["ggx", "beckmann"])
def test_a_rough_mirror_reflects_its_albedo_of_an_even_sky(model: str, technique: str) -> None:
    def add(builder: _core.SceneBuilder) -> None:
        metal = builder.add_bsdf("roughconductor", model, 0.5, 0.5, *MIRROR)
        builder.add_rectangle(HUGE, flip_normals=False, front=metal, back=None, radiance=None)

    eye = np.array([3.0, 0.0, 1.5])
    wo = eye / np.linalg.norm(eye)
    masses = Masses(
        HalfVectorChart(wo, model, 0.5, 0.5), lambda wi: value(model, np.broadcast_to(wo, wi.shape), wi, 0.5, 0.5)
    )
    scene = build(add_sky, add, camera=looking(eye, [0, 0, 0]), fov=1e-3, size=(8, 8))
    got = estimate(scene, 1024, technique=technique)
    doubt = np.sqrt((masses.doubt**2).sum())
    exact = masses.total * SKY
    assert min(got.p(exact * (1 + 3 * doubt)), got.p(exact * (1 - 3 * doubt))) > EACH / 10, (got, exact)
    assert got.p(1.05 * exact) < EACH, "the twin"


def add_glass(ior: float, cube: bool) -> object:
    def add(builder: _core.SceneBuilder) -> None:
        glass = builder.add_bsdf("dielectric", ior, [1, 1, 1], [1, 1, 1])
        if not cube:
            builder.add_sphere([0, 0, 0], 1.0, flip_normals=False, front=glass, back=glass, radiance=None)
            return
        turn = turned([1, 2, 3], 40)
        for axis in (*np.eye(3), *-np.eye(3)):
            n, x = turn @ axis, turn @ np.roll(axis, 1)
            side = affine(x, np.cross(n, x), n, n)
            builder.add_rectangle(side, flip_normals=False, front=glass, back=glass, radiance=None)

    return add


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("cube", [False, True], ids=["ball", "cube"])
@pytest.mark.parametrize("ior", [1.5, 1 / 1.5, 1.0001, 2.4])
def test_glass_in_an_even_sky_cannot_be_seen(ior: float, cube: bool, technique: str) -> None:
    """No path loses or gains anything, whether it is refracted or totally reflected (case S17)."""
    scene = build(add_sky, add_glass(ior, cube), camera=looking([0, -4, 1], [0, 0, 0]), fov=45.0, size=(32, 32))
    got = estimate(scene, 16, technique=technique)
    assert np.abs(got.least / SKY - 1).max() < 1e-5
    assert np.abs(got.most / SKY - 1).max() < 1e-5


def test_glass_of_index_one_changes_nothing() -> None:
    """Cases S16, T8: also seen from within."""
    pixels = texels(3.0).astype(np.float32)

    def add_map(builder: _core.SceneBuilder) -> None:
        builder.add_image_environment(pixels, 1.0, np.eye(4))

    for eye in ([0, -4, 1], [0, -0.5, 0.3]):
        views = [
            render(build(add_map, *more, camera=looking(eye, [0, 0, 0]), fov=50.0, size=(32, 32)), 8)["mean"][0]
            for more in ([], [add_glass(1.0, False)], [add_glass(1.0, True)])
        ]
        for view in views[1:]:
            assert np.abs(view / views[0] - 1).max() < 1e-4
