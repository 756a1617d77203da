"""Records of saved renders that are damaged, or another program's: one clear error, for taking up as for merging."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime import images
from equaltime.checkpoint import Checkpoint
from equaltime.cli import main

SCENE = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
SIZE = ("--size", "6x5")


@pytest.fixture(scope="module")
def render() -> et.Result:
    return et.render(et.load(SCENE).with_(size=(6, 5)), spp=2, threads=1)


def write(path: Path, render: et.Result, record: dict[str, Any]) -> None:
    layers = (render.image, render.standard_error, render.samples)
    images.write_render(path, *layers, record, render.origin.window, moments=render.moments)


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
        ("paths", "many", "'paths' should be a valid integer, found 'many'"),
        ("seed", "x", "'seed' should be a valid integer, found 'x'"),
        ("seed", 2**64, "'seed' should be less than"),
        ("rays", -1, "'rays' should be greater than or equal to 0, found -1"),
        ("looks", [[1]], "'looks.0.1' is missing"),
        ("position", [1, 2], "'position.2' is missing"),
        ("sources", [{"seed": 1}], "'sources.0.seconds' is missing"),
        ("size", [6], "'size'"),
        ("size", [6, 2**31], "'size.1' should be less than"),
        ("stopped_by", "night", "'stopped_by'"),
        ("strategy", "bets", "did you mean 'best'?"),
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
    read = Checkpoint.read(tmp_path / "a.exr").record
    expected = {**render.record, "more": {"of": ["it"]}}
    assert json.loads(json.dumps({key: read[key] for key in expected})) == json.loads(json.dumps(expected))
