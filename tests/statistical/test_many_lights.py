"""Hundreds of lights of every kind and of powers over six decades, picked alike, by power and by the light tree: one
expectation.

Seeds are fixed; 64 a strategy. All comparisons together have a false-alarm rate of 0.1 %, shared equally (Šidák). Each
must also tell apart a scene whose lights are 2 % brighter.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Final

import numpy as np
import pytest

from equaltime import _core
from equaltime._core import parts
from equaltime.statistics.agreement import LEVEL, BlockMeans, compare, share

from .worlds import affine, build, looking, render, turned

SEEDS: Final = 64
METAL: Final = ((0.2, 0.9, 1.1), (3.9, 2.4, 2.1), (1.0, 1.0, 1.0))
STRATEGIES: Final[dict[str, dict[str, Any]]] = {
    "tree": {"lights": "tree"},
    "tree, light": {"lights": "tree", "technique": "light"},
    "tree, balance, independent": {"lights": "tree", "heuristic": "balance", "sampler": "independent"},
    "power": {"lights": "power"},
    "uniform": {"lights": "uniform"},
}
SPP: Final = 64
EACH: Final = share(LEVEL, 2 * (len(STRATEGIES) - 1))


def lamps(builder: _core.SceneBuilder, sky: bool, light: float) -> None:
    """Add lamps in a cloud over the floor, so small that light is found by aiming at them."""
    rng = np.random.default_rng(1)
    for i in range(120):
        place, turn = rng.uniform([-3, 0.5, -3], [3, 2.5, 3]), turned(rng.standard_normal(3), rng.uniform(0, 360))
        size = 0.02 * 4.0 ** rng.uniform(-1, 1)
        radiance = light * rng.uniform(0.2, 1, 3) * 10.0 ** rng.uniform(-3, 3) / size**2 / 1e4
        faces: dict[str, Any] = {"flip_normals": bool(i % 2), "front": None, "back": None, "radiance": radiance}
        if i % 4 == 0:
            builder.add_rectangle(affine(*(size * turn), place), **faces)
        elif i % 4 == 1:
            builder.add_disk(affine(*(size * turn), place), **faces)
        elif i % 4 == 2:
            builder.add_sphere(place, size, **(faces | {"flip_normals": False}))
        else:
            builder.add_point_light(place, radiance * size**2)
    corners = rng.uniform([-3, 0.5, -3], [3, 2.5, 3], (300, 1, 3)) + rng.normal(0, 0.02, (300, 3, 3))
    builder.add_mesh(
        corners.reshape(-1, 3), np.arange(900).reshape(-1, 3), front=None, back=None, radiance=np.full(3, 4 * light)
    )
    if sky:
        builder.add_constant_environment(np.full(3, 0.02 * light))


def room(sky: bool, light: float = 1.0) -> _core.Scene:
    """Return a floor, a metal ball and a glass one under the lamps."""

    def things(builder: _core.SceneBuilder) -> None:
        grey = builder.add_bsdf("diffuse", [0.6, 0.5, 0.4])
        metal = builder.add_bsdf("roughconductor", "ggx", 0.3, 0.3, *METAL)
        glass = builder.add_bsdf("dielectric", 1.5, [1, 1, 1], [1, 1, 1])
        upwards = affine([4, 0, 0], [0, 0, -4], [0, 4, 0])
        builder.add_rectangle(upwards, flip_normals=False, front=grey, back=grey, radiance=None)
        builder.add_sphere([-0.8, 0.6, 0], 0.6, flip_normals=False, front=metal, back=None, radiance=None)
        builder.add_sphere([0.8, 0.6, 0.3], 0.6, flip_normals=False, front=glass, back=glass, radiance=None)

    camera = looking([0, 2, 7], [0, 0.6, 0], up=[0, 1, 0])
    return build(things, lambda b: lamps(b, sky, light), camera=camera, size=(32, 32))


Shoot = Callable[..., BlockMeans]


@pytest.fixture(scope="module")
def shoot() -> Shoot:
    """Return a function that gives the block means over a strategy's seeds, each rendered once."""

    @cache
    def means(strategy: str, sky: bool, light: float = 1.0) -> BlockMeans:
        scene = room(sky, light)
        first = 1000 * (1 + list(STRATEGIES).index(strategy)) + 500 * (light != 1.0)
        images = (render(scene, SPP, s, max_depth=4, **STRATEGIES[strategy]) for s in range(first, first + SEEDS))
        return BlockMeans.of_seeds((image["mean"][0] for image in images), 8)

    return means


@pytest.mark.slow
@pytest.mark.parametrize("sky", [False, True], ids=["lamps", "lamps and sky"])
@pytest.mark.parametrize("strategy", [s for s in STRATEGIES if s != "tree"])
def test_all_ways_to_pick_one_of_many_lights_agree(shoot: Shoot, strategy: str, sky: bool) -> None:
    agreement = compare(shoot("tree", sky), shoot(strategy, sky))
    assert agreement.p > EACH, agreement


@pytest.mark.slow
def test_lights_two_percent_brighter_are_told_apart(shoot: Shoot) -> None:
    twin = compare(shoot("tree", False, light=1.02), shoot("tree, light", False))
    assert twin.p < EACH, twin


@pytest.mark.parametrize("sky", [False, True], ids=["lamps", "lamps and sky"])
def test_the_light_that_falls_on_a_point_is_the_same_however_lights_are_picked(sky: bool) -> None:
    """The irradiance of a place that faces up, without shadows: a z-test of two means of a million samples."""
    scene, n = room(sky), 1_000_000
    places, normals = np.broadcast_to([1.5, 1e-3, 1.5], (n, 3)), np.broadcast_to([0.0, 1.0, 0.0], (n, 3))

    def estimate(lights: str, seed: int) -> tuple[float, float]:
        drawn = parts.sample_lights(scene, lights, places, seed, normals)
        cosine = np.maximum((drawn["wi"] * normals).sum(axis=1), 0.0)
        pdf = np.where(drawn["valid"], drawn["pdf"], 1.0)
        value = np.where(drawn["valid"], drawn["radiance"][:, 0] * cosine / pdf, 0.0)
        return float(value.mean()), float(value.var() / n)

    (tree, tree_variance), (power, power_variance) = estimate("tree", 1), estimate("power", 2)
    deviation = np.sqrt(tree_variance + power_variance)
    assert abs(tree - power) < 4.5 * deviation, (tree, power, deviation)
    assert abs(1.02 * tree - power) > 4.5 * deviation, "the twin"
    assert tree_variance < power_variance
