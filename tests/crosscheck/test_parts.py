"""The parts of the cross-check against formulas: camera, filters, scattering, environments, what rays meet.

Statistical tests have fixed seeds and a false-alarm rate of 1e-4 each.
"""

from __future__ import annotations

import importlib
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime.crosscheck import bsdfs
from equaltime.crosscheck.camera import Camera, filter_offsets
from equaltime.crosscheck.environment import ConstantEnvironment, ImageEnvironment
from equaltime.crosscheck.world import World
from equaltime.scene.model import Box, Bsdf, Conductor, Diffuse, Gaussian, HdrFilm, Perspective, RoughConductor, Tent

Array = NDArray[np.float64]
LEVEL = 1e-4
GOLD: dict[str, Any] = {"eta": (0.2, 0.9, 1.1), "k": (3.9, 2.4, 2.1)}
ROUGH = [
    RoughConductor(distribution=distribution, alpha_u=u, alpha_v=v, **GOLD)
    for distribution in ("ggx", "beckmann")
    for u, v in ((0.3, 0.3), (0.1, 0.6))
]


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(seed))


def p_value(samples: Array, expected: float) -> float:
    """Two-sided, for the mean of many independent samples."""
    error = samples.std(ddof=1) / math.sqrt(samples.size)
    return float(2.0 * stats.norm.sf(abs(samples.mean() - expected) / error))


def sphere(count: int, seed: int = 3) -> Array:
    v = rng(seed).standard_normal((count, 3))
    unit: Array = v / np.linalg.norm(v, axis=1, keepdims=True)
    return unit


def scene(*shapes: dict[str, object]) -> et.Scene:
    return et.load_dict(
        {"type": "scene", "sensor": {"type": "perspective"}, **{f"shape{i}": shape for i, shape in enumerate(shapes)}}
    )


def test_importing_without_embreex_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("equaltime.crosscheck")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "embreex", None)
    with pytest.raises(ImportError, match=r"pip install '\.\[crosscheck\]'"):
        importlib.import_module("equaltime.crosscheck")


def test_the_camera_looks_along_z_with_x_to_the_left_and_row_0_on_top() -> None:
    film = HdrFilm(width=4, height=2)
    directions, near, far = Camera(Perspective(fov=90.0, film=film)).rays(
        np.array([[2.0, 1.0], [0.0, 0.0], [4.0, 2.0]])
    )
    np.testing.assert_allclose(directions[0], (0.0, 0.0, 1.0), atol=1e-15)
    np.testing.assert_allclose(directions[1] / directions[1, 2], (1.0, 0.5, 1.0), atol=1e-15)
    np.testing.assert_allclose(directions[2] / directions[2, 2], (-1.0, -0.5, 1.0), atol=1e-15)
    assert not near.any()
    assert np.isinf(far).all()


def test_clip_planes_lie_across_the_axis() -> None:
    directions, near, far = Camera(Perspective(fov=90.0, near_clip=2.0, far_clip=5.0)).rays(np.zeros((1, 2)))
    assert directions[0, 2] * near[0] == pytest.approx(2.0, rel=1e-15)
    assert directions[0, 2] * far[0] == pytest.approx(5.0, rel=1e-15)


@pytest.mark.parametrize(
    ("rfilter", "cumulative"),
    [
        (Box(), lambda x: np.clip(x + 0.5, 0.0, 1.0)),
        (Tent(radius=1.5), lambda x: np.where(x < 0, 0.5 * (1 + x / 1.5) ** 2, 1 - 0.5 * (1 - x / 1.5) ** 2)),
        (Gaussian(stddev=0.7), lambda x: _lowered_gaussian(x / 0.7)),
    ],
)
def test_offsets_are_distributed_like_the_pixel_filter(rfilter: Box | Tent | Gaussian, cumulative: object) -> None:
    offsets = filter_offsets(rfilter, 200_000, rng())
    for coordinate in offsets.T:
        assert stats.kstest(coordinate, cumulative).pvalue > LEVEL
        assert stats.kstest(1.03 * coordinate, cumulative).pvalue < LEVEL  # the twin: 3 % wider
    assert abs(np.corrcoef(*offsets.T).item(1)) < 4.0 / math.sqrt(len(offsets))


def _lowered_gaussian(x: Array) -> Array:
    floor = math.exp(-8.0)
    whole = math.sqrt(2.0 * math.pi) * (stats.norm.cdf(4.0) - stats.norm.cdf(-4.0)) - 8.0 * floor
    part = math.sqrt(2.0 * math.pi) * (stats.norm.cdf(x) - stats.norm.cdf(-4.0)) - floor * (x + 4.0)
    return np.asarray(part / whole)


def hemisphere_grid() -> tuple[Array, float]:
    """Directions that each stand for the same solid angle, and that angle: a midpoint rule in height and azimuth."""
    n = 800
    z, phi = np.meshgrid((np.arange(n) + 0.5) / n, 2.0 * math.pi * (np.arange(n) + 0.5) / n)
    r = np.sqrt(1.0 - z**2)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).reshape(-1, 3), 2.0 * math.pi / n**2


@pytest.mark.parametrize("degrees", [0.0, 40.0, 80.0])
@pytest.mark.parametrize("bsdf", [Diffuse(reflectance=(0.2, 0.5, 0.8)), *ROUGH])
def test_sampling_a_bsdf_and_integrating_its_values_agree(bsdf: Bsdf, degrees: float) -> None:
    n, angle = 100_000, math.radians(degrees)
    wo = np.array([math.sin(angle) * 0.6, math.sin(angle) * 0.8, math.cos(angle)])
    scattered = bsdfs.sample(bsdf, np.tile(wo, (n, 1)), np.ones(n, np.bool_), rng(1))
    drawn = scattered.weight[:, 1] * np.exp(scattered.wi[:, 0])  # a test function that is not even
    wi, solid_angle = hemisphere_grid()
    value, pdf = bsdfs.evaluate(bsdf, np.broadcast_to(wo, wi.shape), wi)
    integral = float((value[:, 1] * np.exp(wi[:, 0])).sum()) * solid_angle
    assert p_value(drawn, integral) > LEVEL
    assert p_value(drawn, 1.03 * integral) < LEVEL
    above = (scattered.pdf > 0.0).astype(np.float64)  # the others were drawn below the surface
    assert above.all() or p_value(above, float(pdf.sum()) * solid_angle) > LEVEL


@pytest.mark.parametrize("bsdf", ROUGH)
def test_microfacets_cover_the_surface_exactly_and_masking_leaves_what_is_seen(bsdf: RoughConductor) -> None:
    """Integrals of D cos, and of G1 D max(0, m.v): 1 and cos(v); for Beckmann G1 is a fit, good to 0.35 %."""
    m, v = sphere(400_000), np.array([0.48, 0.64, 0.6])
    m[:, 2] = np.abs(m[:, 2])
    d = 2.0 * math.pi * bsdfs.microfacets(bsdf, m)
    assert p_value(d * m[:, 2], 1.0) > LEVEL
    seen = d * np.maximum(m @ v, 0.0) * bsdfs.smith(bsdf, v[None])[0]
    slack = 0.0035 if bsdf.distribution == "beckmann" else 0.0
    assert abs(seen.mean() - v[2]) < slack * v[2] + 4.0 * seen.std() / math.sqrt(seen.size)


def test_rough_metals_obey_reciprocity() -> None:
    wo, wi = sphere(1000, 1), sphere(1000, 2)
    wo[:, 2], wi[:, 2] = np.abs(wo[:, 2]), np.abs(wi[:, 2])
    for bsdf in ROUGH:
        there, back = bsdfs.evaluate(bsdf, wo, wi)[0], bsdfs.evaluate(bsdf, wi, wo)[0]
        np.testing.assert_allclose(there / wi[:, 2:], back / wo[:, 2:], rtol=1e-10, atol=1e-300)


def test_fresnel_reflectances_have_their_known_values() -> None:
    metal = Conductor(eta=(0.2, 1.5, 3.0), k=(3.0, 0.0, 4.0))
    straight = ((np.array(metal.eta) - 1) ** 2 + np.array(metal.k) ** 2) / (
        (np.array(metal.eta) + 1) ** 2 + np.array(metal.k) ** 2
    )
    np.testing.assert_allclose(bsdfs.fresnel_conductor(np.ones(1), metal)[0], straight, rtol=1e-14)
    np.testing.assert_allclose(bsdfs.fresnel_conductor(np.zeros(1), metal)[0], 1.0, rtol=1e-14)
    np.testing.assert_allclose(bsdfs.fresnel_conductor(np.linspace(0, 1, 9), Conductor()), 1.0, rtol=1e-14)
    cosines = np.linspace(0.0, 1.0, 11)
    glass, _ = bsdfs.fresnel_dielectric(cosines, np.full(11, 1.5))
    np.testing.assert_allclose(glass, bsdfs.fresnel_conductor(cosines, metal)[:, 1], rtol=1e-12)  # without extinction
    beyond, cosine = bsdfs.fresnel_dielectric(np.array([0.5]), np.array([1 / 1.5]))
    assert (beyond[0], cosine[0]) == (1.0, 0.0)


def test_an_environment_image_has_its_texels_at_their_centres() -> None:
    pixels = rng().random((5, 8, 3))
    environment = ImageEnvironment(pixels, np.eye(4))
    row, column = np.mgrid[0:5, 0:8].reshape(2, -1)
    theta, phi = math.pi * row / 4, 2 * math.pi * (column + 0.5) / 8
    directions = np.stack([np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], axis=1)
    inner = (row > 0) & (row < 4)  # at the poles all columns meet
    np.testing.assert_allclose(environment.radiance(directions)[inner], pixels[row, column][inner], atol=1e-9)


@pytest.mark.parametrize("kind", ["constant", "image"])
def test_sampling_an_environment_and_integrating_it_agree(kind: str) -> None:
    turned = np.array([[0.8, -0.6, 0, 0], [0.48, 0.64, -0.6, 0], [0.36, 0.48, 0.8, 0], [0, 0, 0, 1]])
    image = ImageEnvironment(rng(7).random((6, 9, 3)) ** 4, turned)
    environment = image if kind == "image" else ConstantEnvironment(np.array([1.0, 2.0, 3.0]))
    n, anywhere = 200_000, sphere(200_000)
    drawn = environment.sample(n, rng())
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, rtol=1e-12)

    def estimates(directions: Array, pdf: Array) -> Array:
        return environment.radiance(directions)[:, 1] * np.exp(directions[:, 0]) / pdf

    ours, plain = estimates(drawn, environment.pdf(drawn)), estimates(anywhere, np.full(n, 0.25 / math.pi))
    error = math.hypot(ours.std(), plain.std()) / math.sqrt(n)
    for factor, agrees in ((1.0, True), (1.02, False)):
        assert bool(2.0 * stats.norm.sf(abs(factor * ours.mean() - plain.mean()) / error) > LEVEL) is agrees
    assert kind == "constant" or p_value(4.0 * math.pi * environment.pdf(anywhere), 1.0) > LEVEL


def test_triangles_are_found_where_float64_finds_them(tmp_path: Path) -> None:
    corners = rng(2).standard_normal((60, 3, 3)) + 1000.0  # far from the origin, where float32 has 16 bits less
    vertices = "\n".join(" ".join(map(repr, v)) for v in corners.reshape(-1, 3).tolist())
    faces = "\n".join(f"3 {3 * i} {3 * i + 1} {3 * i + 2}" for i in range(60))
    (tmp_path / "soup.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 180\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face 60\nproperty list uchar int vertex_indices\nend_header\n{vertices}\n{faces}\n"
    )
    loaded = scene({"type": "ply", "filename": str(tmp_path / "soup.ply")})
    origins, directions = np.full((2000, 3), 1000.0) + 3.0 * sphere(2000, 5), sphere(2000, 6)
    t, patch = World(loaded.model, loaded.assets).intersect(origins, directions, np.full(2000, -1))
    exact, which, margin = _by_cramer(corners, origins, directions)
    clear = margin > 1e-5  # not within float32's rounding of an edge
    assert clear.sum() > 1900
    np.testing.assert_array_equal(patch[clear], which[clear])
    np.testing.assert_allclose(t[clear], exact[clear], rtol=1e-10)


def _by_cramer(corners: Array, origins: Array, directions: Array) -> tuple[Array, Array, Array]:
    """Nearest triangle of each ray by solving for weights and distance; how far the ray is from all edges."""
    best, which = np.full(len(origins), np.inf), np.full(len(origins), -1)
    margin = np.full(len(origins), np.inf)
    for number, (a, b, c) in enumerate(corners):
        columns = np.stack(np.broadcast_arrays(b - a, c - a, -directions), axis=2)
        u, v, t = np.linalg.solve(columns, (origins - a)[..., None])[..., 0].T
        inside = np.minimum(np.minimum(u, v), 1.0 - u - v)
        margin = np.where(t > 0.0, np.minimum(margin, np.abs(inside)), margin)
        nearer = (inside > 0.0) & (t > 0.0) & (t < best)
        best[nearer], which[nearer] = t[nearer], number
    return best, which, margin


@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e5])
def test_a_ray_that_leaves_a_sphere_meets_its_far_side_only(radius: float) -> None:
    loaded = scene({"type": "sphere", "center": [1.0, 2.0, 3.0], "radius": radius})
    world = World(loaded.model, loaded.assets)
    normals, directions = sphere(1000, 1), sphere(1000, 2)
    cosine = (normals * directions).sum(axis=1)
    origins = np.array([1.0, 2.0, 3.0]) + radius * normals
    t, _ = world.intersect(origins, directions, np.zeros(1000, np.int64))
    assert np.isinf(t[cosine > 0.0]).all()
    np.testing.assert_allclose(t[cosine < 0.0], -2.0 * radius * cosine[cosine < 0.0], rtol=1e-9)
