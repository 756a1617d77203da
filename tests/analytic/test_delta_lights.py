"""Spot and directional lights against their formulas: no sample of them has any noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from ..statistical.worlds import build, turned

Array = NDArray[np.float64]
TURN = turned([1, 1, -3], 80)
AXIS = TURN[:, 2]


def at_angles(degrees: Array, distance: float) -> Array:
    """Places at angles from the axis, all round it."""
    theta, phi = np.radians(degrees), np.linspace(0, 50, len(degrees))
    local = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    places: Array = distance * local @ TURN.T
    return places


def spot(cutoff: float, beam: float) -> _core.Scene:
    return build(lambda b: b.add_spot_light([0, 0, 0], 3 * AXIS, [2.0, 3.0, 4.0], cutoff, beam))


@pytest.mark.parametrize("distance", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize(("cutoff", "beam"), [(20.0, 15.0), (80.0, 0.0), (150.0, 100.0), (0.01, 0.005), (30.0, 30.0)])
def test_a_spot_is_even_within_its_beam_and_falls_linearly_to_its_cutoff(
    cutoff: float, beam: float, distance: float
) -> None:
    """Where one angle serves as both, it is cut off sharply."""
    angles = np.concatenate([np.linspace(0, 0.999 * cutoff, 50), np.linspace(1.001 * cutoff, 179, 20)])
    places = at_angles(angles, distance)
    drawn = parts.sample_lights(spot(cutoff, beam), "power", places, 1)
    falloff = np.clip((cutoff - angles) / max(cutoff - beam, 1e-300), 0, 1)
    assert (drawn["valid"] == (angles < cutoff)).all()
    exact = np.outer(falloff / distance**2, [2.0, 3.0, 4.0])
    # Float32 places: an angle is off by 1e-7, which is more of a narrow cone.
    slack = 1e-5 + 1e-6 / np.radians(cutoff)
    assert np.abs(drawn["radiance"] - exact).max() < slack * exact.max()
    assert np.abs(1.01 * drawn["radiance"] - exact).max() > slack * exact.max() or cutoff < 1, "the twin"
    lit = angles < cutoff
    assert np.abs(drawn["wi"][lit] + places[lit] / distance).max() < 1e-6
    assert (drawn["pdf"][lit] == 1.0).all()


def slide(cutoff: float, texture: Array, intensity: float = 2.0) -> Any:
    """Return what adds a projector at the origin, of a picture of nearest texels."""

    def add(b: _core.SceneBuilder) -> None:
        spot = b.add_spot_light([0, 0, 0], 3 * AXIS, [intensity] * 3, cutoff, cutoff)
        index = b.add_bitmap(texture.astype(np.float32), srgb=False, filter="nearest", wrap="clamp")
        b.project(spot, index, u_axis=2 * TURN[:, 0], v_axis=TURN[:, 1])

    return add


@pytest.mark.parametrize("cutoff", [5.0, 40.0, 85.0])
def test_a_slide_is_as_wide_as_the_cone(cutoff: float) -> None:
    picture = np.random.default_rng(4).uniform(0.1, 1.0, (5, 7, 3))
    u, v = np.meshgrid((np.arange(7) + 0.4) / 7, (np.arange(5) + 0.6) / 5)
    half = np.tan(np.radians(cutoff))
    plane = np.stack([(2 * u - 1) * half, (2 * v - 1) * half, np.ones_like(u)], axis=-1)
    inside = np.hypot(2 * u - 1, 2 * v - 1) < 1
    places = (plane @ TURN.T)[inside]
    drawn = parts.sample_lights(build(slide(cutoff, picture)), "power", places, 1)
    assert drawn["valid"].all()
    at_one = 2.0 / (plane[inside] ** 2).sum(axis=-1, keepdims=True)
    np.testing.assert_allclose(drawn["radiance"], at_one * picture[inside], rtol=2e-6)
    for other in (picture[:, ::-1], picture[::-1]):
        assert (np.abs(drawn["radiance"] / (at_one * other[inside]) - 1) > 2e-6).any(axis=1).mean() > 0.5, "the twin"


@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_a_slide_that_is_nearly_black_is_picked_all_the_same(lights: str) -> None:
    """One texel of ten thousand shines, between those at which its mean is taken."""
    picture = np.zeros((101, 101, 3))
    picture[30, 60] = 1.0

    def add(b: _core.SceneBuilder) -> None:
        slide(40.0, picture, 1e4)(b)
        b.add_point_light([9, 9, 9], [1.0] * 3)

    half = np.tan(np.radians(40.0))
    place = TURN @ [(2 * 60.5 / 101 - 1) * half, (2 * 30.5 / 101 - 1) * half, 1.0]
    n = 1 << 15
    drawn = parts.sample_lights(build(add), lights, np.broadcast_to(place, (n, 3)), 3)
    value = np.where(drawn["valid"], drawn["radiance"][:, 0] / drawn["pdf"], 0.0)
    exact = 1e4 / (place**2).sum() + 1.0 / ((place - 9) ** 2).sum()
    error = value.std() / np.sqrt(n) + 1e-5 * exact
    assert abs(value.mean() - exact) < 4 * error
    assert abs(1.1 * value.mean() - exact) > 4 * error, "the twin"


def test_a_slide_is_a_texture_that_is_there() -> None:
    def add(b: _core.SceneBuilder) -> None:
        spot = b.add_spot_light([0, 0, 0], [0, 0, 1], [1.0] * 3, 40, 40)
        b.project(spot, b.add_mesh_attribute(), u_axis=[1, 0, 0], v_axis=[0, 1, 0])

    with pytest.raises(ValueError, match="no texture 0 that a spot light could project"):
        build(add)


def test_a_directional_light_is_the_same_everywhere() -> None:
    scene = build(lambda b: b.add_directional_light(5 * AXIS, [2.0, 3.0, 4.0]), eye=(1, 2, 3))
    places = np.random.default_rng(1).normal(size=(20, 3)) * 10.0 ** np.arange(-10, 10)[:, None]
    drawn = parts.sample_lights(scene, "power", places, 1)
    assert drawn["valid"].all()
    assert np.abs(drawn["wi"] + AXIS).max() < 1e-7
    assert np.allclose(drawn["radiance"], [2.0, 3.0, 4.0], rtol=1e-7)
    assert not np.allclose(1.001 * drawn["radiance"], [2.0, 3.0, 4.0], rtol=1e-7), "the twin"


def add_all(builder: _core.SceneBuilder) -> None:
    builder.add_point_light([0, 0, 4], [20.0] * 3)
    builder.add_spot_light([1, 0, 3], [0, 0, -1], [30.0] * 3, 80, 20)
    builder.add_directional_light([0, 1, -1], [3.0] * 3)
    builder.add_directional_light([0, -1, -1], [1.0] * 3)
    builder.add_rectangle(
        np.diag([1.0, 1.0, 1.0, 1.0]), flip_normals=False, front=None, back=None, radiance=[0.0, 0.0, 0.0]
    )


@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_however_lights_are_picked_their_sum_is_the_irradiance(lights: str) -> None:
    """Picked with a known probability each: the mean of what arrives, over that, is the sum of all."""
    scene = build(add_all, eye=(0, 0, 9))
    place, n = np.array([0.5, 0.25, 0.125]), 1 << 15
    drawn = parts.sample_lights(scene, lights, np.broadcast_to(place, (n, 3)), 3, np.tile([0.0, 0, 1], (n, 1)))
    value = np.where(drawn["valid"], drawn["radiance"][:, 0] * drawn["wi"][:, 2] / drawn["pdf"], 0.0)
    to_point, to_spot = np.array([0, 0, 4]) - place, np.array([1, 0, 3]) - place
    angle = np.degrees(np.arccos(to_spot[2] / np.linalg.norm(to_spot)))
    exact = (
        20 * to_point[2] / np.linalg.norm(to_point) ** 3
        + 30 * min(1.0, (80 - angle) / 60) * to_spot[2] / np.linalg.norm(to_spot) ** 3
        + 4.0 * np.sqrt(0.5)
    )
    error = value.std() / np.sqrt(n)
    assert abs(value.mean() - exact) < 4 * error
    assert abs(1.05 * value.mean() - exact) > 4 * error, "the twin"
