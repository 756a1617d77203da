"""What a command says of how it ended."""

from __future__ import annotations

import json
import math
import shlex
import tempfile
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.messages import Written, doubts
from equaltime.cli.recorded import shown_path
from equaltime.cli.render_outcome import details, outcome
from equaltime.rendering.budget import Look, Stop
from equaltime.rendering.stated import samples_in_words
from equaltime.statistics.in_words import count
from equaltime.words import duration

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


def why(folder: Path, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    """Return why a render says that it stopped."""
    assert main(["render", str(SCENE), "-o", str(folder / "a.exr"), "--seed", "1", *options]) == 0
    return next(line for line in capsys.readouterr().out.splitlines() if not line.startswith("Expect "))


def test_counts_that_differ_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--size", "32x32", "--spp", "32", "--strategy", "best,adaptive=error", "-v"]
    assert main(["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--seed", "1", *words]) == 0
    said = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("pixels have "))
    fewest, most = (int(word) for word in said.split() if word.isdigit())
    assert said == f"pixels have {fewest} to {most} samples"
    assert fewest < 32 < most


def test_what_the_strategy_left_to_the_render_is_said_if_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--size", "32x32", "--spp", "32", "--strategy", "best,roulette=automatic,adaptive=error"]
    command = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), *words]
    decided = (
        "paths are not split: small pictures, and the techniques uniform and mixture, get no pilot; "
        "noisy parts have more samples"
    )
    assert main([*command, "-v"]) == 0
    assert decided in capsys.readouterr().out.splitlines()
    assert main(command) == 0
    assert decided not in capsys.readouterr().out
    assert main(["info", str(tmp_path / "a.exr"), "-v"]) == 0
    assert "decision" in capsys.readouterr().out


def test_every_key_of_the_strategy_is_told_if_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = str(tmp_path / "a.exr")
    in_full = et.Strategy.parse("mis").in_full
    assert "technique=mis,heuristic=balance," in in_full
    assert main(["render", str(SCENE), "-o", output, "--size", "8x8", "--spp", "4", "--strategy", "mis", "-v"]) == 0
    assert f"strategy {in_full}" in capsys.readouterr().out.splitlines()
    assert main(["info", output, "-v"]) == 0
    assert [line.split()[3] for line in capsys.readouterr().out.splitlines() if "strategy in full" in line] == [in_full]


def test_samples_that_follow_the_noise_are_told_beside_those_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(tmp_path / "a.exr")
    assert main(["render", str(SCENE), "-o", path, "--size", "48x48", "--spp", "64"]) == 0
    assert main(["info", path]) == 0
    for line in (line for line in capsys.readouterr().out.splitlines() if "samples a pixel" in line):
        assert " samples a pixel (for 64: more where it is noisy)" in line
    assert samples_in_words(64.2, 64) == samples_in_words(64.2, None) == "64 samples a pixel"


def ended(*looks: tuple[float, ...], target: float = 0.05) -> et.Result:
    """Return a render that ended by these looks at its error: samples, value, upper limit, perhaps brightest path."""
    result = et.render(et.load("cornell-box").with_(size=(8, 8)), spp=2)
    made = tuple(Look(int(samples), *errors) for samples, *errors in looks)
    error = et.Interval(made[-1].value, 0.0, made[-1].high)
    return replace(result, stopped_by="error", stop=Stop("look", target), looks=made, error=error)


@pytest.mark.parametrize(("last", "told"), [(0.037, True), (0.038, False)])
def test_an_error_far_below_the_wanted_one_is_explained(last: float, told: bool) -> None:
    """The looks of a brass ball of 400x300 pixels: the limit at 18 samples is small enough, the one before was not."""
    result = ended((8, 0.075, 0.1227), (12, 0.0489, 0.0729), (18, 0.03, 0.034), (26, 0.0232, last))
    counted = " (a look counts at least 1.15 times the estimate)"  # 3.45 % is above the limit of 3.4 %
    looks = f"at most 7.29 % at 12, 3.45 % at 18, {100.0 * last:.1f} % at 26 samples a pixel{counted}"
    lines = [line for line in outcome(result, Written([Path("a.exr")]), None) if "looks" in line]
    assert (
        lines
        == [f"better than asked for, as a render goes on until two looks in a row find its error small: {looks}"] * told
    )
    assert (f"last looks at the error: {looks}" in details(result, {})) is not told
    later = outcome(result, Written([Path("a.exr")]), None, first=False)
    assert not any("better than asked for" in line for line in later)


def test_a_look_whose_limit_a_bright_path_widened_is_told() -> None:
    """The windmill: polished gold reflects the sun to one pixel."""
    looks = (300, 0.0081, 0.0372, 1.63), (420, 0.0058, 0.0067, 0.2), (588, 0.0044, 0.005, 0.03)
    line = next(line for line in outcome(ended(*looks, target=0.01), Written([Path("a.exr")]), None) if "looks" in line)
    looks = "at most 3.72 % at 300 (due to a bright path), 0.67 % at 420, 0.506 % at 588 samples a pixel"
    assert f"{looks} (a look counts" in line
    wide = (300, 0.0081, 0.0372, 1.63), (420, 0.0058, 0.0067, 0.2), (588, 0.0044, 0.006, 0.03)
    lines = outcome(ended(*wide, target=0.01), Written([Path("a.exr")]), None)
    assert not any("a look counts" in line for line in lines), "all are upper limits"


def test_a_render_that_was_small_enough_before_is_not_explained() -> None:
    """It was resumed with a larger error than it had reached."""
    result = ended((12, 0.03, 0.04), (18, 0.03, 0.034), (26, 0.0232, 0.03))
    assert [line for line in outcome(result, Written([Path("a.exr")]), None) if "looks" in line] == []


@pytest.mark.parametrize(("chosen", "told"), [(9, True), (8, False)])
def test_a_count_that_an_earlier_run_had_reached_is_not_called_missed(chosen: int, told: bool) -> None:
    """A render with --stop fixed was resumed with a time limit."""
    result = replace(et.render(et.load(SCENE).with_(size=(8, 8)), spp=8), stopped_by="time")
    lines = [*outcome(replace(result, stop=Stop("fixed", 0.5, chosen, 5, 2, 0.1)), Written([Path("a.exr")]), None)]
    assert any(line.startswith(f"ended before the {chosen} samples a pixel") for line in lines) is told


@pytest.mark.parametrize(("end", "spp", "told"), [("time", 1, True), ("time", 2, False), ("spp", 1, False)])
def test_a_time_that_is_too_short_for_an_error_is_told(end: str, spp: int, told: bool) -> None:
    result = et.render(et.load(SCENE).with_(size=(8, 8)), spp=spp, strategy="mis,sampler=independent")
    stats = replace(result.stats, phases={**result.stats.phases, "render": 3.0})
    lines = [*outcome(replace(result, stopped_by=end, stats=stats), Written([Path("a.exr")]), None)]
    said = "the time was too short: an error takes 2 samples a pixel, about 6 s here"
    assert (said in lines) is told


@pytest.mark.parametrize(("options", "warned"), [([], True), (["--resume"], False), (["-q"], False)])
def test_a_time_that_may_be_too_short_is_told_before_the_render(
    options: list[str],
    warned: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A resumed render has samples already."""
    monkeypatch.setattr("equaltime.cli.render_picture.seconds_of_pilot", lambda *_: 7.3)
    words = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "8x8"]
    assert main([*words, "--spp", "2"]) == 0
    assert "too short" not in capsys.readouterr().err
    assert main([*words, "--time", "20ms", *(options or ["--overwrite"])]) == 0
    said = "warning: the time of 20 ms may be too short to know the error: 2 samples a pixel, which an error takes, "
    assert (f"{said}take about 7 s\n" in capsys.readouterr().err) is warned


def test_a_quote_of_too_short_a_time_has_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["quote", str(SCENE), "--size", "64x64", "--time", "0.01ms"]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith("In 0.01 ms: no error can be known: it takes 2 samples a pixel, which take ")


def test_the_seconds_of_all_runs_and_of_this_one_are_told_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "32x32", "--time", "0.3s", "--resume"]
    assert main(words) == 0
    assert " runs" not in (said := capsys.readouterr().out)
    assert "this run" not in said
    assert main([*words, "-v"]) == 0
    seconds = duration(et.read(tmp_path / "a.exr").stats.seconds)
    said = capsys.readouterr().out
    assert "Time is up: error " in said
    assert said.count(f"{seconds} over 2 runs,") == 2, "in the first line, and in that of the phases"
    assert " after 300 ms of this run," in said
    assert main(["info", str(tmp_path / "a.exr")]) == 0
    assert f" in {seconds} over 2 runs\n" in capsys.readouterr().out


def test_a_limit_is_that_of_the_noise_unless_the_bias_was_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--size", "12x12", "--error", "60%")
    assert why(tmp_path, capsys, *options).startswith("Reached 60 %: error ")
    assert main(["render", str(SCENE), "-o", str(tmp_path / "a.exr"), *options, "--without", "long_paths=3"]) == 0
    assert "\nReached 60 %: error " in capsys.readouterr().out
    for cut in (("--strategy", "best,truncate=2"), ("--max-depth", "2")):
        assert why(tmp_path, capsys, *options, *cut).startswith("Reached 60 %: noise ")


@pytest.mark.parametrize(
    ("options", "paths", "missing"),
    [
        (["--max-depth", "2"], " of paths up to depth 2", "the scene asks for paths up to depth 30: "
         "`--without long_paths=2` instead of `--max-depth 2` measures the difference"),
        (["--max-depth", "40"], " of paths up to depth 40", "the scene asks for paths up to depth 30"),
        (["--strategy", "best,truncate=2"], " of paths up to depth 2", "biased: best,truncate=2; the scene asks for "
         "paths up to depth 30: `--without long_paths=2` measures the difference"),
        (["--strategy", "best,adaptive=history"], "", "biased: best,adaptive=history; the bias is not in the "
         "noise: `equaltime compare` with a render by `best` measures it"),
    ],
)  # fmt: skip
def test_the_noise_of_an_image_that_is_not_the_scene_s_is_not_called_its_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], paths: str, missing: str
) -> None:
    output = str(tmp_path / "a.exr")
    assert main(["render", str(SCENE), "-o", output, "--size", "12x12", "--spp", "8", *options]) == 0
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("Done: noise ")
    assert f"){paths} in " in first
    assert "unbiased" not in first
    assert second == missing
    assert main(["info", output]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith(f"{output}: noise ")
    assert any(line.startswith("lacks ") for line in said)


def test_a_depth_that_the_scene_has_itself_leaves_the_number_its_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "12x12", "--max-depth", "30"]) == 0
    said = capsys.readouterr().out.splitlines()[0]
    assert said.startswith("Done: error ")
    assert ", unbiased -> " in said


def test_the_record_and_the_quote_name_the_depth_and_the_scene_s_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "12x12", "--error", "60%"]
    assert main([*command, "--max-depth", "2", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    for said in (record, record["quote"]):
        assert (said["max_depth"], said["scene_max_depth"], said["strategy"], said["biased"]) == (2, 30, "best", False)
    assert main([*command, "--max-depth", "2"]) == 0
    quoted = capsys.readouterr().out.splitlines()[0]
    assert quoted.startswith("Expect noise ")
    assert " of paths up to depth 2 after " in quoted


def test_ctrl_c_in_any_command_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(import_module("equaltime.cli.quote"), "load_file", interrupted)
    assert main(["quote", str(SCENE), "--error", "5%"]) == 130
    assert capsys.readouterr().err == "error: interrupted\n"


@pytest.mark.parametrize(
    ("name", "options", "told"),
    [
        ("a.jpg", [], "a picture alone cannot be continued; a render with -o FILE.exr can, by --resume"),
        ("a.png", [], "a picture alone cannot be continued; a render with -o FILE.exr can, by --resume"),
        ("a.exr", ["--small"], "a small file cannot be continued; a render without --small can, by --resume"),
        ("a.exr", [], None),
    ],
)
def test_ctrl_c_tells_that_a_picture_cannot_be_continued(
    name: str,
    options: list[str],
    told: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = et.render(et.load(SCENE).with_(size=(8, 8)), spp=4)
    words = ["render", str(SCENE), "-o", str(tmp_path / name), "--size", "8x8", "--spp", "4", *options]
    for end, code in (("interrupt", 130), ("spp", 0)):
        ended = replace(result, stopped_by=end)
        monkeypatch.setattr("equaltime.cli.render_picture.render", lambda *_, ended=ended, **__: ended)
        assert main([*words, "--overwrite"]) == code
        lines = [line for line in capsys.readouterr().out.splitlines() if "cannot be continued" in line]
        assert lines == ([told] if told and end == "interrupt" else [])


def test_a_render_whose_folder_is_gone_is_kept_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, save, elsewhere = tmp_path / "gone", et.Result.save, tmp_path / "kept"
    folder.mkdir()
    elsewhere.mkdir()

    def late(result: et.Result, path: str | Path, small: bool = False, **more: Any) -> tuple[Path, ...]:
        if folder.exists():
            folder.rmdir()
        return save(result, path, small, **more)

    monkeypatch.setattr(et.Result, "save", late)
    monkeypatch.setattr(tempfile, "tempdir", str(elsewhere))
    assert main(["render", str(SCENE), "-o", str(folder / "a.exr"), "--size", "8x8", "--spp", "4"]) == 1
    place, said = capsys.readouterr().err.rstrip("\n").split("; the render is kept in ")
    assert place == f"error: {folder / 'a.exr'}: the folder {folder} does not exist"
    assert et.render(et.load(SCENE).with_(size=(8, 8)), spp=6, resume=said).spp == 6


def test_an_error_without_an_upper_limit_is_told() -> None:
    result = et.render(et.load("cornell-box").with_(size=(8, 8)), spp=2)
    endless, known = (replace(result, error=et.Interval(0.5, 0.0, high)) for high in (math.inf, 2.0))
    assert doubts(known) == []
    assert [line for line in doubts(endless) if line.startswith("the error has no upper limit yet")] == doubts(endless)
    assert len(doubts(endless)) == 1


def test_no_time_is_told_where_bright_paths_came_after_the_quote() -> None:
    scene = et.load(SCENE).with_(size=(32, 32))
    result, quote = et.render(scene, spp=16), et.quote(scene, spp=16)
    told = [line for line in outcome(result, Written([Path("a.exr")]), quote) if "--resume --error 10%" in line]
    assert [line.split(" takes ")[0] for line in told] == ["10 %"]
    brighter = replace(result.error, value=2.0 * quote.error.high, high=math.inf)
    met = replace(result, error=brighter)
    assert [line for line in outcome(met, Written([Path("a.exr")]), quote) if "--resume" in line] == [
        "how long 20 % takes cannot be told, since a few bright paths make most of the error: "
        f"equaltime render {shown_path(SCENE)} -o a.exr --resume --error 20% --size 32x32 --seed 0"
    ]


@pytest.mark.parametrize("end", ["interrupt", "time", "spp"])
@pytest.mark.parametrize("rule", ["look", "fixed"])
def test_a_render_that_missed_its_error_tells_the_whole_command_that_goes_on_to_it(
    end: Any, rule: Any, tmp_path: Path
) -> None:
    file = tmp_path / "my render.exr"
    options = ["--size", "16x12", "--max-depth", "4", "--seed", "3", "--strategy", "mis"]
    assert main(["render", str(SCENE), "-o", str(file), *options, "--spp", "8", "-q"]) == 0
    result = et.read(file)
    missed = replace(result, stopped_by=end, stop=Stop(rule, 0.5 * result.error.low))
    missed.save(file, overwrite=True)
    lines = [line for line in outcome(missed, Written([file]), None) if "--resume" in line]
    assert len(lines) == 1
    wanted, command = lines[0].split(": ")
    assert wanted == f"to reach {50.0 * result.error.low:.6g} %"
    assert ("--stop fixed" in command) == (rule == "fixed")
    assert main(shlex.split(command)[1:]) == 0
    assert et.read(file).spp > result.spp
    assert not any("--resume" in line for line in outcome(missed, Written([file]), None, resumable=False))
    reached = replace(missed, stop=Stop(rule, 2.0 * result.error.high))
    assert not any("--resume" in line for line in outcome(reached, Written([file]), None))


def test_a_finished_render_tells_how_it_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "16x16", "--resume"]
    assert main([*words, "--spp", "8"]) == 0
    assert "nothing was added" not in capsys.readouterr().out
    for spp in ("8", "2"):
        assert main([*words, "--spp", spp]) == 0
        out = capsys.readouterr().out
        assert "nothing was added: the file had 8 samples a pixel already, and --spp counts all runs together" in out
        more = f"equaltime render {shown_path(SCENE)} -o {tmp_path / 'a.exr'} --resume --spp 16 --size 16x16 --seed 0"
        assert f"together; more: {more}\n" in out
        assert "runs" not in out.splitlines()[0], "a run without samples is none"
    assert main([*words, "--spp", "16"]) == 0
    out = capsys.readouterr().out
    assert "over 2 runs" in out
    assert "nothing was added" not in out


def test_a_picture_and_its_render_have_the_same_digits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.exr"
    assert main(["render", str(SCENE), "-o", str(path), "--size", "48x48", "--spp", "64"]) == 0
    capsys.readouterr()
    assert main(["info", str(path.with_suffix(".png"))]) == 0
    result = et.read(path)
    spp = f"{count(result.spp)} spp (for 64: more where it is noisy)"
    assert f"48x48, {spp}, error {result.error:%}," in capsys.readouterr().out


def test_a_transparent_picture_is_quoted_as_it_is_rendered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A quote of 8 samples has the samples of the render. Without its sky a picture has another mean, and so error."""
    scene = tmp_path / "scene.toml"
    scene.write_text(
        "[camera]\ntype = 'perspective'\nfilm = { type = 'hdrfilm', width = 16, height = 16 }\n"
        "[sky]\ntype = 'constant'\n[ball]\ntype = 'sphere'\ncenter = [0, 0, 6]\nradius = 1.5\n"
    )
    errors = {}
    for options in ((), ("--transparent",)):
        assert main(["quote", str(scene), "--spp", "8", "--no-why", "--json", *options]) == 0
        quoted = json.loads(capsys.readouterr().out)["error"]["value"]
        assert main(["render", str(scene), "-o", str(tmp_path / "a.exr"), "--spp", "8", "-q", *options]) == 0
        errors[options] = et.read(tmp_path / "a.exr").error.value
        assert quoted == errors[options]
        capsys.readouterr()
    assert errors["--transparent",] > 1.5 * errors[()]
