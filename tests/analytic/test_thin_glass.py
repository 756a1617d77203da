"""Light through thin glass, where crossings are no vertices: of lights without extent, which are aimed at through it,
and of those that rays meet, which must not count twice.

A pane lets 1 - 2 R / (1 + R) pass, R that of one of its sides: Fresnel's formula, with all reflections between the two.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from equaltime import _core

from ..statistical.worlds import Add, affine, build, estimate, looking, turned

Array = NDArray[np.float64]
TECHNIQUES = ("uniform", "bsdf", "light", "mis", "mixture")
COLOR = np.array([0.9, 0.8, 0.7])
REFLECTANCE, HEIGHT = 0.5, 2.0
LEVEL = 1e-4
"""Of the tests of light that rays meet, with fixed seeds."""


def side(degrees: float, ior: float = 1.5) -> float:
    """What one side of a pane reflects (Fresnel)."""
    c = np.cos(np.radians(degrees))
    t = np.sqrt(1.0 - (1.0 - c**2) / ior**2)
    s, p = (c - ior * t) / (c + ior * t), (ior * c - t) / (ior * c + t)
    return float((s**2 + p**2) / 2)


def through(degrees: float) -> float:
    return 1.0 - 2.0 * side(degrees) / (1.0 + side(degrees))


def add_floor(b: _core.SceneBuilder) -> None:
    grey = b.add_bsdf("diffuse", [REFLECTANCE] * 3)
    b.add_rectangle(np.diag([3.0, 3.0, 1.0, 1.0]), flip_normals=False, front=grey, back=None, radiance=None)


def freely(b: _core.SceneBuilder) -> None:
    b.cross_freely()


def pure(b: _core.SceneBuilder) -> int:
    return b.add_bsdf("thindielectric", 1.5, [1.0] * 3, COLOR.tolist())


def pane(height: float, tilt: float = 0.0, bsdf: Callable[[_core.SceneBuilder], int] = pure) -> Add:
    def add(b: _core.SceneBuilder) -> None:
        turn, index = turned([1, 2, 0], tilt), bsdf(b)
        b.add_rectangle(
            affine(*(0.7 * turn.T), [0, 0, height]), flip_normals=False, front=index, back=index, radiance=None
        )

    return add


def mixed(share: float, other: Callable[[_core.SceneBuilder], int]) -> Callable[[_core.SceneBuilder], int]:
    """So much of another BSDF, the rest of it glass."""
    return lambda b: b.add_mixture(pure(b), other(b), share)


def checked(b: _core.SceneBuilder) -> int:
    """Glass whose colour is a texture's, of which it shows one square."""
    index = b.add_bsdf("thindielectric", 1.5, [1.0] * 3, [1.0] * 3)
    texture = b.add_checkerboard(COLOR.tolist(), [0.2] * 3, to_uv=[[0.5, 0, 0], [0, 0.5, 0]])
    b.bind(index, "specular_transmittance", texture)
    return index


LIGHTS: dict[str, Add] = {
    "point": lambda b: b.add_point_light([0, 0, HEIGHT], [np.pi * HEIGHT**2] * 3),
    "spot": lambda b: b.add_spot_light([0, 0, HEIGHT], [0, 0, -1], [np.pi * HEIGHT**2] * 3, 40, 30),
    "directional": lambda b: b.add_directional_light([0, 0, -1], [np.pi] * 3),
}
"""Each with an irradiance of π right below it."""


VIEW = looking([0, 1.2, 0.4], [0, 0, 0])


def seen(*add: Add, technique: str = "mis", depth: int = 2) -> Array:
    """Return what the floor below the light sends back; the camera looks at it past all panes."""
    scene = build(add_floor, *add, camera=VIEW, fov=1e-4)
    return estimate(scene, 64, technique=technique, max_depth=depth).mean


def is_seen(got: ArrayLike, exact: ArrayLike) -> bool:
    return bool(np.allclose(got, exact, rtol=1e-5, atol=0.0))


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("light", LIGHTS)
def test_lights_without_extent_shine_through_one_pane_and_two(light: str, technique: str) -> None:
    for tilts in ((0.0,), (30.0,), (60.0,), (0.0, 45.0)):
        panes = [pane(0.8 + 0.6 * i, tilt) for i, tilt in enumerate(tilts)]
        got = seen(LIGHTS[light], freely, *panes, technique=technique)
        assert is_seen(got, REFLECTANCE * np.prod([COLOR * through(tilt) for tilt in tilts], axis=0))
        once = REFLECTANCE * np.prod([COLOR * (1.0 - side(tilt)) ** 2 for tilt in tilts], axis=0)
        assert not is_seen(got, once), "the twin: a pane without the reflections between its sides"


def test_panes_add_nothing_to_the_length_of_a_path() -> None:
    panes = [pane(0.5 + 0.1 * i) for i in range(12)]
    assert is_seen(seen(LIGHTS["point"], freely, *panes), REFLECTANCE * (COLOR * through(0.0)) ** 12)
    assert (seen(LIGHTS["point"], freely, *panes, depth=1) == 0.0).all()


@pytest.mark.parametrize("light", LIGHTS)
def test_they_do_not_where_going_through_glass_is_a_bounce(light: str) -> None:
    assert (seen(LIGHTS[light], pane(1.0), depth=3) == 0.0).all()


WAYS: dict[str, tuple[Callable[[_core.SceneBuilder], int], Array]] = {
    "a hole in the glass": (mixed(0.25, lambda b: b.add_null()), 0.75 * through(0.0) * COLOR + 0.25),
    "a grain on the glass": (mixed(0.25, lambda b: b.add_bsdf("diffuse", [0.8] * 3)), 0.75 * through(0.0) * COLOR),
    "glass of a texture": (checked, through(0.0) * COLOR),
}


@pytest.mark.parametrize("name", WAYS)
def test_glass_passes_as_much_as_there_is_of_it(name: str) -> None:
    bsdf, share = WAYS[name]
    got = seen(LIGHTS["point"], freely, pane(1.0, bsdf=bsdf))
    assert is_seen(got, REFLECTANCE * share)
    assert not is_seen(got, 1.001 * REFLECTANCE * share), "the twin"


def test_bent_glass_passes_by_the_angle_to_its_bent_normal() -> None:
    """As the rays that go through it: a normal map of one colour turns all of it by as much."""

    def bent(b: _core.SceneBuilder) -> int:
        index, lean = pure(b), np.array([0.6, 0.0, 0.8])
        picture = np.broadcast_to((lean + 1) / 2, (1, 1, 3)).astype(np.float32)
        b.bend(index, b.add_bitmap(picture, srgb=False), bump=False, shadowing=False)
        return index

    exact = REFLECTANCE * COLOR * through(np.degrees(np.arccos(0.8)))
    assert is_seen(seen(LIGHTS["point"], freely, pane(1.0, bsdf=bent)), exact)
    assert not is_seen(seen(LIGHTS["point"], freely, pane(1.0)), exact), "the twin"


def add_disk(b: _core.SceneBuilder) -> None:
    """A lamp as wide as it is high above the floor."""
    place = affine([HEIGHT, 0, 0], [0, -HEIGHT, 0], [0, 0, -1], [0, 0, HEIGHT])
    b.add_disk(place, flip_normals=False, front=None, back=None, radiance=[1.0] * 3)


def add_sky(b: _core.SceneBuilder) -> None:
    b.add_constant_environment([1.0] * 3)


@pytest.mark.parametrize(("add", "cone"), [(add_disk, 45.0), (add_sky, 90.0)])
@pytest.mark.parametrize("technique", TECHNIQUES)
def test_lights_that_rays_meet_count_once_behind_glass(add: Add, cone: float, technique: str) -> None:
    """Irradiance is the integral of what passes over the cone of the light; the pane is as good as infinite."""

    def wide(b: _core.SceneBuilder) -> None:
        place, index = np.diag([1e4, 1e4, 1.0, 1.0]), pure(b)
        place[2, 3] = 1.0
        b.add_rectangle(place, flip_normals=False, front=index, back=index, radiance=None)

    x, weights = np.polynomial.legendre.leggauss(200)
    angles = np.radians(cone) * (x + 1) / 2
    passes = np.array([through(float(t)) for t in np.degrees(angles)])
    share = np.radians(cone) / 2 * (weights * passes * np.sin(2 * angles)).sum()
    scene = build(add_floor, wide, add, freely, camera=VIEW, fov=0.01)
    found = estimate(scene, 1 << 16, technique=technique, max_depth=2)
    assert found.p(REFLECTANCE * COLOR * share) > LEVEL
    assert found.p(1.05 * REFLECTANCE * COLOR * share) < LEVEL, "the twin"
