"""Weights of multiple importance sampling over all magnitudes that a density may have (cases S1, S2)."""

from __future__ import annotations

import numpy as np
import pytest

from equaltime._core import parts

PAIRS = 10.0 ** np.random.default_rng(1).uniform(-37.5, 38, (50_000, 2))


@pytest.mark.parametrize("heuristic", ["balance", "power"])
def test_the_weights_of_two_techniques_sum_to_one(heuristic: str) -> None:
    sums = [parts.mis_weight(heuristic, a, b) + parts.mis_weight(heuristic, b, a) for a, b in PAIRS]
    assert np.abs(np.array(sums) - 1.0).max() < 1e-6


@pytest.mark.parametrize("heuristic", ["balance", "power"])
def test_weights_are_those_of_the_formula(heuristic: str) -> None:
    power = 2.0 if heuristic == "power" else 1.0
    a, b = PAIRS.astype(np.float32).astype(np.longdouble).T
    exact = a**power / (a**power + b**power)
    got = np.array([parts.mis_weight(heuristic, x, y) for x, y in PAIRS])
    assert np.abs(got - exact).max() < 1e-6


def test_squares_of_densities_would_have_overflowed() -> None:
    """The twin: the formula as it is written, in float32, loses or doubles energy for densities such as these."""
    a, b = PAIRS.astype(np.float32).T
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        naive = a * a / (a * a + b * b) + b * b / (a * a + b * b)
    assert not (np.abs(naive - 1.0) < 1e-6).all()


def test_a_technique_that_cannot_draw_a_direction_has_no_weight_there() -> None:
    assert parts.mis_weight("power", 1.0, 0.0) == 1.0
    assert parts.mis_weight("balance", 1e-30, 0.0) == 1.0
