"""Subjects of one's own: Python files that an experiment names."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import equaltime as et
from equaltime.experiments.model.reader import make_experiment, read_experiment
from equaltime.experiments.run.subjects import make_subjects

FOLDER = Path(__file__).parents[3] / "scenes" / "experiments"


def experiment(folder: Path, code: str, name: str = "Mine") -> Path:
    (folder / "own.py").write_text(code)
    file = folder / "own.toml"
    file.write_text(
        f'scenes = [{{ path = "{(FOLDER / "constant.toml").as_posix()}" }}]\n'
        f'strategies = [{{ label = "own", python = "own.py:{name}" }}, "best"]\n'
    )
    return file


def test_the_shipped_subjects_can_be_made() -> None:
    for file in ("x9-bias.toml", "x10-estimator.toml"):
        subjects = make_subjects(read_experiment(FOLDER / file))
        assert all(subject.renderer == "command" for subject in subjects)


@pytest.mark.parametrize("file", ["x9-bias.toml", "x10-estimator.toml"])
def test_the_time_between_two_checkpoints_is_not_that_of_a_shipped_subject(file: str) -> None:
    experiment = read_experiment(FOLDER / file)
    scene = experiment.load_scenes()[0].with_(size=(2, 2))
    for subject in make_subjects(experiment):
        subject.prepare(scene, 1)
        begin, walls = time.perf_counter(), []
        for point in subject.run(1, (1, 2, 3), None):
            walls.append(point.wall_s)
            time.sleep(0.05)
        assert walls == sorted(walls)
        assert walls[-1] < time.perf_counter() - begin - 0.14


@pytest.mark.parametrize("name", ["two\nlines", "", 5, "a\0b", "bell\a", "\ud800", "line\u2028line", "\x85"])
def test_a_name_that_no_record_can_hold_is_refused_before_anything_is_rendered(tmp_path: Path, name: object) -> None:
    code = f"class Mine:\n    def __init__(self, label): self.label, self.name = label, {name!r}\n"
    file = experiment(tmp_path, code)
    with pytest.raises(et.EqualtimeError) as caught:
        make_subjects(read_experiment(file))
    assert str(caught.value).startswith(f"{file}:2: strategies[0].name: the name of a subject must be text of one")
    with pytest.raises(et.EqualtimeError, match="must be text of one line"):
        et.cost(file, tmp_path / "out", quick=True)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["10\u00a0s", "\u3000", "\U0001f469\u200d\U0001f52c"])
def test_a_name_may_have_any_space_and_joined_characters(tmp_path: Path, name: str) -> None:
    code = f"class Mine:\n    def __init__(self, label): self.label, self.name = label, {name!r}\n"
    assert make_subjects(read_experiment(experiment(tmp_path, code)))[0].name == name


@pytest.mark.parametrize(
    ("name", "told"), [("bell\a", r"U\+0007 in 'bell\\x07'"), ("a\u2028b", r"U\+2028 \(LINE SEPARATOR\) in")]
)
def test_the_character_that_no_record_can_hold_is_named(tmp_path: Path, name: str, told: str) -> None:
    code = f"class Mine:\n    def __init__(self, label): self.label, self.name = label, {name!r}\n"
    with pytest.raises(et.EqualtimeError, match=told):
        make_subjects(read_experiment(experiment(tmp_path, code)))


def test_two_subjects_cannot_have_one_label(tmp_path: Path) -> None:
    code = "class Mine:\n    def __init__(self, label): self.label, self.name = 'best', 'mine'\n"
    with pytest.raises(et.EqualtimeError, match=r"strategies\[0\]\.label: .* 'own', found 'best'"):
        make_subjects(read_experiment(experiment(tmp_path, code)))


def test_a_place_in_a_file_outlasts_changes_and_makes_no_difference(tmp_path: Path) -> None:
    read = read_experiment(experiment(tmp_path, ""))
    chosen = make_experiment(read, strategies=["best", "own"], repeats=2)
    assert [entry.place[-15:] for entry in chosen.strategies] == [": strategies[1]", ": strategies[0]"]
    assert read.strategies == tuple(entry.at("elsewhere") for entry in read.strategies)


@pytest.mark.parametrize(
    ("code", "name", "message"),
    [
        ("x = 1\ny = 1 / 0\n", "Mine", "own.py:2: ZeroDivisionError"),
        ("def broken(:\n", "Mine", "own.py: SyntaxError"),
        ("class Other: pass\n", "Mine", "has no 'Mine'"),
    ],
)
def test_what_is_wrong_in_an_own_file_is_told_with_its_place(
    tmp_path: Path, code: str, name: str, message: str
) -> None:
    with pytest.raises(et.EqualtimeError, match=message.replace(".", r"\.")):
        make_subjects(read_experiment(experiment(tmp_path, code, name)))


@pytest.mark.parametrize("calls", ["helper()", "pass"])
def test_the_traceback_of_an_own_file_is_logged_from_that_file_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, calls: str
) -> None:
    code = f"def helper():\n    return 1 / 0\ndef Mine(label):\n    helper()\n{calls}\n"
    with pytest.raises(et.ExperimentError, match=r"own\.py:2: ZeroDivisionError"):
        make_subjects(read_experiment(experiment(tmp_path, code)))
    (record,) = caplog.records
    assert record.exc_text is not None
    places = [line.split(", ")[0] for line in record.exc_text.splitlines() if line.startswith("  File ")]
    assert places == [f'  File "{tmp_path / "own.py"}"'] * 2
