"""Meshes whose vertices move while the shutter is open: at each time they are the still mesh of that time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from ...statistical.worlds import build

Array = NDArray[np.float64]

SIDE = 9
STEPS = 3


def sheet(time: float) -> tuple[Array, Array]:
    """Return vertices and normals of a waving sheet."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    phase = 2.0 * time
    z = 0.3 * np.sin(3 * x + phase) + 0.2 * time * y
    normals = np.stack([-0.9 * np.cos(3 * x + phase), np.full_like(x, -0.2 * time), np.ones_like(x)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return np.stack([x + 0.4 * time, y, z], axis=-1).reshape(-1, 3), normals.reshape(-1, 3)


def faces() -> NDArray[np.uint32]:
    i = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.uint32)


def between(time: float) -> tuple[Array, Array]:
    """Return the sheet at a time, evenly between its keys."""
    before = min(int(time * STEPS), STEPS - 1)
    share = time * STEPS - before
    (v0, n0), (v1, n1) = sheet(before / STEPS), sheet((before + 1) / STEPS)
    return (1 - share) * v0 + share * v1, (1 - share) * n0 + share * n1


def scene(vertices: Array, normals: Array | None, later: bool, radiance: Any = None) -> _core.Scene:
    def add(builder: _core.SceneBuilder) -> None:
        white = builder.add_bsdf("diffuse", (0.5, 0.5, 0.5))
        index = builder.add_mesh(vertices, faces(), normals, None, front=white, back=white, radiance=radiance)
        if later:
            keys = [sheet(k / STEPS) for k in range(1, STEPS + 1)]
            turned = None if normals is None else np.array([n for _, n in keys])
            builder.deform_mesh(index, np.array([v for v, _ in keys]), turned)

    return build(add, eye=(0, 0, -4))


def rays(count: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(7)
    origins = rng.normal(size=(count, 3)) + np.array([0.0, 0.0, -4.0])
    aims = np.concatenate([rng.uniform(-1, 1.2, (count, 2)), np.zeros((count, 1))], axis=1)
    return origins, (aims - origins) / np.linalg.norm(aims - origins, axis=1, keepdims=True)


@pytest.mark.parametrize("smooth", [True, False])
def test_a_mesh_is_at_each_time_the_still_mesh_of_that_time(smooth: bool) -> None:
    vertices, normals = sheet(0.0)
    moving = scene(vertices, normals if smooth else None, True)
    assert moving.effects()["motion"]
    origins, directions = rays(4000)
    for time in (0.0, 0.2, 1 / 3, 0.7, 1.0):
        v, n = between(time)
        expected = scene(v, n if smooth else None, False).intersect(origins, directions)
        found = moving.intersect(origins, directions, time=time)
        both = (expected["shape"] == 0) & (found["shape"] == 0)
        same = both & (found["primitive"] == expected["primitive"])
        assert ((expected["shape"] == 0) != (found["shape"] == 0)).sum() <= 4
        assert same.sum() > 0.99 * both.sum() > 2000
        np.testing.assert_allclose(found["t"][same], expected["t"][same], rtol=1e-5)
        np.testing.assert_allclose(found["n"][same], expected["n"][same], atol=1e-4)
        np.testing.assert_allclose(found["shading_normal"][same], expected["shading_normal"][same], atol=1e-4)


def test_vertices_that_stay_call_for_nothing_and_what_cannot_deform_says_so() -> None:
    vertices, _ = sheet(0.0)

    def stays(builder: _core.SceneBuilder) -> None:
        index = builder.add_mesh(vertices, faces(), front=None, back=None, radiance=None)
        builder.deform_mesh(index, np.array([vertices, vertices]))

    assert not build(stays).effects()["motion"]
    with pytest.raises(ValueError, match="shape 0: a mesh that deforms cannot emit"):
        scene(vertices, None, True, radiance=(1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="only a mesh can be deformed"):
        _core.SceneBuilder().deform_mesh(0, np.zeros((1, 3, 3)))


def test_no_ray_that_leaves_a_mesh_that_deforms_meets_it_again() -> None:
    """A convex bowl seen from outside under a white sky: every sample is 1."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    keys = [np.stack([x, y, depth * (x**2 + y**2)], axis=-1).reshape(-1, 3) + 100.0 for depth in (0.2, 0.5, 0.3)]

    def add(builder: _core.SceneBuilder) -> None:
        white = builder.add_bsdf("diffuse", (1, 1, 1))
        index = builder.add_mesh(keys[0], faces(), front=white, back=white, radiance=None)
        builder.deform_mesh(index, np.array(keys[1:]))
        builder.add_constant_environment((1, 1, 1))

    core = build(add, eye=(100.0, 100.0, 96.0), fov=40.0, size=(48, 48))
    renderer = _core.Renderer(core, _core.Settings(max_depth=2, technique="bsdf", sampler="independent"), seed=1)
    assert renderer.advance(8)
    assert renderer.counters["rays"] > 1.2 * renderer.counters["paths"], "it is seen"
    assert 0.99 < renderer.moments["mean"].min() <= renderer.moments["mean"].max() < 1.01
