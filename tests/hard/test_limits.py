"""Hard cases at the limits of something: of roughness, of subdivision, of the unit interval, of what ends at all.

Each has its twin in it or beside it, as README.md says.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime.cli.progress import describe, time_left
from equaltime.hardcases.cases import scenes_folder
from equaltime.rendering.passes import Progress

from ..statistical.worlds import affine, build, looking, octahedron, render, turned

Array = NDArray[np.float64]
F = np.float32
HARD = scenes_folder() / "hard"


def ball_under_a_bulb(levels: int | None) -> Array:
    """Return the image of a ball: smooth triangles, subdivided so often, or the sphere itself."""

    def add(b: _core.SceneBuilder) -> None:
        white = b.add_bsdf("diffuse", [0.8, 0.8, 0.8])
        if levels is None:
            b.add_sphere([0, 0, 0], 1.0, flip_normals=False, front=white, back=None, radiance=None)
        else:
            vertices, faces = octahedron(levels)
            b.add_mesh(vertices, faces, vertices, front=white, back=None, radiance=None)
        b.add_point_light([0, 4, 1.5], [9, 9, 9])

    image: Array = render(build(add, camera=looking([4, 0, 0], [0, 0, 0]), fov=28, size=(24, 24)), 16)["mean"][0]
    return image


def test_G15_the_terminator_of_a_coarse_ball_comes_right_as_it_is_divided() -> None:  # noqa: N802
    """Nothing is smoothed, which would be a bias; the mistake is the mesh's, and falls with its triangles."""
    exact = ball_under_a_bulb(None)
    errors = [float(np.abs(ball_under_a_bulb(levels) - exact).mean() / exact.mean()) for levels in (1, 3, 5)]
    print(f"32, 512, 8192 triangles: {errors}")
    assert errors[0] > 3 * errors[1] > 9 * errors[2], "the twin: the coarse ball"
    assert errors[2] < 0.01


def test_S04_a_cosine_of_nothing_has_no_weight() -> None:  # noqa: N802
    """The twin of the test of BSDFs at the ends of the interval: f over pdf, both of them 0."""
    cosine = np.sqrt(np.maximum(F(0), F(1) - F(1)))
    with np.errstate(invalid="ignore"):
        assert np.isnan(cosine / np.pi / (cosine / np.pi))


def test_S14_a_lamp_in_a_mirror_does_not_change_as_its_roughness_vanishes() -> None:  # noqa: N802
    """From 1e-3 through 1e-4, where others become specular, to 1e-6: the lamp's radiance within 2 per mille."""
    for alpha in (1e-3, 3e-4, 1.1e-4, 1e-4, 0.9e-4, 1e-5, 1e-6):
        image = et.render(et.load(HARD / "rough-mirror.toml", alpha=alpha), spp=64).image
        assert abs(float(image.mean()) - 1.0) < 2e-3, alpha
    rough = et.render(et.load(HARD / "rough-mirror.toml", alpha=0.1), spp=64).image
    assert abs(float(rough.mean()) - 1.0) > 0.05, "the twin"


def test_G17_a_shadow_ray_that_ended_a_ten_thousandth_early_would_miss_the_lid() -> None:  # noqa: N802
    """The twin of the lid before a lamp: what is met on the way to the lamp is the lid, and only at its very end."""
    core = et.load(HARD / "covered-lamp.toml").core
    ground = np.column_stack([np.random.default_rng(3).uniform(-0.1, 0.1, (100, 2)), np.full(100, 1e-6)])
    lamp = np.array([0.0, 0.0, 1.0])
    met = core.intersect(ground, lamp - ground)["t"] / np.linalg.norm(lamp - ground, axis=1)
    assert (met < 1.0).all()
    assert (met > 1.0 - 1e-4).all()


STRETCH = np.diag([-1e-3, 1.0, 1e3])
"""Of an instance, in axes that are turned."""


def stretched(baked: bool, mirrored: bool = True) -> Array:
    """Return the image of half a ball of triangles, smooth, stretched as an instance, or by its vertices."""
    vertices, faces = octahedron(3)
    faces = faces[vertices[faces].mean(axis=1)[:, 0] > 0]
    stretch = STRETCH if mirrored else np.abs(STRETCH)
    axes = turned([1, 2, 3], 10) @ stretch
    flipped = faces[:, ::-1] if np.linalg.det(axes) < 0 else faces

    def add(b: _core.SceneBuilder) -> None:
        front, back = b.add_bsdf("diffuse", [0.9, 0.5, 0.2]), b.add_bsdf("diffuse", [0.1, 0.3, 0.8])
        if baked:
            b.add_mesh(
                vertices @ axes.T, flipped, vertices @ np.linalg.inv(axes), front=front, back=back, radiance=None
            )
        else:
            shape = b.add_mesh(vertices, faces, vertices, front=front, back=back, radiance=None)
            b.add_instance(b.add_group(shape), affine(*axes.T))
        b.add_directional_light([-1.0, 0.2, -0.3], [2, 2, 2])
        b.add_constant_environment([1, 1, 1])

    film = render(build(add, camera=looking([6, 0.3, 0.8], [0, 0, 0]), fov=0.02, size=(24, 24)), 64, technique="bsdf")
    image: Array = film["mean"][0]
    return image


def test_G18_an_instance_looks_as_what_is_stretched_itself() -> None:  # noqa: N802
    """With the same numbers, but for rays that rounding sends past an edge."""
    instance, baked = stretched(baked=False), stretched(baked=True)
    assert baked.mean() > 0.1
    assert np.abs(instance / baked - 1).mean() < 1e-3
    assert np.abs(stretched(baked=False, mirrored=False) / baked - 1).mean() > 1e-2, "the twin: not mirrored"


def test_S25_numbers_of_32_bits_do_round_to_one() -> None:  # noqa: N802
    """The twin of the tests of random numbers: the usual division."""
    assert F((2**32 - 1) / 2**32) == 1.0
    assert F((2**24 - 1) / 2**24) < 1.0


def capped_second_moment(rho: float, cap: float, bounces: int) -> float:
    """Return the expected square of a furnace's estimate, as far as paths of so many bounces make it."""
    return float(sum((rho**2 / min(cap, rho)) ** k for k in range(bounces)))


def test_T02_a_roulette_capped_below_one_has_no_finite_variance() -> None:  # noqa: N802
    """The twin of the test of errors in tests/analytic/test_furnace.py, by the sum of the series."""
    assert capped_second_moment(0.99, 0.95, 2000) > 2 * capped_second_moment(0.99, 0.95, 1900)
    assert capped_second_moment(0.99, 1.0, 2000) == pytest.approx(capped_second_moment(0.99, 1.0, 1900), rel=1e-6)


def test_E14_what_is_not_done_is_not_called_done() -> None:  # noqa: N802
    """Counts are told, which round to nothing, and time left is rounded up."""
    assert "99999/100000 spp" in describe(Progress(99_999, 100_000, 1.0, 0.99999, 1e-3, None))
    assert time_left(1e-3) == "0:01 left"
    assert f"{99_999 / 100_000:.2%}" == "100.00%", "the twin"
