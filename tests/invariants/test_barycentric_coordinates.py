"""A mesh without texture coordinates has the barycentric ones of each triangle, and no unit of its own.

It is, to the bit, the mesh that is given them; and in other units it looks the same.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from ..statistical.worlds import affine, build, looking, render, turned
from .shipped import same_bits

Array = NDArray[np.float64]
CORNERS = np.array(
    [[[-1.0, -0.8, 0.1], [1.2, -1.0, 0.0], [-0.6, 1.1, 0.2]], [[1.2, -1.0, 0.0], [1, 1, 0], [-0.6, 1.1, 0.2]]]
)
"""Of two triangles that share an edge."""
NORMALS = np.array([[0.2, 0.1, 1.0], [-0.1, 0.3, 1.0], [0.3, -0.2, 1.0]])
BARYCENTRIC = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def heights() -> NDArray[np.float32]:
    return np.random.default_rng(2).uniform(0.0, 0.3, (8, 8, 1)).astype(np.float32)


def leaning() -> NDArray[np.float32]:
    n = np.random.default_rng(3).uniform(0.3, 0.7, (8, 8, 3))
    n[..., 2] = 1.0
    return n.astype(np.float32)


def bumpy(b: _core.SceneBuilder, height: float) -> int:
    bsdf = b.add_bsdf("diffuse", [0.5] * 3)
    b.bend(bsdf, b.add_bitmap(heights(), srgb=False), bump=True, scale=height)
    return bsdf


def mapped(b: _core.SceneBuilder, _: float) -> int:
    bsdf = b.add_bsdf("diffuse", [0.5] * 3)
    b.bend(bsdf, b.add_bitmap(leaning(), srgb=False), bump=False)
    return bsdf


def brushed(b: _core.SceneBuilder, _: float) -> int:
    return b.add_bsdf("roughconductor", "ggx", 0.1, 0.5, [0.2, 0.9, 1.1], [3.9, 2.4, 2.1], [1.0] * 3)


BSDFS: dict[str, Callable[[_core.SceneBuilder, float], int]] = {"bumps": bumpy, "normals": mapped, "brushed": brushed}
HOW = ("in the world", "in a group", "moving", "deforming")


def film(bsdf: str, how: str, uvs: Array | None, size: float = 1.0, height: float = 1.0) -> NDArray[Any]:
    """Return the moments of a picture of the mesh, with all lengths times a size, but for that of bumps."""
    stretched = np.diag([1.6, 0.7, 1.1]) @ turned((2, 1, 3), 35)

    def place(x: float) -> Array:
        return affine(*stretched.T, size * np.array([x, 0.1, 0.2]))

    def add(b: _core.SceneBuilder) -> None:
        front, vertices = BSDFS[bsdf](b, height), size * CORNERS.reshape(6, 3)
        faces, normals = np.arange(6, dtype=np.uint32).reshape(2, 3), np.tile(NORMALS, (2, 1))
        given = None if uvs is None else np.tile(uvs, (2, 1))
        mesh = b.add_mesh(vertices, faces, normals, given, front=front, back=front, radiance=None)
        if how == "deforming":
            b.deform_mesh(mesh, [1.1 * vertices + [0.0, 0.1 * size, 0.0]], [normals])
        elif how == "moving":
            b.add_moving_instance(b.add_group(mesh), [0, 1], np.array([place(0.0), place(0.2)]))
        elif how == "in a group":
            b.add_instance(b.add_group(mesh), place(0.1))
        b.add_point_light(size * np.array([1.0, -0.5, 2.0]), [size**2] * 3)
        b.add_constant_environment([0.1, 0.2, 0.3])

    camera = looking(size * np.array([-0.4, 0.3, 5.0]), (0.0, 0.0, 0.0))
    return render(build(add, camera=camera, size=(16, 12)), 4, max_depth=3)


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("bsdf", BSDFS)
def test_a_mesh_without_coordinates_is_the_one_that_is_given_barycentric_ones(bsdf: str, how: str) -> None:
    plain = film(bsdf, how, None)
    assert plain["mean"].mean() > 0.01
    assert same_bits(plain, film(bsdf, how, BARYCENTRIC))
    assert not same_bits(plain, film(bsdf, how, BARYCENTRIC[[0, 2, 1]])), "the twin: u and v have changed places"


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("bsdf", BSDFS)
def test_it_looks_the_same_in_units_that_are_a_power_of_two_as_large(bsdf: str, how: str) -> None:
    plain = film(bsdf, how, None)
    for size in (2.0**-20, 2.0**20):
        assert same_bits(plain, film(bsdf, how, None, size, height=size)), size
    assert same_bits(plain, film(bsdf, how, None, 2.0)) == (bsdf != "bumps"), "the twin: bumps as high as before"
