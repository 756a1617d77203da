"""Hard cases at the limits of something: of roughness, of subdivision, of the unit interval, of what ends at all.

Each has its twin in it or beside it, as README.md says.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime.cli.progress import describe
from equaltime.passes import Progress
from equaltime.selftest.cases import scenes_folder

from ..statistical.worlds import build, looking, octahedron, render

Array = NDArray[np.float64]
F = np.float32
HARD = scenes_folder() / "hard"


def ball_under_a_bulb(levels: int | None) -> Array:
    """Return the image of a ball: smooth triangles, subdivided so often, or the sphere itself."""

    def add(b: _core.SceneBuilder) -> None:
        white = b.add_diffuse([0.8, 0.8, 0.8])
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
    nearly = describe(Progress(99_999, 100_000, 1.0, 0.99999, 1e-3, None))
    assert "99999/100000 spp" in nearly
    assert "0:01 left" in nearly
    assert f"{99_999 / 100_000:.2%}" == "100.00%", "the twin"
