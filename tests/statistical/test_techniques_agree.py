"""However paths are sampled, their images have one expectation: all techniques, heuristics, light choices, roulettes
and number generators against the default, block by block.

Seeds are fixed; 64 a strategy, and no two strategies share one. All comparisons together have a false-alarm rate of
0.1 %. Each strategy must also be told apart from the default in a slightly wrong scene.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Final

import pytest

from equaltime.statistics.agreement import LEVEL, BlockMeans, compare, share

from .changed import changed
from .stages import NAMES, stage
from .worlds import render

BLOCK: Final = 8
SEEDS: Final = 64
BEST: Final = "best"
STRATEGIES: Final[dict[str, dict[str, Any]]] = {
    BEST: {},
    "bsdf": {"technique": "bsdf"},
    "light": {"technique": "light"},
    "balance": {"heuristic": "balance"},
    "lights alike": {"lights": "uniform"},
    "lights by the tree": {"lights": "tree"},
    "independent": {"sampler": "independent"},
    "no roulette": {"roulette": "none"},
    "early roulette": {"roulette_depth": 1},
    "bsdf, independent, early roulette": {"technique": "bsdf", "sampler": "independent", "roulette_depth": 1},
    "light, lights alike": {"technique": "light", "lights": "uniform"},
    "light, lights by the tree": {"technique": "light", "lights": "tree"},
    "constant roulette": {"roulette": "constant", "survival": 0.9, "roulette_depth": 1},
    "albedo roulette": {"roulette": "albedo", "roulette_depth": 1},
    "uniform": {"technique": "uniform"},
    "stratified": {"sampler": "stratified"},
    "lattice": {"sampler": "lattice"},
    "naive": {"technique": "uniform", "lights": "uniform", "roulette": "albedo", "sampler": "independent"},
    "mixture": {"technique": "mixture"},
    "compensated": {"environment": "compensated"},
    "mixture, compensated": {"technique": "mixture", "environment": "compensated"},
    "mixture, lights alike": {"technique": "mixture", "lights": "uniform", "sampler": "independent"},
    "efficiency": {"roulette": "efficiency", "roulette_depth": 1},
    "efficiency, independent": {"roulette": "efficiency", "sampler": "independent"},
    "efficiency, lattice": {"roulette": "efficiency", "sampler": "lattice"},
    "efficiency, light": {"roulette": "efficiency", "technique": "light", "sampler": "stratified"},
}
NOISY: Final = frozenset(s for s in STRATEGIES if s.startswith(("bsdf", "uniform", "naive")))
"""These never aim at a light; they get more samples and a coarser twin."""


def suits(name: str, strategy: str) -> bool:
    """Return whether a strategy that never aims at lights gets a scene whose lights it meets often enough."""
    return name != ("veach" if strategy in NOISY else "veach without its small light")


PAIRS: Final = [(name, s) for name in NAMES for s in STRATEGIES if s != BEST and suits(name, s)]
EVERYDAY: Final = {("cornell", "light"), ("cornell", "early roulette"), ("cornell", "efficiency")}
"""Besides all strategies in one scene."""
EACH: Final = share(LEVEL, len(PAIRS))

Shoot = Callable[..., BlockMeans]


def everyday(name: str, strategy: str) -> bool:
    return name == "sky" or (name, strategy) in EVERYDAY


CASES: Final = [pytest.param(*pair, marks=() if everyday(*pair) else pytest.mark.slow) for pair in PAIRS]


@pytest.fixture(scope="module")
def shoot(tmp_path_factory: pytest.TempPathFactory) -> Shoot:
    """Return a function that gives the block means over a strategy's seeds, each rendered once."""
    folder = tmp_path_factory.mktemp("images")

    @cache
    def means(name: str, strategy: str, light: float = 1.0, reflectance: float = 1.0) -> BlockMeans:
        scene = stage(name, folder)
        core = changed(scene, light=light, reflectance=reflectance)
        first = 1000 * (1 + list(STRATEGIES).index(strategy)) + 500 * ((light, reflectance) != (1.0, 1.0))
        settings = {"max_depth": scene.max_depth, **STRATEGIES[strategy]}
        spp = 128 if strategy in NOISY and name != "sky" else 16
        return BlockMeans.of_seeds(
            (render(core, spp, seed, **settings)["mean"][0] for seed in range(first, first + SEEDS)), BLOCK
        )

    return means


@pytest.mark.parametrize(("name", "strategy"), CASES)
def test_strategies_agree(shoot: Shoot, name: str, strategy: str) -> None:
    agreement = compare(shoot(name, BEST), shoot(name, strategy))
    assert agreement.p > EACH, agreement
    brighter = 1.05 if strategy in NOISY else 1.02
    twin = compare(shoot(name, BEST, light=brighter), shoot(name, strategy))
    assert twin.p < EACH, f"the twin, brighter lights: {twin}"


def test_walls_that_reflect_two_percent_more_are_seen(shoot: Shoot) -> None:
    twin = compare(shoot("cornell", BEST, reflectance=1.02), shoot("cornell", "light"))
    assert twin.p < EACH, twin
