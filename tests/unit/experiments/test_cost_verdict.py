"""The last sentence of an experiment: which numbers it takes, and what it says of them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from equaltime.experiments.analysis.verdict import pick_standard, verdict
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.curves import TYPICAL
from equaltime.statistics.intervals import UNKNOWN, Interval, product_mean

from .fake_summary import curve

TARGETS = (0.1, 0.05)
TIME = Interval(0.5, 0.4, 0.6)
FAR = Interval(2.0, 1.5, 2.5, reach=3.0).noted("extrapolated 3 times beyond the longest run")
RATIO = Interval(30.0, 25.0, 36.0)
FAR_RATIO = replace(RATIO, reach=900.0).noted("baseline: extrapolated 900 times beyond the longest run by slope -1/2")
AT_LEAST = FAR_RATIO.bounded("low", "baseline: heavy tail")


def strategy(label: str, times: tuple[Interval, ...], ratios: tuple[Interval, ...], gain: Interval) -> StrategyResult:
    return StrategyResult(
        label=label,
        name=label,
        renderer="core",
        biased=False,
        repeats=6,
        curve=curve(0.1),
        time_to=dict(zip(TARGETS, times, strict=True)),
        ratio=dict(zip(TARGETS, ratios, strict=True)),
        efficiency=gain,
        error_at_budget=UNKNOWN,
        fewer_samples=UNKNOWN,
        equality_p=None,
        bias=None,
        notes=(),
        image=None,
    )


def scene(times: tuple[Interval, ...], ratios: tuple[Interval, ...], efficiency: Interval = UNKNOWN) -> SceneResult:
    nothing = (UNKNOWN, UNKNOWN)
    strategies = (strategy("naive", nothing, nothing, UNKNOWN), strategy("best", times, ratios, efficiency))
    return SceneResult("box", "abc", (8, 8), 8, 0.01, "naive", "best", 1.0, strategies)


def said(*arguments: tuple[Interval, ...], efficiency: Interval = UNKNOWN) -> str:
    return verdict([scene(*arguments, efficiency=efficiency)], TARGETS)


def test_the_smallest_error_within_the_runs_comes_first() -> None:
    assert said((TIME, TIME), (RATIO, RATIO)).startswith(
        "best: 5 % in 0.5 s [0.4, 0.6], 30\N{MULTIPLICATION SIGN} [25, 36] "
    )
    assert said((TIME, FAR), (RATIO, RATIO)).startswith("best: 10 % in 0.5 s")


def test_a_measured_time_beats_one_beyond_the_runs_even_if_the_baseline_is() -> None:
    sentence = said((TIME, FAR), (FAR_RATIO, RATIO))
    assert sentence.startswith("best: 10 % in 0.5 s")
    assert sentence.endswith("faster than naive; naive is extrapolated, 900\N{MULTIPLICATION SIGN} beyond the runs")
    assert said((UNKNOWN, FAR), (FAR_RATIO, RATIO)).endswith(
        "; partly extrapolated, 3\N{MULTIPLICATION SIGN} beyond the runs"
    )


def test_of_a_baseline_with_a_heavy_tail_the_lower_end_is_said() -> None:
    sentence = said((TIME, UNKNOWN), (AT_LEAST, UNKNOWN))
    assert "at least 25\N{MULTIPLICATION SIGN} faster than naive" in sentence
    assert sentence.endswith("beyond the runs; how much more is not known")
    assert "30" not in sentence


def test_scenes_of_which_something_is_known_are_counted_and_a_single_one_is_named() -> None:
    known, unknown = scene((TIME, TIME), (FAR_RATIO, FAR_RATIO)), scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN))
    one = verdict([known, unknown], TARGETS)
    assert " faster than naive on box (1 of 2 scenes); " in one
    assert one.endswith("extrapolated, 900\N{MULTIPLICATION SIGN} beyond the runs")
    two = verdict([known, known, unknown], TARGETS)
    assert " (geometric means of 2 of 3 scenes); " in two
    assert two.endswith(" up to 900\N{MULTIPLICATION SIGN} beyond the runs")


def test_an_interval_beats_a_lower_end_at_a_smaller_error() -> None:
    assert "[25, 36]" in said((FAR, TIME), (FAR_RATIO, AT_LEAST))


def test_a_ratio_whose_upper_end_alone_is_sound_is_not_said() -> None:
    assert "cannot be told" in said((TIME, TIME), (RATIO.bounded("high", "heavy"), UNKNOWN))


def test_if_nothing_else_can_be_told_typical_runs_are() -> None:
    heavy = FAR.bounded("low", "heavy tail: a pixel")
    sentence = said((heavy, heavy), (UNKNOWN, UNKNOWN), efficiency=Interval(800.0, 300.0, 2000.0))
    times = "\N{MULTIPLICATION SIGN}"
    assert sentence.startswith(f"typical runs of best are 800{times} [300, 2e+03] as efficient as those of naive")
    assert "no strategy's time to a wanted error can be told" in sentence
    assert "heavy tail" in sentence


def test_of_typical_runs_the_sentence_says_so() -> None:
    typical = RATIO.noted(f"baseline: {TYPICAL}; heavy tail")
    assert said((TIME, TIME), (typical, typical)).endswith(
        "[25, 36] faster than naive; typical runs: the median of repeats, since few events make most of the error"
    )
    assert "typical" not in said((TIME, TIME), (RATIO, RATIO))


def test_a_time_without_a_ratio_stands_alone() -> None:
    assert "cannot be told" in said((TIME, TIME), (UNKNOWN, UNKNOWN))
    assert said((TIME, TIME), (UNKNOWN, UNKNOWN), efficiency=RATIO).startswith(
        "best: 5 % in 0.5 s [0.4, 0.6]; typical runs"
    )


def test_without_best_the_unbiased_strategy_that_errs_least_is_the_standard() -> None:
    assert pick_standard(("a", "best"), (False, False), (0.1, 0.2)) == "best"
    assert pick_standard(("a", "b", "c"), (True, False, False), (0.1, 0.3, 0.2)) == "c"
    assert pick_standard(("a", "b"), (False, False), (math.nan, 0.2)) == "b"
    assert pick_standard(("a",), (True,), (0.1,)) is None


def test_scenes_are_joined_by_the_geometric_mean() -> None:
    joined = product_mean([Interval(2.0, 1.0, 4.0), Interval(8.0, 4.0, 16.0)])
    half = 2.0 ** (math.sqrt(2.0) / 2.0)
    assert (joined.value, joined.low, joined.high) == pytest.approx((4.0, 4.0 / half, 4.0 * half))


def test_a_mean_of_lower_ends_is_one() -> None:
    heavy = Interval(8.0, 4.0, 16.0).bounded("low", "heavy")
    assert product_mean([Interval(2.0, 1.0, 4.0), heavy]).bound == "low"
    assert product_mean([Interval(2.0, 1.0, 4.0), heavy.doubted("few")]).bound == ""
