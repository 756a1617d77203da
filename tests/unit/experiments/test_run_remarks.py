"""What a summary tells of the runs and the references that it is made of."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from equaltime.errors import ExperimentError
from equaltime.experiments.analysis.summarise import summarise
from equaltime.experiments.model.summary import Summary
from equaltime.experiments.report.words import facts
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import Row
from equaltime.experiments.run.reference import KnownReference, read, write
from equaltime.images.metrics import Reference
from equaltime.statistics.curves import BETTER

from .made_up_records import KINDS, changed, experiment


def test_a_first_image_that_takes_longer_than_the_budget_is_told(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    first = {label: np.mean([row.wall_s for row in rows if row.strategy == label and row.spp == 2]) for label in KINDS}
    budget = 0.5 * first["naive"]
    (scene,) = summarise(experiment().replace(budget=float(budget)), rows, folder).scenes
    late = {strategy.label: strategy.late for strategy in scene.strategies if strategy.late is not None}
    assert late == {label: pytest.approx(time) for label, time in first.items() if time > 1.1 * budget}
    assert "naive" in late
    assert "cut" not in late
    for strategy in scene.strategies:
        told = any("longer than the budget" in note for note in strategy.notes)
        assert told == (strategy.label in late)
    assert not any(one.late for one in summarise(experiment(), rows, folder).scenes[0].strategies)


def test_runs_that_do_not_end_at_the_equal_time_are_told_with_their_median_and_range(
    recorded: tuple[Path, list[Row]], summary: Summary
) -> None:
    (scene,) = summary.scenes
    best = next(one for one in scene.strategies if one.label == "best")
    assert best.run_seconds == tuple(row.wall_s for row in recorded[1] if row.strategy == "best" and row.last)
    assert scene.other_end(best) == np.median(best.run_seconds)
    assert scene.other_ends.startswith("runs did not end at the equal time of 20 s (median, range): naive after ")
    assert "best after 67 s (64 to 70)" in scene.other_ends
    assert f" Note: {scene.other_ends}." in facts(scene)
    near = replace(scene, strategies=tuple(replace(one, run_seconds=(20.5, 21.0, 20.0)) for one in scene.strategies))
    assert (near.other_ends, near.other_end(near.strategies[0])) == ("", None)


def test_a_first_run_that_had_too_little_of_its_processors_is_told(
    recorded: tuple[Path, list[Row]], summary: Summary
) -> None:
    first = {row.strategy: row for row in recorded[1] if row.last and row.repeat == 0}
    (scene,) = summary.scenes
    for one in scene.strategies:
        row = first[one.label]
        assert one.first_share == pytest.approx(row.cpu_s / (row.wall_s * row.threads))
    even = replace(scene, strategies=tuple(replace(one, first_share=0.95) for one in scene.strategies))
    assert " All runs take the samples of the first one. Errors" in even.other_ends
    best = next(one for one in even.strategies if one.label == "best")
    for other, told in ((replace(best, run_seconds=(20.0,) * 3), False), (best, True)):
        slow = replace(other, first_share=0.47)
        others = tuple(one for one in even.strategies if one is not best)
        said = replace(even, strategies=(*others, slow)).other_ends
        assert (" of the first one, which had as little as 47 % of its processors. " in said) is told


def test_what_strategies_decided_by_themselves_is_told(summary: Summary) -> None:
    (scene,) = summary.scenes
    assert scene.decisions == ""
    best = next(one for one in scene.strategies if one.label == "best")
    even, uneven = "roulette=efficiency,adaptive=none", "roulette=efficiency,adaptive=error"
    small = replace(best, decided=("roulette=throughput",) * 3)
    split = replace(best, decided=(even, uneven, even), splitting=(0.71, 0.8, 0.75))
    counts = replace(best, decided=("adaptive=none",))
    for other, told in (
        (
            small,
            "roulette=throughput in 3 runs; splitting was not tried: the picture is small, or the technique has no "
            "pilot",
        ),
        (
            split,
            f"{even} in 2 runs and {uneven} in 1 run; by its pilots, splitting paths multiplies variance times rays "
            "by 0.71 to 0.8",
        ),
        (counts, "adaptive=none in 1 run"),
    ):
        found = replace(scene, strategies=(other,))
        assert found.decisions == f"best decided by itself: {told}"
        assert facts(found).endswith(f" {found.decisions}.")


def test_repeats_without_a_common_count_are_left_out_and_said_to_be(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    apart = changed(rows, "best", spp=lambda row: 100 * row.repeat + row.spp)
    (scene,) = summarise(experiment(), apart, folder).scenes
    assert [strategy.label for strategy in scene.strategies] == ["naive", "cut", "fireflies"]
    assert scene.left_out == (("best", "its repeats have no sample count in common, so that they cannot be joined"),)
    alone = [row for row in apart if row.strategy == "best"]
    with pytest.raises(ExperimentError, match="box: its repeats have no sample count in common"):
        summarise(experiment(("best",), "best"), alone, folder)


def test_runs_that_have_not_ended_do_not_count(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    torn = [row for row in rows if not (row.strategy == "best" and row.repeat == 5 and row.last)]
    best = summarise(experiment(), torn, folder).scenes[0].strategies[1]
    assert best.repeats == 5


def test_without_images_and_references_the_curves_remain(recorded: tuple[Path, list[Row]], tmp_path: Path) -> None:
    summary = summarise(experiment(), recorded[1], tmp_path)
    best = summary.scenes[0].strategies[1]
    assert best.bias is None
    assert best.time_to[0.2].trusted
    assert summary.scenes[0].reference_error > 0.0


def test_two_repeats_are_said_to_be_too_few(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded
    summary = summarise(experiment(), [row for row in rows if row.repeat < 2], folder)
    best = summary.scenes[0].strategies[1]
    assert not best.time_to[0.2].trusted
    assert any("too few repeats for intervals: 2" in note for note in best.notes)
    assert "No time to a given error can be trusted" in summary.verdict


def test_errors_against_a_black_reference_are_infinite_and_told_without_warnings(
    recorded: tuple[Path, list[Row]],
) -> None:
    folder, rows = recorded
    endless = [replace(row, relmse=math.inf) for row in rows]
    best = summarise(experiment(), endless, folder).scenes[0].strategies[1]
    assert not best.time_to[0.2].known


def test_a_reference_with_a_heavy_tail_is_told_and_another_one_is_not(
    recorded: tuple[Path, list[Row]], tmp_path: Path
) -> None:
    folder, rows = recorded
    copied = ExperimentFolder(Path(shutil.copytree(folder, tmp_path / "copy")))
    known = read(copied.reference("box")).reference

    def notes(firefly: float) -> tuple[str, ...]:
        variance = known.variance.copy()
        variance[3, 4] *= firefly
        write(copied.reference("box"), KnownReference(Reference(known.mean, variance, known.halves), {}))
        return summarise(experiment(), rows, copied.path).verdict_notes

    doubtful = notes(1e3)
    assert doubtful[0].startswith("The reference of box (stated error ")
    assert " has a heavy tail too: one pixel makes much of the stated error, and light may be missing." in doubtful[0]
    assert BETTER in doubtful[0]
    assert doubtful[1:] == notes(1.0)


def test_a_reference_whose_time_ended_early_is_told_with_the_time_that_would_do(
    recorded: tuple[Path, list[Row]], tmp_path: Path
) -> None:
    """If its error exceeds a third of the smallest target: 1 % here."""
    folder, rows = recorded
    copied = ExperimentFolder(Path(shutil.copytree(folder, tmp_path / "copy")))

    def notes(error: float, command: str = "equaltime cost box.toml") -> tuple[str, ...]:
        facts = {"box": {"error": error, "error_wanted": 0.005, "seconds": 60.0, "seconds_allowed": 60.0}}
        copied.provenance.write_text(json.dumps({"references": facts, "sessions": {"1": {"command": command}}}))
        return summarise(experiment(), rows, copied.path).verdict_notes

    *others, told = notes(0.014)
    assert told == (
        "The reference of box has an error of 1.4 %, where 0.5 % was wanted: its time ended. It widens the "
        "intervals of small errors; about 7.83 min would do (reference.seconds of an experiment file)."
    )
    assert notes(0.005) == notes(0.014, "equaltime cost box.toml --quick") == tuple(others)
    larger = experiment().replace(targets=(0.1, 0.05))
    for error, ends in ((0.014, False), (0.02, True)):  # a third of 5 % is 1.7 %
        notes(error)
        told = summarise(larger, rows, copied.path).verdict_notes[0]
        assert told.startswith("The reference of box has an error of 2 %, where 0.5 % was wanted") == ends
        said = "about 16 min would do, and 86 s for a third of the smallest target (reference.seconds of an experiment "
        assert (said in told) == ends


def test_a_busy_machine_is_told_by_the_share_of_the_processors_that_runs_had(recorded: tuple[Path, list[Row]]) -> None:
    folder, rows = recorded

    def notes(share: float, renderer: str = "core", shorter: float = 1.0) -> str:
        found = [
            replace(
                row, renderer=renderer, wall_s=shorter * row.wall_s, cpu_s=share * shorter * row.wall_s * row.threads
            )
            for row in rows
        ]
        return " ".join(summarise(experiment(), found, folder).verdict_notes)

    said = "The machine was busy: runs had 61 % of their processors, in the median. Times are too long"
    assert said in notes(0.612)
    for told in (notes(0.81), notes(0.3, renderer="command"), notes(0.3, shorter=1e-6)):
        assert "busy" not in told
    one_of_many = [replace(row, cpu_s=(0.3 if row.repeat == 0 else 0.97) * row.wall_s * row.threads) for row in rows]
    assert "busy" not in " ".join(summarise(experiment(), one_of_many, folder).verdict_notes), "one run is no machine"
