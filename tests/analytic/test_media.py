"""Media where their light is known in closed form, by every technique.

A statement that holds is rejected with a probability of 1e-4 a test, with fixed seeds; the twins at the end show what
such a test sees.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from equaltime import _core

from ..statistical.worlds import Add, Estimate, build, estimate, octahedron

Array = NDArray[np.float64]
LEVEL = 1e-4
TECHNIQUES = ("uniform", "bsdf", "light", "mis", "mixture")
SKY = np.array([0.5, 1.0, 2.0])
SIGMA = np.array([1.0, 2.0, 0.25])
Shape = Callable[[_core.SceneBuilder, int], int]


def ball(radius: float = 0.75, center: ArrayLike = (0.1, 0.2, 3.0)) -> Shape:
    return lambda b, bsdf: b.add_sphere(
        np.asarray(center).tolist(), radius, flip_normals=False, front=bsdf, back=bsdf, radiance=None
    )


def crystal(b: _core.SceneBuilder, bsdf: int) -> int:
    vertices, faces = octahedron(1, 0.75, (0.1, 0.2, 3.0))
    return b.add_mesh(vertices, faces, front=bsdf, back=bsdf, radiance=None)


def slab(thickness: float) -> Shape:
    def add(b: _core.SceneBuilder, bsdf: int) -> int:
        x, y, z = 50.0, 50.0, thickness
        corners = [(sx * x, sy * y, 1.0 + sz * z) for sz in (0, 1) for sy in (-1, 1) for sx in (-1, 1)]
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        faces = [t for a, b_, c, d in quads for t in ((a, b_, c), (a, c, d))]
        return b.add_mesh(np.array(corners), np.array(faces), front=bsdf, back=bsdf, radiance=None)

    return add


def fog(b: _core.SceneBuilder, sigma_t: ArrayLike, albedo: ArrayLike, g: float) -> int:
    return b.add_medium(
        np.broadcast_to(sigma_t, 3).tolist(), np.broadcast_to(albedo, 3).tolist(), [(1.0, "hg", {"g": g})]
    )


def filled(shape: Shape, sigma_t: ArrayLike, albedo: ArrayLike, g: float = 0.0, free: bool = True) -> Add:
    """A medium in a shape whose surface is nothing, with vacuum around."""

    def add(b: _core.SceneBuilder) -> None:
        index = shape(b, b.add_null())
        b.set_media(index, exterior=None, interior=fog(b, sigma_t, albedo, g))
        if free:
            b.cross_freely()

    return add


def sky(b: _core.SceneBuilder) -> None:
    b.add_constant_environment(SKY)


def haze(sigma_t: ArrayLike, albedo: ArrayLike = 0.0, g: float = 0.0) -> Add:
    """A medium that is everywhere."""

    def add(b: _core.SceneBuilder) -> None:
        b.set_camera_medium(fog(b, sigma_t, albedo, g))

    return add


def wall(distance: float, radiance: ArrayLike | None = None, reflectance: float = 0.0) -> Add:
    """A square that looks at the camera."""
    place = np.diag([50.0, -50.0, -1.0, 1.0])
    place[2, 3] = distance
    return lambda b: b.add_rectangle(
        place,
        flip_normals=False,
        front=b.add_bsdf("diffuse", [reflectance] * 3) if reflectance else None,
        back=None,
        radiance=None if radiance is None else np.asarray(radiance).tolist(),
    )


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("g", [0.0, 0.6])
@pytest.mark.parametrize("shape", [ball(), crystal], ids=["ball", "crystal"])
def test_what_takes_no_light_is_not_seen_where_light_comes_from_all_around(
    technique: str, g: float, shape: Shape
) -> None:
    if technique == "uniform" and g != 0.0:
        pytest.skip("directions that know nothing of a lobe have no finite variance where nothing is absorbed")
    found = estimate(build(filled(shape, SIGMA, 1.0, g), sky, fov=20.0), 4096, technique=technique)
    assert found.p(SKY) > LEVEL, found
    assert (found.error < 0.1 * SKY).all()


@pytest.mark.parametrize("technique", ["bsdf", "light", "mis"])
def test_a_lamp_is_weakened_by_what_is_before_it(technique: str) -> None:
    lit = estimate(build(haze(SIGMA), wall(1.5, SKY), fov=0.01), 16, technique=technique)
    np.testing.assert_allclose(lit.mean, SKY * np.exp(-1.5 * SIGMA), rtol=1e-5)
    seen_through = estimate(build(filled(slab(0.5), SIGMA, 0.0), wall(3.0, SKY), fov=0.01), 16, technique=technique)
    np.testing.assert_allclose(seen_through.mean, SKY * np.exp(-0.5 * SIGMA), rtol=1e-5)


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_light_is_weakened_on_its_way_to_a_wall_and_back(technique: str) -> None:
    def point(b: _core.SceneBuilder) -> None:
        b.add_point_light((0.0, 0.0, 0.5), SKY.tolist())

    found = estimate(build(haze(SIGMA), wall(2.0, reflectance=0.5), point, fov=0.01), 64, technique=technique)
    exact = 0.5 / np.pi * SKY / 1.5**2 * np.exp(-(1.5 + 2.0) * SIGMA)
    np.testing.assert_allclose(found.mean, exact, rtol=1e-4)


def scattered_once(sigma_t: Array, albedo: Array, g: float, thickness: float) -> Array:
    """Return what a slab sends straight back of light that falls straight on it with irradiance SKY, scattered once."""
    backwards = (1 - g) / (4 * np.pi * (1 + g) ** 2)
    bright: Array = SKY * albedo * backwards * -np.expm1(-2 * sigma_t * thickness) / 2
    return bright


def slab_in_the_sun(sigma_t: Array, albedo: Array, g: float, thickness: float) -> _core.Scene:
    return build(
        filled(slab(thickness), sigma_t, albedo, g),
        lambda b: b.add_directional_light((0.0, 0.0, 1.0), SKY.tolist()),
        fov=0.01,
    )


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("g", [0.0, 0.5, -0.5])
def test_a_slab_in_the_sun_sends_back_what_it_scatters_once(technique: str, g: float) -> None:
    albedo = np.array([0.9, 0.5, 0.2])
    scene = slab_in_the_sun(SIGMA, albedo, g, 0.7)
    found = estimate(scene, 8192, technique=technique, max_depth=2)
    assert found.p(scattered_once(SIGMA, albedo, g, 0.7)) > LEVEL, found


@pytest.mark.parametrize("depth", [1, 2, 3])
@pytest.mark.parametrize("technique", ["bsdf", "mis"])
def test_surfaces_of_nothing_are_no_vertices_where_that_is_asked_for(technique: str, depth: int) -> None:
    vacuum = [filled(ball(radius, (0.0, 0.0, 0.0)), 0.0, 0.0) for radius in (100.0, 200.0)]
    clear = build(*vacuum, wall(3.0, reflectance=1.0), sky)
    found = estimate(clear, 64, technique=technique, max_depth=depth)
    np.testing.assert_allclose(found.mean, SKY if depth > 1 else 0.0, rtol=0.2)


def test_the_surface_that_is_left_says_what_the_medium_is() -> None:
    """A ball within a ball, which names no exterior: behind it is vacuum, as in Mitsuba, until the next surface."""

    def nested(exterior: bool) -> Add:
        def add(b: _core.SceneBuilder) -> None:
            nothing, thin, thick = b.add_null(), b.add_medium(0.5 * SIGMA, [0.0] * 3), b.add_medium(SIGMA, [0.0] * 3)
            for radius, inside, outside in ((1.0, thin, None), (0.25, thick, thin if exterior else None)):
                index = ball(radius, (0.0, 0.0, 3.0))(b, nothing)
                b.set_media(index, exterior=outside, interior=inside)
            b.cross_freely()

        return add

    named, unnamed = (estimate(build(nested(e), sky, fov=1e-3), 16).mean for e in (True, False))
    np.testing.assert_allclose(named, SKY * np.exp(-SIGMA * (0.5 + 0.5 * 1.5)), rtol=1e-5)
    np.testing.assert_allclose(unnamed, SKY * np.exp(-SIGMA * (0.5 + 0.5 * 0.75)), rtol=1e-5)


def test_a_medium_in_an_instance_has_the_density_of_the_world() -> None:
    def add(b: _core.SceneBuilder) -> None:
        index = ball(1.0, (0.0, 0.0, 0.0))(b, b.add_null())
        b.set_media(index, exterior=None, interior=b.add_medium(SIGMA.tolist(), [0.0] * 3))
        group, place = b.add_group(index), np.diag([0.5, 0.5, 0.25, 1.0])
        place[2, 3] = 4.0
        b.add_instance(group, place)
        b.cross_freely()

    found = estimate(build(add, sky, fov=1e-3), 16)
    np.testing.assert_allclose(found.mean, SKY * np.exp(-0.5 * SIGMA), rtol=1e-5)


def test_the_way_from_the_camera_to_the_geometry_counts() -> None:
    for eye in (0.0, -1000.0):
        scene = build(haze(SIGMA / 1000.0), wall(3.0, SKY), eye=(0.0, 0.0, eye), fov=1e-3)
        found = estimate(scene, 16)
        np.testing.assert_allclose(found.mean, SKY * np.exp(-SIGMA / 1000.0 * (3.0 - eye)), rtol=1e-5)


def test_no_sky_is_seen_through_a_haze_without_end() -> None:
    assert (estimate(build(haze(SIGMA, 0.9), sky), 64).mean == 0.0).all()
    red = estimate(build(haze([0.0, 1.0, 1.0], 0.9), sky), 4096)
    assert (red.mean[1:] == 0.0).all()
    assert abs(red.mean[0] - SKY[0]) < 4.0 * red.error[0]


WRONG: dict[str, Callable[[], tuple[Estimate, Any]]] = {
    "a slab that scatters four percent too much": lambda: (
        estimate(slab_in_the_sun(SIGMA, np.full(3, 0.52), 0.3, 0.7), 32768, technique="mis", max_depth=2),
        scattered_once(SIGMA, np.full(3, 0.5), 0.3, 0.7),
    ),
    "a white ball that takes one percent": lambda: (
        estimate(build(filled(ball(), SIGMA, 0.99), sky, fov=20.0), 32768, technique="bsdf"),
        SKY,
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_a_little_wrong_is_found(name: str) -> None:
    found, expected = WRONG[name]()
    assert found.p(expected) < LEVEL


@pytest.mark.parametrize(
    ("add", "message"),
    [
        (lambda b: b.add_medium([-1.0, 0.0, 0.0], [0.5] * 3), "medium 0: extinction is finite and not negative"),
        (lambda b: b.add_medium([1.0] * 3, [1.5] * 3), r"medium 0: an albedo lies in \[0, 1\]"),
        (lambda b: b.set_camera_medium(3), "no medium 3"),
        (lambda b: b.set_media(0, exterior=None, interior=None), "a surface is that of a shape that was added"),
        (lambda b: b.set_media(ball()(b, b.add_null()), exterior=2, interior=None), "no medium 2"),
    ],
)
def test_a_bad_medium_is_refused(add: Add, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        build(add)
