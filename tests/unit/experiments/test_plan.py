"""What an experiment says of its length before it begins."""

from __future__ import annotations

from pathlib import Path

import pytest

from equaltime.cli import main
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.plan import planned
from equaltime.experiments.model.reader import quicker, read_experiment

SCENES = Path(__file__).resolve().parents[3] / "scenes"
CORNELL = SCENES / "cornell-box.toml"


def test_a_budget_tells_how_long_all_takes() -> None:
    experiment = Experiment(
        scenes=({"path": str(CORNELL)},),  # type: ignore[arg-type]
        strategies=("mis", "best"),  # type: ignore[arg-type]
        budget=2.0,
        repeats=6,
        reference={"seconds": 10.0},  # type: ignore[arg-type]
    )
    assert planned(experiment) == "about 39 s: references of up to 10 s each, then 12 runs of 2 s"
    assert planned(experiment.replace(spp=(4, 64))) == (
        "references of up to 10 s each, then 12 runs of 64 samples a pixel"
    )


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
