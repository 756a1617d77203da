"""The command line as a user meets it: messages, exit codes, files, and what a signal leaves behind."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import typer

from equaltime.cli import main
from equaltime.cli.options import (
    parse_crop,
    parse_definitions,
    parse_duration,
    parse_percent,
    parse_size,
    parse_whole,
)
from equaltime.cli.progress import describe, progress_bar
from equaltime.images import image_files as images
from equaltime.rendering.passes import Progress
from equaltime.rendering.render_file import read_picture
from equaltime.statistics.intervals import Interval
from equaltime.strategy import PRESETS, Strategy

SCENE = """
<scene version="3.0.0">
  <default name="depth" value="4"/>
  <integrator type="path"><integer name="max_depth" value="$depth"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="45"/>
    <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="6"/></sampler>
    <film type="hdrfilm">
      <integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="box"/>
    </film>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"/></shape>
  <shape type="sphere">
    <point name="center" x="2" y="3" z="3"/><float name="radius" value="0.5"/>
    <emitter type="area"><rgb name="radiance" value="20,20,20"/></emitter>
  </shape>
</scene>
"""


@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "ball.xml"
    path.write_text(SCENE)
    return str(path)


@pytest.fixture
def output(tmp_path: Path) -> Path:
    return tmp_path / "out.exr"


def render_record(arguments: Sequence[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["render", *arguments, "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    record = json.loads(captured.out)
    assert isinstance(record, dict)
    return record


def test_a_render_writes_picture_and_preview_and_says_what_it_did(
    scene: str, output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["render", scene, "-o", str(output), "--spp", "4"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Done: error ")
    preview = output.with_suffix(".png")
    assert lines[0].endswith(f", 4 samples a pixel, unbiased -> {output}, {preview} (3 stops brighter)")
    assert "rays/s" not in "".join(lines)
    assert images.read(output).image.shape == (16, 24, 3)
    assert images.read(output.with_suffix(".png")).image.shape == (16, 24, 3)


def test_the_record_has_what_scripts_rely_on(scene: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = render_record([scene, "-o", str(output), "--spp", "8", "--seed", "5", "--threads", "1"], capsys)
    assert set(record) >= {"seconds", "phases", "spp", "rays", "error", "stopped_by", "kernel", "effects", "seed"}
    assert set(record["phases"]) >= {"load", "build", "render", "write"}
    assert {"value", "low", "high"} <= set(record["error"]) <= {"value", "low", "high", "trusted", "doubt"}
    assert (record["spp"], record["seed"], record["threads"], record["stopped_by"]) == (8, 5, 1, "spp")
    assert record["files"] == [str(output), str(output.with_suffix(".png"))]
    stored = read_picture(output).record
    assert {key: record[key] for key in ("seed", "digest", "strategy", "error", "effects")} == {
        key: stored[key] for key in ("seed", "digest", "strategy", "error", "effects")
    }


def test_the_scene_s_own_sample_count_is_the_default(
    scene: str, output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render_record([scene, "-o", str(output)], capsys)["spp"] == 6


def test_options_beat_the_scene(scene: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--spp", "2", "--size", "30x20", "--max-depth", "2", "--strategy", "mis,truncate=3"]
    record = render_record([scene, "-o", str(output), *options], capsys)
    assert (record["size"], record["max_depth"], record["strategy"], record["biased"]) == (
        [30, 20],
        2,
        "mis,truncate=3",
        True,
    )


def test_definitions_reach_the_scene(scene: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = render_record([scene, "-o", str(output), "-D", "depth=3"], capsys)
    assert (record["max_depth"], record["scene_max_depth"]) == (3, 3)


def test_a_crop_has_the_bits_of_the_whole(scene: str, output: Path, tmp_path: Path) -> None:
    part = tmp_path / "part.exr"
    assert main(["render", scene, "-o", str(output), "--spp", "4", "--quiet"]) == 0
    assert main(["render", scene, "-o", str(part), "--spp", "4", "--crop", "5,3,10,7", "--quiet"]) == 0
    np.testing.assert_array_equal(images.read(part).image, images.read(output).image[3:10, 5:15])
    window = images.read(part).window
    assert (window.x, window.y, window.full_width, window.full_height) == (5, 3, 24, 16)


def test_a_time_limit_ends_the_render(scene: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = render_record([scene, "-o", str(output), "--time", "100ms"], capsys)
    assert record["stopped_by"] == "time"
    assert 0.09 <= record["seconds"] < 1.0


def test_quiet_prints_nothing(scene: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", scene, "-o", str(output), "--spp", "2", "-q"]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_biased_render_says_so(scene: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["render", scene, "-o", str(output), "--spp", "2", "--strategy", "best,truncate=2"])
    assert "biased: best,truncate=2" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--time", "soon"], "'soon' is no duration"),
        (["--spp", "0"], "'0' is no whole number from 1 to 4294967296"),
        (["--spp", "many"], "'many' is no whole number from 1"),
        (["--spp", "1e3"], "'1e3' is no whole number from 1"),
        (["--max-depth", "two"], "'two' is no whole number from -1"),
        (["--size", "12"], "'12' is no size"),
        (["--size", "50%"], "such as 640x480; `equaltime info SCENE` tells the scene's own size"),
        (["--crop", "1,2,3"], "'1,2,3' is no crop window"),
        (["--seed", "-1"], "'-1' is no whole number from 0"),
        (["--seed", "18446744073709551616"], "is no whole number from 0 to 18446744073709551615"),
        (["--threads", "-1"], "'-1' is no whole number from 0 to 4096"),
        (["-D", "depth"], "'depth' is no definition"),
        (["--strategy", "bets"], "did you mean 'best'?"),
        (["--strategy", "best,sampler=sobl"], "did you mean 'sobol'?"),
        (["--backend", "mitsuba"], "--backend"),
        (["--sppp", "4"], "--sppp"),
        (["--size", "0x4"], "'0x4' is no size"),
        (["--size", "1000000000x1000000000"], "memory"),
        (["--crop", "20,0,10,10"], "crop window"),
        (["--backend", "embreex", "--time", "1s"], "no limit except spp"),
        (["-D", "unknown=1"], "unknown"),
        (["--error", "1"], "'1' is 100 %; did you mean 1%?"),
        (["--within", "1"], "'1' is 100 %; did you mean 1%?"),
    ],
)
def test_bad_options_are_one_clear_message_and_leave_everything_alone(
    scene: str, output: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    output.write_bytes(b"old")
    assert main(["render", scene, "-o", str(output), "--overwrite", *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ")
    assert len(captured.err.splitlines()) == 1
    assert message in captured.err
    assert output.read_bytes() == b"old"


def test_every_problem_of_a_scene_is_a_line(tmp_path: Path, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "wrong.xml"
    path.write_text(SCENE.replace("radius", "raduis").replace("hdrfilm", "hdrflim"))
    assert main(["render", str(path), "-o", str(output)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert all(line.startswith("error: ") and "wrong.xml:" in line for line in lines)
    assert not output.exists()


def test_a_missing_scene_is_said_to_be_missing(output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "nowhere.toml", "-o", str(output)]) == 2
    assert "nowhere.toml" in capsys.readouterr().err


def test_the_output_path_is_checked_before_the_scene_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "nowhere.toml", "-o", "nowhere/out.exr"]) == 2
    assert "the folder nowhere does not exist" in capsys.readouterr().err


def test_an_output_is_asked_for(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", scene]) == 2
    assert "--output" in capsys.readouterr().err


def test_the_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.split()[0] == "equaltime"


def test_no_command_prints_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "render" in capsys.readouterr().out


def test_an_unknown_command_names_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rendr"]) == 2
    assert "Did you mean 'render'?" in capsys.readouterr().err


def test_the_help_of_render_names_every_strategy(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "--help"]) == 0
    text = capsys.readouterr().out
    parts = [part for field in Strategy.model_fields.values() for part in get_args(field.annotation)]
    words = [word for part in parts for word in (part, *get_args(part)) if isinstance(word, str)]
    assert all(word in text for word in [*PRESETS, *Strategy.model_fields, *words])
    best, constant = Strategy(), Strategy.parse("best,roulette=constant")
    for default in (best.heuristic, best.environment, best.roulette_depth, constant.survival):
        assert f"default {default})" in " ".join(text.split())


def test_info_tells_what_is_in_a_scene(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", scene, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["size"], facts["max_depth"], facts["spp"], facts["shapes"]) == ([24, 16], 4, 6, 2)
    assert main(["info", scene]) == 0
    assert "24x16" in capsys.readouterr().out


def start(arguments: Sequence[str]) -> subprocess.Popen[str]:
    code = "import sys; from equaltime.cli import main; print('begun', file=sys.stderr, flush=True); sys.exit(main())"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    assert process.stderr.readline() == "begun\n"
    return process


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_keeps_what_is_finished(scene: str, output: Path, number: signal.Signals) -> None:
    process = start(["render", scene, "-o", str(output), "--time", "1h", "--checkpoint", "200ms", "--json"])
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not output.exists():  # a checkpoint: it renders
        time.sleep(0.05)
    process.send_signal(number)
    printed, complaints = process.communicate(timeout=30)  # of an hour
    assert process.returncode == 130
    assert complaints == ""
    record = json.loads(printed)
    assert record["stopped_by"] == "interrupt"
    assert record["spp"] > 2
    assert read_picture(output).record["stopped_by"] == "interrupt"


def test_a_closed_pipe_is_no_error(scene: str, output: Path) -> None:
    process = start(["render", scene, "-o", str(output), "--spp", "2"])
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.wait(timeout=20) == 1
    assert process.stderr.read() == ""
    process.stderr.close()
    assert output.exists()


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("10", 10.0),
        ("10s", 10.0),
        ("500ms", 0.5),
        ("2.5m", 150.0),
        ("1h30m", 5400.0),
        ("1H 5 min", 3900.0),
        ("2d", 172800.0),
    ],
)
def test_durations_are_written_as_people_do(text: str, seconds: float) -> None:
    assert parse_duration(text) == pytest.approx(seconds)


@pytest.mark.parametrize("text", ["", "s", "10x", "-1s", "0", "1s2", "inf"])
def test_what_is_no_duration_is_refused(text: str) -> None:
    with pytest.raises(typer.BadParameter):
        parse_duration(text)


@pytest.mark.parametrize(
    ("text", "error"), [("2%", 0.02), (" 2 % ", 0.02), ("0.02", 0.02), ("99%", 0.99), ("0.4", 0.4)]
)
def test_errors(text: str, error: float) -> None:
    assert parse_percent(text) == pytest.approx(error)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1", "'1' is 100 %; did you mean 1%?"),
        ("0.5", "'0.5' is 50 %; did you mean 0.5%, or 50%?"),
        ("99", "'99' is 9900 %; did you mean 99%?"),
        ("150", "'150' is too large; an error to be reached is below 100 %"),
        ("150%", "'150%' is too large; an error to be reached is below 100 %"),
        ("100%", "'100%' is too large"),
        *(
            (text, f"'{text}' is no error; write a positive percentage")
            for text in ("0", "-1", "nan", "inf", "2%x", "")
        ),
    ],
)
def test_what_is_no_error_to_be_reached_is_refused_with_what_may_be_meant(text: str, message: str) -> None:
    with pytest.raises(typer.BadParameter) as refused:
        parse_percent(text)
    assert str(refused.value).startswith(message)


def test_sizes_windows_and_seeds_are_read() -> None:
    assert parse_size("640x480") == (640, 480)
    assert parse_crop("1, 2, 30, 40") == (1, 2, 30, 40)
    assert parse_whole(0, 2**64 - 1)("18446744073709551615") == 2**64 - 1
    assert parse_definitions(["a=1", "b=x=y", "a=2"]) == {"a": "2", "b": "x=y"}


def test_the_progress_line_shows_samples_and_error() -> None:
    progress = Progress(24, 64, 4.0, 0.375, 67.4, Interval(0.0312, 0.03, 0.033))
    assert describe(progress) == "24/64 spp  noise 3.12 %"
    assert describe(Progress(0, None, 0.1, 0.0, None, None)) == "0 spp"


def test_a_log_file_gets_a_line_soon_and_then_every_minute(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = 1000.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    with progress_bar() as show:
        assert show is not None
        for now in (1001.0, 1021.0, 1061.0, 1082.0, 1122.0, 1143.0):
            show(Progress(24, 64, now - 1000.0, 0.375, 67.4, None))
    assert capsys.readouterr().err.splitlines() == [
        "21 s, 38 %, 24/64 spp, 1:08 left",
        "1 min, 38 %, 24/64 spp, 1:08 left",
        "2 min, 38 %, 24/64 spp, 1:08 left",
    ]
