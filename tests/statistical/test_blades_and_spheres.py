"""Lenses whose blades leave a polygon, and cameras that see all directions.

Seeds are fixed. The χ² tests have a false-alarm rate of 0.1 % together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.errors import SceneError

from .chi2 import LEVEL, SAMPLES, chi_square, share, uniforms
from .test_sensors import HEIGHT, LENS, ORIGIN, VIEW, WIDTH, Array, X, Y, Z, film_places, lens_points, rays, scene
from .worlds import estimate

BLADES = (3, 4, 5, 6, 9)
TURN = 25.0


def polygon(blades: int) -> Any:
    return scene(**LENS, blades=blades, rotation_degrees=TURN)


def within(points: Array, blades: int) -> tuple[Array, Array]:
    """Return the squared distance from the centre, in parts of that to the side there, and the angle in turns."""
    turns = (np.arctan2(points[:, 1], points[:, 0]) - np.radians(TURN)) / (2 * np.pi) % 1
    from_middle = (turns * blades % 1 - 0.5) * 2 * np.pi / blades
    side = np.cos(np.pi / blades) / np.cos(from_middle)
    return (points**2).sum(axis=1) / side**2, np.asarray(turns)


def area(blades: int, turns: Array) -> Array:
    """Return the part of the polygon's area that is within a part of a turn from the first corner."""
    sector, rest = np.floor(turns * blades), turns * blades % 1
    half = np.pi / blades
    return np.asarray((sector + 0.5 + 0.5 * np.tan((2 * rest - 1) * half) / np.tan(half)) / blades)


@pytest.mark.parametrize("blades", BLADES)
def test_rays_leave_the_whole_polygon_evenly(blades: int) -> None:
    count = SAMPLES // 4
    points = lens_points(polygon(blades), np.tile((20.0, 15.0), (count, 1)), uniforms(count, 2, 7))
    out, turns = within(points, blades)
    assert out.max() < 1 + 1e-4

    def p(power: float) -> float:
        ring = np.clip((out**power * 8).astype(int), 0, 7)
        cells = ring * 12 + np.clip((area(blades, turns) * 12).astype(int), 0, 11)
        return chi_square(np.bincount(cells, minlength=96).astype(float), np.full(96, count / 96))

    assert p(1.0) > share(LEVEL, len(BLADES))
    assert p(1.04) < share(LEVEL, len(BLADES)), "the twin"
    round_lens = lens_points(scene(**LENS), np.tile((20.0, 15.0), (count, 1)), uniforms(count, 2, 7))
    assert (within(round_lens, blades)[0] > 1).mean() == pytest.approx(
        1 - blades / (2 * np.pi) * np.sin(2 * np.pi / blades), abs=0.005
    ), "the area in closed form"


def test_a_polygon_is_focused_as_a_disk_is_and_its_first_corner_is_where_it_is_turned_to() -> None:
    places, u = film_places(1000), film_places(1000, 2) / (WIDTH, HEIGHT)
    tangents = np.tan(np.radians(20.0)) * np.stack(
        [1 - 2 * places[:, 0] / WIDTH, (HEIGHT - 2 * places[:, 1]) / WIDTH], axis=1
    )
    focus = ORIGIN + LENS["focus_distance"] * (tangents[:, :1] * X + tangents[:, 1:] * Y + Z)
    origin, direction, _ = rays(polygon(5), places, u)
    assert np.linalg.norm(np.cross(focus - origin, direction), axis=1).max() < 1e-5
    corner = lens_points(polygon(5), np.array([[20.0, 15.0]]), np.array([[(1 - 2.0**-24) / 5, 0.0]]))
    assert corner[0] == pytest.approx([np.cos(np.radians(TURN)), np.sin(np.radians(TURN))], abs=1e-4)


def test_blades_of_a_lens_without_width_are_a_pinhole_to_the_bit() -> None:
    places, u = film_places(1000), film_places(1000, 2) / (WIDTH, HEIGHT)
    for a, b in zip(rays(scene(), places), rays(scene(blades=5), places, u), strict=True):
        assert (a == b).all()


def loaded(size: tuple[int, int] = (8, 4), **sensor: Any) -> et.Scene:
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    ball = {"type": "sphere", "center": [0.2, 0.1, 3], "radius": 1.0}
    return et.load_dict({"type": "scene", "sensor": sensor | {"film": film}, "ball": ball, "sky": {"type": "constant"}})


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        ({"type": "thinlens", "aperture_radius": 0.1, "blades": 2}, r"sensor\.blades: "),
        ({"type": "thinlens", "aperture_radius": 0.1, "rotation": 2.0}, "rotation needs blades"),
        ({"type": "perspective", "blades": 5}, "blades"),
        ({"type": "spherical", "fov": 50}, "fov"),
        ({"type": "spherical", "near_clip": 2.0, "far_clip": 1.0}, "near_clip"),
    ],
)
def test_a_camera_that_is_none_is_refused_with_its_place(sensor: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        loaded(**sensor)
    with pytest.raises(ValueError, match="no blades, or three"):
        scene(**LENS, blades=2)


def spherical(clips: tuple[float | None, float | None] = (None, None)) -> Any:
    builder = _core.SceneBuilder()
    builder.add_sphere([0, 0, 0], 0.5, flip_normals=False, front=None, back=None, radiance=None)
    builder.set_spherical(VIEW, *clips)
    builder.set_film(WIDTH, HEIGHT, (0, 0, WIDTH, HEIGHT), "box", 0.5)
    return builder.build()


def directions(places: Array) -> Array:
    phi, theta = 2 * np.pi * places[:, 0] / WIDTH, np.pi * places[:, 1] / HEIGHT
    return np.asarray(
        np.outer(np.sin(phi) * np.sin(theta), X) + np.outer(np.cos(theta), Y) - np.outer(np.cos(phi) * np.sin(theta), Z)
    )


def test_a_spherical_camera_sees_all_directions_equal_angles_apart() -> None:
    places = film_places(1000)
    origin, direction, length = rays(spherical(), places)
    assert np.abs(direction - directions(places)).max() < 1e-6
    assert np.abs(np.cross(origin - ORIGIN, direction)).max() < 2e-6
    assert np.isinf(length).all()
    middle, right, top = directions(np.array([[WIDTH / 2, HEIGHT / 2], [0.75 * WIDTH, HEIGHT / 2], [3.0, 0.0]]))
    assert np.allclose([middle, right, top], [Z, -X, Y])
    assert np.abs(direction - directions(places + np.array([0.01, 0]))).max() > 1e-3, "the twin"


def test_its_clips_are_distances() -> None:
    origin, direction, length = rays(spherical((3.2, 4.5)), film_places(500))
    assert np.linalg.norm(origin - ORIGIN, axis=1) == pytest.approx(np.full(500, 3.2), abs=1e-5)
    assert np.linalg.norm(origin + length[:, None] * direction - ORIGIN, axis=1) == pytest.approx(
        np.full(500, 4.5), abs=1e-5
    )


def test_a_picture_of_the_sky_is_the_sky() -> None:
    """Mitsuba's environment map has a row at each pole: the film's rows lie half a step within."""
    rng = np.random.default_rng(1)
    pixels = rng.uniform(0.1, 2.0, (5, 8, 3)).astype(np.float32)
    builder = _core.SceneBuilder()
    builder.add_image_environment(pixels, 1.0, np.eye(4))
    builder.set_spherical(np.eye(4))
    builder.set_film(8, 4, (0, 0, 8, 4), "box", 1e-6)
    mean = _core_mean(builder.build())
    np.testing.assert_allclose(mean, (pixels[1:] + pixels[:-1]) / 2, rtol=1e-4)


def _core_mean(built: Any) -> Array:
    renderer = _core.Renderer(built, _core.Settings(max_depth=1), 1, 1)
    assert renderer.advance(4)
    return np.asarray(renderer.moments["mean"].mean(axis=0))


def test_a_furnace_is_even_all_round_and_a_crop_has_the_bits_of_the_whole() -> None:
    def furnace(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.5] * 3)
        b.add_sphere([0, 0, 0], 2.0, flip_normals=True, front=bsdf, back=bsdf, radiance=[0.5] * 3)

    builder = _core.SceneBuilder()
    furnace(builder)
    builder.set_spherical(np.eye(4))
    builder.set_film(16, 8, (0, 0, 16, 8), "box", 0.5)
    found = estimate(builder.build(), 64)
    assert found.p(np.ones(3)) > 1e-4, found
    whole = loaded(type="spherical")
    part = whole.with_(crop=(2, 1, 5, 2))
    assert np.array_equal(et.render(part, spp=4).image, et.render(whole, spp=4).image[1:3, 2:7])


def test_a_spherical_camera_and_blades_survive_export() -> None:
    for sensor in (
        {"type": "spherical", "near_clip": 0.5, "to_world": [{"translate": [0, 0, 1]}]},
        {"type": "thinlens", "aperture_radius": 0.2, "focus_distance": 3.0, "blades": 5, "rotation": 10.0},
    ):
        first = loaded(**sensor)
        again = et.load_dict(first.to_dict())
        assert again.model.sensor == first.model.sensor
        assert np.array_equal(et.render(again, spp=2).image, et.render(first, spp=2).image)


def test_depths_of_a_spherical_camera_are_distances() -> None:
    description = loaded((32, 16), type="spherical").to_dict() | {"integrator": {"type": "depth"}}
    depth = et.render(description, spp=1).aovs["depth.T"]
    assert depth[7:9, 15:17] == pytest.approx(np.full((2, 2), np.hypot(0.2, 3.0) - 1.0), abs=0.3)
    assert (depth[:, :8] == 0).all()
