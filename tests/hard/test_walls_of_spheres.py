"""Balls of radius 1e5 as walls of a room a hundred wide, as in scenes/montelight (G6): where they are, and no leaks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime.film.moments import squared_deviations
from equaltime.scene.model import Sphere

from ..statistical.worlds import build, render
from .exact import meet_sphere, roundings, textbook_sphere, traced

Array = NDArray[np.float64]
MONTELIGHT = Path(__file__).parents[2] / "scenes" / "montelight"
RADIUS, HALF = 1e5, 50.0
AXES = [sign * axis for sign in (-1.0, 1.0) for axis in np.eye(3)]
GREY, WHITE = (0.5,) * 3, (1e6,) * 3


def balls(scene: et.Scene) -> tuple[Array, Array]:
    """Return centres (N, 3) and radii (N,) of a scene's shapes, all spheres."""
    shapes = [shape for shape in scene.model.shapes if isinstance(shape, Sphere)]
    assert len(shapes) == len(scene.model.shapes)
    return np.array([s.center for s in shapes]), np.array([s.radius for s in shapes])


def ball_rays(count: int, eye: Array) -> tuple[Array, Array]:
    """Return rays from all over the room; origins are places that float32 holds when counted from the camera."""
    rng = np.random.default_rng(11)
    origins = np.round(rng.uniform((5, 20, 5), (95, 60, 160), (count, 3)))
    return np.round((origins - eye) * 64) / 64 + eye, rng.normal(size=(count, 3))


@pytest.mark.parametrize("name", ["simple", "complex"])
def test_hit_points_are_the_exact_ones_rounded_once(name: str) -> None:
    scene = et.load(MONTELIGHT / f"{name}.toml")
    centers, radii = balls(scene)
    eye = np.asarray(scene.model.sensor.to_world)[:3, 3]
    origins, directions = ball_rays(1500, eye)
    hits = scene.core.intersect(origins, directions)
    unit = traced(directions)
    met = [
        [meet_sphere(o, d, c, r) for c, r in zip(centers, radii, strict=True)]
        for o, d in zip(origins, unit, strict=True)
    ]
    distance = np.array(
        [[np.inf if p is None else np.linalg.norm(p - o) for p in row] for row, o in zip(met, origins, strict=True)]
    )
    nearest = distance.argmin(axis=1)
    found = np.isfinite(distance.min(axis=1))
    np.testing.assert_array_equal(hits["shape"], np.where(found, nearest, -1))
    points = np.array([row[k] for row, k, ok in zip(met, nearest, found, strict=True) if ok])
    normals = (points - centers[nearest[found]]) / radii[nearest[found], None]
    slope = (normals * unit[found]).sum(axis=1)
    off = roundings(hits["p"][found] - eye, points - eye, slope, 4.0 * RADIUS)
    print(f"{name}: {found.sum()} hits, at most {off.max():.4f} of the rounding of the point")
    assert (nearest[found] < 5).mean() > 0.5
    assert off.max() <= 1.0


def test_the_mark_sees_a_sphere_solved_in_single_precision() -> None:
    """The power twin: the textbook quadratic in float32 puts no point on a wall where it is."""
    rng = np.random.default_rng(12)
    directions = traced(rng.normal(size=(200, 3)) * (1, 1, 0.2) + (0, 0, 1))
    center = np.array([0.0, 0.0, RADIUS + HALF])
    exact = np.array([meet_sphere(np.zeros(3), direction, center, RADIUS) for direction in directions])
    slope = directions[:, 2]
    off = roundings(textbook_sphere(directions, center, RADIUS), exact, slope, 4.0 * RADIUS)
    assert (~(off <= 1.0)).mean() > 0.9


def room(inside: bool, *, shine: bool, walls: int = 6) -> _core.Scene:
    """A room of grey walls with the camera in its middle, in the midst of light a million strong if they do not shine.

    The walls are balls that stand round the room, each with a light in it, or that the room is inside of.
    """

    def add(builder: _core.SceneBuilder) -> None:
        grey = builder.add_bsdf("diffuse", GREY)
        radiance = GREY if shine else None
        for axis in AXES[:walls]:
            center = axis * (HALF - RADIUS if inside else HALF + RADIUS)
            builder.add_sphere(center, RADIUS, flip_normals=inside, front=grey, back=grey, radiance=radiance)
            if not (shine or inside):
                builder.add_sphere(center, RADIUS / 2, flip_normals=False, front=None, back=None, radiance=WHITE)
        if not shine:
            builder.add_constant_environment(WHITE)

    return build(add, fov=110.0, size=(64, 64))


@pytest.mark.parametrize("technique", ["bsdf", "light", "mis"])
@pytest.mark.parametrize("inside", [False, True])
def test_no_light_comes_through_the_walls(inside: bool, technique: str) -> None:
    """Two million points in the room, all of them black."""
    film = render(room(inside, shine=False), 64, technique=technique, max_depth=8, roulette="none")
    assert film["mean"].max() == 0.0


def test_the_chink_that_a_missing_wall_leaves_is_seen() -> None:
    """The power twin: the other balls part slowly, so that the sky shows in a handful of pixels only."""
    film = render(room(False, shine=False, walls=5), 64, technique="bsdf", max_depth=8, roulette="none")
    assert film["mean"].max() > 0.0


@pytest.mark.parametrize("depth", [1, 2, 8])
@pytest.mark.parametrize("inside", [False, True])
def test_no_path_is_lost_at_the_walls(inside: bool, depth: int) -> None:
    """All walls shine with 1/2 and reflect 1/2: what a path of N surfaces brings is 1 - 2^-N, without any noise.

    Of ten million rays one runs along the crease of two walls, on both of them; with these numbers none does.
    """
    film = render(room(inside, shine=True), 64, technique="bsdf", max_depth=depth, roulette="none", sampler="sobol")
    np.testing.assert_allclose(film["mean"], 1.0 - 0.5**depth, rtol=1e-6)
    assert squared_deviations(film).max() < 1e-9
