"""Frames of an animation on the command line: ``equaltime render --frames``."""

from __future__ import annotations

from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main

from ..scene.test_frames import KEYS, STANDING

SMALL = ("--size", "8x6", "--spp", "4")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.toml"
    path.write_text(STANDING + KEYS)
    return path


def render(scene: Path, output: str, *words: str) -> int:
    return main(["render", str(scene), "-o", str(scene.parent / output), *SMALL, *words])


def test_every_frame_gets_a_file(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert render(scene, "f.exr", "--frames", "0-4:2", "--fps", "2", "--blur", "0.5", "--seed", "7") == 0
    assert sorted(path.name for path in scene.parent.glob("f_*.exr")) == ["f_0000.exr", "f_0002.exr", "f_0004.exr"]
    assert [et.read(scene.parent / f"f_000{number}.exr").origin.seed for number in (0, 2, 4)] == [7, 9, 11]
    said = capsys.readouterr().out.splitlines()
    assert [line.startswith("Done: ") for line in said] == [True, True, True, False]
    assert said[-1].startswith("3 frames in ")
    assert not said[-1].endswith(" of this run")


def test_a_frame_is_the_still_of_its_time(scene: Path) -> None:
    assert render(scene, "f-#.exr", "--frames", "3", "--fps", "2") == 0
    still = et.render(et.load(scene).with_(size=(8, 6), shutter=(1.5, 1.5)), spp=4, seed=3)
    assert (et.read(scene.parent / "f-3.exr").image == still.image).all()


def test_an_animation_goes_on_where_it_was(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert render(scene, "f.exr", "--frames", "0-1") == 0
    capsys.readouterr()
    assert render(scene, "f.exr", "--frames", "0-2", "--spp", "8", "--resume") == 0
    *each, together = capsys.readouterr().out.splitlines()
    assert [" over 2 runs, " in line for line in each] == [True, True, False]
    assert together.endswith(" of this run")
    assert [et.read(scene.parent / f"f_000{number}.exr").spp for number in range(3)] == [8, 8, 8]


def test_the_first_frame_alone_is_measured_for_a_time_that_is_too_short(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = []
    monkeypatch.setattr("equaltime.cli.render_picture.seconds_of_pilot", lambda *of: measured.append(of) or 10.0)
    assert render(scene, "f.exr", "--frames", "0-2", "--time", "1s") == 0
    assert len(measured) == 1
    assert capsys.readouterr().err.count("may be too short to know the error") == 1


def test_a_frame_does_not_replace_what_is_no_render(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (scene.parent / "f_0001.png").write_text("mine")
    assert render(scene, "f.png", "--frames", "0-1") == 2
    assert "f_0001.png: is there already, and does not say that equaltime made it" in capsys.readouterr().err
    assert (scene.parent / "f_0001.png").read_text() == "mine"
    assert not (scene.parent / "f_0000.png").exists(), "all files are looked at before the first frame"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--frames", "b"], "Invalid value for '--frames': expected frames such as 0-47"),
        (["--frames", "1", "--fps", "0"], "Invalid value for '--fps': '0' is no number from 0.001 to 1e+06"),
        (["--frames", "1", "--blur", "1.5"], "Invalid value for '--blur': '1.5' is no number from 0 to 1"),
        (["--fps", "12"], "--fps and --blur belong to --frames"),
    ],
)
def test_what_makes_no_sense_is_told(
    scene: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render(scene, "f.png", *words) == 2
    assert message in capsys.readouterr().err
