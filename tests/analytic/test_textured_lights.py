"""Lights whose radiance is a texture: what they send to a diffuse floor, against quadrature in float64.

A statement that holds is rejected with a probability of 1e-4 a test, with fixed seeds; a twin shows what is found.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from ..statistical.worlds import Estimate, affine, build, estimate, looking

Array = NDArray[np.float64]
LEVEL = 1e-4
PICTURE = np.random.default_rng(4).uniform(0.0, 1.0, (3, 5, 3)) ** 4 * 8
PICTURE[0, 0] = 0.0
PLACE = affine((0.9, 0.1, 0), (-0.1, 0.9, 0), (0, 0, -1), (0.3, 0.2, 1.2))
"""Of a square lamp over the floor z = 0; it shines downwards."""
GAZE = np.array([0.1, -0.2, 0.0])


def floor(b: _core.SceneBuilder) -> None:
    b.add_rectangle(
        np.diag([9.0, 9.0, 1.0, 1.0]),
        flip_normals=False,
        front=b.add_bsdf("diffuse", [0.5] * 3),
        back=None,
        radiance=None,
    )


def shine(b: _core.SceneBuilder, shape: int) -> None:
    b.bind_radiance(shape, b.add_bitmap(PICTURE.astype(np.float32), srgb=False, filter="nearest"))


def square(b: _core.SceneBuilder) -> None:
    shine(b, b.add_rectangle(PLACE, flip_normals=False, front=None, back=None, radiance=(1.0, 0.5, 2.0)))


def mesh(b: _core.SceneBuilder) -> None:
    """The same square as triangles."""
    corners = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]]) @ PLACE.T
    uvs, faces = [[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 2, 1], [0, 3, 2]]
    shine(b, b.add_mesh(corners[:, :3], faces, None, uvs, front=None, back=None, radiance=(1.0, 0.5, 2.0)))


def exact() -> Array:
    """Return the radiance that the floor sends back at `GAZE`."""
    n = 600
    u, v = np.meshgrid(*2 * [(np.arange(n) + 0.5) / n])
    points = np.stack([2 * u - 1, 2 * v - 1, 0 * u, 1 + 0 * u], axis=-1) @ PLACE.T
    to_light = points[..., :3] - GAZE
    distance2 = (to_light**2).sum(axis=-1)
    area = 4 * np.linalg.norm(np.cross(PLACE[:3, 0], PLACE[:3, 1])) / n**2
    form = to_light[..., 2] * to_light[..., 2] / distance2**2 * area / np.pi
    radiance = PICTURE[(v * 3).astype(int), (u * 5).astype(int)] * (1.0, 0.5, 2.0)
    return np.asarray(0.5 * (form[..., None] * radiance).sum(axis=(0, 1)))


def seen(lamp: Any, technique: str, spp: int, **settings: Any) -> Estimate:
    scene = build(floor, lamp, camera=looking((0.1, -0.5, 0.3), GAZE, up=(0, 1, 0)), fov=0.01)
    return estimate(scene, spp, technique=technique, max_depth=2, **settings)


@pytest.mark.parametrize("technique", ["uniform", "bsdf", "light", "mis", "mixture"])
@pytest.mark.parametrize("lamp", [square, mesh])
def test_a_textured_lamp_lights_a_floor_as_quadrature_says(lamp: Any, technique: str) -> None:
    assert seen(lamp, technique, 2048).p(exact()) > LEVEL


@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_it_does_so_however_lights_are_picked(lights: str) -> None:
    assert seen(mesh, "mis", 2048, lights=lights).p(exact()) > LEVEL


def test_a_lamp_ten_percent_too_bright_is_found() -> None:
    assert seen(square, "light", 8192).p(exact() / 1.1) < LEVEL


def test_a_lamp_shows_its_picture() -> None:
    for x, y in ((-0.9, -0.9), (0.3, 0.5), (0.9, -0.2)):
        point = (PLACE @ [x, y, 0, 1])[:3]
        scene = build(square, camera=looking((0, 0, 0), point), fov=0.01)
        color = PICTURE[int((y + 1) / 2 * 3), int((x + 1) / 2 * 5)] * (1.0, 0.5, 2.0)
        np.testing.assert_allclose(estimate(scene, 4, max_depth=1).mean, color, rtol=1e-5)


def test_a_texture_to_shine_by_is_there() -> None:
    def lamp(b: _core.SceneBuilder) -> None:
        b.bind_radiance(b.add_rectangle(PLACE, flip_normals=False, front=None, back=None, radiance=(1.0, 1.0, 1.0)), 3)

    with pytest.raises(ValueError, match="shape 0: no texture 3 to shine by"):
        build(lamp)
