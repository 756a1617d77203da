"""Light that one square sends to another, against the closed forms of their view factors (cases FF, S8).

Seeds are fixed. The tests of this file together have a false-alarm rate of 0.1 %, by t-tests over replicates.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import atan, log, pi, sqrt

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime import _core
from equaltime.statistics.agreement import sidak

from ..statistical.chi2 import LEVEL, share
from ..statistical.worlds import affine, build, render, turned

Array = NDArray[np.float64]
RHO, RADIANCE = np.array([0.8, 0.5, 0.2]), np.array([1.0, 2.0, 3.0])
PLACE, TURN = np.array([0.3, -0.2, 0.7]), turned([1, -2, 1], 35)
PARALLEL = 2 / pi * (0.5 * log(4 / 3) + 2 * sqrt(2) * atan(1 / sqrt(2)) - 2 * atan(1))
"""Two unit squares that face each other at distance 1."""
TOUCHING = 1 / pi * (2 * atan(1) - sqrt(2) * atan(1 / sqrt(2)) + 0.25 * log(3 / 4))
"""Two unit squares at a right angle that share an edge."""


def placed(x: Array, y: Array, z: Array, origin: Array) -> Array:
    """Return a transform that is turned and moved with the whole scene."""
    return affine(TURN @ x, TURN @ y, TURN @ z, TURN @ origin + PLACE)


X, Y, Z = np.eye(3)
SOURCES = {
    "parallel": (placed(X / 2, -Y / 2, -Z, Z), PARALLEL),
    "touching": (placed(-Y / 2, -Z / 2, X, (Z - X) / 2), TOUCHING),
}


def add_square(builder: _core.SceneBuilder, matrix: Array) -> None:
    builder.add_rectangle(matrix, flip_normals=False, front=None, back=None, radiance=RADIANCE)


def add_triangles(builder: _core.SceneBuilder, matrix: Array) -> None:
    corners = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]]) @ matrix.T
    builder.add_mesh(corners[:, :3], [[0, 1, 2], [0, 2, 3]], front=None, back=None, radiance=RADIANCE)


def lit_square(source: Array, add: Callable[[_core.SceneBuilder, Array], None]) -> _core.Scene:
    """Return the scene of a diffuse unit square, lit, that fills the film of a camera above its middle."""

    def add_floor(builder: _core.SceneBuilder) -> None:
        diffuse = builder.add_bsdf("diffuse", RHO)
        builder.add_rectangle(
            placed(X / 2, Y / 2, Z, 0 * Z), flip_normals=False, front=diffuse, back=None, radiance=None
        )

    camera = placed(X, -Y, -Z, Z / 2)
    return build(add_floor, lambda b: add(b, source), camera=camera, fov=90.0, size=(16, 16))


def factors(scene: _core.Scene, technique: str, spp: int = 1024, replicates: int = 32) -> Array:
    """Return one estimate of the view factor for each replicate and channel."""
    film = render(scene, spp, replicates=replicates, technique=technique, max_depth=2)
    means: Array = film["mean"].mean(axis=(1, 2)) / (RHO * RADIANCE)
    return means


def p_of(estimates: Array, exact: float) -> float:
    return sidak(float(stats.ttest_1samp(estimates, exact).pvalue.min()), 3)


CASES = list(product(SOURCES, [add_square, add_triangles], ["bsdf", "light", "mis"]))
EACH = share(LEVEL, len(CASES))


@pytest.mark.parametrize(("name", "add", "technique"), CASES)
def test_a_square_lights_another_by_their_view_factor(
    name: str, add: Callable[[_core.SceneBuilder, Array], None], technique: str
) -> None:
    source, exact = SOURCES[name]
    estimates = factors(lit_square(source, add), technique)
    assert p_of(estimates, exact) > EACH
    assert p_of(1.01 * estimates, exact) < EACH, "the twin: one percent too bright"


def test_closed_forms_are_those_of_the_tables() -> None:
    assert pytest.approx(0.19982489569838732, abs=1e-15) == PARALLEL
    assert pytest.approx(0.20004377607540316, abs=1e-15) == TOUCHING


def test_errors_halve_with_four_times_the_samples_even_where_light_and_receiver_touch() -> None:
    """Points drawn over the light's area would have unbounded variance here (case S8). An F-test at 0.1 %."""
    scene = lit_square(SOURCES["touching"][0], add_square)

    def variance(spp: int) -> float:
        film = render(scene, 64 * spp, replicates=64, technique="light", max_depth=2, sampler="independent")
        return float(film["mean"][..., 0].mean(axis=(1, 2)).var(ddof=1))

    low, high = stats.f.ppf([0.0005, 0.9995], 63, 63)
    assert low < variance(4) * 4 / variance(1) < high
