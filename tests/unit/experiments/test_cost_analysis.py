"""From records to a summary: made-up runs of strategies whose speed, bias and tails are known."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from equaltime.experiments.analysis import summarise as summarising
from equaltime.experiments.analysis.disagreement import least_error
from equaltime.experiments.analysis.summarise import summarise
from equaltime.experiments.model.experiment import Question
from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.report.captions import mean_of_runs, this_run
from equaltime.experiments.report.charts import curve_titles
from equaltime.experiments.report.gallery import kinds_of
from equaltime.experiments.report.latex import latex_table
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.losing import losing
from equaltime.experiments.report.own import other_renderers
from equaltime.experiments.report.pictures import Pictures, load_pictures
from equaltime.experiments.report.tables import Table, check_table, time_table
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import Row
from equaltime.experiments.run.reference import KnownReference, write
from equaltime.images.metrics import Reference
from equaltime.statistics.curves import AGAINST_SAMPLES
from equaltime.statistics.intervals import Interval
from equaltime.statistics.runs import MISSING, TYPICAL

from .made_up_records import KINDS, REPEATS, SIZE, SPP, TARGETS, TRUTH, changed, experiment


def test_the_summary_has_the_scene_and_its_strategies_in_order(summary: Summary) -> None:
    (scene,) = summary.scenes
    assert (scene.name, scene.digest, scene.size, scene.max_depth) == ("box", "abc", (SIZE, SIZE), 8)
    assert (scene.baseline, scene.standard, scene.budget_s) == ("naive", "best", 20.0)
    assert [strategy.label for strategy in scene.strategies] == list(KINDS)
    assert scene.reference_error == pytest.approx(math.sqrt(0.5e-4 / 1.01), rel=0.02)
    assert summary.targets == (0.2, 0.1, 0.01)
    assert summary.provenance["runs"] == len(KINDS) * REPEATS


def holds(interval: Interval, value: float) -> bool:
    return interval.trusted and interval.low < value < interval.high


def test_times_and_ratios_are_found(strategies: Mapping[str, StrategyResult]) -> None:
    expected = 1.0 / (0.2**2 * 1.01)
    assert holds(strategies["best"].time_to[0.2], 1.05 * expected)
    assert holds(strategies["best"].ratio[0.2], 10.0)
    assert strategies["naive"].ratio[0.2] == Interval(1.0, 1.0, 1.0)
    assert holds(strategies["best"].curve.slope, -0.5)
    assert strategies["best"].error_at_budget.value == pytest.approx((20.0 / 1.05) ** -0.5, rel=0.1)


def test_curves_have_all_checkpoints(strategies: Mapping[str, StrategyResult]) -> None:
    curve = strategies["best"].curve
    assert curve.spp == SPP
    for error, spp in zip(curve.error, SPP, strict=True):
        assert error.value == pytest.approx((spp * 1.01) ** -0.5, rel=0.05)
        assert 0.0 < error.high - error.low < 0.1 * error.value
    assert curve.own_estimate[1] == Interval(0.5, pytest.approx(0.45), pytest.approx(0.55))  # type: ignore[arg-type]
    assert not strategies["fireflies"].curve.own_estimate[1].known


def test_independent_samples_are_extrapolated_by_their_law(strategies: Mapping[str, StrategyResult]) -> None:
    assert "slope -1/2" in strategies["naive"].time_to[0.1].note
    assert strategies["naive"].time_to[0.01].note == "not reached in 100 times the longest run"
    assert "slope -1/2" not in strategies["best"].time_to[0.01].note


def test_a_command_that_starts_anew_is_extrapolated_by_its_samples(recorded: tuple[Path, list[Row]]) -> None:
    """Its start of 60 s makes its errors fall steeply with time; a sample takes a second all the same."""
    rows = changed(
        recorded[1],
        "best",
        renderer=lambda _: "command",
        name=lambda _: "mine",
        wall_s=lambda row: 60.0 + row.wall_s,
    )
    mine = summarise(experiment(("naive", "best")).replace(targets=(0.06,)), rows, recorded[0]).scenes[0].strategies[1]
    truth = 60.0 + 1.05 / (0.06**2 * 1.01)
    assert holds(mine.time_to[0.06], truth)
    assert mine.time_to[0.06].value == pytest.approx(truth, rel=0.05)
    assert "each render takes 60 s beside its samples" in mine.time_to[0.06].note
    assert mine.curve.slope.value == pytest.approx(-0.5, abs=0.03)


def test_a_bias_is_measured_and_told(strategies: Mapping[str, StrategyResult]) -> None:
    cut = strategies["cut"]
    assert cut.bias is not None
    assert cut.bias.value == pytest.approx(0.2 / math.sqrt(1.01), rel=0.05)
    assert cut.bias.low > 0.19
    assert cut.equality_p is not None
    assert cut.equality_p < 1e-6
    assert (cut.time_to[0.1].value, cut.time_to[0.1].low) == (math.inf, math.inf), "its bias is larger"
    assert "cuts paths, so its picture stays different (20 % off)" in cut.notes
    assert any("its picture differs from the picture of best (p < 0.0001)" in note for note in cut.notes)


def test_a_renderer_that_failed_its_test_of_agreement_is_told_with_its_difference(
    recorded: tuple[Path, list[Row]], tmp_path: Path
) -> None:
    """Its distance is that from the common reference. Errors that it would spoil and their times are not given."""
    folder = ExperimentFolder(shutil.copytree(recorded[0], tmp_path / "cost"))
    write(folder.reference("box", "cut"), KnownReference(Reference(1.2 * TRUTH, np.full(TRUTH.shape, 1e-6)), {}))
    folder.note("agreements", "box", {"cut": {"agrees": False, "p": 1e-9, "note": "another"}})
    rows = changed(recorded[1], "cut", renderer=lambda _: "command", name=lambda _: "mine", biased=lambda _: False)
    summary = summarise(experiment(("naive", "cut")), rows, folder.path)
    (scene,) = summary.scenes
    mine = scene.strategies[1]
    assert scene.standard == "naive"
    assert (mine.agreement_p, scene.strategies[0].agreement_p) == (1e-9, None)
    assert mine.difference is not None
    assert mine.difference.value == pytest.approx(0.2 / math.sqrt(1.01), rel=0.02)
    assert 0.19 < mine.difference.low < mine.difference.value < mine.difference.high < 0.21
    assert "Not the picture of equaltime: cut is 19.73 % off (" in " ".join(summary.verdict_notes)
    told = other_renderers(summary)[0]
    assert told.startswith("cut: its picture disagrees with the reference by 19.73 % (")
    assert re.search(r": no error below 99(\.\d)? % is given, and no time to one\.$", told)
    assert told.removeprefix("cut: ").rstrip(".") in mine.notes
    numbers = (*mine.time_to.values(), *mine.ratio.values(), *mine.curve.error, mine.curve.slope, mine.efficiency)
    assert not any(number.known for number in (*numbers, mine.fewer_samples, mine.error_at_budget))
    assert mine.image_error is None
    assert mine.bias == mine.difference, "against its own reference it would have none"
    assert r"cut (another picture) & disagrees & disagrees" in latex_table(summary)
    pictures = load_pictures(scene)
    assert isinstance(pictures, Pictures)
    views, _ = losing(scene, pictures, looks(["naive", "cut"], "naive"), 64)
    assert not any("than naive" in " ".join(view.sentences) for view in views)
    assert summary.to_frame().query("strategy == 'cut'")["error"].isna().all()
    look = looks(["naive", "cut"], "naive")
    cells = [cell for cells in time_table("box", scene, TARGETS, look).rows[1].cells for cell in cells]
    assert {str(cell) for cell in cells} == {"disagrees"}
    assert all("disagrees with the reference by 19.73 %" in cell.note for cell in cells)
    row = check_table("box", scene, look).rows[1]
    assert "no (p < 0.0001)" in [str(cell) for cells in row.cells for cell in cells]


def test_the_table_says_against_what_each_slope_is(recorded: tuple[Path, list[Row]]) -> None:
    (scene,) = summarise(experiment(), recorded[1], recorded[0]).scenes
    look = looks(list(KINDS), "naive")

    def table(*against_samples: str) -> Table:
        strategies = []
        for one in scene.strategies:
            note = AGAINST_SAMPLES if one.label in against_samples else ""
            slope = Interval(-0.5, -0.51, -0.49, note=note)
            strategies.append(replace(one, curve=replace(one.curve, slope=slope)))
        return check_table("box", replace(scene, strategies=tuple(strategies)), look)

    assert (table().columns[0], table(*KINDS).columns[0]) == ("slope against time", "slope against samples")
    assert table().caption.startswith("Slope of log error against log time (independent")
    assert table(*KINDS).caption.startswith("Slope of log error against log samples (independent")
    both = table("best")
    assert both.columns[0] == "slope"
    assert "against log time or against log samples" in both.caption
    said = {row.label: str(row.cells[0][1]) for row in both.rows}
    assert said == {label: "against samples" if label == "best" else "against time" for label in KINDS}


def test_a_table_of_times_says_that_other_programs_may_have_a_start(recorded: tuple[Path, list[Row]]) -> None:
    (scene,) = summarise(experiment(("naive", "best")), recorded[1], recorded[0]).scenes
    look = looks(["naive", "best"], "naive")
    own, other = scene.strategies
    with_other = replace(scene, strategies=(own, replace(other, renderer="command")))
    for each, told in ((scene, False), (with_other, True)):
        assert ("may contain a start" in time_table("box", each, TARGETS, look).caption) == told


def test_a_difference_that_is_small_beside_an_error_spoils_nothing(
    recorded: tuple[Path, list[Row]], tmp_path: Path
) -> None:
    """The difference is 1 %: at 20 % it makes a thousandth of the error, at 1 % all of it."""
    folder = ExperimentFolder(shutil.copytree(recorded[0], tmp_path / "cost"))
    folder.note("agreements", "box", {"best": {"agrees": False, "p": 1e-9, "note": "another"}})
    rows = changed(recorded[1], "best", renderer=lambda _: "command", name=lambda _: "mine")
    (scene,) = summarise(experiment(("naive", "best")), rows, folder.path).scenes
    mine = scene.strategies[1]
    assert mine.difference is not None
    assert 0.01 < least_error(mine.difference) < 0.1
    assert mine.time_to[0.2].trusted
    assert mine.ratio[0.2].trusted
    assert mine.error_at_budget.trusted
    assert not mine.time_to[0.01].known
    (turned,) = summarise(experiment(("naive", "best"), baseline="best"), rows, folder.path).scenes
    assert turned.strategies[0].ratio[0.2].trusted
    assert "baseline: its picture disagrees" in turned.strategies[0].ratio[0.01].note
    assert turned.strategies[0].time_to[0.01].trusted, "only ratios need the baseline"


def test_windows_that_a_small_film_makes_too_small_are_left_out_and_told(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    whole = experiment().replace(crops=((0, 0, 4, 4),))
    assert summarise(whole, rows, folder).scenes[0].crops == ((0, 0, 4, 4),)
    own = (whole.scenes[0].model_copy(update={"crops": ((0, 0, 16, 16), (2, 3, 12, 7))}),)
    (scene,) = summarise(whole.replace(scenes=own), rows, folder).scenes
    assert scene.crops == ((0, 0, 16, 16),)
    told = "Not shown enlarged, since a side has fewer than 8 pixels at this size: 12x7 at 2, 3."
    assert scene.crops_left_out == told


@pytest.mark.parametrize("question", ["bias", "time"])
def test_numbers_of_a_strategy_that_is_found_biased_are_trusted(
    recorded: tuple[Path, list[Row]], question: Question
) -> None:
    """The twin asks for times: a shared offset may then be light that no image has, so that only limits are known."""
    rows = changed(recorded[1], "cut", biased=lambda _: False)
    asked = experiment(("naive", "cut")).model_copy(update={"question": question})
    naive, cut = summarise(asked, rows, recorded[0]).scenes[0].strategies
    assert cut.unequal == (question == "bias"), "a careful test needs more repeats"
    assert (MISSING in cut.error_at_budget.note) == (question == "time")
    assert cut.error_at_budget.trusted == (question == "bias")
    assert MISSING not in naive.error_at_budget.note
    if question == "bias":
        assert cut.bias is not None
        assert cut.bias.low > min(cut.time_to)
        assert cut.time_to[min(cut.time_to)] == Interval(math.inf, math.inf, math.inf).noted(
            "never reached: its bias is larger"
        )


@pytest.mark.parametrize(("biased", "why"), [(False, "found to be biased"), (True, "cuts paths")])
def test_a_bias_is_told_with_how_it_is_known_and_beside_the_map_of_errors(
    recorded: tuple[Path, list[Row]], biased: bool, why: str
) -> None:
    rows = changed(recorded[1], "cut", biased=lambda _: biased)
    asked = experiment(("naive", "cut")).model_copy(update={"question": "bias"})
    (scene,) = summarise(asked, rows, recorded[0]).scenes
    assert f"{why}, so its picture stays different (20 % off)" in scene.strategies[1].notes
    pictures = load_pictures(scene)
    assert isinstance(pictures, Pictures)
    views, _ = losing(scene, pictures, looks(["naive", "cut"], "naive"), 64)
    told = "Its error contains its bias of 20\u202f%: a block shows the bias only where the noise of naive is smaller."
    assert [told in view.sentences for view in views] == [False, True]


def test_a_bias_is_not_trusted_where_rare_bright_paths_make_the_errors(
    recorded: tuple[Path, list[Row]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The question of the twin is the bias: it declares that the scene has no such paths."""
    folder, rows = recorded
    for question, trusted in (("time", False), ("bias", True)):
        asked = experiment(("naive", "fireflies")).model_copy(update={"question": question})
        naive, fireflies = summarise(asked, rows, folder).scenes[0].strategies
        assert fireflies.bias is not None
        assert naive.bias is not None
        assert naive.bias.trusted
        assert fireflies.bias.trusted == trusted
        assert ("heavy tail: one pixel" in fireflies.bias.note) != trusted
        assert ("told despite the heavy tail: an experiment with question" in fireflies.bias.note) == trusted
        assert naive.bias.note == ""
    below = Interval(-0.28, -0.31, -0.23)
    monkeypatch.setattr(summarising, "_bias", lambda parts, differs: below)
    impossible = summarise(experiment(("naive",)), rows, folder).scenes[0].strategies[0].bias
    assert impossible == below.doubted(
        "its square is below 0 by more than its interval: rare bright paths make the errors"
    )


def test_the_unbiased_are_not_called_biased(strategies: Mapping[str, StrategyResult]) -> None:
    naive = strategies["naive"]
    assert naive.bias is not None
    assert naive.bias.low < 0.0 < naive.bias.high
    assert naive.equality_p is not None
    assert naive.equality_p > 0.001
    assert naive.notes == ()
    assert strategies["best"].equality_p is None


def test_heavy_tails_are_marked_in_every_number(strategies: Mapping[str, StrategyResult]) -> None:
    fireflies = strategies["fireflies"]
    assert any("heavy tail" in note for note in fireflies.notes)
    assert not any(number.trusted for number in (*fireflies.curve.error, fireflies.curve.slope))
    assert all(number.bound == "low" for number in fireflies.curve.error), "what was not seen can only add"
    assert all(";" not in number.note for number in fireflies.curve.error), "a footnote that says nothing alone"
    assert all("heavy tail" in number.note for number in (*fireflies.time_to.values(), *fireflies.ratio.values()))
    assert all(TYPICAL in number.note for number in fireflies.time_to.values())


def test_what_renders_said_is_joined_as_what_they_did(recorded: tuple[Path, list[Row]]) -> None:
    """The mean of five errors of 1 % and one of 13 % is 3 %; the root of their mean square is 5.4 %."""
    folder, rows = recorded
    firefly = changed(
        rows,
        "best",
        estimate=lambda row: 0.13 if row.repeat == 2 else 0.01,
        estimate_low=lambda row: 0.1 if row.repeat == 2 else 0.01,
        estimate_high=lambda row: 0.2 if row.repeat == 2 else 0.01,
    )
    said = summarise(experiment(), firefly, folder).scenes[0].strategies[1].curve.own_estimate[-1]
    expected = [math.sqrt((5.0 * 0.01**2 + one**2) / 6.0) for one in (0.13, 0.1, 0.2)]
    assert (said.value, said.low, said.high) == pytest.approx(expected)
    assert said.trusted


def test_what_renders_doubt_is_doubted_of_all_together(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    unsure = changed(rows, "best", doubt=lambda row: "heavy tail" if row.repeat in (1, 4) else None)
    said = summarise(experiment(), unsure, folder).scenes[0].strategies[1].curve.own_estimate
    assert all((one.trusted, one.bound, one.note) == (False, "low", "2 of 6 renders: heavy tail") for one in said)


def test_images_are_those_of_the_first_repeat(strategies: Mapping[str, StrategyResult]) -> None:
    image = strategies["best"].image
    assert image is not None
    np.testing.assert_allclose(np.load(image), KINDS["best"].image(1000)[-1], rtol=1e-6)


def test_the_image_of_one_run_has_the_error_and_the_time_of_that_run(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    first = next(row for row in rows if row.strategy == "best" and row.repeat == 0 and row.last)
    best = summarise(experiment(), rows, folder).scenes[0].strategies[1]
    assert best.image_error == pytest.approx(math.sqrt(first.relmse or 0.0))
    assert best.image_seconds == first.wall_s
    for relmse, error in ((-0.04, -0.2), (math.inf, None), (None, None)):
        odd = [replace(row, relmse=relmse) if row is first else row for row in rows]
        assert summarise(experiment(), odd, folder).scenes[0].strategies[1].image_error == error


@pytest.mark.parametrize("label", list(KINDS))
def test_curve_table_caption_and_map_show_one_error_at_one_time(recorded: tuple[Path, list[Row]], label: str) -> None:
    """Also where a few events make most of the error, and where the reference's noise is subtracted."""
    folder, rows = recorded
    end = float(np.mean([row.wall_s for row in rows if row.strategy == label and row.last]))
    timed = experiment().model_copy(update={"budget": end})
    (scene,) = summarise(timed, rows, folder).scenes
    strategy = next(one for one in scene.strategies if one.label == label)
    pictures = load_pictures(scene)
    assert isinstance(pictures, Pictures)
    measured = math.sqrt(np.mean([row.relmse or 0.0 for row in rows if row.strategy == label and row.last]))
    assert strategy.curve.error[-1].value == pytest.approx(measured)
    assert strategy.error_at_budget.value == pytest.approx(measured)
    assert math.sqrt(pictures.squares[label].mean()) == pytest.approx(measured, rel=1e-5)  # images are float32
    table = check_table("box", scene, looks(list(KINDS), "naive"))
    at_budget, at_the_end = next(row.cells[1] for row in table.rows if row.label == label)
    said = mean_of_runs(strategy)
    shown = said.removeprefix(f"the mean of {REPEATS} runs: ").partition(" after ")[0]
    assert shown != said
    titles = [title for titles in curve_titles(0, strategy).values() for title in titles]
    assert any(title.startswith(f"{label}: {at_the_end} after ") for title in titles)
    assert shown in str(at_the_end)
    number = float(re.findall(r"[\d.]+", str(at_budget) if "measured" not in str(at_budget) else shown)[0])
    assert number == pytest.approx(100.0 * measured, rel=0.01), "in the digits that its wider interval allows"
    kinds = {kind.slug: kind for kind in kinds_of(scene, pictures, looks(list(KINDS), "naive"), 64)}
    for slug in ("image", "error"):
        caption = next(frame.caption for frame in kinds[slug].frames if frame.label == label)
        assert caption.endswith(said)
    assert next(f.caption for f in kinds["image"].frames if f.label == label).startswith(this_run(strategy))


def test_the_verdict_is_one_sentence_with_intervals(summary: Summary) -> None:
    assert re.match(r"On \w+, best is about [\d.]+ times faster than naive \(", summary.verdict)
    assert ": 20 % error in 2" in summary.verdict
    first, fastest = summary.verdict.split(" Fastest ")
    assert first.count(" to ") == 2
    fastest, own = fastest.split(" fireflies needs ")
    assert re.fullmatch(r"to 20 % in typical runs: fireflies, [\d.]+ s \([^)]*\)\.", fastest)
    assert re.fullmatch(r"[\d.]+ times less time than naive \([^)]*\) for 20 %, in typical runs\.", own)
