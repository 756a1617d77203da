"""Irradiance from single lights against closed forms, over many orders of magnitude, by sampling the lights alone.

Seeds are fixed. The z-tests of this file together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime import _core
from equaltime._core import parts

from ..statistical.chi2 import LEVEL, share
from ..statistical.worlds import Add, affine, build, turned

Array = NDArray[np.float64]
SAMPLES = 1 << 16
WHITE = (1.0, 1.0, 1.0)
TURN = turned([1, 1, -3], 80)
EACH = share(LEVEL, 60)


def irradiance(add: Add, receiver: Array, normal: Array, seed: int = 1) -> Array:
    """Return independent estimates of what arrives at a place with a normal, without occlusion."""
    scene = build(add, eye=receiver)
    drawn = parts.sample_lights(scene, "power", np.broadcast_to(receiver, (SAMPLES, 3)), seed)
    cosine = np.maximum(0.0, drawn["wi"] @ normal)
    density = np.where(drawn["valid"], drawn["pdf"], 1.0)
    estimates: Array = np.where(drawn["valid"], drawn["radiance"][:, 0] * cosine / density, 0.0)
    return estimates


def p_of(estimates: Array, exact: float, rounding: float = 1e-6) -> float:
    error = estimates.std() / np.sqrt(len(estimates)) + rounding * exact
    return 2 * float(stats.norm.sf(abs(estimates.mean() - exact) / error))


def check(estimates: Array, exact: float, rounding: float = 1e-6) -> None:
    assert p_of(estimates, exact, rounding) > EACH
    assert p_of(1.03 * estimates, exact, rounding) < EACH, "the twin: three percent too bright"


@pytest.mark.parametrize("tilt", [0.0, 40.0])
@pytest.mark.parametrize("ratio", [0.6, 0.1, 1e-2, 1e-4, 1e-6, 1e-7])
def test_spheres_light_by_the_square_of_radius_over_distance(ratio: float, tilt: float) -> None:
    """π L (r/d)² cosθ, as long as the whole sphere is above the horizon (case S5)."""
    distance = 5.0
    normal = TURN @ [np.sin(np.radians(tilt)), 0.0, np.cos(np.radians(tilt))]
    receiver = -distance * TURN[:, 2]

    def add(builder: _core.SceneBuilder) -> None:
        builder.add_sphere([0, 0, 0], ratio * distance, flip_normals=False, front=None, back=None, radiance=WHITE)

    check(irradiance(add, receiver, normal), np.pi * ratio**2 * np.cos(np.radians(tilt)))


@pytest.mark.parametrize("height", [1e-2, 0.3, 1.0, 30.0, 1e4])
def test_disks_light_points_on_their_axis_by_their_share_of_the_hemisphere(height: float) -> None:
    """π L r²/(r² + h²)."""

    def add(builder: _core.SceneBuilder) -> None:
        builder.add_disk(affine(*TURN.T), flip_normals=False, front=None, back=None, radiance=WHITE)

    estimates = irradiance(add, height * TURN[:, 2], -TURN[:, 2])
    exact = np.pi / (1 + height**2)
    # Uniform over the area, points close by are rare and weigh much.
    if height >= 0.3:
        check(estimates, exact)
    else:
        assert p_of(estimates, exact) > EACH


def lambert(corners: Array, receiver: Array, normal: Array) -> float:
    """Return the irradiance from a polygon of radiance 1 above the horizon (Lambert 1760)."""
    rays = corners - receiver
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(rays, np.roll(rays, -1, axis=0), strict=True):
        cross = np.cross(a, b)
        sine = np.linalg.norm(cross)
        total += float(np.arctan2(sine, a @ b) * (cross @ normal) / sine)
    return abs(total) / 2


QUADS = {
    "square": np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float),
    "thin": np.array([[-1, -0.001, 0], [1, -0.001, 0], [1, 0.001, 0], [-1, 0.001, 0]]),
    "triangle": np.array([[-1, -1, 0], [1.5, -0.5, 0], [0, 1.2, 0]]),
    "sliver": np.array([[-1, 0, 0], [1, 0, 0], [0.3, 1e-3, 0]]),
}
PLACES = {"near": (0.2, 0.3, 0.4), "aside": (1.5, 0.4, 0.6), "far": (3.0, -2.0, 6.0), "close": (0.1, 0.05, 0.05)}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("shape", QUADS)
def test_polygons_light_by_lamberts_formula(shape: str, place: str) -> None:
    corners, receiver = QUADS[shape] @ TURN.T, TURN @ PLACES[place]
    normal = -TURN[:, 2]

    def add(builder: _core.SceneBuilder) -> None:
        faces = [[0, 1, 2], [0, 2, 3]][: len(corners) - 2]
        builder.add_mesh(corners, faces, front=None, back=None, radiance=WHITE)

    # Corners are rounded to 2^-24 of the distances: a thin shape's width suffers.
    width = {"thin": 0.002, "sliver": 1e-3}.get(shape, 1.0)
    check(irradiance(add, receiver, normal), lambert(corners, receiver, normal), 2.0**-22 * 10 / width)


@pytest.mark.parametrize("triangles", [False, True])
def test_a_receiver_right_above_a_wide_light_sees_half_a_world_of_it(triangles: bool) -> None:
    """Down to a ten-millionth above a light a thousand wide: E = π L (case S10)."""

    def add(builder: _core.SceneBuilder) -> None:
        if triangles:
            builder.add_mesh(500 * QUADS["square"], [[0, 1, 2], [0, 2, 3]], front=None, back=None, radiance=WHITE)
        else:
            square = affine([500, 0, 0], [0, 500, 0], [0, 0, 1])
            builder.add_rectangle(square, flip_normals=False, front=None, back=None, radiance=WHITE)

    for height in (1e-1, 1e-3, 1e-5, 1e-7):
        estimates = irradiance(add, np.array([3.0, 5.0, height]), np.array([0.0, 0.0, -1.0]))
        assert p_of(estimates, np.pi) > EACH
        assert p_of(1.05 * estimates, np.pi) < EACH, "the twin"


@pytest.mark.parametrize("shape", QUADS)
def test_irradiance_vanishes_smoothly_as_a_receiver_comes_down_to_a_lamp_s_plane(shape: str) -> None:
    """By Lambert's formula to a ten-millionth above it; in it, and below, exactly nothing (case S7)."""

    def add(builder: _core.SceneBuilder) -> None:
        faces = [[0, 1, 2], [0, 2, 3]][: len(QUADS[shape]) - 2]
        builder.add_mesh(QUADS[shape], faces, front=None, back=None, radiance=WHITE)

    for height in (1e-1, 1e-3, 1e-5, 1e-7):
        receiver, normal = np.array([2.0, 0.25, height]), np.array([-1.0, 0.0, 0.0])
        check(irradiance(add, receiver, normal), lambert(QUADS[shape], receiver, normal), 1e-4)
        assert irradiance(add, receiver * [1, 1, -1], normal).max() == 0.0
    assert irradiance(add, receiver * [1, 1, 0], normal).max() == 0.0


@pytest.mark.parametrize("distance", [1e-3, 1.0, 1e3])
def test_point_lights_fall_off_with_the_square_of_the_distance_without_noise(distance: float) -> None:
    def add(builder: _core.SceneBuilder) -> None:
        builder.add_point_light([0, 0, 0], [2.0, 3.0, 4.0])
        builder.add_sphere([0, 0, -2], 1.0, flip_normals=False, front=None, back=None, radiance=None)

    receiver = distance * TURN[:, 1]
    drawn = parts.sample_lights(build(add, eye=receiver), "uniform", receiver[None, :], 1)
    assert drawn["pdf"][0] == 1.0
    rounding = 2.0**-22 * (1 + 1 / distance)  # of places to 2^-24 of the sphere's size
    assert np.abs(drawn["radiance"][0] * distance**2 / [2, 3, 4] - 1).max() < rounding
    assert np.abs(drawn["wi"][0] + TURN[:, 1]).max() < rounding
