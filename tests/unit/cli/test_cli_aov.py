"""``render --aov variance``: the picture beside the others, its scale, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import OpenImageIO as oiio  # noqa: N813
import pytest

import equaltime as et
from equaltime.cli import main

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
SMALL = ["--size", "12x10"]


def render(folder: Path, name: str, *options: str) -> int:
    return main(["render", str(SCENE), "-o", str(folder / name), *SMALL, "--aov", "variance", *options])


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.jpg"])
def test_the_picture_stands_beside_the_others_and_its_scale_is_told(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render(tmp_path, name, "--spp", "8") == 0
    picture = tmp_path / "a.variance.png"
    preview = "a.png" if name == "a.exr" else name
    assert {file.name for file in tmp_path.iterdir()} == {name, preview, "a.variance.png"}
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first.endswith(f", {picture}")
    assert second.startswith(f"{picture}: variance of one sample, from ")
    spec = oiio.ImageBuf(str(picture)).spec()
    assert (spec.width, spec.height, spec.nchannels) == (12, 10, 1)
    assert second.split(": ", 1)[1] in spec.getattribute("ImageDescription")
    assert render(tmp_path, name, "--spp", "8", "--aov", "variance", "--json") == 0
    assert json.loads(capsys.readouterr().out)["files"][-1] == str(picture)


def test_a_file_that_keeps_no_moments_has_the_picture_too(tmp_path: Path) -> None:
    assert render(tmp_path, "a.exr", "--spp", "8", "--small", "-q") == 0
    assert (tmp_path / "a.variance.png").exists()
    with pytest.raises(ValueError, match="no moments"):
        et.read(tmp_path / "a.exr").save(tmp_path / "b.exr", aov=["variance"])
    assert not (tmp_path / "b.exr").exists()


@pytest.mark.parametrize("wrong", [["albedo"], "variance"])
def test_python_refuses_what_is_not_known(wrong: Any, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="aov lists pictures to write, of variance; found '"):
        et.render(et.load(SCENE).with_(size=(4, 4)), spp=4).save(tmp_path / "a.exr", aov=wrong)
    assert [*tmp_path.iterdir()] == []


def test_too_few_samples_lose_the_picture_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert render(tmp_path, "a.exr", "--spp", "2") == 0
    assert {file.name for file in tmp_path.iterdir()} == {"a.exr", "a.png"}
    assert "warning: there is no picture of the variance: no pixel has the 3 samples" in capsys.readouterr().err
    with pytest.raises(ValueError, match="no pixel has the 3 samples that a variance needs"):
        et.read(tmp_path / "a.exr").save(tmp_path / "b.exr", aov=["variance"])


def test_a_picture_of_another_program_is_not_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = tmp_path / "a.variance.png"
    other.write_bytes(b"mine")
    assert render(tmp_path, "a.exr", "--spp", "4") == 2
    assert f"{other}: is there already" in capsys.readouterr().err
    assert other.read_bytes() == b"mine"
    assert render(tmp_path, "a.exr", "--spp", "4", "--overwrite", "-q") == 0
    assert render(tmp_path, "a.exr", "--spp", "8", "--resume", "-q") == 0, "it is ours now"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--aov", "albedo"], "'albedo' is not known here, only variance; integrator 'aov' of the scene makes others"),
        (["--backend", "embreex", "--spp", "2"], "the backend embreex does not report the variance of its samples"),
    ],
)
def test_what_cannot_be_made_is_refused(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render(tmp_path, "a.exr", *options) == 2
    assert capsys.readouterr().err == f"error: Invalid value for {_option(options)}: {said}\n"
    assert [*tmp_path.iterdir()] == []


def _option(options: list[str]) -> str:
    return "'--aov'" if options[0] == "--aov" else "--aov"
