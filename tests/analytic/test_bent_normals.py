"""Normal and bump maps under a point light, whose reflection by a diffuse floor is a formula in float64.

The shadowing is that of Conty Estevez et al. 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator
Problem".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from equaltime import _core

from ..statistical.worlds import affine, build, estimate, looking, render

Array = NDArray[np.float64]
LIGHT = np.array([1.0, -0.5, 2.0])
EYE = np.array([-0.4, 0.3, 1.5])
LEVEL = 1e-4


def unit(v: ArrayLike) -> Array:
    array = np.asarray(v, dtype=float)
    return np.asarray(array / np.linalg.norm(array))


def normal_map(n: ArrayLike) -> Array:
    """Return a map that is n but for texels that no test looks at, so that it is no constant."""
    texels = np.tile((0.5 * unit(n) + 0.5).astype(np.float32), (4, 4, 1))
    texels[0, 0] = (0.5, 0.5, 1.0)
    return texels


def floor(bend: Callable[[_core.SceneBuilder, int], None], size: float = 1.0, back: bool = False) -> Any:
    def add(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.5, 0.5, 0.5])
        bend(b, bsdf)
        b.add_rectangle(
            affine((size, 0, 0), (0, size, 0), (0, 0, 1)),
            flip_normals=back,
            front=None if back else bsdf,
            back=bsdf if back else None,
            radiance=None,
        )

    return add


def seen(add: Any) -> float:
    """Return what the floor's middle sends to the eye."""
    scene = build(
        add,
        lambda b: b.add_point_light(LIGHT, [np.pi] * 3),
        camera=looking(EYE, (0.3, 0.3, 0.0)),
        fov=1e-3,
    )
    return float(render(scene, 1, max_depth=2)["mean"][0, 0, 0, 0])


def expected(n: ArrayLike, shadowing: bool = True) -> float:
    """Return the same for a floor at the point (0.3, 0.3, 0) whose normal is bent from +z to n."""
    n, to_light, to_eye = unit(n), LIGHT - (0.3, 0.3, 0.0), EYE - (0.3, 0.3, 0.0)
    if n @ to_eye <= 0:
        n = n * (-1, -1, 1)
    wi = unit(to_light)
    alpha2 = min(1.0, 0.125 * (1 / n[2] ** 2 - 1)) if shadowing else 0.0
    shadow = 2 / (1 + np.sqrt(1 + alpha2 * (1 / wi[2] ** 2 - 1)))
    return float(0.5 * max(0.0, n @ wi) * shadow / (to_light @ to_light))


TILTS = [(0.3, 0.1, 1.0), (-0.8, 0.5, 1.0), (1.5, 0.2, 1.0), (0.0, 0.0, 1.0), (3.0, -2.0, 1.0)]


@pytest.mark.parametrize("shadowing", [True, False])
@pytest.mark.parametrize("n", TILTS)
def test_a_normal_map_bends_the_normal_along_u_and_v(n: tuple[float, float, float], shadowing: bool) -> None:
    def bend(b: _core.SceneBuilder, bsdf: int) -> None:
        b.bend(bsdf, b.add_bitmap(normal_map(n), srgb=False), bump=False, shadowing=shadowing)

    assert seen(floor(bend)) == pytest.approx(expected(n, shadowing), rel=2e-5)


def test_a_normal_map_on_a_back_is_the_mirror_image_or_turned() -> None:
    n = (0.3, 0.1, 1.0)  # seen from behind, v runs the other way
    for turned, tilt in ((False, (0.3, -0.1, 1.0)), (True, (-0.3, 0.1, 1.0))):

        def bend(b: _core.SceneBuilder, bsdf: int, turned: bool = turned) -> None:
            b.bend(bsdf, b.add_bitmap(normal_map(n), srgb=False), bump=False, turned=turned)

        assert seen(floor(bend, back=True)) == pytest.approx(expected(tilt), rel=2e-5)


@pytest.mark.parametrize("slope", [(0.2, 0.0), (0.0, -0.4), (0.7, 0.5)])
@pytest.mark.parametrize("size", [1.0, 2.5])
def test_a_bump_map_is_a_height(slope: tuple[float, float], size: float) -> None:
    """A height that rises evenly with x and y, over a floor of some size, leans the normal the other way."""
    x, y = np.meshgrid(*2 * [2.0 * size * (np.arange(64) + 0.5) / 64])
    height = (slope[0] * x + slope[1] * y)[..., None].astype(np.float32)

    def bend(b: _core.SceneBuilder, bsdf: int) -> None:
        b.bend(bsdf, b.add_bitmap(0.5 * height, srgb=False, wrap="clamp"), bump=True, scale=2.0)

    assert seen(floor(bend, size)) == pytest.approx(expected((-slope[0], -slope[1], 1.0)), rel=1e-4)


def on_a_triangle(corners: Array, rise: ArrayLike, uvs: ArrayLike | None, how: str, unit: float) -> Any:
    """A height that rises so much along u and v, on a triangle that a group is `unit` times as large as it stands."""
    u, v = np.meshgrid(*2 * [(np.arange(64) + 0.5) / 64])
    height = np.tensordot(rise, np.stack([u, v]), axes=1)[..., None].astype(np.float32)

    def add(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.5] * 3)
        b.bend(bsdf, b.add_bitmap(height, srgb=False, wrap="clamp"), bump=True)
        faces = np.array([[0, 1, 2]], dtype=np.uint32)
        mesh = b.add_mesh(corners / unit, faces, None, uvs, front=bsdf, back=None, radiance=None)
        places = np.array([affine(*unit * np.eye(3), (x, 0, 0)) for x in (0.0, 0.1)])
        if how == "in a group":
            b.add_instance(b.add_group(mesh), places[0])
        elif how == "moving":
            b.add_moving_instance(b.add_group(mesh), [0, 1], places)
        b.add_sphere((0, 0, -500), 1.0, flip_normals=False, front=None, back=None, radiance=None)  # widens the world

    return add


@pytest.mark.parametrize("scale", [0.25, 1.0, 3.0])
@pytest.mark.parametrize("how", ["in the world", "in a group", "moving"])
def test_a_bump_map_of_a_mesh_without_uvs_rises_along_the_edges(how: str, scale: float) -> None:
    """From the first corner to the second as u does, and to the third as v does, wherever they are placed."""
    corners = scale * np.array([[-8.0, -8.0, 0.0], [16.0, -4.0, 0.0], [-3.0, 16.0, 0.0]])
    edges = (corners[1:] - corners[0])[:, :2]
    slope = np.array([0.5, -0.3])
    unit = 1.0 if how == "in the world" else scale
    assert seen(on_a_triangle(corners, edges @ slope, None, how, unit)) == pytest.approx(
        expected((*-slope, 1.0)), rel=1e-4
    )


@pytest.mark.parametrize("scale", [0.25, 1.0, 3.0])
@pytest.mark.parametrize("how", ["in the world", "in a group", "moving"])
def test_a_bump_map_where_uvs_are_all_the_same_rises_along_the_authors_unit(how: str, scale: float) -> None:
    """Along that of its group, as it is placed, for a mesh of a group; however large the world or the group is."""
    corners = scale * np.array([[-8.0, -8.0, 0.0], [16.0, -8.0, 0.0], [-8.0, 16.0, 0.0]])
    slope = np.array([0.5, -0.3])
    unit = 1.0 if how == "in the world" else scale
    assert seen(on_a_triangle(corners, slope, np.full((3, 2), 0.4), how, unit)) == pytest.approx(
        expected((*-slope / unit, 1.0)), rel=1e-4
    )


def test_a_flat_map_changes_nothing() -> None:
    def bend(b: _core.SceneBuilder, bsdf: int) -> None:
        b.bend(bsdf, b.add_checkerboard([0.5, 0.5, 1.0], [0.5, 0.5, 1.0]), bump=False)

    assert seen(floor(bend)) == pytest.approx(seen(floor(lambda b, bsdf: None)), rel=1e-6)


def bumpy(b: _core.SceneBuilder, bsdf: int) -> None:
    height = np.random.default_rng(2).uniform(0, 0.3, (8, 8, 1)).astype(np.float32)
    b.bend(bsdf, b.add_bitmap(height, srgb=False), bump=True)


def lit(technique: str, spp: int = 2048) -> Any:
    """A bumpy floor in a room of light: what it reflects of it, and its standard error."""
    scene = build(
        floor(bumpy),
        lambda b: b.add_constant_environment([1.0, 2.0, 3.0]),
        lambda b: b.add_sphere([1, 0, 1], 0.3, flip_normals=False, front=None, back=None, radiance=[9.0, 9.0, 9.0]),
        camera=looking(EYE, (0.3, 0.3, 0.0)),
        fov=30.0,
    )
    return estimate(scene, spp, technique=technique, max_depth=2)


def test_the_techniques_agree_on_bumps() -> None:
    reference = lit("mis")
    for technique in ("bsdf", "light", "uniform"):
        found = lit(technique)
        z = (found.mean - reference.mean) / np.hypot(found.error, reference.error)
        assert np.abs(z).max() < 4.4, (technique, z)  # 3 channels at 1e-5 each


def test_bumps_do_not_reflect_more_than_they_receive() -> None:
    scene = build(floor(bumpy), lambda b: b.add_constant_environment([1.0] * 3), camera=looking(EYE, (0.3, 0.3, 0)))
    assert 0.2 < estimate(scene, 1024, technique="bsdf", max_depth=2).mean[0] < 0.5


@pytest.mark.parametrize(("bsdf", "texture", "message"), [(7, 0, "no BSDF 7"), (0, 7, "no texture 7")])
def test_what_is_bent_is_there(bsdf: int, texture: int, message: str) -> None:
    def bend(b: _core.SceneBuilder, _: int) -> None:
        b.add_checkerboard([0, 0, 0], [1, 1, 1])
        b.bend(bsdf, texture, bump=False)

    with pytest.raises(ValueError, match=message):
        build(floor(bend))
