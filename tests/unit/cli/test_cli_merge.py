"""``equaltime merge``: what it says of the joined image, and what it does not write over."""

from __future__ import annotations

import os
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.film.focus import Focus

from ..scene.test_frames import KEYS, STANDING

CORNELL = str(Path(__file__).parents[3] / "scenes" / "cornell-box.toml")
BALL = et.load_dict(
    {
        "type": "scene",
        "sensor": {"type": "perspective"},
        "sky": {"type": "constant"},
        "ball": {"type": "sphere", "center": [0.0, 0.0, 3.0], "bsdf": {"type": "diffuse"}},
    }
).with_(size=(12, 10))


@pytest.fixture(scope="module")
def parts() -> list[et.Result]:
    return [et.render(BALL, spp=4, seed=seed, threads=1) for seed in range(2)]


def saved(parts: list[et.Result], folder: Path) -> list[str]:
    """Save renders, with their pictures, and return their files."""
    files = [folder / f"{seed}.exr" for seed in range(len(parts))]
    for part, file in zip(parts, files, strict=True):
        part.save(file)
    return [str(file) for file in files]


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def changed(parts: list[et.Result], field: str, value: float) -> list[et.Result]:
    """Return renders with something else in one of their pixels, in one replicate or in all."""
    moments = [part.moments.copy() for part in parts if part.moments is not None]
    for part in moments:
        part[field][(0 if value else slice(None)), 4, 5] = value
    return [replace(part, moments=film) for part, film in zip(parts, moments, strict=True)]


def said(parts: list[et.Result], folder: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    both = str(folder / "both.exr")
    assert main(["merge", *saved(parts, folder), "-o", both]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    lines = captured.out.splitlines()
    assert lines[1] == f"wrote {both}, {folder / 'both.png'}"
    return [lines[0], *lines[2:]]


def test_of_an_image_without_bias_the_seeds_and_the_error_are_told(
    parts: list[et.Result], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line, _ = said(parts, tmp_path, capsys)
    assert line.startswith("Joined 2 renders: 12x10, 8 spp of 2 seeds, error ")
    assert line.endswith(", unbiased")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"strategy": "best,truncate=3"}, "biased: best,truncate=3"),
        ({"without": ["long_paths=3"]}, "biased: without long_paths=3, which makes "),
    ],
)
def test_a_bias_is_told_as_of_a_render(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: dict[str, Any], words: str
) -> None:
    biased = [et.render(BALL, spp=4, seed=seed, threads=1, **options) for seed in range(2)]
    assert words in said(biased, tmp_path, capsys)[0]


def test_the_depth_is_told_as_of_a_render(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cut = [et.render(BALL.with_(max_depth=2), spp=4, seed=seed, threads=1) for seed in range(2)]
    line = said(cut, tmp_path, capsys)[0]
    assert " of 2 seeds, noise " in line
    assert ") of paths up to depth 2; the scene asks for paths of any length: " in line


def test_a_limit_in_doubt_and_pixels_without_a_sample_are_told_as_of_a_render(
    parts: list[et.Result], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    focused = [replace(part, focus=Focus(paths=1.0, light=1e3, share=1e-4)) for part in parts]
    assert "the error's upper limit cannot be trusted: " in said(focused, tmp_path, capsys)[1]
    assert said(changed(parts, "count", 0), tmp_path, capsys)[1:] == ["1 of 120 pixels have no sample"]


@pytest.mark.parametrize("output", ["0.exr", "1.exr", "./0.exr", "link.exr", "pictured.exr"])
def test_a_file_that_is_merged_is_not_written_over(
    parts: list[et.Result], tmp_path: Path, capsys: pytest.CaptureFixture[str], output: str
) -> None:
    files = saved(parts, tmp_path)
    (tmp_path / "link.exr").symlink_to("1.exr")
    (tmp_path / "pictured.png").symlink_to("0.exr")
    before = contents(tmp_path)
    assert main(["merge", *files, "-o", os.path.join(tmp_path, output)]) == 2
    assert "is one of the files to be merged; write to another" in capsys.readouterr().err
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("output", "told"),
    [
        ("both.png", "the joined render is an EXR file with a PNG beside it; give -o {}/both.exr instead\n"),
        ("both.jpg", "the joined render is an EXR file with a PNG beside it; give -o {}/both.exr instead\n"),
        ("both", "; expected .exr\n"),
    ],
)
def test_a_file_that_cannot_hold_moments_is_refused(
    parts: list[et.Result], tmp_path: Path, capsys: pytest.CaptureFixture[str], output: str, told: str
) -> None:
    files = saved(parts, tmp_path)
    before = contents(tmp_path)
    assert main(["merge", *files, "-o", str(tmp_path / output)]) == 2
    assert capsys.readouterr().err.endswith(told.format(tmp_path))
    assert contents(tmp_path) == before


def test_a_picture_is_no_part(parts: list[et.Result], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, *_ = saved(parts, tmp_path)
    picture = str(Path(first).with_suffix(".png"))
    for given, told in ((picture, f"give {first} instead"), ("lost.jpg", "render it with -o FILE.exr, and give that")):
        assert main(["merge", first, given, "-o", str(tmp_path / "both.exr")]) == 2
        assert f"{given}: a picture has no samples to merge; {told}" in capsys.readouterr().err


def test_info_gives_the_commands_that_make_the_parts_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """They run as they are printed, and give the same picture."""
    monkeypatch.chdir(tmp_path)
    for seed, spp in ((3, 4), (8, 6)):
        words = ["--size", "8x6", "--max-depth", "3", "-D", "light_scale=0.5", "--seed", str(seed), "--spp", str(spp)]
        assert main(["render", CORNELL, "-o", f"{seed}.exr", *words, "-q"]) == 0
    assert main(["merge", "3.exr", "8.exr", "-o", "both.exr"]) == 0
    capsys.readouterr()
    assert main(["info", "both.exr"]) == 0
    lines = capsys.readouterr().out.splitlines()
    commands = [line[10:] for line in lines if line[10:].startswith("equaltime ")]
    assert [line[:10].strip() for line in lines if line[10:] in commands] == ["repeat", "", ""]
    assert not any("but " in line for line in lines)
    image = et.read("both.exr").image
    Path("both.exr").unlink()
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0
    assert (et.read("both.exr").image == image).all()


def test_info_gives_few_commands_of_many_parts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = [et.render(et.load(CORNELL).with_(size=(8, 6)), spp=2, seed=seed) for seed in range(6)]
    monkeypatch.chdir(tmp_path)
    et.merge([et.merge(parts[:2]), *parts[2:]]).save("all.exr")
    assert main(["info", "all.exr"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 12
    assert [line[:16] for line in lines].count("          equalt") == 2
    assert "          and so on for 3 more parts, then equaltime merge: -v shows all" in lines
    assert main(["info", "all.exr", "-v"]) == 0
    told = capsys.readouterr().out
    assert all(f"-o part-{seed}.exr --spp 2 " in told for seed in range(6))
    assert "equaltime merge part-0.exr " in told


def test_a_frame_of_merged_renders_is_repeated_as_a_frame(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(STANDING + KEYS)
    for seed in (0, 7):
        words = ["--size", "8x6", "--spp", "2", "--frames", "1", "--seed", str(seed), "-q"]
        assert main(["render", "scene.toml", "-o", f"{seed}-#.exr", *words]) == 0
    assert main(["merge", "0-1.exr", "7-1.exr", "-o", "both.exr"]) == 0
    capsys.readouterr()
    assert main(["info", "both.exr"]) == 0
    told = capsys.readouterr().out
    assert "-o 'part-8_####.exr' --spp 2 --frames 1 --size 8x6 --seed 7" in told
    assert "equaltime merge part-1_0001.exr part-8_0001.exr -o both.exr" in told


def test_the_number_of_renders_that_a_smaller_error_takes_is_told(
    parts: list[et.Result], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["merge", *saved(parts, tmp_path), "-o", str(tmp_path / "m.exr")]) == 0
    last, error = capsys.readouterr().out.splitlines()[-1], et.read(tmp_path / "m.exr").error
    found = re.fullmatch(r"([\d.]+) % takes about ([\d.]+) \(.+ to .+\) such renders in all, each with .*", last)
    assert found is not None
    assert float(found[2]) == pytest.approx(2 * (error.value / (0.01 * float(found[1]))) ** 2, rel=0.06)
