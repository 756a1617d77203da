"""The verdict of an experiment: a plain sentence first, which numbers it takes, and what it says of them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from equaltime.experiments.analysis import winners
from equaltime.experiments.analysis.verdict import headline_target, pick_standard
from equaltime.experiments.analysis.verdict import verdict as answer_of
from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.tables import geometric_mean, time_table
from equaltime.experiments.report.words import factor_cell, plain_cell, seconds_cell
from equaltime.statistics.curves import BELOW
from equaltime.statistics.intervals import TOO_WIDE, UNKNOWN, Interval, product_mean
from equaltime.statistics.runs import MISSING, TYPICAL

from .fake_verdict import AT_LEAST, FAR, FAR_RATIO, RATIO, TARGETS, TIME, said, scene, verdict


def test_the_answer_is_a_plain_sentence_with_its_interval() -> None:
    assert said((TIME, TIME), (RATIO, RATIO)) == (
        "On box, best is about 30 times faster than naive (25 to 36): 5 % error in 500 ms (400 to 600)."
    )


def test_the_smallest_error_within_the_runs_comes_first() -> None:
    assert ": 5 % error in " in said((TIME, TIME), (RATIO, RATIO))
    assert ": 10 % error in " in said((TIME, FAR), (RATIO, RATIO))


def test_the_error_of_the_sentence_is_known_to_tables() -> None:
    for times, target in (((TIME, TIME), 0.05), ((TIME, FAR), 0.1), ((UNKNOWN, UNKNOWN), None)):
        scenes = [scene(times, (RATIO, RATIO))]
        assert headline_target(scenes, TARGETS, "time") == target
        assert (target is None) != (f": {100 * (target or 0):g} % error in" in verdict(scenes, TARGETS))
        assert headline_target(scenes, TARGETS, "samples") is None
    alone = [scene((TIME, TIME), (UNKNOWN, UNKNOWN))]
    assert headline_target(alone, TARGETS, "time") == 0.05


def test_a_measured_time_beats_one_beyond_the_runs_even_if_the_baseline_is() -> None:
    answer = said((TIME, FAR), (FAR_RATIO, RATIO))
    assert ": 10 % error in " in answer
    assert answer.endswith(" The time of naive is extrapolated: it is 90 times its longest run.")
    assert said((UNKNOWN, FAR), (FAR_RATIO, RATIO)).endswith(
        " Extrapolated: the time to 5 % is 3 times the longest run."
    )
    near = replace(FAR, reach=1.02)
    assert said((UNKNOWN, near), (FAR_RATIO, RATIO)).endswith(
        " Extrapolated: the time to 5 % is a little longer than the longest run."
    )


def test_of_extrapolated_targets_the_reference_comes_first_then_the_scenes_then_the_way_beyond_the_runs() -> None:
    """To 10 % within a reference of 3.3 %, to 5 % within one of 1.6 %."""
    near, far = replace(FAR, reach=2.0), replace(FAR, reach=6.0)

    def target(scenes: Sequence[SceneResult], error: float) -> float | None:
        return headline_target([replace(one, reference_error=error) for one in scenes], TARGETS, "time")

    assert target([scene((near, far), (RATIO, RATIO))], 0.01) == 0.1, "nearer"
    assert target([scene((far, near), (RATIO, RATIO))], 0.01) == 0.05, "nearer: 10 % is before the first measurement"
    assert target([scene((far, near), (RATIO, RATIO))], 0.018) == 0.1, "the reference"
    assert target([scene((far, near), (RATIO, RATIO))], 0.04) == 0.05, "it is too noisy for both"
    slow = (replace(RATIO, reach=43.0), replace(RATIO, reach=7.0))
    assert target([scene((TIME, TIME), slow)], 0.01) == 0.05, "the time of the baseline counts too"
    lacking = (UNKNOWN, UNKNOWN)
    three = [scene((far, near), (RATIO, RATIO)), scene((far, UNKNOWN), (RATIO, UNKNOWN)), scene(lacking, lacking)]
    assert target(three, 0.01) == 0.1, "on two of three scenes"
    assert target([scene((near, TIME), (RATIO, RATIO))], 0.04) == 0.05, "within the runs"
    assert target([scene((near, far), lacking)], 0.01) == 0.1, "no speed-up is known"


def test_a_time_before_the_first_measurement_is_not_told_as_one_beyond_the_longest_run() -> None:
    early = Interval(0.2, 0.15, 0.25, reach=3.0).noted("extrapolated 3 times before the first measurement")
    assert said((UNKNOWN, early), (UNKNOWN, RATIO)).endswith(
        " Extrapolated: the time to 5 % is 3 times shorter than the time of the first measurement."
    )
    ratio = replace(RATIO, reach=9.0).noted("baseline: extrapolated 9 times before the first measurement")
    assert said((TIME, TIME), (ratio, ratio)).endswith(
        " The time of naive is extrapolated: it is 9 times shorter than the time of its first measurement."
    )
    late = replace(FAR_RATIO, note=f"{FAR_RATIO.note}; this: extrapolated 3 times before the first measurement")
    assert said((TIME, TIME), (late, late)).endswith(" it is 90 times its longest run.")


def test_a_ratio_that_may_be_one_is_no_difference() -> None:
    even = Interval(1.1, 0.9, 1.3)
    assert "best is about 1.1 times as fast as naive (0.9 to 1.3), no clear difference" in said(
        (TIME, TIME), (even, even)
    )
    slower = Interval(0.25, 0.2, 0.5)
    assert "best is about 4 times slower than naive (2 to 5)" in said((TIME, TIME), (slower, slower))


def test_of_a_baseline_with_a_heavy_tail_the_lower_end_is_said() -> None:
    answer = said((TIME, UNKNOWN), (AT_LEAST, UNKNOWN))
    assert "best is at least 25 times faster than naive" in answer
    assert "30" not in answer


def test_scenes_of_which_something_is_known_are_counted_and_a_single_one_is_named() -> None:
    known, unknown = scene((TIME, TIME), (FAR_RATIO, FAR_RATIO)), scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN))
    one = verdict([known, unknown], TARGETS)
    assert one.startswith("On box (1 of 2 scenes), best is about ")
    assert one.endswith("extrapolated: it is 90 times its longest run.")
    slow = tuple(time.map(lambda seconds: 40.0 * seconds) for time in (TIME, TIME))
    room = replace(scene(slow, (FAR_RATIO, FAR_RATIO)), name="room")
    two = verdict([known, room, unknown], TARGETS)
    assert two.startswith("On average over 2 of 3 scenes (geometric mean), best is about ")
    assert (
        ": 5 % error in 500 ms (400 to 600) on box to 20 s (16 to 24) on room, with the time of naive extrapolated."
        in two
    )
    assert two.endswith(" it is up to 90 times its longest run.")


def test_of_times_on_several_scenes_those_that_are_extrapolated_are_named() -> None:
    near, far = scene((UNKNOWN, TIME), (UNKNOWN, RATIO)), scene((UNKNOWN, FAR), (UNKNOWN, RATIO))
    said = ": 5 % error in 500 ms (400 to 600) on box to 2 s (1.5 to 2.5) on hall, extrapolated"
    assert f"{said} on hall." in verdict([near, replace(far, name="hall")], TARGETS)
    beyond = scene((UNKNOWN, replace(TIME, reach=2.0)), (UNKNOWN, RATIO))
    assert f"{said}." in verdict([beyond, replace(far, name="hall")], TARGETS)


def test_an_interval_beats_a_lower_end_at_a_smaller_error() -> None:
    assert "(25 to 36)" in said((FAR, TIME), (FAR_RATIO, AT_LEAST))


def test_a_measured_gain_comes_before_a_limit_of_another_scene() -> None:
    """The scene with a limit may have the largest gain: its baseline shows the least of its own error."""
    dark = replace(scene((TIME, TIME), (AT_LEAST, AT_LEAST)), name="dark")
    gains = [Interval(800.0, 300.0, 2000.0), Interval(90.0, 60.0, 100.0)]
    rooms = [
        replace(scene((TIME, TIME), (UNKNOWN, UNKNOWN), efficiency=gain), name=name)
        for gain, name in zip(gains, ("hall", "room"), strict=True)
    ]
    answer = answer_of([*rooms, dark], TARGETS)
    assert answer.text.startswith(
        "On average over 2 of 3 scenes (geometric mean), a typical run of best is about 270 times faster than naive "
        "(158 to 426), to the error that it has after 1 s"
    )
    assert answer.notes[:2] == (
        "The gain is 90 times on room to 800 times on hall.",
        "To 5 % error, only a limit of the speed-up over naive is known: at least 25 times on dark. "
        "A larger limit does not show a larger gain.",
    )
    measured = answer_of([scene((TIME, TIME), (RATIO, RATIO)), dark], TARGETS)
    assert measured.text.startswith("On box (1 of 2 scenes), best is about 30 times faster than naive (25 to 36)")
    assert any("at least 25 times on dark" in note for note in measured.notes)
    assert "limit" not in verdict([scene((TIME, TIME), (RATIO, RATIO))], TARGETS)


def test_a_limit_says_that_the_baseline_may_have_met_too_little_light() -> None:
    unlit = FAR_RATIO.bounded("low", f"baseline: {MISSING}")
    assert "best is at least 25 times faster than naive (samples of naive may have met too little light): " in said(
        (TIME, TIME), (unlit, unlit)
    )


def test_a_ratio_whose_upper_end_alone_is_sound_is_not_said() -> None:
    assert "cannot be told" in said((TIME, TIME), (RATIO.bounded("high", "heavy"), UNKNOWN))


def test_of_typical_runs_the_sentence_says_so() -> None:
    typical = RATIO.noted(f"baseline: {TYPICAL}; heavy tail")
    assert said((TIME, TIME), (typical, typical)).endswith(
        " The verdict holds for typical runs: a few rare events make most of the error."
    )
    assert "typical" not in said((TIME, TIME), (RATIO, RATIO))


def test_limits_are_a_few_words_of_the_answer_and_sentences_of_the_notes() -> None:
    found = answer_of([scene((TIME, FAR), (FAR_RATIO, RATIO))], TARGETS)
    assert found.text.endswith("error in 500 ms (400 to 600), with the time of naive extrapolated.")
    assert found.notes == ("The time of naive is extrapolated: it is 90 times its longest run.",)
    typical = FAR.noted(TYPICAL)
    found = answer_of([scene((UNKNOWN, typical), (UNKNOWN, RATIO))], TARGETS)
    assert found.text.endswith("5 % error in 2 s (1.5 to 2.5), in typical runs, extrapolated.")
    assert len(found.notes) == 2


def test_a_baseline_that_does_not_get_there_makes_a_speed_up_a_lower_limit() -> None:
    never = Interval(math.inf, 25.0, math.inf, note="baseline: not reached in 100 times the longest run")
    time = Interval(math.inf, 100.0, math.inf, note="not reached in 100 times the longest run")

    def one(*ratios: Interval) -> SceneResult:
        found = scene((TIME, TIME), ratios)
        naive, best = found.strategies
        return replace(found, strategies=(replace(naive, time_to=dict.fromkeys(TARGETS, time)), best))

    assert answer_of([one(never, never)], TARGETS).text == (
        "On box, best is at least 25 times faster than naive (not reached in 100 times the longest run): "
        "5 % error in 500 ms (400 to 600)."
    )
    assert "10 % error in" in verdict([one(RATIO, never)], TARGETS), "an interval beats a limit"
    room = replace(one(RATIO, RATIO), name="room")
    assert verdict([one(never, never), room], TARGETS).startswith("On room (1 of 2 scenes), best is about 30 times")
    naive, best = one(never, never).strategies
    gain = replace(best, efficiency=Interval(40.0, 30.0, 50.0))
    typical = verdict([replace(one(never, never), strategies=(naive, gain))], TARGETS)
    assert "a typical run of best is about 40 times faster than naive (30 to 50)" in typical


def test_a_time_without_a_ratio_stands_alone() -> None:
    assert said((TIME, TIME), (UNKNOWN, UNKNOWN)) == (
        "On box, best reaches 5 % error in 500 ms (400 to 600). How much faster it is than naive cannot be told."
    )
    assert said((TIME, TIME), (UNKNOWN, UNKNOWN), efficiency=RATIO).endswith(
        "; the error of naive is taken to fall as 1/sqrt(time). On box, best reaches 5 % error in 500 ms (400 to 600)."
    )


def test_speed_ups_of_typical_runs_and_of_mean_errors_have_no_common_mean() -> None:
    """The first are medians over pairs of runs, the others ratios of the times of root mean squares."""
    typical = (Interval(2.7, 1.6, 8.9).noted(TYPICAL), RATIO.noted(TYPICAL))
    scenes = [
        replace(scene((TIME, TIME), ratios), name=name)
        for name, ratios in (("veach", typical[:1] * 2), ("box", (RATIO, RATIO)))
    ]
    assert verdict(scenes, TARGETS).startswith(
        "On box, best is about 30 times faster than naive (25 to 36): 5 % error in 500 ms (400 to 600). On veach, best "
        "is about 2.7 times faster than naive (1.6 to 8.9): 5 % error in 500 ms (400 to 600), in typical runs."
    )
    alike = [scenes[0], replace(scenes[0], name="hall")]
    assert verdict(alike, TARGETS).startswith("On average over 2 scenes (geometric mean), best is about 2.7 times")
    shown = Summary("", "", tuple(scenes), TARGETS, {}, "")
    mean = geometric_mean(shown, "best", 0.05)
    assert mean is not None
    assert mean.note == "speed-ups of typical runs and of mean errors have no common mean"
    assert geometric_mean(replace(shown, scenes=tuple(alike)), "best", 0.05) == product_mean(typical[:1] * 2)


def test_numbers_of_no_use_are_left_out_of_the_sentence() -> None:
    useless = replace(UNKNOWN, note=TOO_WIDE)
    lacking = f"No time to a given error can be trusted: {TOO_WIDE}."
    longer = "What to do: longer runs (--budget), or more of them (--repeats)."
    assert said((useless, useless), (useless, useless)) == f"{lacking} {longer}"
    found = scene((useless, useless), (useless, useless))
    other = replace(found, strategies=(*found.strategies, times(found.strategies[0], "mine", 2.0)))
    assert f"No time of best to a given error can be trusted: {TOO_WIDE}." in verdict([other], TARGETS)
    assert said((TIME, TIME), (useless, useless)).endswith(
        f"How much faster it is than naive cannot be told. Speed-up over naive: {TOO_WIDE}."
    )
    assert (str(seconds_cell(useless)), str(factor_cell(useless))) == ("cannot tell", "cannot tell")


def test_without_any_time_the_runs_that_would_give_one_are_told() -> None:
    """The equal time is 1 s, and the largest target 10 %."""
    found = scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN))

    def told(error: Interval, note: str = "") -> str:
        times = dict.fromkeys(TARGETS, UNKNOWN.doubted(note))
        strategies = [replace(one, error_at_budget=error, time_to=times) for one in found.strategies]
        return " ".join(answer_of([replace(found, strategies=tuple(strategies))], TARGETS).notes)

    error = Interval(0.3, 0.25, 0.35)
    law = "would reach 10 %, if errors go on to fall as 1/sqrt(time)."
    assert told(error) == f"What to do: runs of about 9 s (--budget) {law}"
    assert told(error.bounded("low", "a tail")) == f"What to do: runs of at least 6.2 s (--budget) {law}"
    assert told(Interval(0.08, 0.07, 0.09)) == "What to do: longer runs (--budget), or more of them (--repeats)."
    assert told(error, BELOW) == "", "the reason says what to do"


def test_the_samples_that_a_heavy_tail_needs_are_told() -> None:
    """The equal time is 1 s. One pixel of one render makes 22.5 % of the squared error, where 1.5 % is the limit."""
    found = scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN))
    naive, best = found.strategies
    for tails in ((0.225, 0.0), (0.1, 0.225)):
        strategies = tuple(replace(one, tail_share=tail) for one, tail in zip((naive, best), tails, strict=True))
        notes = answer_of([replace(found, strategies=strategies)], TARGETS).notes
        assert notes[-1] == (
            "What to do: about 15 times as many samples in all, such as runs of 15 s (--budget). An event like the "
            "brightest so far then makes 1.5 % of the squared error, the most that is trusted; brighter ones may come."
        )
    other = replace(naive, label="mis", tail_share=0.5)
    notes = answer_of([replace(found, strategies=(naive, best, other))], TARGETS).notes
    assert "times as many samples" not in notes[-1], "neither baseline nor standard"


def test_a_biased_strategy_with_the_lowest_error_is_told_with_the_bias_that_it_keeps() -> None:
    plain = scene((TIME, TIME), (RATIO, RATIO))
    naive, best = (replace(one, error_at_budget=Interval(0.2, 0.19, 0.21)) for one in plain.strategies)
    bias = Interval(0.017, 0.007, 0.022)
    cut = replace(naive, label="cut", biased=True, error_at_budget=Interval(0.1, 0.09, 0.11), bias=bias)
    found = replace(plain, strategies=(naive, cut, best))
    lowest = "cut has the lowest measured error at equal time, and keeps a bias of"
    never = "more time takes its error to that bias, not to 0."
    for question in ("time", "bias"):
        assert f"{lowest} 1.7 % (0.7 to 2.2): {never}" in verdict([found], TARGETS, question)
    late = replace(best, error_at_budget=Interval(0.2, 0.19, 0.21, reach=1.1))
    told = verdict([replace(found, strategies=(naive, cut, late))], TARGETS)
    assert lowest.replace("measured", "extrapolated") in told
    limit = replace(cut, bias=bias.bounded("high", "noise"))
    assert f"{lowest} at most 2.2 %: {never}" in verdict([replace(found, strategies=(naive, limit, best))], TARGETS)
    assert "cut on box has the lowest" in verdict([found, found], TARGETS)
    worse = replace(cut, error_at_budget=Interval(0.3, 0.2, 0.4))
    assert "lowest" not in verdict([replace(found, strategies=(naive, worse, best))], TARGETS)


def test_a_renderer_of_ones_own_is_told_beside_standard_and_baseline() -> None:
    """Beside the baseline by the speed-up of tables, else as a ratio of independent times."""
    found = scene((TIME, TIME), (RATIO, RATIO))
    slow = Interval(20.0, 18.0, 22.0)
    naive, best = (
        replace(one, time_to={0.1: time, 0.05: time}) for one, time in zip(found.strategies, (slow, TIME), strict=True)
    )
    speed = dict.fromkeys(TARGETS, Interval(1.0, 0.8, 1.25))
    own = replace(naive, label="mine", renderer="command", ratio=speed)
    needs = " mine needs about as long as naive (factor 1; 0.8 to 1.2) and 40 times as long as best (32 to 51) for 5 %."
    for renderer in ("command", "core"):
        mine = replace(own, renderer=renderer)
        answer = answer_of([replace(found, strategies=(naive, best, mine))], TARGETS)
        assert answer.text.endswith(needs), "in the answer, not in a note"
    preset = replace(own, label="mis", renderer="core")
    assert "needs" not in verdict([replace(found, strategies=(naive, best, preset))], TARGETS)
    several = [replace(found, name=name, strategies=(naive, best, own)) for name in ("box", "hall")]
    assert answer_of(several, TARGETS).text.endswith(
        " mine needs 40 times as long as best (34 to 47) for 5 % on average."
    )
    unknown = replace(several[1], strategies=(naive, best, replace(own, time_to=dict.fromkeys(TARGETS, UNKNOWN))))
    assert "times as long as best" not in verdict([several[0], unknown], TARGETS)


def times(result: StrategyResult, label: str, seconds: float, renderer: str = "core") -> StrategyResult:
    time = dict.fromkeys(TARGETS, Interval(seconds, 0.9 * seconds, 1.1 * seconds))
    return replace(result, label=label, renderer=renderer, time_to=time)


def test_a_strategy_that_beats_the_standard_is_named_with_its_time() -> None:
    found = scene((TIME, TIME), (RATIO, RATIO))
    naive, best = found.strategies
    mis = times(naive, "mis", 0.1)
    answer = verdict([replace(found, strategies=(times(naive, "naive", 20.0), best, mis))], TARGETS)
    assert answer.endswith(" Fastest to 5 %: mis, 100 ms (90 to 110).")
    unknown = verdict([replace(found, strategies=(naive, best, mis))], TARGETS)
    assert unknown.endswith(" Fastest to 5 % of those whose time is known: mis, 100 ms (90 to 110).")


def test_strategies_whose_intervals_overlap_are_equally_fast() -> None:
    """Also where the ratio of the two alone would exclude 1: the fastest is chosen after the runs."""
    found = scene((TIME, TIME), (RATIO, RATIO))
    naive, best = found.strategies
    naive = times(naive, "naive", 20.0)
    for seconds in (0.45, 0.6):
        near = times(naive, "mis", seconds)
        answer = verdict([replace(found, strategies=(naive, best, near))], TARGETS)
        assert answer.endswith(" Fastest to 5 %: best and mis (their intervals overlap).")
    apart, other = times(naive, "one", 1.0), times(naive, "two", 1.21)
    assert (quotient := winners.quotient(apart.time_to[0.05], other.time_to[0.05])) is not None
    assert quotient.high < 1.0, "the two alone"
    answer = verdict([replace(found, strategies=(naive, times(best, "best", 4.0), apart, other))], TARGETS)
    assert " Fastest to 5 %: one and two (their intervals overlap), 1 s (0.9 to 1.1)." in answer
    far = times(naive, "mis", 0.8)
    assert "Fastest" not in verdict([replace(found, strategies=(naive, best, far))], TARGETS)
    slow = (times(naive, "naive", 0.5), best)
    assert "Fastest" not in verdict([replace(found, strategies=slow)], TARGETS), "the speed-up tells it"


def test_one_known_time_is_no_ranking_unless_others_are_surely_longer() -> None:
    found = scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN))
    naive, best = found.strategies
    only = times(naive, "mine", 2.0)

    def told(*others: StrategyResult) -> str:
        own = replace(found, strategies=(*others, only))
        box = replace(scene((TIME, TIME), (RATIO, RATIO)), name="hall")
        return verdict(
            [replace(box, strategies=(times(naive, "naive", 20.0), *box.strategies[1:], only)), own], TARGETS
        )

    assert "Fastest to 5 %: best on hall." in told(naive, best)
    never = replace(best, time_to=dict.fromkeys(TARGETS, Interval(math.inf, 64.0, math.inf)))
    assert "Fastest to 5 %: best on hall." in told(naive, never), "naive may be faster"
    assert "Fastest to 5 %: best on hall, mine on box." in told(replace(never, label="naive"), never)


def typical(strategy: StrategyResult) -> StrategyResult:
    return replace(strategy, time_to={target: time.noted(TYPICAL) for target, time in strategy.time_to.items()})


def test_times_of_typical_runs_and_of_the_mean_error_are_compared_and_the_winner_is_told_with_its_kind() -> None:
    found = scene((TIME, TIME), (RATIO, RATIO))
    naive, best = found.strategies
    slow = times(naive, "mis", 125.0)
    answer = verdict([replace(found, strategies=(slow, best, typical(times(naive, "mine", 0.1))))], TARGETS)
    assert answer.endswith(" Fastest to 5 % in typical runs: mine, 100 ms (90 to 110).")
    tails = (slow, typical(best), typical(times(naive, "mine", 3.0)))
    answer = verdict([replace(found, strategies=tails, standard="best")], TARGETS)
    assert " Fastest to 5 % in typical runs: best. " in f"{answer} ", "and not the slowest, as others are medians"


@pytest.mark.parametrize("renderer", ["core", "command"])
def test_beside_a_method_of_ones_own_the_fastest_of_each_scene_is_named(renderer: str) -> None:
    scenes = []
    for name, seconds in (("box", 4.0), ("room", 0.1), ("hall", 0.48)):
        found = scene((TIME, TIME), (RATIO, RATIO))
        naive, best = found.strategies
        own = times(naive, "mine", seconds, renderer)
        scenes.append(replace(found, name=name, strategies=(times(naive, "naive", 20.0), best, own)))
    said = "Fastest to 5 %: best on box, mine on room, best and mine (their intervals overlap) on hall."
    assert f" {said} mine needs " in verdict(scenes, TARGETS)
    twice = verdict([scenes[0], replace(scenes[0], name="lobby")], TARGETS)
    assert " Fastest to 5 %: best on box and lobby. mine needs " in twice


def test_an_average_efficiency_names_the_best_of_each_scene_where_it_changes() -> None:
    scenes = []
    for name, gain in (("box", 4.0), ("room", 0.25)):
        found = scene((TIME, TIME), (RATIO, RATIO), efficiency=Interval(gain, 0.9 * gain, 1.1 * gain))
        naive, best = found.strategies
        scenes.append(replace(found, name=name, strategies=(replace(naive, efficiency=Interval(1.0, 1.0, 1.0)), best)))
    assert verdict(scenes, TARGETS, "efficiency").endswith(" Best on each scene: best on box, naive on room.")
    assert "Best on each" not in verdict([scenes[0], replace(scenes[0], name="hall")], TARGETS, "efficiency")
    assert "Best on each" not in verdict(scenes[:1], TARGETS, "efficiency")


def decimals(text: str) -> int:
    return len(text.partition(".")[2])


def numbers(text: str) -> list[str]:
    return [number.replace(",", "") for number in re.findall(r"\d[\d,]*(?:\.\d+)?", text)]


def agree(sentence: str, cell: str) -> bool:
    """Tell whether ``12 (10 to 14)`` and ``12.1 s (10.2 to 13.9)`` are the same numbers, but for their rounding."""
    pairs = list(zip(numbers(sentence), numbers(cell), strict=True))
    units = (0.5 * 10.0 ** -decimals(number) for pair in pairs for number in pair)
    steps = [sum(both) for both in zip(*[iter(units)] * 2, strict=True)]
    steps[0] = max(steps[0], 0.051 * float(pairs[0][0]))  # two digits alone are said of a ratio
    return all(
        abs(float(one) - float(other)) <= 1.001 * max(step, 0.0051 * float(one))
        for (one, other), step in zip(pairs, steps, strict=True)
    )


@pytest.mark.parametrize("seed", range(12))
def test_the_sentence_has_the_numbers_of_the_table(seed: int) -> None:
    """On one scene: the speed-up, the time, and how much longer another renderer takes than the baseline."""
    random = np.random.default_rng(seed)

    def some(value: float) -> Interval:
        low, high = np.exp(random.uniform(0.02, 1.5, 2))
        return Interval(value, value / low, value * high)

    naive, best, mine = (some(float(np.exp(random.uniform(-2.0, 5.0)))) for _ in range(3))
    ratio, own = some(2.0 * naive.value / best.value), some(naive.value / mine.value)
    found = scene((best, best), (ratio, ratio))
    base, standard = found.strategies
    base = replace(base, time_to=dict.fromkeys(TARGETS, naive))
    other = replace(
        base,
        label="mine",
        renderer="command",
        time_to=dict.fromkeys(TARGETS, mine),
        ratio=dict.fromkeys(TARGETS, own),
    )
    found = replace(found, strategies=(base, standard, other))
    answer = verdict([found], TARGETS)
    look = looks(["naive", "best", "mine"], "naive")
    table = {row.label: row.cells[1] for row in time_table("box", found, TARGETS, look).rows}
    time, faster = table["best"]
    said_ratio = re.search(r"best is about (\S+) times (faster|slower|as fast)[^(]*(\([^)]*\))", answer)
    assert said_ratio is not None
    if said_ratio[2] == "slower":
        faster = factor_cell(ratio.map(lambda x: 1.0 / x))
    assert agree(f"{said_ratio[1]} {said_ratio[3]}", str(faster))
    said_time = re.search(r": 5 % error in ([\d.,]+) (ms|s|min) (\([^)]*\))", answer)
    assert said_time is not None
    unit = {"ms": 1e-3, "s": 1.0, "min": 60.0}[said_time[2]]
    assert agree(f"{said_time[1]} {said_time[3]}", str(plain_cell(best.map(lambda x: x / unit))))
    assert time.text == seconds_cell(best).text
    told = re.sub(r"about as long as naive \(factor ([\d.,]+); ", r"\1 times as long as naive (", answer)
    assert (told != answer) == (own.low <= 1.0 <= own.high), "no clear difference"
    said_own = re.search(r"mine needs ([\d.,]+) times (as long as|less time than) naive (\([^)]*\))", told)
    assert said_own is not None
    assert (said_own[2] == "less time than") == (own.low > 1.0)
    factor = own if own.low > 1.0 else own.map(lambda x: 1.0 / x)
    assert agree(f"{said_own[1]} {said_own[3]}", str(factor_cell(factor)))
    assert str(factor_cell(own)) == str(table["mine"][1]), "and the table has the inverse of it"


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
