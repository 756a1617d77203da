"""Previews of results: their exposure in files, in notebooks, at checkpoints and on the command line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.images import image_files, preview
from equaltime.rendering.render_file import read_picture

DIM = """
[sensor]
type = "perspective"
film = { type = "hdrfilm", width = 6, height = 4 }
[sky]
type = "constant"
radiance = 0.04
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "dim.toml"
    file.write_text(DIM)
    return file


def shade(path: Path) -> int:
    return int(oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)[1, 2, 0])


def description(path: Path) -> str:
    return image_files.read_attributes(path)["ImageDescription"]


def test_a_dark_picture_is_shown_brighter_and_its_data_stay(scene: Path, tmp_path: Path) -> None:
    result = et.render(scene, spp=2)
    assert result.exposure() == 4.0
    result.save(tmp_path / "a.exr")
    assert shade(tmp_path / "a.png") == 209  # 0.64
    assert description(tmp_path / "a.png").endswith("; shown 4 stops brighter")
    assert "stops brighter" not in description(tmp_path / "a.exr")
    assert read_picture(tmp_path / "a.exr").image == pytest.approx(0.04, rel=1e-3)
    result.save(tmp_path / "b.png", exposure=-1.5)
    assert shade(tmp_path / "b.png") < shade(tmp_path / "a.png")
    with pytest.raises(ValueError, match="'auto' or a number of stops"):
        result.save(tmp_path / "c.png", exposure="bright")  # type: ignore[arg-type]
    assert not (tmp_path / "c.png").exists()


def test_an_exposure_of_the_opaque_parts_alone_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "dark.toml"
    file.write_text(f"""{DIM.replace("0.04", "1.0")}
[ball]
type = "sphere"
center = [0.0, 0.0, 8.0]
bsdf = {{ type = "diffuse", reflectance = 0.02 }}
""")
    render = ["render", str(file), "-o", str(tmp_path / "a.exr"), "--spp", "4", "--size", "32x32"]
    said = " (5 stops brighter for what is not transparent)\n"
    assert main(render) == 0
    assert "stops brighter" not in capsys.readouterr().out
    assert main([*render, "--transparent"]) == 0
    assert f"a.png{said}" in capsys.readouterr().out
    assert main(["convert", str(tmp_path / "a.exr"), str(tmp_path / "b.png")]) == 0
    assert f"b.png{said}" in capsys.readouterr().out
    assert main([*render, "--transparent", "--exposure", "5"]) == 0
    assert "a.png (5 stops brighter)\n" in capsys.readouterr().out


def test_a_notebook_shows_what_the_file_shows(scene: Path, tmp_path: Path) -> None:
    result = et.render(scene, spp=2)
    (tmp_path / "shown.png").write_bytes(result._repr_png_())
    assert shade(tmp_path / "shown.png") == 209


def test_pixels_without_a_sample_have_no_say(scene: Path) -> None:
    result = et.render(scene, spp=2)
    image, samples = result.image.copy(), result.samples.copy()
    image[1:], samples[1:] = 0.0, 0
    assert replace(result, image=image, samples=samples).exposure() == 4.0


def test_a_transparent_background_has_no_say(scene: Path) -> None:
    """A tenth of the picture is opaque to a half and has a radiance of 0.04."""
    result = et.render(scene, spp=2)
    image, alpha = np.zeros((10, 10, 3), np.float32), np.zeros((10, 10), np.float32)
    image[0], alpha[0] = 0.02, 0.5
    origin = replace(result.origin, picture=replace(result.origin.picture, alpha=True))
    samples = np.full((10, 10), 2)
    seen = replace(result, image=image, samples=samples, aovs={"A": alpha}, origin=origin)
    assert seen.exposure() == 4.0


def test_the_preview_of_checkpoints_keeps_its_exposure(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last preview is 3 stops brighter whatever came before, and those on the way stay at the first one's 4."""
    shown: list[float] = []
    write = preview.write

    def watched(path: Path, image: Any, *rest: Any, **named: Any) -> None:
        shown.append(rest[3])
        write(path, image, *rest, **named)

    monkeypatch.setattr(preview, "write", watched)
    brighter = iter([1.0, 1.0])
    plain = et.Result.exposure

    def stops(result: et.Result, exposure: Any = "auto", before: float = 0.0) -> float:
        return plain(replace(result, image=result.image * np.float32(next(brighter, 1.6))), exposure, before)

    monkeypatch.setattr(et.Result, "exposure", stops)
    path = tmp_path / "a.exr"
    large = et.load(scene).with_(size=(64, 64))
    result = et.render(large, spp=512, checkpoint=path, checkpoint_every=1e-6)
    result.save(path)
    assert len(shown) >= 3
    assert {*shown[:-1]} == {4.0}
    assert shown[-1] == 3.0
    shown.clear()
    et.render(large, spp=64, checkpoint=path, checkpoint_every=1e-6, checkpoint_exposure=-2.0)
    assert {*shown} == {-2.0}
    with pytest.raises(ValueError, match="at most 150 stops"):
        et.render(large, spp=1, checkpoint=path, checkpoint_exposure=1e3)


def test_the_command_says_how_the_preview_is_shown(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["render", str(scene), "-o", str(tmp_path / "a.exr"), "--spp", "2"]
    assert main(command) == 0
    assert capsys.readouterr().out.rstrip().endswith(f"{tmp_path / 'a.png'} (4 stops brighter)")
    for stops, shown, how in (("-2", " (exposure -2)", "6 stops"), ("0", " (exposure 0)", "4 stops")):
        assert main([*command, "--exposure", stops]) == 0
        first, told, *_ = capsys.readouterr().out.splitlines()[-2:]
        assert first.endswith(f"{tmp_path / 'a.png'}{shown}")
        said = "exposures are counted from the scene's own values (0): auto would be 4, and"
        assert told == f"{said} {stops} is {how} darker"
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["exposure"] == 4.0


@pytest.mark.parametrize("wrong", ["bright", "nan", "1e3", ""])
def test_what_is_no_exposure_is_refused(
    wrong: str, scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["render", str(scene), "-o", str(tmp_path / "a.exr"), "--exposure", wrong]) == 2
    said = f"error: Invalid value for '--exposure': '{wrong}' is no exposure; write auto, or stops such as 1.5 or -2\n"
    assert capsys.readouterr().err == said


@pytest.mark.parametrize("name", ["a.jpg", "a.jpeg", "A.JPG"])
def test_a_jpeg_is_the_preview_alone_and_guarded_as_a_png_is(
    name: str, scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    command = ["render", str(scene), "-o", str(path), "--spp", "2", "-q"]
    assert main(command) == main(command) == 0
    assert {file.name for file in tmp_path.iterdir()} == {"dim.toml", name}
    assert abs(shade(path) - 209) <= 1
    other = tmp_path / "other.toml"
    other.write_text(DIM.replace("0.04", "0.05"))
    before = path.read_bytes()
    assert main([*command[:1], str(other), *command[2:]]) == 2
    assert "a render of another scene" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert main([*command, "--resume"]) == 2
    assert "only FILE.exr can be continued" in capsys.readouterr().err
