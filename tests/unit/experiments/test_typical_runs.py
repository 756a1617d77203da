"""The sentences of a verdict on gains of typical runs, and on scenes without a speed-up."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from equaltime.experiments.analysis.verdict import verdict as answer_of
from equaltime.experiments.model.summary import SceneResult
from equaltime.statistics.curves import BELOW, ERROR_OF, TOO_NOISY
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.statistics.runs import MISSING, TYPICAL

from .fake_summary import curve
from .fake_verdict import AT_LEAST, FAR, RATIO, TARGETS, TIME, said, scene, verdict


def test_the_scenes_that_the_answer_leaves_out_have_a_sentence_in_it() -> None:
    lacking = (UNKNOWN, UNKNOWN)
    box, dark = scene((TIME, TIME), (RATIO, RATIO)), replace(scene(lacking, lacking), name="dark")
    hall = replace(scene(lacking, lacking, efficiency=Interval(33.0, 32.0, 35.0)), name="hall")
    room = replace(scene(lacking, lacking, efficiency=Interval(33.0, 32.0, 35.0)), name="room")

    def told(*others: SceneResult) -> str:
        return answer_of([box, *others], TARGETS).text.partition("500 ms (400 to 600). ")[2]

    assert told() == ""
    gain = "a typical run of best is about 33 times faster than naive"
    assert told(hall) == f"On hall, {gain} (32 to 35), to the error at its end."
    assert told(hall, room).startswith(f"On 2 other scenes (geometric mean), {gain} (")
    assert told(dark) == "On dark, no speed-up is known: these runs cannot tell."
    assert told(hall, dark).endswith(
        "(32 to 35), to the error at its end. On dark, no speed-up is known: these runs cannot tell."
    )
    assert told(dark, replace(dark, name="cave")) == "On 2 other scenes, no speed-up is known: these runs cannot tell."


@pytest.mark.parametrize(
    ("time", "ratio", "why"),
    [
        (UNKNOWN.doubted(f"{ERROR_OF} 2.61 %{TOO_NOISY}"), UNKNOWN, "the reference is too noisy"),
        (UNKNOWN.doubted(BELOW), UNKNOWN, "the reference is too noisy"),
        (TIME.bounded("low", MISSING), UNKNOWN, "images may lack light"),
        (Interval(math.inf, 60.0, math.inf), UNKNOWN, "best does not reach 5 %"),
        (TIME, AT_LEAST, "there is only a limit"),
    ],
)
def test_a_scene_without_a_speed_up_has_the_reason_in_a_few_words(time: Interval, ratio: Interval, why: str) -> None:
    other = replace(scene((time, time), (ratio, ratio)), name="dark")
    answer = answer_of([scene((TIME, TIME), (RATIO, RATIO)), other], TARGETS)
    assert f" On dark, no speed-up is known: {why}." in answer.text


def test_if_nothing_else_can_be_told_typical_runs_are() -> None:
    heavy = FAR.bounded("low", "heavy tail: a pixel")
    answer = said((heavy, heavy), (UNKNOWN, UNKNOWN), efficiency=Interval(800.0, 300.0, 2000.0))
    assert answer.startswith(
        "On box, a typical run of best is about 800 times faster than naive (300 to 2,000), to the error that it has "
        "after 2 s (measured 7.07 %); the error of naive is taken to fall as 1/sqrt(time). "
        "No time to a given error can be trusted: "
    )
    assert "can be trusted: heavy tail: a pixel." in answer
    far = FAR.noted("extrapolated 17.6 times beyond the longest run").bounded("low", "heavy tail: a pixel")
    chain = said((far, far), (UNKNOWN, UNKNOWN), efficiency=Interval(800.0, 300.0, 2000.0))
    assert "can be trusted: heavy tail: a pixel." in chain, "the reason that matters alone"
    assert "e+" not in answer


def test_a_gain_at_the_end_of_the_runs_is_told_with_the_time_at_which_they_ended() -> None:
    found = scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN), efficiency=Interval(800.0, 300.0, 2000.0))
    points = replace(curve(0.1), seconds=(Interval(0.52, 0.4, 0.7),), error=(Interval(0.233, 0.2, 0.3),))
    equal = Interval(0.16, 0.15, 0.17, reach=1.9).noted("extrapolated 1.9 times beyond the longest run")
    early = replace(
        found,
        strategies=tuple(
            replace(one, run_seconds=(0.9, 0.4, 0.41, 0.39, 0.5), curve=points, error_at_budget=equal)
            for one in found.strategies
        ),
    )
    assert "to the error that it has after 520 ms (measured 23.3 %)" in verdict([early], TARGETS), "not at 1 s"
    hidden = replace(points, error=(UNKNOWN,))
    unknown = replace(early, strategies=tuple(replace(one, curve=hidden) for one in early.strategies))
    assert "to the error that it has after 520 ms;" in verdict([unknown], TARGETS)
    other = replace(found, name="hall")
    assert "to the error that it has at the end of its runs;" in verdict([early, other], TARGETS)


def test_different_winners_are_named_with_their_scenes() -> None:
    found = scene((UNKNOWN, UNKNOWN), (UNKNOWN, UNKNOWN), efficiency=Interval(90.0, 60.0, 100.0))
    naive, best = found.strategies
    tree = replace(best, label="tree", efficiency=Interval(40.0, 30.0, 50.0))
    lamps = replace(found, name="lamps", standard="tree", strategies=(naive, tree))
    answer = answer_of([found, lamps], TARGETS)
    assert "a typical run of best (on box) or tree (on lamps) is about 60 times faster than naive" in answer.text
    assert "The gain is 40 times on lamps (tree) to 90 times on box (best)." in " ".join([answer.text, *answer.notes])


def test_a_baseline_that_is_the_standard_is_compared_with_the_nearest_rival() -> None:
    found = scene((TIME, TIME), (UNKNOWN, UNKNOWN))
    naive, best = found.strategies
    own = replace(naive, time_to=best.time_to)
    rival = replace(best, time_to=naive.time_to, efficiency=Interval(0.02, 0.01, 0.04))
    worse = replace(rival, label="bsdf", efficiency=Interval(0.001, 0.0005, 0.002))
    biased = replace(rival, label="cut", biased=True, efficiency=Interval(0.5, 0.4, 0.6))
    alone = replace(found, baseline="naive", standard="naive", strategies=(own, rival, worse, biased))
    answer = answer_of([alone], TARGETS).text
    assert (
        "naive reaches 5 % error in 500 ms (400 to 600). In typical runs, naive is about 50 times faster than" in answer
    )
    assert answer.endswith("best (25 to 100), to the error at the end of the runs.")
    unknown = replace(alone, strategies=(own, replace(rival, efficiency=UNKNOWN)))
    assert answer_of([unknown], TARGETS).text.endswith("It is the baseline of the comparison.")


def test_the_gain_is_said_to_grow_where_the_error_of_the_standard_falls_faster_than_the_law() -> None:
    grows = "The error of best falls faster than 1/sqrt(time), so the gain is larger for smaller errors."
    found = scene((TIME, TIME), (UNKNOWN, UNKNOWN), efficiency=RATIO)
    naive, best = found.strategies
    steep = replace(best, curve=replace(best.curve, slope=Interval(-0.7, -0.75, -0.65)))
    assert grows in answer_of([replace(found, strategies=(naive, steep))], TARGETS).notes
    assert grows not in answer_of([found], TARGETS).notes, "-0.52 to -0.48"


def test_a_mean_error_that_says_the_opposite_of_typical_runs_is_told_in_the_answer() -> None:
    typical = Interval(2.7, 1.6, 8.9).noted(TYPICAL)
    found = scene((TIME, TIME), (typical, typical))
    naive, best = found.strategies

    def told(error: float, reach: float = 1.0) -> str:
        errors = (Interval(0.114, 0.08, 0.3, reach=reach), Interval(error, 0.04, 0.5))
        strategies = [replace(one, error_at_budget=e) for one, e in zip((naive, best), errors, strict=True)]
        return answer_of([replace(found, strategies=tuple(strategies))], TARGETS).text

    assert told(0.165).endswith(
        "in typical runs; over all runs, the measured error at equal time is 1.45 times larger."
    )
    assert told(0.165, reach=1.2).endswith("the extrapolated error at equal time is 1.45 times larger.")
    assert "over all runs" not in told(0.08)
