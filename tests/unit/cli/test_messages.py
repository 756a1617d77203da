"""How the command line writes numbers."""

import math
import shlex
from dataclasses import replace
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.messages import doubts, lint_command, once_each, print_error, print_remarks, while_heard
from equaltime.film.focus import Focus
from equaltime.words import duration, seconds_of


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0 ms"),
        (0.01234, "12.3 ms"),
        (0.9996, "1 s"),
        (4.56, "4.56 s"),
        (299.0, "299 s"),
        (2040.0, "34 min"),
        (7140.0, "119 min"),
        (7196.0, "2 h"),
        (18001.0, "5 h"),
        (1e6, "11.6 days"),
        (math.inf, "inf days"),
    ],
)
def test_a_time_is_written_in_the_unit_that_people_would_use(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize("seconds", [0.0123, 4.56, 2040.0, 18000.0, 950400.0, 1e9])
def test_a_time_that_is_written_can_be_read_again(seconds: float) -> None:
    assert seconds_of(duration(seconds)) == pytest.approx(seconds, rel=5e-3)  # three digits are written


def test_what_nobody_hears_any_more_is_said_once_and_harms_nobody() -> None:
    tried: list[str] = []

    def say(words: str) -> None:
        tried.append(words)
        raise BrokenPipeError

    said = while_heard(say)
    said("one")
    said("two")
    assert tried == ["one"]


def test_a_problem_with_a_line_separator_of_unicode_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    print_error("a\u2028b\x85c\x0cd\nsecond")
    assert capsys.readouterr().err == "error: a\\u2028b\\x85c\\x0cd\nerror: second\n"


def test_warnings_that_differ_by_place_or_file_name_alone_are_told_once() -> None:
    lost = [f"a.mtl:{line}: the image 'lost{line}.png' is left out: no such file" for line in (3, 5, 8)]
    other = [
        "a.mtl:4: 'Ks' is not used: gloss comes from Pr and Pm alone",
        "a.mtl:6: 'Ni' is not used: surfaces are diffuse",
    ]
    told = once_each([lost[0], other[0], *lost[1:], other[1]])
    assert told == [f"{lost[0]} (and 2 more like it: lint -v)", *other]


def test_commands_without_a_picture_tell_many_remarks_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = tmp_path / "a shape.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")

    def told(*command: str) -> list[str]:
        assert main([*command, "--size", "8x8"]) == 0
        return [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning")]

    in_full = told("render", str(mesh), "-o", str(tmp_path / "a.png"), "--spp", "2")
    assert len(in_full) > 1
    short = [f"warning: {len(in_full)} kinds of remarks on how the file was read; see equaltime lint '{mesh}'"]
    assert told("quote", str(mesh), "--error", "50%", "--no-why") == short
    assert told("quote", str(mesh), "--error", "50%", "--no-why", "-D", "up=z") == [f"{short[0]} -D up=z"]
    assert told("effects", str(mesh), "--quick") == short
    assert told("replay", str(mesh), "--pixel", "1,1", "--sample", "0") == short
    assert main(["info", str(mesh)]) == 0
    assert capsys.readouterr().err.splitlines() == short
    assert main(["lint", str(mesh)]) == 0
    listed = capsys.readouterr().out
    assert all(line.removeprefix("warning: ") in listed for line in in_full)
    print_remarks(replace(et.load(mesh), warnings=("only this",)))
    assert capsys.readouterr().err == "warning: only this\n"


def test_the_command_that_lists_remarks_reads_the_scene_with_the_same_options(tmp_path: Path) -> None:
    scene = tmp_path / "a.toml"
    scene.write_text('a = { type = "sphere", bsdf = { type = "hair" } }\nb = { type = "constant", radiance = "$r" }\n')
    told = lint_command(et.load(scene, substitute=True, r=2))
    assert told == f"equaltime lint {scene} -D r=2 --substitute"
    assert main(shlex.split(told)[1:]) == 0


RARE = "light that the 12.5 samples of a pixel have not met is not in the error"


@pytest.mark.parametrize(
    ("forecast", "line"),
    [
        ("", f"the error's upper limit cannot be trusted: {RARE}"),
        (RARE.replace("12.5", "8"), "the error's upper limit cannot be trusted, for the reason told with the forecast"),
        ("a heavy tail", f"the error's upper limit cannot be trusted: {RARE}"),
    ],
)
def test_a_doubt_of_the_forecast_is_not_told_again(forecast: str, line: str) -> None:
    result = et.render(et.load("cornell-box").with_(size=(8, 8)), spp=2)
    assert doubts(replace(result, error=result.error.doubted(RARE)), forecast=forecast) == [line]


def test_the_size_of_the_sun_of_a_mesh_is_named_where_its_light_is_focused(tmp_path: Path) -> None:
    mesh = tmp_path / "a.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    focus = Focus(paths=1.0, light=1e3, share=1e-4)
    for scene, told in ((et.load(mesh), True), (et.load(mesh, sun=0), False), (et.load("cornell-box"), False)):
        result = et.render(scene.with_(size=(8, 8)), spp=2)
        doubtful = replace(result, error=result.error.doubted(RARE), focus=focus)
        assert any("-D sun_angle=15" in line for line in doubts(doubtful)) == told
