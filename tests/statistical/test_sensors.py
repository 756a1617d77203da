"""Camera rays: where they go by their formulas, and how evenly they leave a lens.

Seeds are fixed. The χ² tests have a false-alarm rate of 0.1 % together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from .chi2 import LEVEL, SAMPLES, chi_square, share, uniforms
from .worlds import affine, looking

Array = NDArray[np.float64]
VIEW = looking((3, -2, 1), (0.5, 0, 0.25))
ORIGIN, X, Y, Z = VIEW[:3, 3], VIEW[:3, 0], VIEW[:3, 1], VIEW[:3, 2]
WIDTH, HEIGHT = 40, 30
LENS = {"aperture_radius": 0.3, "focus_distance": 2.5}


def scene(*, ortho: Array | None = None, clips: tuple[float | None, float | None] = (None, None), **lens: Any) -> Any:
    """A camera that sees a ball of radius 0.5 round the origin."""
    builder = _core.SceneBuilder()
    builder.add_sphere([0, 0, 0], 0.5, flip_normals=False, front=None, back=None, radiance=None)
    if ortho is None:
        builder.set_perspective(VIEW, 40.0, *clips, **lens)
    else:
        builder.set_orthographic(ortho, *clips)
    builder.set_film(WIDTH, HEIGHT, (0, 0, WIDTH, HEIGHT), "box", 0.5)
    return builder.build()


def rays(subject: Any, places: Array, lens: Array | None = None) -> tuple[Array, Array, Array]:
    found = parts.camera_rays(subject, places, np.full_like(places, 0.5) if lens is None else lens)
    return found["origin"], found["direction"], found["length"]


def film_places(count: int, seed: int = 1) -> Array:
    return np.random.default_rng(seed).random((count, 2)) * (WIDTH, HEIGHT)


def film_plane(places: Array) -> Array:
    """Points (N, 3) one unit before the pinhole, on the rays through places on the film."""
    half = np.tan(np.radians(20.0))
    x, y = half * (1 - 2 * places[:, 0] / WIDTH), half * (HEIGHT - 2 * places[:, 1]) / WIDTH
    return np.asarray(np.outer(x, X) + np.outer(y, Y) + Z)


def apart(points: Array, origins: Array, directions: Array) -> Array:
    """Distances (N,) of points from rays."""
    return np.asarray(np.linalg.norm(np.cross(points - origins, directions), axis=1))


def test_a_lens_without_width_is_a_pinhole_to_the_bit() -> None:
    places, u = film_places(1000), film_places(1000, 2) / (WIDTH, HEIGHT)
    for a, b in zip(rays(scene(), places), rays(scene(**(LENS | {"aperture_radius": 0.0})), places, u), strict=True):
        assert (a == b).all()


def test_all_rays_of_one_place_meet_where_the_lens_is_focused() -> None:
    places, u = film_places(1000), film_places(1000, 2) / (WIDTH, HEIGHT)
    origin, direction, _ = rays(scene(**LENS), places, u)
    focus = ORIGIN + 2.5 * film_plane(places)
    assert apart(focus, origin, direction).max() < 1e-5
    assert apart(ORIGIN + 2.6 * film_plane(places), origin, direction).max() > 1e-3, "the twin"
    assert np.abs(np.linalg.norm(direction, axis=1) - 1).max() < 1e-6


def lens_points(subject: Any, places: Array, u: Array) -> Array:
    """Where the rays leave the lens (N, 2), in radii."""
    origin, direction, _ = rays(subject, places, u)
    back = ((ORIGIN - origin) @ Z) / (direction @ Z)
    at = origin + back[:, None] * direction - ORIGIN
    return np.stack([at @ X, at @ Y], axis=1) / LENS["aperture_radius"]


@pytest.mark.parametrize("place", [(20.0, 15.0), (1.0, 29.0)])
def test_rays_leave_the_whole_lens_evenly(place: tuple[float, float]) -> None:
    points = lens_points(scene(**LENS), np.tile(place, (SAMPLES, 1)), uniforms(SAMPLES, 2, 7))
    radius, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    assert radius.max() < 1 + 1e-5

    def p(area: Array) -> float:
        cells = np.clip((area * 8).astype(int), 0, 7) * 12 + np.clip(((angle / np.pi + 1) * 6).astype(int), 0, 11)
        return chi_square(np.bincount(cells, minlength=96).astype(float), np.full(96, SAMPLES / 96))

    assert p(radius**2) > share(LEVEL, 2)
    assert p(radius**2.02) < share(LEVEL, 2), "the twin"


def test_orthographic_rays_are_parallel_and_a_pixel_apart() -> None:
    placed = affine(0.8 * X, 0.8 * Y, 0.8 * Z, ORIGIN)
    places = film_places(1000)
    origin, direction, length = rays(scene(ortho=placed), places)
    assert np.abs(direction - Z).max() < 1e-7
    assert np.isinf(length).all()
    x, y = 0.8 * (1 - 2 * places[:, 0] / WIDTH), 0.8 * (HEIGHT - 2 * places[:, 1]) / WIDTH
    exact = ORIGIN + np.outer(x, X) + np.outer(y, Y)
    assert apart(exact, origin, direction).max() < 1e-6
    assert apart(exact + 1e-4 * X, origin, direction).max() > 5e-5, "the twin"
    assert ((origin - exact) @ Z).min() >= 0, "what is behind the camera is not seen"


@pytest.mark.parametrize("kind", ["pinhole", "lens", "parallel"])
def test_clips_are_planes_across_the_axis(kind: str) -> None:
    cameras: dict[str, dict[str, Any]] = {"pinhole": {}, "lens": LENS, "parallel": {"ortho": VIEW}}
    u = film_places(500, 2) / (WIDTH, HEIGHT)
    origin, direction, length = rays(scene(clips=(3.2, 4.5), **cameras[kind]), film_places(500), u)
    assert (origin - ORIGIN) @ Z == pytest.approx(np.full(500, 3.2), abs=1e-5)
    assert (origin + length[:, None] * direction - ORIGIN) @ Z == pytest.approx(np.full(500, 4.5), abs=1e-5)


@pytest.mark.parametrize("kind", ["pinhole", "lens", "parallel"])
def test_rays_begin_before_the_geometry_and_hardly_farther_from_it_than_they_must(kind: str) -> None:
    """So that a distant camera loses no digits."""
    cameras: dict[str, dict[str, Any]] = {"pinhole": {}, "lens": LENS, "parallel": {"ortho": VIEW}}
    u = film_places(500, 2) / (WIDTH, HEIGHT)
    origin, direction, _ = rays(scene(**cameras[kind]), film_places(500), u)
    along = -((origin * direction).sum(axis=1))
    outside = np.abs(origin).max(axis=1) > 0.5 - 1e-6
    assert outside.all()
    assert (np.linalg.norm(origin - ORIGIN, axis=1) > 2.0).all()
    assert (along > -2.0).all()


@pytest.mark.parametrize(
    ("lens", "message"),
    [
        ({"aperture_radius": -1.0}, "a lens needs a finite radius"),
        ({"aperture_radius": float("nan")}, "a lens needs a finite radius"),
        ({"aperture_radius": 1.0, "focus_distance": 0.0}, "positive focus distance"),
    ],
)
def test_a_lens_that_is_none_is_refused(lens: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        scene(**lens)
