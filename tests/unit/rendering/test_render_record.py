"""Records of saved renders that are damaged, or another program's: one clear error, for taking up as for merging."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.rendering.render_file import RenderFile
from equaltime.rendering.render_record import checked
from equaltime.rendering.saved import SavedRender, differences

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
SIZE = ("--size", "6x5")


@pytest.fixture(scope="module")
def render() -> et.Result:
    return et.render(et.load(SCENE).with_(size=(6, 5)), spp=2, threads=1)


def write(path: Path, render: et.Result, record: dict[str, Any]) -> None:
    shown = (render.image, render.standard_error, render.samples)
    RenderFile(*shown, record, render.origin.window, moments=render.moments).write(path)


def complaint(file: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line that taking the file up, and merging it, end with."""
    before = file.read_bytes()
    take_up = ["render", str(SCENE), *SIZE, "-o", str(file), "--spp", "4", "--resume", "-q"]
    said = []
    for command in (take_up, ["merge", str(file), str(file), "-o", str(file.with_name("both.exr"))]):
        assert main(command) == 2
        said.append(capsys.readouterr().err)
    assert said[0] == said[1]
    assert said[0].startswith(f"error: {file}: ")
    assert said[0].count("\n") == 1
    assert file.read_bytes() == before
    assert not file.with_name("both.exr").exists()
    return said[0]


@pytest.mark.parametrize("key", ["stopped_by", "sources", "seconds", "looks", "strategy", "crop", "effects"])
def test_a_key_that_is_missing_is_named(
    render: et.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str
) -> None:
    write(tmp_path / "a.exr", render, {name: value for name, value in render.record.items() if name != key})
    assert f"its record is damaged: '{key}' is missing" in complaint(tmp_path / "a.exr", capsys)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("paths", "many", "'paths': expected an integer, found 'many'"),
        ("seed", "x", "'seed': expected an integer, found 'x'"),
        ("seed", 2**64, "'seed': must be less than"),
        ("rays", -1, "'rays': must be at least 0, found -1"),
        ("looks", [[1]], "'looks.0.1' is missing"),
        ("position", [1, 2], "'position.2' is missing"),
        ("sources", [{"seed": 1}], "'sources.0.seconds' is missing"),
        ("size", [6], "'size'"),
        ("size", [6, 2**31], "'size.1': must be less than"),
        ("stopped_by", "night", "'stopped_by'"),
        ("strategy", "bets", "did you mean 'best'?"),
        ("frame", {"number": 1, "fps": 0.0, "blur": 0.0}, "'frame.fps': must be more than 0"),
        ("bias", {"value": "small"}, "'bias.value'"),
        ("crop", [0, 0, 5, 6], "its parts are not of one size"),
        ("replicates", 3, "its parts are not of one size"),
    ],
)
def test_a_value_that_cannot_be_is_named(
    render: et.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str, value: object, words: str
) -> None:
    write(tmp_path / "a.exr", render, {**render.record, key: value})
    assert words in complaint(tmp_path / "a.exr", capsys)


def test_all_that_is_wrong_is_told_at_once(
    render: et.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "a.exr", render, {"software": "another"})
    said = complaint(tmp_path / "a.exr", capsys)
    assert all(f"'{key}' is missing" in said for key in ("scene", "seed", "paths", "build"))


def test_what_is_no_json_at_all_is_told(
    render: et.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for text in ("{", "9" * 5000, "[" * 100_000):
        monkeypatch.setattr(json, "dumps", lambda *_, text=text, **__: text)
        write(tmp_path / "a.exr", render, {})
        monkeypatch.undo()
        assert "the attribute equaltime:record is damaged" in complaint(tmp_path / "a.exr", capsys)


def test_a_record_is_read_as_it_was_written_whatever_else_it_says(render: et.Result, tmp_path: Path) -> None:
    write(tmp_path / "a.exr", render, {**render.record, "more": {"of": ["it"]}})
    read = SavedRender.read(tmp_path / "a.exr").record
    expected = {**render.record, "more": {"of": ["it"]}}
    assert json.loads(json.dumps({key: read[key] for key in expected})) == json.loads(json.dumps(expected))


def test_a_record_that_does_not_say_what_the_scene_asks_for_is_taken_up_and_merged(tmp_path: Path) -> None:
    scene = et.load(SCENE).with_(size=(6, 5), max_depth=3)
    files = [tmp_path / f"{seed}.exr" for seed in range(2)]
    for seed, file in enumerate(files):
        part = et.render(scene, spp=2, seed=seed, threads=1)
        record = {key: value for key, value in part.record.items() if key != "scene_max_depth" or seed}
        write(file, part, record)
    assert et.render(scene, spp=4, threads=1, resume=files[0]).record["scene_max_depth"] == 30
    for parts in (files, files[::-1]):  # the one that says it counts
        assert et.merge(parts).record["scene_max_depth"] == 30
    write(files[1], part, {**part.record, "scene_max_depth": None})
    assert et.merge(files).record["scene_max_depth"] is None


def test_merged_renders_name_the_scene_s_own_depth_if_one_of_them_does(tmp_path: Path) -> None:
    scene, files = et.load(SCENE).with_(size=(6, 5), max_depth=3), [tmp_path / f"{seed}.exr" for seed in range(2)]
    for seed, file in enumerate(files):
        part = et.render(scene, spp=2, seed=seed, threads=1)
        write(file, part, {**part.record, "scene_max_depth": (3, 30)[seed]})
    for parts in (files, files[::-1]):
        assert et.merge(parts).record["scene_max_depth"] == 30


def test_a_result_says_of_which_paths_it_is() -> None:
    scene = et.load(SCENE).with_(size=(6, 5))
    assert ", error " in repr(et.render(scene, spp=2, threads=1))
    cut = repr(et.render(scene.with_(max_depth=3), spp=2, threads=1))
    assert ", noise " in cut
    assert ") of paths up to depth 3 (the scene asks for paths up to depth 30), stopped by spp)" in cut


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, []),
        ({"size": [7, 5], "crop": [0, 0, 7, 5], "digest": "0"}, ["size 7x5, not 6x5"]),
        ({"crop": [1, 0, 5, 5], "digest": "0"}, ["crop 1,0,5,5, not 0,0,6,5"]),
        ({"max_depth": 2, "digest": "0"}, ["max depth 2, not 8"]),
        ({"max_depth": 2, "digest": "0", "scene": "b"}, ["max depth 2, not 8", "another scene (b, not a)"]),
        ({"without": ["lens"], "digest": "0"}, ["left out lens, not nothing"]),
        ({"strategy": "naive", "digest": "0"}, ["strategy naive, not best", "another scene (a, with other content)"]),
        ({"defines": {"x": "1"}, "digest": "0"}, ["-D x=1"]),
        ({"digest": "0", "scene": "b"}, ["another scene (b, not a)"]),
        ({"digest": "0", "scene": None}, ["another scene"]),
        ({"scene": "b"}, []),
        ({"build": {"embree": "4"}, "seed": 3}, ["seed 3, not 0", "build embree 4, not 3"]),
    ],
)
def test_what_differs_is_said_in_words(changes: dict[str, Any], words: list[str]) -> None:
    size, crop = {"size": [6, 5]}, {"crop": [0, 0, 6, 5]}
    how = {"max_depth": 8, "strategy": "best", "without": [], "replicates": 2, "nets": 2, "backend": "core", "seed": 0}
    record = {"scene": "a", "digest": "1", **size, **crop, **how, "build": {"embree": "3", "cpu": "2"}}
    assert differences({**record, **changes}, record, ("seed", "build")) == words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--size", "6x4"], "it has size 6x5, not 6x4"),
        (["--max-depth", "3"], "it has max depth 30, not 3"),
        (["--strategy", "naive"], "it has strategy best, not naive"),
        (["-D", "light_scale=0.5"], "it has no -D light_scale=0.5"),
    ],
)
def test_another_render_is_bad_input_to_taking_up_as_to_merging(
    render: et.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], words: str
) -> None:
    a, b = tmp_path / "a.exr", tmp_path / "b.exr"
    render.save(a)
    before = a.read_bytes()
    other = ["render", str(SCENE), *SIZE, "--spp", "2", "-q", *options]
    assert main([*other, "-o", str(a), "--resume"]) == 2
    assert f"{a}: cannot be resumed: {words}\n" in capsys.readouterr().err
    assert main([*other, "-o", str(b), "--seed", "1"]) == 0
    assert main(["merge", str(b), str(a), "-o", str(tmp_path / "c.exr")]) == 2
    assert (
        f"{a}: cannot be merged with {b}: {words}. Parts of one render differ only in --seed" in capsys.readouterr().err
    )
    assert a.read_bytes() == before


@pytest.mark.parametrize(
    ("then", "now"),
    [
        ("best", "best,roulette=throughput,sampler=sobol,adaptive=none"),
        ("best,adaptive=error", "best,roulette=throughput,sampler=sobol"),
        ("best,roulette=none", "best,roulette=none,sampler=sobol,adaptive=none"),
        ("mis", "mis"),
    ],
)
def test_the_strategy_of_an_earlier_version_means_what_it_meant(render: et.Result, then: str, now: str) -> None:
    record = json.loads(json.dumps(render.record))
    before = {key: value for key, value in record.items() if key != "nets"} | {"strategy": then}
    assert checked(before, "a.exr")["strategy"] == now
    assert checked(record | {"strategy": then}, "a.exr")["strategy"] == then
