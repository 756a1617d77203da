"""The experiment files that are shipped: each can be read, and so can its scenes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from equaltime.experiments.model.plan import planned_seconds
from equaltime.experiments.model.reader import is_experiment, quicker, read_experiment
from equaltime.words import seconds_of

FOLDER = Path(__file__).parents[3] / "scenes" / "experiments"
FILES = sorted(path for path in FOLDER.glob("*.toml") if is_experiment(path))


def test_the_experiments_that_started_the_project_are_there() -> None:
    assert {"x1", "x2", "x3", "x4", "x5", "x6", "x7", "x8", "x9", "x10"} <= {path.stem.split("-")[0] for path in FILES}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_shipped_experiment_can_be_read_with_all_its_scenes(path: Path) -> None:
    experiment = read_experiment(path)
    assert experiment.title
    assert len(experiment.description) > 100, "it says what is compared, what to see and why"
    assert len(experiment.load_scenes()) == len(experiment.scenes)


def test_the_page_tells_how_long_a_first_look_takes() -> None:
    told = dict(re.findall(r"^\| `([\w-]+)\.toml` \| ([^|]+) \|", (FOLDER / "README.md").read_text(), re.MULTILINE))
    assert told.keys() == {path.stem for path in FILES}
    for path in FILES:
        planned = planned_seconds(quicker(read_experiment(path)))
        if planned is not None and told[path.stem] != "minutes":
            assert planned <= seconds_of(told[path.stem]), path.stem
