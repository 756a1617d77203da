"""The command ``equaltime convert`` on saved renders: their pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "a.exr"
    assert main(["render", str(SCENE), "-o", str(path), "--size", "8x6", "--spp", "4", "--seed", "1", "-q"]) == 0
    return path


@pytest.mark.parametrize("name", ["b.jpg", "b.png"])
def test_the_picture_of_a_saved_render_is_that_of_a_render_to_the_picture(name: str, saved: Path) -> None:
    assert main(["convert", str(saved), str(saved.with_name(name)), "--exposure", "1", "-q"]) == 0
    words = ["--size", "8x6", "--spp", "4", "--seed", "1", "--exposure", "1", "-q"]
    assert main(["render", str(SCENE), "-o", str(saved.with_name(f"c{name}")), *words]) == 0
    assert saved.with_name(name).read_bytes() == saved.with_name(f"c{name}").read_bytes()


def test_an_exposure_is_told_beside_the_automatic_one(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    dark = et.read(saved)
    replace(dark, image=dark.image / np.float32(64.0)).save(saved, overwrite=True)
    automatic = et.read(saved).exposure()
    assert automatic > 2.0
    for stops, shown in ((f"{automatic:g}", f"{automatic:g} stops"), ("auto", f"{automatic:g} stops"), ("1", "1 stop")):
        picture = saved.with_name(f"{stops}.png")
        assert main(["convert", str(saved), str(picture), "--exposure", stops]) == 0
        said = f"wrote {picture} ({shown} brighter)\n"
        if stops == "1":
            said += f"--exposure 1 is counted from the scene's own values (0); auto takes {automatic:g} here\n"
        assert capsys.readouterr().out == said


def test_a_picture_overwrites_no_file_and_is_png_or_jpeg(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, problem in (
        ("a.png", "exists already, and no file is overwritten"),
        ("a.toml", "is a file .png or .jpg"),
    ):
        assert main(["convert", str(saved), str(saved.with_name(name))]) == 2
        assert problem in capsys.readouterr().err
    assert not saved.with_name("a.toml").exists()


@pytest.mark.parametrize("name", ["a.pfm", "a.hdr", "a.PNG", "a.jpg", "a.tiff"])
def test_other_pictures_are_refused_as_pictures(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / name).touch()
    assert main(["convert", str(tmp_path / name), str(tmp_path / "b.png")]) == 2
    said = capsys.readouterr().err
    assert "is a picture, and convert takes a scene file, or of pictures a render that equaltime saved as" in said
    assert "kind of scene file" not in said
