"""``equaltime info`` tells what is in a scene."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.recorded import shown_path
from equaltime.images import image_files as images
from equaltime.images import preview
from equaltime.rendering.render_file import read_picture
from equaltime.scene.frame_scenes import frames_of
from equaltime.scene.frames import Frame, frame_files

from ..scene.test_frames import KEYS, STANDING
from ..scene.test_gltf_animations import animated

SCENES = Path(__file__).parents[3] / "scenes"

TEXT = """
[sensor]
type = "thinlens"
aperture_radius = 0.1
film = { type = "hdrfilm", width = 8, height = 4, rfilter = { type = "box" } }
[red]
type = "diffuse"
reflectance = [1, 0, 0]
[paper]
type = "twosided"
bsdf = "red"
[a]
type = "sphere"
bsdf = "red"
[b]
type = "cube"
bsdf = "paper"
[c]
type = "sphere"
[c.emitter]
type = "area"
"""


def test_it_counts_plugins_and_what_is_shared_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    file = tmp_path / "scene.toml"
    file.write_text(TEXT)
    assert main(["info", str(file), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["sensor"], facts["filter"], facts["integrator"]) == ("thinlens", "box", "path")
    assert facts["plugins"] == {
        "shape": {"cube": 1, "sphere": 2},
        "bsdf": {"diffuse": 1, "twosided": 1},
        "texture": {},
        "emitter": {"area": 1},
        "medium": {},
    }
    assert facts["files"] == {}
    assert main(["info", str(file)]) == 0
    told = capsys.readouterr().out
    assert "1 cube, 2 sphere" in told
    assert len(told.splitlines()) <= 12
    assert told.startswith(f"{file}: 8x4 pixels, 12 triangles in 3 shapes, ")
    assert main(["info", str(file), "-v"]) == 0
    told = capsys.readouterr().out
    assert facts["digest"] in told
    assert "substitutions" not in told
    assert "-v for more" not in told
    assert "not given" not in told


def test_it_tells_the_sizes_of_files(capsys: pytest.CaptureFixture[str]) -> None:
    terrain = SCENES / "terrain"
    assert main(["info", str(terrain / "terrain.toml"), "--json"]) == 0
    files = {Path(name).name: size for name, size in json.loads(capsys.readouterr().out)["files"].items()}
    assert files == {name: (terrain / name).stat().st_size for name in ("terrain.ply", "venice_sunset.exr")}


@pytest.mark.parametrize("source", [("veach-mis.toml",), ("render/windmill.glb", "--frames", "1")])
def test_the_command_that_goes_on_to_a_smaller_error_works_as_it_stands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], source: tuple[str, ...]
) -> None:
    output, (scene, *frames) = tmp_path / "my film.exr", source
    options = ["--size", "8x6", "--spp", "8", "--seed", "7", "-q", *frames]
    assert main(["render", str(SCENES / scene), "-o", str(output), *options]) == 0
    (saved,) = tmp_path.glob("*.exr")
    assert main(["info", str(saved)]) == 0
    picture, on = capsys.readouterr().out.splitlines()[-2:]
    assert picture == f"picture   {saved.with_suffix('.png')}"
    before = read_picture(saved).record
    assert main(shlex.split(on.removeprefix("goes on   "))[1:]) == 0
    after = read_picture(saved).record
    assert after["error"]["high"] < before["error"]["high"]
    assert after["spp"] > before["spp"]
    saved.with_suffix(".png").unlink()
    capsys.readouterr()
    assert main(["info", str(saved)]) == 0
    (command,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("picture ")]
    assert main(shlex.split(command.removeprefix("picture   "))[1:]) == 0
    assert saved.with_suffix(".png").exists()


def test_a_render_of_a_changed_scene_has_no_command_that_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, output = tmp_path / "scene.toml", tmp_path / "a.exr"
    shutil.copy(SCENES / "cornell-box.toml", scene)
    assert main(["render", str(scene), "-o", str(output), "--size", "8x6", "--spp", "8", "-q"]) == 0
    scene.unlink()
    assert main(["info", str(output)]) == 0
    assert capsys.readouterr().out.endswith("goes on   only with the scene as it was: with --resume or merge\n")


@pytest.mark.parametrize("small", [False, True])
def test_it_tells_how_a_saved_render_was_made(tmp_path: Path, capsys: pytest.CaptureFixture[str], small: bool) -> None:
    output = tmp_path / "a.exr"
    options = ["--size", "8x6", "--spp", "4", "--seed", "1234567", "-q", *(["--small"] if small else [])]
    assert main(["render", str(SCENES / "cornell-box.toml"), "-o", str(output), *options]) == 0
    assert main(["info", str(output), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["format"], record["size"], record["spp"]) == (2, [8, 6], 4)
    assert main(["info", str(output)]) == 0
    told = capsys.readouterr().out
    assert "8x6" in told
    assert len(told.splitlines()) <= 12
    assert ("no longer: it was saved small" in told) == small
    assert "-v for more" in told
    assert main(["info", str(output), "-v"]) == 0
    told = capsys.readouterr().out
    assert "-v for more" not in told
    rows = [line.split("  ", 1) for line in told.split("\n\n")[1].splitlines()]
    values = {title: text.strip() for title, text in rows}
    assert values["digest"] == record["digest"]
    assert values["camera and bounce rays"] == f"{record['rays']:,}"
    assert values["shadow rays"] == f"{record['shadow_rays']:,}"
    assert values["spp"] == "4"
    assert values["seed"] == "1234567"
    assert "splitting none" in values["decision"]
    assert main(["render", str(SCENES / "cornell-box.toml"), "-o", str(output), *options, "--resume"]) == 2 * small


def test_more_of_a_render_names_its_bright_dots_and_what_shows_their_paths(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, output = str(SCENES / "montelight" / "complex.toml"), tmp_path / "a.exr"
    options = ["--size", "48x48", "--crop", "8,16,32,32", "--spp", "16", "--seed", "1", "-q"]
    assert main(["render", scene, "-o", str(output), *options, "--strategy", "bsdf"]) == 0
    assert main(["info", str(output)]) == 0
    assert "dots " not in capsys.readouterr().out
    assert main(["info", str(output), "-v"]) == 0
    lines = capsys.readouterr().out.splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("dots "))
    assert "of error², far above their neighbours: " in lines[at]
    *_, x, y = map(int, re.findall(r"\d+", lines[at].partition(";")[0]))
    image = images.read(output).image
    assert image[y - 16, x - 8].mean() > 10.0 * np.median(image.mean(axis=2))
    command = shlex.split(lines[at + 1])
    assert command == ["equaltime", "replay", str(output), "--pixel", f"{x},{y}"]
    assert main(command[1:]) == 0
    assert "brightest" in capsys.readouterr().out
    assert main(["render", scene, "-o", str(output), *options, "--small", "--overwrite"]) == 0
    assert main(["info", str(output), "-v"]) == 0
    assert "dots " not in capsys.readouterr().out, "the file has no samples"


def test_it_reads_a_render_of_before_and_refuses_the_picture_of_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(Path(__file__).parents[1] / "data" / "format_1" / "merged.exr")]) == 0
    told = capsys.readouterr().out
    assert "seed 0: 6 spp, seed 1: 4 spp" in told
    assert "goes on   with merge\n" in told
    assert "but " not in told, "it does not tell how its parts ended, so that there is no command to comment"
    images.write_exr(tmp_path / "a.exr", np.zeros((2, 2, 3)))
    assert main(["info", str(tmp_path / "a.exr")]) == 2
    assert "was not rendered by equaltime" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--size", "8x4"],
        ["--size", "6x6", "--crop", "1,1,3,3"],
        ["--max-depth", "3"],
        ["--without", "long_paths=3"],
    ],
)
def test_it_says_that_a_scene_has_changed_since_only_if_it_has(
    options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, output = tmp_path / "scene.toml", str(tmp_path / "out.exr")
    scene.write_text(TEXT)
    assert main(["render", str(scene), "-o", output, "--spp", "1", *options]) == 0
    assert main(["info", output]) == 0
    assert "changed" not in capsys.readouterr().out
    scene.write_text(TEXT.replace("0.1", "0.2"))
    assert main(["info", output]) == 0
    assert "but the scene has changed since" in capsys.readouterr().out


def test_the_command_that_repeats_a_render_has_its_definitions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It runs as it is printed, and gives the same picture."""
    motion = str(SCENES / "experiments" / "motion.toml")
    words = ["--spp", "2", "--size", "8x8", "-D", "ball=24", "-D", "shutter=0.5"]
    assert main(["render", motion, "-o", str(tmp_path / "a.exr"), *words]) == 0
    capsys.readouterr()
    assert main(["info", str(tmp_path / "a.exr")]) == 0
    lines = capsys.readouterr().out.splitlines()
    (again,) = [line for line in lines if line.startswith("repeat")]
    assert "-D ball=24 -D shutter=0.5" in again
    assert not any(line.strip().startswith("but ") for line in lines)
    _, _, *command = shlex.split(again)
    command[command.index("-o") + 1] = str(tmp_path / "b.exr")
    assert main(command) == 0
    a, b = (et.read(tmp_path / name) for name in ("a.exr", "b.exr"))
    assert (a.image == b.image).all()
    assert a.origin.defines == {"ball": "24", "shutter": "0.5"}


@pytest.mark.parametrize("kind", ["toml", "gltf"])
@pytest.mark.parametrize(
    ("output", "words", "said"),
    [
        (
            "f.exr",
            "--frames 3 --blur 0.5 --seed 7",
            "-o '{folder}/f_####.exr' --spp 2 --frames 3 --blur 0.5 --size 8x6 --seed 7",
        ),
        (
            "f-##.exr",
            "--frames 1,3 --fps 2.5",
            "-o '{folder}/f-##.exr' --spp 2 --frames 3 --fps 2.5 --size 8x6 --seed 0",
        ),
    ],
)
def test_the_command_that_repeats_a_frame_has_its_number(
    kind: str, output: str, words: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It runs as it is printed, and gives the same picture."""
    scene = tmp_path / f"scene.{kind}"
    if kind == "toml":
        scene.write_text(STANDING + KEYS)
    else:
        animated("translation", [0, 4], [[0, 0, 0], [4, 0, 0]]).gltf(scene)
    file = tmp_path / frame_files(Path(output), [3])[0]
    assert (
        main(["render", str(scene), "-o", str(tmp_path / output), "--size", "8x6", "--spp", "2", *words.split()]) == 0
    )
    capsys.readouterr()
    assert main(["info", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    (again,) = [line for line in lines if line.startswith("repeat")]
    assert again == f"repeat    equaltime render {scene} {said.format(folder=tmp_path)}"
    assert f"shows     {scene} at 8x6, frame 3" in lines
    assert not any(line.strip().startswith("but ") for line in lines)
    _, _, *command = shlex.split(again)
    command[command.index("-o") + 1] = str(tmp_path / "again" / output)
    (tmp_path / "again").mkdir()
    assert main(command) == 0
    a, b = et.read(file), et.read(tmp_path / "again" / file.name)
    assert (a.image == b.image).all()
    assert a.origin.frame == b.origin.frame
    assert a.origin.defines == {}


def test_a_frame_with_a_seed_below_its_number_is_repeated_with_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (scene := tmp_path / "scene.toml").write_text(STANDING + KEYS)
    (moment,) = frames_of(scene, [Frame(3)], {})
    et.render(moment.with_(size=(8, 6)), spp=2, seed=1).save(tmp_path / "f_0003.exr")
    assert main(["info", str(tmp_path / "f_0003.exr")]) == 0
    told = capsys.readouterr().out
    output = f"'{tmp_path}/f_####.exr'"
    assert f"similar   equaltime render {scene} -o {output} --spp 2 --frames 3 --size 8x6 --seed 0\n" in told


@pytest.mark.parametrize(
    ("end", "why"),
    [
        ("interrupt", "it was interrupted; only --spp and --error end at the same samples again"),
        ("time", "the time was up; only --spp and --error end at the same samples again"),
        ("unfinished", "it is a checkpoint: the render was not finished; only --spp and --error end at the same"),
        ("error", "the file does not tell where it ended; only --spp and --error end at the same samples again"),
        ("spp", ""),
    ],
)
def test_a_command_that_gives_a_similar_render_tells_why(
    end: Any, why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for source in (None, {"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}}):
        scene = et.load_dict(source) if source else et.load(SCENES / "cornell-box.toml")
        result = et.render(scene.with_(size=(8, 6)), spp=2, seed=1)
        replace(result, stopped_by=end).save(tmp_path / "a.exr", overwrite=True)
        for picture in ("a.exr", "a.png"):
            assert main(["info", str(tmp_path / picture)]) == 0
            lines = capsys.readouterr().out.splitlines()
            (first,) = (i for i, line in enumerate(lines) if line.startswith(("similar ", "repeat ")))
            assert lines[first].startswith("similar " if why else "repeat ")
            assert lines[first + 1].startswith(f"          not exactly, since {why}") == bool(why)
            assert len(lines) <= 10


def test_more_of_a_render_has_numbers_that_explain_themselves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Paths of any length; radiances of 1e14 and 1 in one picture."""
    sky = {"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}}
    result = et.render(et.load_dict(sky).with_(size=(8, 6), max_depth=-1), spp=2, seed=1)
    image = np.where(np.arange(8)[:, None] == 0, 1e14, result.image).astype(np.float32)
    replace(result, image=image).save(tmp_path / "a.exr")
    assert main(["info", str(tmp_path / "a.exr"), "-v"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"^max depth +no limit$", told, re.MULTILINE)
    assert re.search(r"^radiance range +1e\+14, the brightest value over the darkest above 0$", told, re.MULTILINE)


def test_more_of_a_render_tells_its_frame(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (scene := tmp_path / "scene.toml").write_text(STANDING + KEYS)
    words = ["--size", "8x6", "--spp", "2", "--frames", "3", "-q"]
    assert main(["render", str(scene), "-o", str(tmp_path / "f.exr"), *words]) == 0
    assert main(["info", str(tmp_path / "f_0003.exr"), "-v"]) == 0
    assert "number 3, fps 24.0, blur 0.0" in capsys.readouterr().out
    assert main(["info", str(tmp_path / "f_0003.exr"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frame"] == {"number": 3, "fps": 24.0, "blur": 0.0}


def test_a_render_of_a_dict_is_repeated_by_a_call(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = {"type": "hdrfilm", "width": 8, "height": 8}
    scene = {"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": {"type": "constant"}}
    path, seen = tmp_path / "sky.exr", []
    et.render(scene, error=0.5, seed=3, strategy="mis", stop="fixed").save(path)
    before = et.read(path).image
    assert main(["info", str(path)]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith(("repeat", "similar")))
    assert "in Python, with the same scene or dict, which no file holds: " in line
    call = line.partition(": ")[2].partition(".save(")[0]
    exec(f"seen.append({call})", {"et": et, "scene": scene, "seen": seen})
    assert np.array_equal(seen[0].image, before)
    parts = [et.render(scene, spp=4, seed=seed) for seed in (1, 2)]
    et.merge(parts).save(path)
    assert main(["info", str(path)]) == 0
    assert "in Python: the scene was made there, and this file does not hold it" in capsys.readouterr().out


def test_definitions_from_python_are_recorded_as_text() -> None:
    motion = et.load(SCENES / "experiments" / "motion.toml", ball=24.0)
    assert motion.defines == {"ball": "24.0"}
    assert motion.with_(size=(8, 8)).defines == {"ball": "24.0"}


@pytest.mark.parametrize("name", ["a.exr", "a.png"])
def test_a_scene_below_the_working_directory_has_a_relative_path(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "scene.toml").write_text(STANDING)
    monkeypatch.chdir(tmp_path)
    assert main(["render", "set/scene.toml", "-o", name, "--size", "8x6", "--spp", "4", "-q"]) == 0
    assert main(["info", name]) == 0
    told = capsys.readouterr().out
    assert "\nrepeat    equaltime render set/scene.toml -o a." in told
    assert "\nshows     set/scene.toml" in told
    monkeypatch.chdir(tmp_path / "set")
    assert main(["info", f"../{name}"]) == 0
    assert "\nrepeat    equaltime render scene.toml -o ../a." in capsys.readouterr().out
    (tmp_path / "set" / "below").mkdir()
    monkeypatch.chdir(tmp_path / "set" / "below")
    assert main(["info", f"../../{name}"]) == 0
    assert f"\nrepeat    equaltime render {tmp_path / 'set' / 'scene.toml'} -o ../../a." in capsys.readouterr().out


@pytest.mark.parametrize("name", ["a.exr", "a.png"])
def test_the_commands_on_a_render_in_another_folder_write_into_that_folder(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for folder in ("set", "send"):
        (tmp_path / folder).mkdir()
    (tmp_path / "set" / "scene.toml").write_text(STANDING)
    monkeypatch.chdir(tmp_path)
    assert main(["render", "set/scene.toml", "-o", f"send/{name}", "--size", "8x6", "--spp", "4", "-q"]) == 0
    for given in (f"send/{name}", str(tmp_path / "send" / name)):
        assert main(["info", given]) == 0
        commands = [line for line in capsys.readouterr().out.splitlines() if "equaltime render" in line]
        assert commands
        assert all(f"equaltime render set/scene.toml -o send/{name} " in command for command in commands)


def test_a_kept_copy_is_read_as_a_render(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(SCENES / "cornell-box.toml", "scene.toml")
    for seed in ("1", "2"):
        command = ["render", "scene.toml", "-o", "a.exr", "--size", "16x16", "--spp", "8", "--seed", seed, "-q"]
        assert main(command) == 0
        if seed == "1":
            Path("a.exr").rename("a.exr~")
            Path("a.png").rename("a.png~")
    assert main(["info", "a.exr~"]) == 0
    lines = {line[:10].strip(): line[10:] for line in capsys.readouterr().out.splitlines()}
    assert lines["repeat"] == "equaltime render scene.toml -o a-kept.exr --spp 8 --size 16x16 --seed 1"
    assert lines["picture"] == "equaltime convert 'a.exr~' a-kept.png"
    copy, _, on = lines["goes on"].partition(" && ")
    assert copy == "cp 'a.exr~' a-kept.exr"
    assert main(shlex.split(lines["picture"])[1:]) == 0
    shutil.copy(*shlex.split(copy)[1:])
    before = et.read("a.exr~")
    assert main([*shlex.split(on)[1:], "-q"]) == 0
    assert et.read("a-kept.exr").spp > before.spp
    capsys.readouterr()
    assert main(["info", "a.png~"]) == 0
    assert "-o a-kept.png " in capsys.readouterr().out
    assert main(["compare", "a.exr~", "a.exr"]) == 0
    assert main(["merge", "a.exr~", "a.exr", "-o", "both.exr"]) == 0
    assert main(["replay", "a.exr~", "--pixel", "1,1"]) == 0
    capsys.readouterr()
    assert main(["render", "scene.toml", "-o", "a.exr~", "--resume"]) == 2
    assert "a.exr~: is a kept copy, which is only read" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["a.png", "a.jpg"])
def test_it_tells_the_tags_of_a_picture(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The file with the record is named only if it is of the same render."""
    scene, picture = str(SCENES / "cornell-box.toml"), tmp_path / name
    assert main(["render", scene, "-o", str(picture), "--size", "8x6", "--spp", "4", "-q"]) == 0
    assert main(["info", str(picture)]) == 0
    first, shows, _, strategy, repeat, record = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{picture}: 8x6, 4 spp, error ")
    scene = shown_path(Path(scene))
    assert shows == f"shows     {scene}"
    assert strategy == "strategy  best, seed 0"
    exposure = float(repeat.rpartition(" ")[2])  # the automatic one
    options = f"--spp 4 --size 8x6 --seed 0 --exposure {exposure:g}"
    assert repeat == f"repeat    equaltime render {scene} -o {picture} {options}"
    assert record == "record    only -o FILE.exr keeps one"
    command = ["render", scene, "-o", str(tmp_path / "a.exr"), "--size", "8x6", "--spp", "4", "-q"]
    assert main([*command, "--seed", "1"]) == 0
    assert main([*command[:3], str(picture), *command[4:]]) == 0
    assert main(["info", str(picture)]) == 0
    assert "record    only -o FILE.exr keeps one\n" in capsys.readouterr().out  # that one is of another render
    (tmp_path / "a.exr").unlink()
    assert main(command) == 0
    assert main(["info", str(picture)]) == 0
    assert f"record    equaltime info {tmp_path / 'a.exr'}\n" in capsys.readouterr().out
    assert main(["info", str(picture), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["scene"], facts["record"]) == (str(SCENES / "cornell-box.toml"), str(tmp_path / "a.exr"))


@pytest.mark.parametrize("name", ["a.png", "a.jpg"])
def test_the_command_in_a_picture_repeats_its_bytes(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "again").mkdir()
    scene = str(SCENES / "montelight" / "simple.toml")
    options = ["--crop", "2,1,4,3", "--strategy", "mis", "--seed", "7", "--exposure", "-0.5"]
    options += ["-D", "light_radius=1.5", "--size", "8x6", "--spp", "4", "-q"]
    assert main(["render", scene, "-o", str(tmp_path / name), *options]) == 0
    assert main(["info", str(tmp_path / name), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["seed"] == 7
    strategy, line = facts["repeat"]
    assert strategy == "strategy  mis, seed 7"
    words = shlex.split(line.removeprefix("repeat    equaltime "))
    words[words.index("-o") + 1] = str(tmp_path / "again" / name)
    assert main([*words, "-q"]) == 0
    assert (tmp_path / "again" / name).read_bytes() == (tmp_path / name).read_bytes()


def test_the_picture_of_a_merged_render_tells_how_to_merge_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts = [str(tmp_path / f"{seed}.exr") for seed in (1, 2)]
    for seed, part in enumerate(parts, 1):
        command = ["render", str(SCENES / "cornell-box.toml"), "-o", part, "--size", "8x6", "--spp", "4", "-q"]
        assert main([*command, "--seed", str(seed)]) == 0
    assert main(["merge", *parts, "-o", str(tmp_path / "both.exr")]) == 0
    capsys.readouterr()
    assert main(["info", str(tmp_path / "both.png")]) == 0
    out = capsys.readouterr().out
    assert "strategy  best, seed 1: 4 spp, seed 2: 4 spp\n" in out
    one, two, both = (tmp_path / name for name in ("part-1.exr", "part-2.exr", "both.exr"))
    assert f"equaltime merge {one} {two} -o {both}\n" in out


def test_a_damaged_tag_of_a_picture_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for tag in ("[1]", "{", '{"exposure": 0}'):
        preview.write(tmp_path / "a.png", np.zeros((2, 2, 3)), "2x2", repeat=tag)
        assert main(["info", str(tmp_path / "a.png")]) == 2
        assert "damaged" in capsys.readouterr().err


def test_a_picture_is_no_scene_for_other_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (picture := tmp_path / "a.png").touch()
    assert main(["render", str(picture), "-o", str(tmp_path / "b.exr")]) == 2
    assert "a picture, not a scene; if equaltime rendered it, `equaltime info` tells how" in capsys.readouterr().err
    assert main(["lint", str(tmp_path / "sky.hdr")]) == 2
    assert "a picture, not a scene; a scene file names it" in capsys.readouterr().err


def test_it_refuses_a_picture_of_another_program(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    images.write(tmp_path / "a.png", "png", [images.Layer(("R", "G", "B"), np.zeros((2, 2, 3), np.uint8), {})])
    assert main(["info", str(tmp_path / "a.png")]) == 2
    assert "a.png: was not rendered by equaltime" in capsys.readouterr().err
