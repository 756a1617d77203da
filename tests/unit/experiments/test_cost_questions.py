"""Verdicts about bias and about samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.experiments.analysis import combination, questions
from equaltime.experiments.analysis.disagreement import reason, withheld
from equaltime.experiments.analysis.sentences import LONGEST, Answer
from equaltime.experiments.analysis.strategy_runs import StrategyRuns, efficiency, fewer_samples
from equaltime.experiments.analysis.summarise import _bias as bias_of
from equaltime.experiments.analysis.verdict import verdict as answer_of
from equaltime.experiments.model.experiment import Question
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.images.bias_variance import BiasVariance
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.curves import BELOW, error_curve, second_curve
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.statistics.runs import TYPICAL, Runs

from .fake_summary import curve
from .made_up_runs import SPP, power_law


def whole(found: Answer) -> str:
    """Return a verdict with all of its notes."""
    assert len(found.text) <= LONGEST
    return " ".join((found.text, *found.notes))


def verdict(scenes: Sequence[SceneResult], targets: Sequence[float], question: Question = "time") -> str:
    return whole(answer_of(scenes, targets, question))


def bias_verdict(scenes: Sequence[SceneResult], level: float) -> str:
    return whole(questions.bias_verdict(scenes, level))


def samples_verdict(scenes: Sequence[SceneResult]) -> str:
    return whole(questions.samples_verdict(scenes))


def efficiency_verdict(scenes: Sequence[SceneResult]) -> str:
    return whole(questions.efficiency_verdict(scenes))


def combination_verdict(scenes: Sequence[SceneResult]) -> str:
    return whole(combination.combination_verdict(scenes))


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
    assert found == (
        "Wrong picture, however long it renders: wrong is 20 % off (19 to 21). No bias was found in same. "
        "Compared with right; the risk of a false alarm is 0.1 %."
    )


@pytest.mark.parametrize("question", ["bias", "samples", "efficiency"])
def test_a_verdict_on_many_strategies_names_a_few_and_counts_the_others(question: Question) -> None:
    many = [
        replace(strategy(f"depth {depth}", 1e-9, Interval(0.2, 0.19, 0.21), exactly(2.0)), efficiency=exactly(2.0))
        for depth in range(20)
    ]
    found = answer_of([scene(*many)], (0.1,), question)
    assert len(found.text) <= LONGEST
    named = found.text.count("depth")
    assert 2 < named < 20
    assert found.text.endswith(f", and {20 - named} more.")
    assert found.notes[0].startswith("In full: depth 0 ")
    assert found.notes[0].count("depth") == 20


def test_the_notes_of_a_bias_name_what_was_not_found() -> None:
    found = answer_of(
        [scene(strategy("wrong", 1e-9, Interval(0.2, 0.19, 0.21)), strategy("same", 0.4))], (0.1,), "bias"
    )
    assert found.text == "Wrong picture, however long it renders: wrong is 20 % off (19 to 21)."
    assert found.notes[0] == "No bias was found in same."
    assert answer_of([scene(strategy("same", 0.4))], (0.1,), "bias").text == "No bias was found in same."


def test_a_bias_that_was_not_found_has_its_largest_size() -> None:
    found = bias_verdict([scene(strategy("same", 0.4, Interval(0.01, -0.02, 0.057)), strategy("other", 0.4))], LEVEL)
    assert found.startswith("No bias was found in same (at most 5.7 %) and other. ")


def test_strategies_that_are_tested_despite_a_heavy_tail_are_named_with_the_reason() -> None:
    heavy = replace(strategy("heavy", 0.4), tail_share=0.03)
    said = "Compared despite a heavy tail: heavy; an experiment with question = "
    assert said in bias_verdict([scene(heavy, strategy("same", 0.4))], LEVEL)
    assert "heavy tail" not in bias_verdict([scene(strategy("same", 0.4))], LEVEL)


def test_paths_that_are_cut_are_named_as_the_cause() -> None:
    cut = replace(strategy("depth 2", 1e-9, Interval(0.6, 0.59, 0.61)), name="best,truncate=2")
    assert bias_verdict([scene(cut)], LEVEL).startswith(
        "Cutting paths makes the picture wrong, however long it renders: depth 2 is 60 % off (59 to 61). "
    )


def test_a_bias_that_the_reference_cannot_show_has_no_size() -> None:
    assert "renders: wrong (how much is not known). Comp" in bias_verdict(
        [scene(strategy("wrong", 1e-9, Interval(0.02, -0.01, 0.03)))], LEVEL
    )


def test_what_cannot_be_tested_is_neither() -> None:
    assert bias_verdict([scene(strategy("lone"))], LEVEL) == "Not tested: lone (one repeat)."


def test_of_several_scenes_each_is_named() -> None:
    scenes = [scene(strategy("wrong", 1e-9), name=name) for name in ("box", "ball")]
    assert "wrong on box (how much is not known), wrong on ball" in bias_verdict(scenes, LEVEL)


@pytest.mark.parametrize(
    ("fewer", "said"),
    [
        (Interval(6.4, 6.3, 6.5), "needs 6.4 times fewer samples (6.3 to 6.5)"),
        (Interval(0.25, 0.2, 0.5), "needs 4 times more samples (2 to 5)"),
        (Interval(0.25, 0.2, 0.5).bounded("high", "this: heavy"), "needs at least 2 times more samples"),
        (Interval(6.4, 6.3, 6.5).bounded("low", "baseline: heavy"), "needs at least 6.3 times fewer samples"),
        (Interval(6.4, 6.3, 6.5).doubted("2 repeats"), "cannot be told (2 repeats)"),
        (Interval(math.inf, math.inf, math.inf), "needs one sample (it is exact)"),
    ],
)
def test_samples_are_said_as_ratios(fewer: Interval, said: str) -> None:
    found = questions.samples_verdict([scene(strategy("x", fewer=fewer))])
    assert found.text == f"For the same error, compared with right: x {said}."


def with_efficiency(label: str, *numbers: float) -> StrategyResult:
    return replace(strategy(label), efficiency=Interval(*numbers) if numbers else UNKNOWN.doubted("few repeats"))


def part(technique: str, fewer: Interval, gain: Interval) -> StrategyResult:
    """Return a strategy of one technique; both ratios are the baseline's squared error over its own."""
    return replace(strategy(technique, fewer=fewer), name=f"best,technique={technique}", efficiency=gain)


def exactly(value: float) -> Interval:
    return Interval(value, 0.9 * value, 1.1 * value)


def test_a_combination_is_compared_with_the_better_of_its_parts_on_the_worst_scene() -> None:
    smooth = scene(part("bsdf", exactly(1.2), exactly(1.5)), part("light", exactly(0.01), exactly(0.02)), name="smooth")
    rough = scene(part("bsdf", exactly(0.1), exactly(0.2)), part("light", exactly(1.1), exactly(2.0)), name="rough")
    assert combination_verdict([smooth, rough]) == (
        "Compared with the better of bsdf and light, right has at worst 1.2 times the squared error at equal samples "
        "(1.08 to 1.32), against bsdf on smooth. At equal time, right has at worst 2 times the squared error "
        "(1.8 to 2.2), against light on rough. Equal samples: at 32 a pixel, the largest count that both have. "
        "At equal time, bsdf alone has 5 times (its worst scene: rough) and light alone has 50 times (its worst scene: "
        "smooth) the squared error of right."
    )
    assert verdict([smooth], [0.1], "combination") == (
        "Compared with the better of bsdf and light, right has 1.2 times the squared error at equal samples "
        "(1.08 to 1.32), against bsdf. At equal time, right has 1.5 times the squared error (1.35 to 1.65), "
        "against bsdf. Equal samples: at 32 a pixel, the largest count that both have. "
        "At equal time, bsdf alone has 0.667 times and light alone has 50 times the squared error of right."
    )


def test_equal_samples_have_their_counts() -> None:
    short = part("bsdf", exactly(1.2), exactly(1.5))
    short = replace(short, curve=replace(short.curve, spp=(2, 4, 8, 5000)))  # the baseline has 2, 4, 8, 16, 32
    box, ball = scene(short, name="box"), scene(part("bsdf", exactly(1.1), exactly(1.2)), name="ball")
    told = "Equal samples: at 8 to 32 a pixel, the largest count that both have on a scene."
    assert told in combination_verdict([box, ball])
    few = strategy("few", fewer=exactly(2.0))
    assert samples_verdict([scene(few)]).endswith("Equal samples: at 32 a pixel, the largest count that both have.")
    alone = replace(few, curve=replace(few.curve, spp=(3,)))
    assert "Equal samples" not in samples_verdict([scene(alone)])


def test_an_interval_that_includes_1_shows_no_loss_unless_another_scene_does() -> None:
    open_one = scene(part("bsdf", Interval(1.4, 0.9, 1.7), exactly(2.0)), name="open")
    worse = scene(part("bsdf", exactly(1.3), exactly(2.0)), name="worse")
    first = "right has at worst 1.4 times the squared error at equal samples (0.9 to 1.7), against bsdf on open"
    assert f"{first}; this interval includes 1." in combination_verdict([open_one, worse])
    assert f"{first}; right is not shown to be worse on any scene." in combination_verdict([open_one, open_one])
    assert "against bsdf; right is not shown to be worse. At" in combination_verdict([open_one])


def test_a_scene_where_the_better_part_is_open_does_not_count() -> None:
    doubted = exactly(3.0).doubted("few repeats")
    behind = exactly(0.2).bounded("high", "this: heavy")
    known = scene(part("bsdf", exactly(1.2), behind), part("light", behind, behind), name="known")
    unknown = scene(part("bsdf", doubted, doubted), part("light", exactly(9.0), exactly(9.0)), name="unknown")
    found = combination_verdict([known, unknown])
    assert "1.2 times the squared error at equal samples (1.08 to 1.32), against bsdf on known. " in found
    assert "right has at most 0.22 times the squared error, against bsdf on known. " in found
    assert " Not known on unknown (few repeats). " in found
    assert "time, bsdf alone has at least 4.55 times (its worst scene: known) and light alone has at least 4.5" in found
    assert combination_verdict([unknown]).startswith(
        "Compared with the better of bsdf and light, the squared error of right cannot be compared at equal samples. "
        "At equal time, the squared error of right cannot be compared. Not known on unknown (few repeats)."
    )
    hidden = exactly(3.0).noted(TYPICAL).doubted(f"this: heavy; baseline: {BELOW}")
    apart = scene(part("bsdf", exactly(1.2), hidden), name="apart")
    assert (
        f" Not known at equal time on apart (right: {BELOW.partition('; ')[0]}). " in f"{combination_verdict([apart])} "
    )
    many = [scene(part("bsdf", doubted, doubted), name=str(number)) for number in range(5)]
    assert " Not known on 0 (few repeats), 1 (few repeats), 2 (few repeats) and 2 more." in combination_verdict(many)


def test_a_combination_says_which_ratios_are_of_typical_runs() -> None:
    said = "Where a few rare events make most of an error, the ratios are those of typical runs."
    heavy = scene(part("bsdf", exactly(1.2), exactly(1.5).noted(TYPICAL)))
    assert combination_verdict([heavy]).endswith(f"the squared error of right. {said}")
    assert said not in combination_verdict([scene(part("bsdf", exactly(1.2), exactly(1.5)))])


def test_only_strategies_of_one_technique_are_parts() -> None:
    other = replace(part("bsdf", exactly(9.0), exactly(9.0)), renderer="mitsuba")
    assert combination_verdict([scene(part("mixture", exactly(9.0), exactly(9.0)), other)]) == (
        "right has no parts to compare with: no other strategy has the technique bsdf, light or uniform."
    )


def test_efficiency_is_told_over_all_scenes_the_standard_first() -> None:
    box = scene(with_efficiency("split", 1.0, 0.5, 2.0), with_efficiency("best", 4.0, 2.0, 8.0), name="box")
    ball = scene(with_efficiency("split"), with_efficiency("best", 0.25, 0.2, 0.5), name="ball")
    scenes = [replace(one, standard="best") for one in (box, ball)]
    assert efficiency_verdict(scenes) == (
        "For the same error, compared with typical runs of right, on average over 2 scenes (geometric mean): "
        "best needs 1 times the time (0.6 to 1.4), from 4 times more on ball to 4 times less on box, "
        "split needs 1 times the time (0.5 to 2) on 1 of 2 scenes."
    )


def test_efficiency_on_one_scene_has_no_mean() -> None:
    found = efficiency_verdict([scene(with_efficiency("x", 2.0, 1.5, 3.0), with_efficiency("y"))])
    assert found == (
        "For the same error, compared with typical runs of right: "
        "x needs about 2 times less time (1.5 to 3), y cannot be told (few repeats)."
    )


def test_an_experiment_chooses_its_question() -> None:
    scenes = [scene(strategy("x", 0.4, fewer=Interval(2.0, 1.9, 2.1)))]
    assert verdict(scenes, [0.1], "bias").startswith("No bias was found in x.")
    assert "times fewer samples" in verdict(scenes, [0.1], "samples")
    assert verdict(scenes, [0.1], "efficiency").startswith("For the same error")


def runs(factor: float, seed: int, spp: NDArray[np.float64] = SPP) -> StrategyRuns:
    made = power_law(seed=seed)
    made = replace(made, relmse=factor * made.relmse[:, : len(spp)], seconds=made.seconds[:, : len(spp)])
    return StrategyRuns(str(seed), (), Path(), tuple(map(int, spp)), made)


def test_samples_are_compared_at_the_most_that_both_have() -> None:
    found = fewer_samples(runs(4.0, 1), runs(1.0, 2, SPP[:4]))
    assert found.low < 4.0 < found.high < 4.3
    assert not fewer_samples(runs(4.0, 1), replace(runs(1.0, 2), spp=(3, 5))).known


def test_an_error_that_the_reference_hides_makes_samples_a_bound() -> None:
    seen = runs(1.0, 1)
    shared = 0.1 * float(seen.runs.relmse[0, -1])
    hidden = replace(seen, runs=replace(seen.runs, relmse=seen.runs.relmse / 400.0, shared=shared))
    seen = replace(seen, runs=replace(seen.runs, shared=shared))
    more, less = fewer_samples(seen, hidden), fewer_samples(hidden, seen)
    assert (more.bound, less.bound) == ("low", "high")
    assert 1.0 < more.low < 10.0
    assert less.high < 1.0


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


def test_another_picture_is_told_whatever_the_question() -> None:
    """A strategy that is biased by name says so itself, and one that the test lets pass is not named."""
    other, same = strategy("other", 1e-9, fewer=Interval(2.0, 1.5, 2.5)), strategy("same", 0.4)
    cut = replace(strategy("cut", 1e-9), biased=True)
    other, dark = (replace(other, label=label, renderer=by) for label, by in (("other", "command"), ("dark", "core")))
    for question in ("time", "samples", "efficiency", "combination"):
        said = verdict([scene(other, same, cut)], (0.1,), question)
        assert said.endswith(" Not the picture of right: other (p < 0.0001).")
        said = verdict([scene(dark, same, cut)], (0.1,), question)
        assert said.endswith(" Unlike right, by a bias or because few samples met some light: dark (p < 0.0001).")
        assert "Not the picture" not in verdict([scene(same, cut)], (0.1,), question)


OFF = Interval(0.099, 0.098, 0.1)


def test_a_renderer_that_failed_its_test_of_agreement_is_told_whatever_the_question() -> None:
    """How far its picture is off, and which errors and times it does not get, also without a second test."""
    mine = replace(strategy("mine", fewer=Interval(2.0, 1.5, 2.5)), renderer="command", agreement_p=0.0, difference=OFF)
    mine = replace(mine, name="mine --filter {filter}")
    told = "Not the picture of equaltime: mine is 9.9 % off (9.8 to 10). "
    told += "No error below 50 % and no time to one is given for it."
    for question in ("time", "samples", "efficiency", "combination", "bias"):
        assert verdict([scene(mine, strategy("same", 0.4))], (0.1,), question).endswith(f" {told}")
    assert bias_verdict([scene(mine)], LEVEL) == told
    unequal = replace(mine, equality_p=1e-9, unequal=True)
    assert verdict([scene(unequal)], (0.1,)).count("Not the picture") == 1


def test_several_renderers_that_failed_are_told_with_their_scenes() -> None:
    bound = OFF.bounded("high", "the picture differs, and by no more than this")
    known = replace(strategy("mine"), renderer="command", agreement_p=1e-9, difference=bound)
    unknown = replace(known, label="theirs", difference=UNKNOWN)
    said = verdict([scene(known), scene(unknown, name="room")], (0.1,))
    assert "mine on box is off by up to 10 %, theirs on room (p < 0.0001). Such runs need a box filter" in said
    assert "the scene's own; {filter} in a command stands for it. Errors below 5 times the difference" in said
    assert verdict([scene(unknown)], (0.1,)).endswith("No error and no time is given for it.")


def test_a_renderer_that_is_given_the_box_filter_gets_no_hint_on_it() -> None:
    mine = replace(strategy("mine"), renderer="command", agreement_p=1e-9, difference=OFF)
    for command, hint in (("mine {scene}", True), ("mine {json}", False), ("mine {scene} {filter}", False)):
        assert ("box filter" in verdict([scene(replace(mine, name=command))], (0.1,))) == hint


def test_an_error_below_a_renderers_own_reference_is_not_for_want_of_a_better_one() -> None:
    below = UNKNOWN.doubted(BELOW)
    mine = replace(strategy("mine"), renderer="command", agreement_p=1e-9, difference=OFF, error_at_budget=below)
    found = withheld(replace(mine, time_to={0.6: below}, ratio={0.6: below}), None)
    for number in (found.error_at_budget, found.time_to[0.6], found.ratio[0.6]):
        assert number.note == reason(OFF)


@pytest.mark.parametrize("difference", [OFF, UNKNOWN])
def test_an_unknown_error_of_a_renderer_with_another_picture_is_unknown_for_that_reason(difference: Interval) -> None:
    """Not because no run is near that time, which longer runs would mend."""
    mine = replace(strategy("mine"), renderer="command", agreement_p=1e-9, difference=difference)
    found = withheld(replace(mine, error_at_budget=UNKNOWN.doubted("no run is near that time")), None)
    assert found.error_at_budget.note == reason(difference)


def test_a_renderer_that_differs_from_the_standard_alone_is_told_with_its_bias() -> None:
    other = replace(strategy("other", 1e-9, OFF), renderer="command")
    assert verdict([scene(other)], (0.1,)).endswith(" Not the picture of right: other is 9.9 % off (9.8 to 10).")


def test_samples_of_typical_runs_are_not_those_of_the_mean() -> None:
    ratio = Interval(0.025, 0.016, 0.029)
    typical = samples_verdict([scene(strategy("opposite", fewer=ratio.noted(TYPICAL)))])
    assert (
        "opposite needs 40 times more samples (34 to 62) by typical runs of both with 32 samples, without rare"
        in typical
    )
    assert "typical" not in samples_verdict([scene(strategy("opposite", fewer=ratio))])


def test_a_bias_of_a_known_size_at_the_most_is_an_upper_limit() -> None:
    limit = Interval(0.01, -0.02, 0.025).bounded("high", "it differs")
    for bias in (limit, replace(limit, value=-0.001)):
        found = bias_verdict([scene(strategy("wrong", 1e-9, bias))], LEVEL)
        assert found.startswith("Biased, by an amount of which only a limit is known: wrong (at most 2.5 %). ")
        assert "noise hides its size: the reference of box has an error of 1 %." in found
    deep = bias_verdict([scene(strategy("depth 20", 0.4, limit))], LEVEL)
    assert "No bias was found in depth 20 (at most 2.5 %)." in deep
    sure = strategy("wrong", 1e-9, Interval(0.2, 0.19, 0.21))
    assert "reference" not in bias_verdict([scene(sure)], LEVEL)
    both = bias_verdict([scene(sure, strategy("deep", 1e-9, limit))], LEVEL)
    assert both.startswith("Wrong picture, however long it renders: wrong is 20 % off (19 to 21). Biased too, by ")
    assert "known: deep (at most 2.5 %)." in both


@pytest.mark.parametrize(
    ("bias2", "differs", "low", "bound"),
    [
        (Interval(0.0036, 0.0025, 0.0049), False, 0.0, ""),  # an offset that may be the reference's
        (Interval(0.0036, 0.0025, 0.0049), True, 0.05, ""),
        (Interval(0.0001, -0.0004, 0.0006), True, -0.02, "high"),
        (Interval(0.0001, -0.0004, 0.0006), False, -0.02, ""),
    ],
)
def test_a_bias_is_told_only_of_pictures_that_differ(bias2: Interval, differs: bool, low: float, bound: str) -> None:
    found = bias_of(BiasVariance(bias2, UNKNOWN), differs)
    assert (found.low, found.bound) == (pytest.approx(low), bound)


def test_no_error_is_an_error_of_zero_and_no_time_is_negative() -> None:
    exact = Runs(np.array([[0.01, 0.02], [0.1, 0.2]]), np.zeros((2, 2)), True, False)
    assert all((error.value, error.high) == (0.0, 0.0) for error in error_curve(exact))
    assert [seconds.low for seconds in second_curve(exact)] == [0.0, 0.0]
    noisy = replace(exact, shared=1e-6)
    assert not any(error.trusted for error in error_curve(noisy)), "a reference with noise cannot show an error of 0"
