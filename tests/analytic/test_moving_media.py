"""Paths begin in what the camera is in at their time: bodies that move, deform, or that a moving camera goes through.

All absorb and are seen along an axis under an even sky, so that the mean over the shutter is an integral. Seeds are
fixed. The z-tests of this file together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate

from equaltime import _core

from ..statistical.chi2 import LEVEL, share
from ..statistical.worlds import Add, Estimate, affine, build, estimate, octahedron

Array = NDArray[np.float64]

SIGMA = np.array([1.0, 2.0, 0.25])
OTHER = np.array([0.5, 0.25, 1.5])
SPP = 1 << 14
KINDS = ("a ball", "a mesh", "bodies that overlap", "a mesh that grows", "a camera that goes through")
EACH = share(LEVEL, len(KINDS))


def ball(b: _core.SceneBuilder, z: float, sigma: Array, mesh: bool, priority: int | None = None) -> int:
    nothing = b.add_null()
    if mesh:
        vertices, faces = octahedron(2, 1.0, (0, 0, z))
        index = b.add_mesh(vertices, faces, front=nothing, back=nothing, radiance=None)
    else:
        index = b.add_sphere((0, 0, z), 1.0, flip_normals=False, front=nothing, back=nothing, radiance=None)
    b.set_media(index, exterior=None, interior=b.add_medium(sigma.tolist(), [0.0] * 3))
    if priority is not None:
        b.set_priority(index, priority)
    return index


def places(begin: float, end: float) -> Array:
    return np.stack([affine(*np.eye(3), (0, 0, z)) for z in (begin, end)])


def flying(mesh: bool, priority: int | None = None) -> Add:
    """Return what adds a ball that flies along the axis from -3 to 3."""

    def add(b: _core.SceneBuilder) -> None:
        index = ball(b, 0.0, SIGMA, mesh, priority)
        b.add_moving_instance(b.add_group(index), [0, 1], places(-3, 3))

    return add


def radius(t: float) -> float:
    return 0.5 + 1.5 * t


def growing(b: _core.SceneBuilder) -> None:
    """Add a ball about (0, 0, 1) whose radius grows from 1/2 to 2, so that the camera comes into it."""
    nothing = b.add_null()
    vertices, faces = octahedron(2, 1.0)
    index = b.add_mesh(0.5 * vertices + [0, 0, 1], faces, front=nothing, back=nothing, radiance=None)
    b.set_media(index, exterior=None, interior=b.add_medium(SIGMA.tolist(), [0.0] * 3))
    b.deform_mesh(index, np.array([2.0 * vertices + [0, 0, 1]]))


def within(near: float, far: float) -> float:
    """Return how much of a stretch of the axis lies before the camera at 0."""
    return max(far, 0.0) - max(near, 0.0)


def seen(kind: str) -> tuple[Estimate, Callable[[float], Array]]:
    """Return what is rendered and what the depth of all media together is at a time."""
    if kind == "bodies that overlap":

        def depth(t: float) -> Array:
            z = -3 + 6 * t
            both = max(0.0, within(max(z - 1, 1), min(z + 1, 3))) if z > 0 else 0.0
            return SIGMA * within(z - 1, z + 1) + OTHER * (2.0 - both)

        fixed: Add = lambda b: ball(b, 2.0, OTHER, False, 1)  # noqa: E731
        return rendered(fixed, flying(True, 2)), depth
    if kind == "a mesh that grows":
        return rendered(growing), lambda t: SIGMA * within(1 - radius(t), 1 + radius(t))
    if kind == "a camera that goes through":
        going: Add = lambda b: (ball(b, 0.0, SIGMA, True), b.move_sensor([0, 1], places(3, -3)))  # noqa: E731
        return rendered(going), lambda t: SIGMA * within(-4 + 6 * t, -2 + 6 * t)
    return rendered(flying(kind == "a mesh")), lambda t: SIGMA * within(-4 + 6 * t, -2 + 6 * t)


def rendered(*add: Add) -> Estimate:
    def sky(b: _core.SceneBuilder) -> None:
        b.add_constant_environment((1, 1, 1))
        b.cross_freely()

    return estimate(build(sky, *add, fov=1e-3), SPP, max_depth=4)


def mean(depth: Callable[[float], Array]) -> Array:
    times = np.linspace(0, 1, 20001)
    return np.array(integrate.simpson([np.exp(-depth(t)) for t in times], x=times, axis=0))


@pytest.mark.parametrize("kind", KINDS)
def test_a_path_begins_in_what_the_camera_is_in_at_its_time(kind: str) -> None:
    found, depth = seen(kind)
    assert found.p(mean(depth)) > EACH
    assert found.p(mean(lambda t: depth(min(1.06 * t, 1.0)))) < EACH, "the twin: a little too early"
