"""The command ``equaltime convert`` on saved renders: their pictures."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.images import image_files, preview
from equaltime.images.preview import srgb_bytes

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
    converted, rendered = (oiio.ImageBuf(str(saved.with_name(each))) for each in (name, f"c{name}"))
    assert np.array_equal(converted.get_pixels(), rendered.get_pixels())
    ours, theirs = (image_files.read_attributes(saved.with_name(each)) for each in (name, f"c{name}"))
    told = json.loads(ours[preview.REPEAT])
    assert told.pop("saved") == str(saved)
    assert {**ours, preview.REPEAT: told} == {**theirs, preview.REPEAT: json.loads(theirs[preview.REPEAT])}


def test_info_on_a_converted_picture_names_the_render_it_was_made_from(
    saved: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(saved.parent)
    Path("pictures").mkdir()
    assert main(["convert", "a.exr", "pictures/b.jpg", "-q"]) == 0
    assert main(["info", "pictures/b.jpg"]) == 0
    assert capsys.readouterr().out.endswith(f"record    equaltime info {saved}\n")
    assert main(["info", "pictures/b.jpg", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["record"] == facts["made_from"] == str(saved)
    saved.unlink()
    assert main(["info", "pictures/b.jpg"]) == 0
    gone = f"record    was in {saved}, which is not there or shows another render now\n"
    assert capsys.readouterr().out.endswith(gone)


def test_an_exposure_is_told_beside_the_automatic_one(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    dark = et.read(saved)
    replace(dark, image=dark.image / np.float32(64.0)).save(saved, overwrite=True)
    automatic = et.read(saved).exposure()
    assert automatic > 2.0
    for stops, shown in (
        (f"{automatic:g}", f"{automatic:g} stops brighter"),
        ("auto", f"{automatic:g} stops brighter"),
        ("1", "exposure 1"),
    ):
        picture = saved.with_name(f"{stops}.png")
        assert main(["convert", str(saved), str(picture), "--exposure", stops]) == 0
        said = f"wrote {picture} ({shown})\n"
        if stops == "1":
            more = f"{automatic - 1:g} stop{'s' * (automatic != 2.0)} darker"
            said += (
                f"exposures are counted from the scene's own values (0): auto would be {automatic:g}, and 1 is {more}\n"
            )
        assert capsys.readouterr().out == said


def test_a_picture_that_is_burnt_out_says_how_much(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The twin has fewer white pixels than are told."""
    plain = et.read(saved)
    few, count = plain.image[..., 0].size // 25, plain.image[..., 0].size // 5
    for number, told in ((count, True), (few, False)):
        image = np.full_like(plain.image, 0.25)
        image.reshape(-1, 3)[:number] = 0.6
        replace(plain, image=image).save(saved, overwrite=True)
        assert main(["convert", str(saved), str(saved.with_name(f"{number}.png")), "--exposure", "1"]) == 0
        share = round(100.0 * number / plain.image[..., 0].size)
        said = f"; {share} % of the picture is white: larger values are cut, not tone mapped\n"
        assert capsys.readouterr().out.endswith(said) == told


def test_a_picture_overwrites_no_file_and_is_png_or_jpeg(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, problem in (
        ("a.png", "is there already; choose another name, or --overwrite replaces it"),
        ("a.toml", "is a file .png or .jpg"),
    ):
        assert main(["convert", str(saved), str(saved.with_name(name))]) == 2
        assert problem in capsys.readouterr().err
    assert not saved.with_name("a.toml").exists()
    before = saved.with_name("a.png").read_bytes()
    assert main(["convert", str(saved), str(saved.with_name("a.png")), "--exposure", "-1", "--overwrite"]) == 0
    assert saved.with_name("a.png").read_bytes() != before
    assert not saved.with_name("a.png~").exists()


@pytest.mark.parametrize("name", ["a.pfm", "a.hdr", "a.PNG", "a.jpg", "a.tiff"])
def test_other_pictures_are_refused_as_pictures(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / name).touch()
    assert main(["convert", str(tmp_path / name), str(tmp_path / "b.png")]) == 2
    said = capsys.readouterr().err
    assert "is a picture, and convert takes a scene file, or of pictures a render that equaltime saved as" in said
    assert "kind of scene file" not in said


@pytest.mark.parametrize("name", ["client.png", "client.jpg"])
def test_a_picture_without_metadata_tells_nothing_of_its_render(
    name: str, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture, plain = saved.with_name(name), saved.with_name(f"plain-{name}")
    assert main(["convert", str(saved), str(plain), "-q"]) == 0
    assert main(["convert", str(saved), str(picture), "--no-metadata", "-q"]) == 0
    assert np.array_equal(oiio.ImageBuf(str(picture)).get_pixels(), oiio.ImageBuf(str(plain)).get_pixels())
    assert b"cornell" in plain.read_bytes()
    for private in (b"cornell", b"equaltime", str(saved.parent).encode(), et.read(saved).origin.digest.encode()):
        assert private not in picture.read_bytes()
    assert "oiio:ColorSpace" in image_files.read_attributes(picture)
    assert main(["info", str(picture)]) == 2
    assert "was not rendered by equaltime, or was written with --no-metadata" in capsys.readouterr().err
    again = ["render", str(SCENE), "-o", str(picture), "--size", "8x6", "--spp", "4", "-q"]
    assert main(again) == 2
    assert "does not say that equaltime made it; --overwrite replaces it" in capsys.readouterr().err
    assert main([*again, "--overwrite"]) == 0


def test_only_a_picture_can_do_without_metadata(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="only a PNG or JPEG that is written alone can do without metadata"):
        et.read(saved).save(saved.with_name("b.exr"), metadata=False)
    assert main(["convert", str(SCENE), str(saved.with_name("b.toml")), "--no-metadata"]) == 2
    assert "--no-metadata: is for the picture of a render" in capsys.readouterr().err


def test_a_jpeg_of_less_quality_is_smaller(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fine, usual, coarse = (saved.with_name(f"{quality}.jpg") for quality in (100, 95, 20))
    for picture in (fine, coarse):
        assert main(["convert", str(saved), str(picture), "--quality", picture.stem, "-q"]) == 0
    assert main(["convert", str(saved), str(usual), "-q"]) == 0
    assert fine.stat().st_size > usual.stat().st_size > coarse.stat().st_size
    for name, quality, problem in (
        ("b.png", "50", "a PNG loses nothing: only a JPEG has a quality"),
        ("b.jpg", "0", "'0' is no whole number from 1 to 100"),
        ("b.jpg", "101", "'101' is no whole number from 1 to 100"),
    ):
        assert main(["convert", str(saved), str(saved.with_name(name)), "--quality", quality]) == 2
        assert problem in capsys.readouterr().err
    with pytest.raises(ValueError, match="the quality of a JPEG must be in"):
        et.read(saved).save(saved.with_name("b.jpg"), quality=0)


def test_an_option_of_pictures_is_answered_by_the_command_that_has_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["render", str(SCENE), "-o", "a.jpg", "--no-metadata"]) == 2
    assert "equaltime convert has --no-metadata for a PNG or JPEG of a saved render" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (["render", str(SCENE), "-o", "a.jpg"], "--error 2% chooses the accuracy of a render, and equaltime convert"),
        (["lint", str(SCENE)], "there is no option --quality here; equaltime convert has --quality for a JPEG"),
    ],
)
def test_a_quality_elsewhere_is_answered_by_where_it_is(
    command: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*command, "--quality", "90"]) == 2
    assert told in capsys.readouterr().err


SKY = """
[sensor]
type = "perspective"
to_world = [{ look_at = { origin = [0, 0, 4], target = [0, 0, 0], up = [0, 1, 0] } }]
film = { type = "hdrfilm", width = 8, height = 8 }
[sky]
type = "constant"
radiance = 0.5
[ball]
type = "sphere"
"""


@pytest.fixture
def cut_out(tmp_path: Path) -> Path:
    (tmp_path / "ball.toml").write_text(SKY)
    path = tmp_path / "cut.exr"
    assert main(["render", str(tmp_path / "ball.toml"), "-o", str(path), "--spp", "4", "--transparent", "-q"]) == 0
    return path


def corner(picture: Path) -> list[int]:
    return [round(255.0 * value) for value in oiio.ImageBuf(str(picture)).getpixel(0, 0)]


def test_a_jpeg_of_a_transparent_render_is_told_to_be_black_behind(
    cut_out: Path, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for source, name, told in ((cut_out, "b.jpg", True), (cut_out, "b.png", False), (saved, "c.jpg", False)):
        assert main(["convert", str(source), str(source.with_name(name))]) == 0
        assert ("a JPEG has no alpha: it is black where" in capsys.readouterr().out) == told
    assert corner(cut_out.with_name("b.jpg")) == [0, 0, 0]
    assert corner(cut_out.with_name("b.png"))[3] == 0


@pytest.mark.parametrize(("name", "within"), [("b.png", 0), ("b.jpg", 2)])
@pytest.mark.parametrize(
    ("colour", "expected"),
    [
        ("white", [255, 255, 255]),
        ("0.5,0.25,0.1", [188, 137, 89]),
        ("#ff8800", [255, 136, 0]),  # encoded sRGB, as on web pages
        ("#F80", [255, 136, 0]),
    ],
)
def test_a_background_is_seen_behind_a_transparent_render(
    colour: str, expected: list[int], name: str, within: int, cut_out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = cut_out.with_name(name)
    assert main(["convert", str(cut_out), str(picture), "--background", colour, "--exposure", "-1"]) == 0
    assert "no alpha" not in capsys.readouterr().out
    assert corner(picture) == pytest.approx(expected, abs=within)


def test_the_pixels_at_an_edge_are_mixed_with_the_background_in_linear_light(cut_out: Path) -> None:
    result = et.read(cut_out)
    assert result.alpha is not None
    result.save(cut_out.with_name("b.png"), exposure=1.0, background=(0.0, 0.5, 0.0))
    linear = 2.0 * result.image + (1.0 - result.alpha)[..., None] * np.array([0.0, 0.5, 0.0])
    shown = oiio.ImageBuf(str(cut_out.with_name("b.png"))).get_pixels(oiio.UINT8)
    assert (shown == srgb_bytes(linear)).all()
    with pytest.raises(ValueError, match="background is a linear colour"):
        result.save(cut_out.with_name("c.png"), background=(1.0, 1.0))


@pytest.mark.parametrize(
    ("source", "colour", "problem"),
    [
        ("cut.exr", "red", "'red' is no colour; write white, black, #rrggbb as on web pages, or linear R,G,B"),
        ("cut.exr", "#ff88", "'#ff88' is no colour; write white, black, #rrggbb"),
        ("cut.exr", "1,1,2", "'1,1,2' is no colour"),
        ("a.exr", "white", "a.exr has no alpha: render it with --transparent"),
        ("ball.toml", "white", "is for the picture of a render"),
    ],
)
def test_a_background_is_a_colour_behind_a_render_with_alpha(
    source: str, colour: str, problem: str, cut_out: Path, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["convert", str(saved.with_name(source)), str(cut_out.with_name("b.png")), "--background", colour]) == 2
    assert problem in capsys.readouterr().err


def test_the_commands_that_repeat_a_converted_picture_give_the_picture_again(
    cut_out: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(cut_out.parent)
    for name, words in (("b.jpg", []), ("c.png", ["--background", "1,0.12345678,0"]), ("d.png", [])):
        assert main(["convert", cut_out.name, name, "--exposure", "1", *words]) == 0
        before = oiio.ImageBuf(name).get_pixels()
        capsys.readouterr()
        assert main(["info", name]) == 0
        commands = [
            shlex.split(line)[2:]
            for line in capsys.readouterr().out.splitlines()
            if line.startswith(("repeat ", "then "))
        ]
        Path(name).unlink()
        for command in commands:
            assert main([*command, "-q"]) == 0
        assert np.array_equal(oiio.ImageBuf(name).get_pixels(), before)
