"""Verdicts about bias and about samples."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.experiments.analysis.strategy_runs import StrategyRuns, efficiency, fewer_samples
from equaltime.experiments.analysis.verdict import bias_verdict, efficiency_verdict, samples_verdict, verdict
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.intervals import UNKNOWN, Interval

from .fake_summary import curve
from .made_up_runs import SPP, power_law

TIMES = "\N{MULTIPLICATION SIGN}"


def strategy(
    label: str, p: float | None = None, bias: Interval | None = None, fewer: Interval = UNKNOWN
) -> StrategyResult:
    return StrategyResult(
        label=label,
        name=label,
        renderer="core",
        biased=False,
        repeats=6,
        curve=curve(0.1),
        time_to={0.1: UNKNOWN},
        ratio={0.1: UNKNOWN},
        efficiency=UNKNOWN,
        error_at_budget=UNKNOWN,
        fewer_samples=fewer,
        equality_p=p,
        unequal=p is not None and p < LEVEL,
        bias=bias,
        notes=() if p is not None else ("one repeat",),
        image=None,
    )


def scene(*others: StrategyResult, name: str = "box") -> SceneResult:
    return SceneResult(name, "abc", (8, 8), 8, 0.01, "right", "right", 1.0, (strategy("right"), *others))


def test_the_biased_are_named_with_their_bias_and_the_right_ones_too() -> None:
    found = bias_verdict([scene(strategy("wrong", 1e-9, Interval(0.2, 0.19, 0.21)), strategy("same", 0.4))], LEVEL)
    assert found == "found biased at a level of 0.1 %, held against right: wrong by 20 % [19, 21]; not: same"


def test_a_bias_that_the_reference_cannot_show_has_no_size() -> None:
    assert "wrong; not: none" in bias_verdict([scene(strategy("wrong", 1e-9, Interval(0.02, -0.01, 0.03)))], LEVEL)


def test_what_cannot_be_tested_is_neither() -> None:
    assert bias_verdict([scene(strategy("lone"))], LEVEL).endswith("not: none; not to be told: lone (one repeat)")


def test_of_several_scenes_each_is_named() -> None:
    scenes = [scene(strategy("wrong", 1e-9), name=name) for name in ("box", "ball")]
    assert "wrong on box, wrong on ball" in bias_verdict(scenes, LEVEL)


@pytest.mark.parametrize(
    ("fewer", "said"),
    [
        (Interval(6.4, 6.3, 6.5), f"6.4{TIMES} [6.3, 6.5] fewer"),
        (Interval(0.25, 0.2, 0.5), f"4{TIMES} [2, 5] more"),
        (Interval(0.25, 0.2, 0.5).bounded("high", "this: heavy"), f"at least 2{TIMES} more"),
        (Interval(6.4, 6.3, 6.5).bounded("low", "baseline: heavy"), f"at least 6.3{TIMES} fewer"),
        (Interval(6.4, 6.3, 6.5).doubted("2 repeats"), "not to be told (2 repeats)"),
        (Interval(math.inf, math.inf, math.inf), "needs one, being exact"),
    ],
)
def test_samples_are_said_as_ratios(fewer: Interval, said: str) -> None:
    assert samples_verdict([scene(strategy("x", fewer=fewer))]) == f"samples to the same error, against right: x {said}"


def with_efficiency(label: str, *numbers: float) -> StrategyResult:
    return replace(strategy(label), efficiency=Interval(*numbers) if numbers else UNKNOWN.doubted("few repeats"))


def test_efficiency_is_told_over_all_scenes_the_standard_first() -> None:
    box = scene(with_efficiency("split", 1.0, 0.5, 2.0), with_efficiency("best", 4.0, 2.0, 8.0), name="box")
    ball = scene(with_efficiency("split"), with_efficiency("best", 0.25, 0.2, 0.5), name="ball")
    scenes = [replace(one, standard="best") for one in (box, ball)]
    assert efficiency_verdict(scenes) == (
        f"squared error {TIMES} time, of typical runs, against right (geometric means): "
        f"best 1{TIMES} [0.695, 1.63] less (ball: 4{TIMES} [2, 5] more; box: 4{TIMES} [2, 8] less), "
        f"split 1{TIMES} [0.5, 2] less on 1 of 2 scenes"
    )


def test_efficiency_on_one_scene_has_no_mean() -> None:
    found = efficiency_verdict([scene(with_efficiency("x", 2.0, 1.5, 3.0), with_efficiency("y"))])
    assert found == (
        f"squared error {TIMES} time, of typical runs, against right: "
        f"x 2{TIMES} [1.5, 3] less, y not to be told (few repeats)"
    )


def test_an_experiment_chooses_its_question() -> None:
    scenes = [scene(strategy("x", 0.4, fewer=Interval(2.0, 1.9, 2.1)))]
    assert verdict(scenes, [0.1], "bias").startswith("found biased at a level of 0.1 %")
    assert verdict(scenes, [0.1], "samples").startswith("samples to the same error")
    assert verdict(scenes, [0.1], "efficiency").startswith(f"squared error {TIMES} time")


def runs(factor: float, seed: int, spp: NDArray[np.float64] = SPP) -> StrategyRuns:
    made = power_law(seed=seed)
    made = replace(made, relmse=factor * made.relmse[:, : len(spp)], seconds=made.seconds[:, : len(spp)])
    return StrategyRuns(str(seed), (), Path(), tuple(map(int, spp)), made)


def test_samples_are_compared_at_the_most_that_both_have() -> None:
    found = fewer_samples(runs(4.0, 1), runs(1.0, 2, SPP[:4]))
    assert found.low < 4.0 < found.high < 4.3
    assert not fewer_samples(runs(4.0, 1), replace(runs(1.0, 2), spp=(3, 5))).known


def test_what_has_no_error_needs_no_samples_and_a_bias_is_not_compared() -> None:
    assert math.isinf(fewer_samples(runs(4.0, 1), runs(0.0, 2)).value)
    cut = runs(1.0, 2)
    assert not fewer_samples(runs(4.0, 1), replace(cut, runs=replace(cut.runs, biased=True))).known


def test_errors_beyond_all_reason_leave_no_traceback() -> None:
    """Their quotient, and their product with a time, are beyond float64."""
    vast, tiny = runs(1e300, 1), runs(1e-300, 2)
    assert fewer_samples(vast, tiny).value == math.inf
    assert fewer_samples(tiny, vast).value == 0.0
    assert efficiency(vast.runs, tiny.runs).value == math.inf
    assert efficiency(tiny.runs, vast.runs).value == 0.0
