"""What an experiment says of its length before it begins."""

from __future__ import annotations

from pathlib import Path

import pytest

from equaltime.cli import main
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.plan import PeerTimes, planned, planned_seconds
from equaltime.experiments.model.reader import quicker, read_experiment

SCENES = Path(__file__).resolve().parents[3] / "scenes"
CORNELL = SCENES / "cornell-box.toml"
TWO = Experiment(
    scenes=({"path": str(CORNELL)},),  # type: ignore[arg-type]
    strategies=("mis", "best"),  # type: ignore[arg-type]
    budget=2.0,
    repeats=6,
    reference={"seconds": 10.0},  # type: ignore[arg-type]
)


def test_a_budget_tells_how_long_all_takes() -> None:
    assert planned(TWO) == "about 39 s: references of up to 10 s each, then 12 runs of 2 s"
    assert planned(TWO.replace(spp=(4, 64))) == ("references of up to 10 s each, then 12 runs of 64 samples a pixel")


@pytest.mark.parametrize(
    ("repeats", "told"),
    [
        (1, "; with 1 repeat there are no intervals: --repeats 3 is the least, 6 are better"),
        (
            4,
            "; with 4 repeats there are no trusted times where rare events make most of an error: "
            "--repeats 6 is the least",
        ),
        (6, ""),
    ],
)
def test_too_few_repeats_are_told_before_the_runs(repeats: int, told: str) -> None:
    experiment = Experiment(
        scenes=({"path": str(CORNELL)},),  # type: ignore[arg-type]
        strategies=("best",),  # type: ignore[arg-type]
        budget=2.0,
        repeats=repeats,
    )
    assert planned(experiment).partition(" of 2 s")[2] == told
    assert planned(experiment.replace(budget=None, spp=(4,))).partition(" samples a pixel")[2] == told


def test_machines_divide_the_time_of_runs_and_of_nothing_else() -> None:
    assert planned(TWO, machines=5) == ("about 21 s: references of up to 10 s each, then 12 runs of 2 s on 5 machines")
    assert planned_seconds(TWO, machines=12) == 10 + 5 + 2 * 2, "repeats wait for the first one's counts"
    assert planned(TWO.replace(spp=(4, 64)), machines=2).endswith("12 runs of 64 samples a pixel on 2 machines")


def test_the_time_holds_tests_and_runs_of_other_renderers() -> None:
    """A run of theirs renders each checkpoint anew: 2 s, 1.4 times 2 s for the earlier ones, and 10 starts of 0.5 s."""
    command = {"label": "theirs", "peer": {"command": "render {spp} {seed} {out}"}}
    experiment = Experiment(
        scenes=({"path": str(CORNELL)},),  # type: ignore[arg-type]
        strategies=("best", command),  # type: ignore[arg-type]
        budget=2.0,
        repeats=6,
        reference={"seconds": 10.0},  # type: ignore[arg-type]
    )
    times = PeerTimes(tests=64.0, small_renders=0.5)
    assert planned_seconds(experiment, times) == pytest.approx(64 + 10 + 5 + 12 * 2 + 6 * (1.4 * 2 + 10 * 0.5))
    assert planned(experiment, times) == (
        "about 150 s: tests of agreement with other renderers (64 s), references of up to 10 s each, then 12 runs of "
        "2 s; up to 10 s more for each renderer whose picture differs"
    )
    assert planned_seconds(experiment.replace(spp=(4, 64)), times) is None
    assert planned(experiment).startswith("more than 56 s: references of up to 10 s each, then 12 runs of 2 s; other ")
    assert planned(experiment).endswith("cost measures how long before it runs them")
    assert planned(experiment.replace(spp=(4, 64)), times).startswith("tests of agreement with other renderers (64 s),")


def test_the_time_holds_films_and_a_report_for_each_scene() -> None:
    scenes = ({"path": str(CORNELL)}, {"path": str(CORNELL), "name": "again"})
    experiment = Experiment(scenes=scenes, strategies=("best",), budget=2.0, repeats=1, animate=True)  # type: ignore[arg-type]
    assert planned_seconds(experiment) == pytest.approx(2 * (experiment.reference.seconds + 5 + 2 + 2))


@pytest.mark.parametrize("path", sorted((SCENES / "experiments").glob("x*.toml")), ids=lambda path: path.stem)
def test_a_first_look_takes_at_most_a_minute(path: Path) -> None:
    """As planned; those with sample counts are measured, and take 7 to 40 seconds."""
    quick = quicker(read_experiment(path))
    if quick.budget is not None:
        runs = quick.repeats * len(quick.scenes) * len(quick.strategies) * quick.budget
        assert runs + quick.reference.seconds * len(quick.scenes) <= 50.0
    assert quick.repeats == 6


def test_the_command_says_it_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["cost", str(CORNELL), "-o", str(tmp_path / "a"), "--size", "6x6", "--budget", "10ms", "--repeats", "1"]
    assert main([*command, "--strategies", "best", "--quick"]) == 0
    assert "then 1 run of 10 ms" in capsys.readouterr().err.splitlines()[0]
