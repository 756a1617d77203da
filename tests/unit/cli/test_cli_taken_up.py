"""A render that is resumed, merged or handed on keeps its exposure, and finds a copy of its scene."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.images import image_files as images
from equaltime.images import preview
from equaltime.rendering.render_file import read_picture

SCENES = Path(__file__).parents[3] / "scenes"


def test_a_resumed_render_keeps_the_exposure_that_was_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "a.exr"
    command = ["render", str(SCENES / "veach-mis.toml"), "-o", str(output), "--size", "8x6"]

    def shown() -> float:
        return float(json.loads(images.read_attributes(output.with_suffix(".png"))[preview.REPEAT])["exposure"])

    assert main([*command, "--spp", "4", "--exposure", "-3.5", "-q"]) == 0
    assert main(["info", str(output)]) == 0
    repeat, picture, on = capsys.readouterr().out.splitlines()[-3:]
    assert repeat.startswith("repeat ")
    assert all(line.endswith(" --exposure -3.5") for line in (repeat, on))
    assert main([*command, "--spp", "8", "--resume"]) == 0
    told = "--exposure -3.5 is kept from the earlier run; --exposure auto chooses one for this picture"
    assert told in capsys.readouterr().out.splitlines()
    assert shown() == -3.5
    output.with_suffix(".png").unlink()
    assert main(["info", str(output)]) == 0
    (picture,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("picture "))
    assert main(shlex.split(picture.removeprefix("picture   "))[1:]) == 0
    assert shown() == -3.5
    assert main([*command, "--spp", "16", "--resume", "--exposure", "auto", "-q"]) == 0
    assert shown() == et.read(output).exposure() != -3.5
    assert "exposure" not in read_picture(output).record
    assert main([*command, "--spp", "16", "-q"]) == 0  # a new render does not
    assert shown() == et.read(output).exposure()


def test_a_resumed_render_counts_the_remarks_on_its_file_and_tells_last_what_the_command_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, output = str(SCENES / "render" / "windmill.glb"), tmp_path / "a.exr"
    command = ["render", model, "-o", str(output), "--size", "8x6", "--transparent", "--resume"]
    new = f"{output} is not there: there is nothing to resume, and a new render begins"
    for spp, remarks in (("4", 3), ("8", 1)):
        assert main([*command, "--spp", spp]) == 0
        *told, last = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("lint")]
        if spp == "4":
            assert last == new
            last = told.pop()
        assert new not in told
        assert last.startswith("warning: the ground is a surface, not background")
        assert len(told) == remarks
    assert told == [f"warning: 3 kinds of remarks on how the file was read; see equaltime lint {model}"]


@pytest.mark.parametrize("name", ["simple.toml", "a.toml"])
def test_a_copied_scene_takes_the_place_of_the_recorded_file(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A copy has the recorded file's name or the picture's, and the values of -D in it."""
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    scene = here / "simple.toml"
    shutil.copy(SCENES / "montelight" / "simple.toml", scene)
    words = ["-D", "light_radius=1.5"]
    assert main(["render", str(scene), "-o", str(here / "a.exr"), "--size", "8x6", "--spp", "8", "-q", *words]) == 0
    (there / "sent").mkdir(parents=True)
    copy = there / "sent" / name
    assert main(["convert", str(scene), str(copy), "--copy", *words]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("in the folder sent, ")]
    assert line == f"in the folder sent, wherever it is: equaltime render {name} -o {copy.stem}.exr"
    for file in ("a.exr", "a.png"):
        shutil.copy(here / file, copy.with_name(file))
    monkeypatch.chdir(copy.parent)
    for there_still in (True, False):
        if not there_still:
            scene.unlink()
        assert main(["info", "a.exr"]) == 0
        shows, *_, repeat, _, on = capsys.readouterr().out.splitlines()[1:]
        assert shows == f"shows     {name} at 8x6"
        assert repeat == f"repeat    equaltime render {name} -o a.exr --spp 8 --size 8x6 --seed 0"
        assert main(["info", "a.png"]) == 0
        assert f"equaltime render {name} -o a.png --spp 8 --size 8x6" in capsys.readouterr().out
    assert main(shlex.split(on.removeprefix("goes on   "))[1:]) == 0
    assert main(["render", name, "-o", "b.exr", "--size", "8x6", "--spp", "8", "--seed", "1", "-q"]) == 0
    assert main(["merge", "a.exr", "b.exr", "-o", "both.exr"]) == 0
    copy.write_text(copy.read_text().replace("1.5", "1.25"))
    capsys.readouterr()
    assert main(["info", "a.exr"]) == 0
    assert "          but the scene has changed since" in capsys.readouterr().out


def test_a_checkpoint_keeps_the_exposure_that_was_asked_for(tmp_path: Path) -> None:
    for asked, kept in ((2.0, 2.0), ("auto", None)):
        path = tmp_path / f"{asked}.exr"
        scene = et.load(SCENES / "veach-mis.toml").with_(size=(8, 6))
        et.render(scene, spp=64, checkpoint=path, checkpoint_every=1e-6, checkpoint_exposure=asked)
        record = read_picture(path).record
        assert record["stopped_by"] == "unfinished"
        assert record.get("exposure") == kept


def test_a_merged_render_keeps_its_exposure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parts = [str(tmp_path / f"{seed}.exr") for seed in (1, 2)]
    for seed, part in enumerate(parts, 1):
        command = ["render", str(SCENES / "cornell-box.toml"), "-o", part, "--size", "8x6", "--spp", "4", "-q"]
        assert main([*command, "--seed", str(seed), "--exposure", "2"]) == 0
    assert main(["merge", *parts, "-o", str(tmp_path / "both.exr"), "--exposure", "1"]) == 0
    capsys.readouterr()
    assert main(["info", str(tmp_path / "both.exr")]) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "--exposure" in line]
    assert told == [
        f"          equaltime merge {shlex.join(str(tmp_path / f'part-{n}.exr') for n in (1, 2))} "
        f"-o {tmp_path / 'both.exr'} --exposure 1"
    ]
