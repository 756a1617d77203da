"""Our numbers beside those of the text that an experiment goes back to."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from equaltime.errors import ExperimentError
from equaltime.experiments.analysis.beside import beside
from equaltime.experiments.model.experiment import Experiment, TheirNumber, Theirs
from equaltime.experiments.model.summary import Beside, Summary
from equaltime.experiments.report import page, write_report
from equaltime.experiments.report.tables import beside_table
from equaltime.statistics.curves import AGAINST_SAMPLES

from .fake_summary import CONSTANTS, TARGETS, doubted, summary


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Summary:
    return summary(tmp_path_factory.mktemp("summary"), scenes=2)


def line(found: Summary, ours: Any, strategy: str = "best", **more: Any) -> Beside:
    number = TheirNumber(what="a number", ours=ours, strategy=strategy, **more)
    return beside(Theirs(source="they", claim="so", numbers=(number,)), found)[0]


def test_a_speed_up_is_that_to_the_smallest_error_that_can_be_trusted(found: Summary) -> None:
    best = line(found, "speed-up")
    assert (best.scene, best.target) == ("box0", min(TARGETS))
    assert best.value == found.scenes[0].strategies[2].ratio[min(TARGETS)]


def test_a_target_that_is_given_is_kept_even_if_nothing_can_be_trusted_there(found: Summary) -> None:
    doubtful = replace(found, scenes=(doubted(found.scenes[0], "best"),))
    assert line(doubtful, "time", target=0.02).target == 0.02
    assert not line(doubtful, "time", target=0.02).value.trusted
    assert line(doubtful, "time").target == max(TARGETS)


def test_what_lies_within_the_runs_is_preferred_to_what_is_extrapolated(found: Summary) -> None:
    scene = found.scenes[0]
    best = scene.strategies[2]
    times = {target: replace(time, reach=2.0) if target < 0.05 else time for target, time in best.time_to.items()}
    changed = replace(scene, strategies=(*scene.strategies[:2], replace(best, time_to=times)))
    assert line(replace(found, scenes=(changed,)), "time").target == 0.05


def test_samples_are_time_over_the_time_of_a_sample(found: Summary) -> None:
    time = (CONSTANTS["best"] / 0.02) ** 2
    samples = line(found, "samples", target=0.02).value
    assert samples.value == pytest.approx(time * 16.0)
    part = math.exp(math.hypot(math.log(1.0 / 0.9), math.log(1.1)))  # both are known to a tenth
    assert (samples.low, samples.high) == (
        pytest.approx(samples.value / part, rel=1e-6),
        pytest.approx(samples.value * part, rel=0.02),
    )


def test_what_a_sample_costs_is_held_against_the_baseline(found: Summary) -> None:
    scene = found.scenes[0]
    best = scene.strategies[2]
    slower = replace(best.curve, seconds=tuple(time.map(lambda t: 2.0 * t) for time in best.curve.seconds))
    changed = replace(found, scenes=(replace(scene, strategies=(*scene.strategies[:2], replace(best, curve=slower))),))
    assert line(changed, "time of a sample").value.value == pytest.approx(2.0)


def test_if_nothing_can_be_trusted_a_number_of_which_one_end_holds_is_shown(found: Summary) -> None:
    scene = doubted(found.scenes[0], "best")
    best = scene.strategies[2]
    half = found.scenes[0].strategies[2].ratio[0.05].bounded("low", "a heavy tail")
    changed = replace(best, ratio={target: half if target == 0.05 else ratio for target, ratio in best.ratio.items()})
    shown = line(replace(found, scenes=(replace(scene, strategies=(*scene.strategies[:2], changed)),)), "speed-up")
    assert (shown.target, shown.value.bound) == (0.05, "low")


@pytest.mark.parametrize(
    ("ours", "strategy", "text"),
    [
        ("slope", "cut", "\N{MINUS SIGN}0.50"),
        ("error", "cut", "14.1"),
        ("bias", "cut", "none found (at most 0.3"),
        ("p", "cut", "0.40"),
        ("p", "best", "\N{EN DASH}"),
    ],
)
def test_each_number_is_printed_in_its_unit(found: Summary, ours: Any, strategy: str, text: str) -> None:
    table = beside_table("x", replace(found, beside=(line(found, ours, strategy),)))
    assert table is not None
    assert str(table.rows[0].cells[-1][0]).startswith(text)


def test_the_column_of_numbers_that_no_one_published_has_its_own_heading(found: Summary) -> None:
    lines = (replace(line(found, "slope", "cut"), theirs="0.5"),)
    for heading in ("they say", "in closed form"):
        theirs = Theirs(source="a", claim="b", heading=heading)
        table = beside_table("x", replace(found, theirs=theirs, beside=lines))
        assert table is not None
        assert table.columns == (heading, "we measure")


def test_a_slope_has_its_axis_beside_it(found: Summary) -> None:
    one = line(found, "slope", "cut")
    for note, axis in (("", "against time"), (f"{AGAINST_SAMPLES}: more", "against samples")):
        table = beside_table("x", replace(found, beside=(replace(one, value=replace(one.value, note=note)),)))
        assert table is not None
        assert str(table.rows[0].cells[-1][1]).endswith(axis)


def test_a_strategy_that_did_not_run_is_said_not_to_have(found: Summary) -> None:
    assert line(found, "time", "nobody").value.note == "it has not run"
    assert line(found, "time", scene="nowhere").value.note == "it has not run"


def test_the_report_shows_the_claim_and_both_columns(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    theirs = Theirs(
        source="A <page>",
        claim="it is faster.",
        figures="ten times",
        numbers=(TheirNumber(what="speed-up of all", says="10 times", ours="speed-up", strategy="best", scene="box1"),),
    )
    value = replace(found, theirs=theirs, beside=beside(theirs, found), scenes=found.scenes[1:])
    text = write_report(value, tmp_path).read_text("utf-8")
    for part in ("A &lt;page&gt;", "it is faster.", "ten times", "speed-up of all", "10 times", "they say", "64"):
        assert part in text


SCENES = [{"path": "a.toml"}]
NUMBER = {"what": "x", "ours": "slope", "strategy": "best"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"strategy": "bset"},
            "theirs.numbers[0].strategy: the experiment has no strategy 'bset'; did you mean 'best'?",
        ),
        ({"scene": "b"}, "theirs.numbers[0].scene: the experiment has no scene 'b'"),
        ({"target": 0.3}, "theirs.numbers[0].target: 0.3 is none of the targets"),
        ({"ours": "speed"}, "theirs.numbers[0].ours: expected "),
        ({"shows": "x"}, "theirs.numbers[0].shows: unknown key 'shows'; expected one of 'ours', 'says'"),
    ],
)
def test_a_number_that_could_have_none_beside_it_is_refused(change: dict[str, Any], message: str) -> None:
    theirs = {"source": "they", "claim": "so", "numbers": [NUMBER | change]}
    with pytest.raises(ExperimentError) as caught:
        Experiment(scenes=SCENES, strategies=["best"], theirs=theirs)  # type: ignore[arg-type]
    assert message in str(caught.value)


def test_numbers_of_strategies_that_are_left_out_go_with_them() -> None:
    theirs = {"source": "they", "claim": "so", "numbers": [NUMBER, NUMBER | {"strategy": "mis"}]}
    made = Experiment(scenes=SCENES, strategies=["best", "mis"], theirs=theirs)  # type: ignore[arg-type]
    left = made.replace(strategies=made.strategies[:1])
    assert left.theirs is not None
    assert [number.strategy for number in left.theirs.numbers] == ["best"]
