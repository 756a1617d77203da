"""Bias is told from variance: estimators that are wrong on purpose are found out, right ones are not.

All looks together have a false-alarm rate of 0.1 %; seeds are fixed.
"""

from __future__ import annotations

import runpy
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.statistics.agreement import LEVEL, equality_test, share

SCENES: Final = Path(__file__).parents[2] / "scenes"
FILE: Final = SCENES / "montelight" / "complex.toml"
ESTIMATORS: Final = runpy.run_path(str(SCENES / "experiments" / "wrong_estimators.py"))
WRONG: Final = ("choice_forgotten", "weights_above_one", "fixed_cone")
REPEATS, SPP, SIDE = 16, 8, 16
EACH: Final = share(LEVEL, len(WRONG) + 1)


@cache
def images(name: str, first_seed: int) -> NDArray[np.float32]:
    """Return the images (repeats, height, width, 3) of an estimator."""
    subject = ESTIMATORS[name](name)
    subject.prepare(et.load(FILE, light_radius=8.5).with_(size=(SIDE, SIDE), max_depth=4), 0)
    runs = (subject.run(seed, (SPP,), None) for seed in range(first_seed, first_seed + REPEATS))
    return np.stack([next(run).image for run in runs])


def test_light_sampling_alone_has_the_expectation_of_mis() -> None:
    assert equality_test(images("light_sampling", 100), images("mis", 200), block=4) > EACH


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_estimator_is_found_out(name: str) -> None:
    assert equality_test(images(name, 300), images("mis", 200), block=4) < EACH


@pytest.mark.parametrize("name", [*WRONG, "light_sampling"])
def test_no_strategy_leads_to_an_estimator_of_the_tests(name: str) -> None:
    with pytest.raises(et.StrategyError):
        et.Strategy.parse(name)
