"""Bad input on the real command line: one clear error with its place, nothing overwritten, nothing left behind."""

import errno
import io
import os
import signal
import subprocess
import sys
import time
from contextlib import redirect_stdout
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.standard_output import OutputError, named_output
from equaltime.images import image_files as images
from equaltime.rendering.render_file import read_picture

HEAD = """
[sensor]
type = "perspective"
[[sensor.to_world]]
look_at = {origin = [0, 0, 4], target = [0, 0, 0], up = [0, 1, 0]}
[sensor.film]
type = "hdrfilm"
width = 24
height = 16
[sky]
type = "constant"
"""
DIGITS = "9" * 400  # more than a float64 holds
NAME = "x" * 300  # longer than a file's name can be


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.toml"
    path.write_text(HEAD)
    return path


@pytest.fixture
def output(tmp_path: Path) -> Path:
    """Return a file that is there already, with its preview."""
    path = tmp_path / "results" / "out.exr"
    path.parent.mkdir()
    path.write_text("old")
    path.with_suffix(".png").write_text("old")
    return path


def untouched(output: Path) -> bool:
    return {file.name: file.read_text() for file in output.parent.iterdir()} == {"out.exr": "old", "out.png": "old"}


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line that is said about bad input."""
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    return captured.err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f'[s]\ntype = "sphere"\nradius = {DIGITS}', "scene.toml:14: s.radius: expected a number below 1.8e308"),
        (f'[s]\ntype = "sphere"\ncenter = [{DIGITS}, 0, 0]', "scene.toml:14: s.center: expected a number below"),
        (
            f'[s]\ntype = "cube"\nto_world = [{{translate = [{DIGITS}, 0, 0]}}]',
            "s.to_world: translate: expected finite",
        ),
        (f'[s]\ntype = "sphere"\nradius = {DIGITS * 20}', "more digits than can be read"),
        (f"[s]\ntype = 0x{DIGITS * 20}", "found a number of thousands of digits"),
        (f'[s]\ntype = "ply"\nfilename = "{NAME}.ply"', "scene.toml:14: s.filename: File name too long"),
        ('[s]\ntype = "ply"\nfilename = "a\\u001b[2Jb.ply"', r"no such file: "),
        ('[s]\ntype = "cube"\n[[s.to_world]]\nscale = 0', "scene.toml:14: s.to_world: the transform is singular"),
        ('[integrator]\ntype = "path"\nmax_depth = -2', "max_depth: must be at least -1"),
        ('[integrator]\ntype = "path"\nmax_depth = 2147483648', "max_depth: must be less than 2147483648"),
        ('[sensor.sampler]\ntype = "independent"\nsample_count = 4294967297', "must be at most 4294967296"),
    ],
)
def test_a_value_that_no_scene_can_have_is_refused_with_its_place(
    scene: Path, output: Path, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    scene.write_text(HEAD + text)
    said = refusal(["render", str(scene), "-o", str(output)], capsys)
    assert message in said
    assert "\x1b" not in said
    assert untouched(output)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--threads", "4097"], "--threads"),
        (["--threads", "99999999999999999999"], "--threads"),
        (["--spp", "4294967297"], "--spp"),
        (["--time", "99999999999999999999h"], "is too long"),
        (["--max-depth", "-2"], "'-2' is no whole number from -1 to 2147483647"),
        (["--max-depth", "2147483648"], "'2147483648' is no whole number from -1"),
        (["--strategy", "best,truncate=2147483648"], "truncate must be below 2^31"),
        (["--strategy", "best,roulette_depth=99999999999999999999"], "roulette_depth must be below 2^31"),
        (["--size", "1000001x1"], "1000000 to a side"),
        (["-D", "path=3"], "nothing in the scene uses the definition 'path'"),
        (["-D", f"x={'[' * 9999}"], "nothing in the scene uses the definition 'x'"),
    ],
)
def test_a_number_beyond_what_can_be_done_is_refused(
    scene: Path, output: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert message in refusal(["render", str(scene), "-o", str(output), *options], capsys)
    assert untouched(output)


def test_the_largest_numbers_that_are_taken_do_no_harm(scene: Path, tmp_path: Path) -> None:
    most = ["--threads", "4096", "--max-depth", "2147483647", "--strategy", "best,truncate=2147483647"]
    assert main(["render", str(scene), "-o", str(tmp_path / "a.exr"), "--spp", "2", "-q", *most]) == 0
    assert main(["render", str(scene), "-o", str(tmp_path / "a.exr"), "--spp", "1", "-q", "--size", "1000000x1"]) == 0


def test_a_benchmark_refuses_what_it_could_not_do(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "up to 4096" in refusal(["bench", str(scene), "--threads", "4097"], capsys)
    assert "--repeats" in refusal(["bench", str(scene), "--repeats", "1001"], capsys)
    assert "--spp" in refusal(["bench", str(scene), "--spp", "4294967297"], capsys)


def test_an_experiment_is_no_scene_and_that_is_all_to_be_said(capsys: pytest.CaptureFixture[str]) -> None:
    experiment = Path(__file__).parents[3] / "scenes" / "experiments" / "x6-lens.toml"
    assert main(["bench", str(experiment)]) == 2
    assert capsys.readouterr().err == f"error: {experiment}: an experiment, not a scene: `equaltime cost` runs it\n"


def test_text_that_is_not_utf_8_is_refused_with_its_line(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene.write_bytes(HEAD.encode() + b"# caf\xe9\n")
    assert "scene.toml:12: not UTF-8 text (byte" in refusal(["info", str(scene)], capsys)


def test_a_byte_order_mark_does_no_harm(scene: Path) -> None:
    scene.write_text("\ufeff" + HEAD, encoding="utf-8")
    assert et.load(scene).size == (24, 16)


def test_the_preview_s_place_is_checked_before_the_render_too(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out.png").mkdir()
    assert "out.png: is a folder" in refusal(["render", str(scene), "-o", str(tmp_path / "out.exr")], capsys)
    assert not (tmp_path / "out.exr").exists()


def test_an_output_name_may_be_as_long_as_names_can_be_and_no_longer(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    longest = tmp_path / f"{'x' * 251}.exr"
    assert main(["render", str(scene), "-o", str(longest), "--spp", "2", "-q"]) == 0
    assert longest.exists()
    assert "File name too long" in refusal(["render", str(scene), "-o", str(tmp_path / f"x{longest.name}")], capsys)


def test_a_damaged_image_is_one_line(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pixels = np.random.default_rng(1).random((64, 64, 3), np.float32)
    images.write(tmp_path / "whole.exr", "openexr", [images.Layer(("R", "G", "B"), pixels, {})])
    (tmp_path / "sky.exr").write_bytes((tmp_path / "whole.exr").read_bytes()[:4000])
    scene.write_text(HEAD.replace('"constant"', '"envmap"\nfilename = "sky.exr"'))
    assert "scene.toml:12: sky.filename: " in refusal(["info", str(scene)], capsys)


def test_light_beyond_all_measure_is_one_error_with_its_pixel(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene.write_text(HEAD + "radiance = 1e300\n")
    assert main(["render", str(scene), "-o", str(tmp_path / "a.exr"), "--spp", "2"]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"error: {scene}: pixel 0,0 is ")
    assert captured.err.endswith("more than an image of float32 can hold\n")
    assert captured.err.count("\n") == 1


def run(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "equaltime", *arguments]
    return subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=60, check=False, **options)  # type: ignore[call-overload,no-any-return]


def test_the_package_runs_as_a_module() -> None:
    assert run("--version", stdout=subprocess.PIPE).stdout == f"equaltime {et.__version__}\n"


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_under_the_output_is_said_in_one_line(scene: Path, unbuffered: str) -> None:
    for command in (["info", str(scene)], ["info", str(scene), "--json"]):
        with Path("/dev/full").open("w") as full:
            ended = run(*command, stdout=full, env={**os.environ, "PYTHONUNBUFFERED": unbuffered})
        assert (ended.returncode, ended.stderr) == (1, "error: standard output: No space left on device\n")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_gone_is_no_error(scene: Path, unbuffered: str) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as pipe:
        ended = run("schema", stdout=pipe, env={**os.environ, "PYTHONUNBUFFERED": unbuffered})
    assert (ended.returncode, ended.stderr) == (1, "")


def test_a_closed_standard_output_is_no_error(scene: Path) -> None:
    command = [sys.executable, "-m", "equaltime", "info", str(scene), "--json"]
    ended = subprocess.run(["sh", "-c", 'exec "$@" >&-', "sh", *command], capture_output=True, check=False, timeout=60)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, b"", b"")


@pytest.mark.parametrize("write", ["write", "writelines"])
def test_each_way_of_writing_names_the_output(write: str) -> None:
    class Full(io.StringIO):
        def write(self, text: str) -> int:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        def writelines(self, lines: object) -> None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with redirect_stdout(Full()), pytest.raises(OutputError, match="standard output"), named_output():
        getattr(sys.stdout, write)("x")


@pytest.mark.parametrize("number", [errno.EIO, errno.EPIPE])
def test_what_the_system_refuses_elsewhere_is_not_blamed_on_the_output(
    scene: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(import_module("equaltime.cli.info"), "load_file", refuse)
    assert main(["info", str(scene)]) == 1
    print("the output is open", flush=True)
    assert capfd.readouterr() == ("the output is open\n", f"error: {os.strerror(number)}\n")


def test_names_and_signs_that_the_terminal_cannot_show_are_escaped(scene: Path, tmp_path: Path) -> None:
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    output = os.fsdecode(os.fsencode(tmp_path) + b"/b\xff.exr")
    ended = run("render", str(scene), "-o", output, "--spp", "2", stdout=subprocess.PIPE, env=ascii_only)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert r"b\udcff.exr" in ended.stdout
    assert Path(output).exists()


def test_a_file_of_the_scene_is_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sky = tmp_path / "sky.exr"
    images.write_exr(sky, np.ones((4, 8, 3)))
    before, scene = sky.read_bytes(), tmp_path / "sky.toml"
    scene.write_text(HEAD.replace('type = "constant"', 'type = "envmap"\nfilename = "sky.exr"'))
    for output in ("sky.exr", "../" + tmp_path.name + "/sky.exr"):
        assert "the scene is made of this file" in refusal(["render", str(scene), "-o", str(tmp_path / output)], capsys)
    picture = tmp_path / "wall.png"
    picture.write_bytes(sky.read_bytes())
    scene.write_text(scene.read_text().replace("sky.exr", "wall.png"))
    assert "wall.png: " in refusal(["render", str(scene), "-o", str(tmp_path / "wall.exr")], capsys)
    assert sky.read_bytes() == picture.read_bytes() == before


def test_folders_and_files_whose_names_no_image_library_reads_are_refused_at_once(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9"))
    folder.mkdir()
    assert "not UTF-8" in refusal(["render", str(scene), "-o", str(folder / "a.exr")], capsys)
    assert "not UTF-8" in refusal(["cost", str(scene), "-o", str(folder), "--quick"], capsys)
    output = os.fsdecode(os.fsencode(tmp_path) + b"/b\xff.exr")
    assert main(["render", str(scene), "-o", output, "--spp", "2", "-q"]) == 0
    assert "not UTF-8" in refusal(["render", str(scene), "-o", output, "--resume", "--spp", "4"], capsys)
    assert "not UTF-8" in refusal(["compare", output, output], capsys)


def test_a_scene_file_whose_name_is_not_utf_8_is_rendered_twice(scene: Path, tmp_path: Path) -> None:
    """Its name stands in the preview, by which a second render knows that it may replace the first."""
    named = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff.toml"))
    scene.rename(named)
    for _ in range(2):
        assert main(["render", str(named), "-o", str(tmp_path / "out.exr"), "--spp", "2", "-q"]) == 0
    assert images.read_attributes(tmp_path / "out.png")["equaltime:scene"] == f"{tmp_path}/\\udcff.toml"


C_LOCALE = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        *([[command, "--help"], f"Usage: equaltime {command}"] for command in ("cost", "quote", "render")),
        (["quote", "caf\u00e9.toml", "--error", "50%"], "This quote took"),
        (["render", "caf\u00e9.toml", "-o", "caf\u00e9.exr", "--spp", "2"], r"-> caf\udcc3\udca9.exr"),
        (["cost", "caf\u00e9.toml", "-o", "out", "--quick"], "error: "),
        (["info", "no\u00e9.toml"], r"error: no\udcc3\udca9.toml: "),
    ],
)
def test_the_c_locale_shows_escapes_for_what_ascii_lacks(
    scene: Path, tmp_path: Path, words: list[str], shown: str
) -> None:
    scene.rename(tmp_path / "caf\u00e9.toml")
    command = [sys.executable, "-m", "equaltime", *words]
    done = subprocess.run(command, cwd=tmp_path, env={**os.environ, **C_LOCALE}, capture_output=True, timeout=300)
    said = (done.stdout + done.stderr).decode("ascii")
    assert shown in " ".join(said.split())
    assert "Traceback" not in said
    assert done.returncode == (2 if shown.startswith("error") else 0), said


@pytest.mark.parametrize("between", [0.1, 0.02])
def test_an_impatient_second_ctrl_c_loses_nothing(scene: Path, tmp_path: Path, between: float) -> None:
    output = tmp_path / "out.exr"
    command = [sys.executable, "-m", "equaltime", "render", str(scene), "-o", str(output), "--time", "1h", "--json"]
    often = ["--size", "800x800", "--checkpoint", "100ms"]
    process = subprocess.Popen([*command, *often], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    while not output.exists() and process.poll() is None:  # until it renders, however slow the machine is
        time.sleep(0.05)
    while process.poll() is None:
        process.send_signal(signal.SIGINT)
        time.sleep(between)
    _, complaints = process.communicate(timeout=30)
    assert (process.returncode, complaints) == (130, b"")
    assert read_picture(output).record["stopped_by"] == "interrupt"
    assert {file.name for file in tmp_path.iterdir()} == {"scene.toml", "out.exr", "out.png"}
