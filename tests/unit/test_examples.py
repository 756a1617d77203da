"""The examples that come with the package: found by name, listed, copied, and all readable."""

from __future__ import annotations

from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.examples import example_of, experiment_names, experiments_of, scene_names, scenes_folder
from equaltime.experiments.model.reader import read_experiment

NEEDS_A_CHOICE = {"mitsuba/cornell-box", "mitsuba/veach-mis"}
"""Scenes whose files name an integrator of their own."""


def test_every_scene_and_experiment_has_a_name() -> None:
    named = {"cornell-box", "veach-mis", "montelight/simple", "mitsuba/veach-mis", "hard/glass", "render/windmill"}
    assert named <= set(scene_names())
    assert {f"experiments/x{number}-" for number in range(1, 11)} <= {
        name.rstrip("abcdefghijklmnopqrstuvwxyz") for name in experiment_names()
    }


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_is_read_by_its_name(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scene = et.load(name, integrator="path") if name in NEEDS_A_CHOICE else et.load(name)
    assert scene.source == scene_names()[name]
    assert any("the example" in said for said in scene.warnings)


@pytest.mark.parametrize("name", experiment_names())
def test_an_experiment_has_what_it_names(name: str) -> None:
    read_experiment(experiment_names()[name])


def test_the_last_part_of_a_name_is_enough_if_it_is_the_only_one() -> None:
    assert example_of(Path("simple")) == scenes_folder() / "montelight" / "simple.toml"
    assert example_of(Path("x3-light")) == scenes_folder() / "experiments" / "x3-light.toml"
    assert example_of(Path("cornell-box")) == scenes_folder() / "cornell-box.toml"
    assert example_of(Path("no-such-scene")) is None


def test_a_file_or_a_name_with_a_suffix_is_never_an_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert example_of(Path("cornell-box.toml")) is None
    Path("cornell-box").mkdir()
    assert example_of(Path("cornell-box")) is None


def test_the_command_renders_an_example_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["render", "cornell-box", "-o", "box.exr", "--spp", "1", "--size", "8x8"]) == 0
    assert "there is no such file, so the example" in " ".join(capsys.readouterr().err.split())


def test_examples_are_listed_and_copied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples"]) == 0
    assert {"  cornell-box", "  experiments/x3-light"} <= set(capsys.readouterr().out.splitlines())
    copies = tmp_path / "mine"
    assert main(["examples", str(copies)]) == 0
    assert (copies / "terrain" / "terrain.ply").is_file()
    assert (copies / "render" / "windmill.glb").is_file()
    assert not (copies / "gallery").exists()
    assert main(["examples", str(copies)]) == 2
    assert "exists already" in capsys.readouterr().err


def test_the_command_measures_an_example_experiment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["cost", "x10-estimator", "-o", "out", "--quick"]) == 0
    said = capsys.readouterr()
    assert "x10-estimator.toml" in "".join(said.err.split("\n"))
    assert said.out.startswith("For the same error")


def test_the_folder_of_the_experiments_has_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = experiments_of(Path("experiments"))
    assert found is not None
    assert (found / "x4-depth.toml").exists()
    assert experiments_of(Path("scenes/experiments")) is None
    (tmp_path / "experiments").mkdir()
    assert experiments_of(Path("experiments")) is None


def test_a_name_without_an_example_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(et.SceneError, match="no-room: there is no such file, and no example of that name"):
        et.load("no-room")
