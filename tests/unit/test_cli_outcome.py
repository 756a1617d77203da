"""What a command says of how it ended."""

from __future__ import annotations

import tempfile
from importlib import import_module
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main

SCENE = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"


def why(folder: Path, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    """Return why a render says that it stopped."""
    assert main(["render", str(SCENE), "-o", str(folder / "a.exr"), "--seed", "1", *options]) == 0
    return next(line for line in capsys.readouterr().out.splitlines() if line.startswith("stopped by "))


def test_counts_that_differ_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = why(tmp_path, capsys, "--size", "32x32", "--spp", "32", "--strategy", "best,adaptive=error")
    fewest, most = (int(word) for word in said.split() if word.isdigit())
    assert said == f"stopped by spp: pixels have {fewest} to {most} samples"
    assert fewest < 32 < most


def test_that_nobody_knows_a_bias_is_told_and_one_that_was_measured_is_in_the_limit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--size", "12x12", "--error", "60%")
    met = "stopped by error: the upper limit of the error is where it was asked to be"
    assert why(tmp_path, capsys, *options) == met
    assert why(tmp_path, capsys, *options, "--without", "long_paths=3") == met
    unknown = why(tmp_path, capsys, *options, "--strategy", "best,truncate=2")
    assert unknown == f"{met}, but for a bias that nobody knows"


def test_ctrl_c_in_any_command_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(import_module("equaltime.cli.quote"), "load_file", interrupted)
    assert main(["quote", str(SCENE), "--error", "5%"]) == 130
    assert capsys.readouterr().err == "error: interrupted\n"


def test_a_render_whose_folder_is_gone_is_kept_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, save, elsewhere = tmp_path / "gone", et.Result.save, tmp_path / "kept"
    folder.mkdir()
    elsewhere.mkdir()

    def late(result: et.Result, path: str | Path) -> tuple[Path, ...]:
        if folder.exists():
            folder.rmdir()
        return save(result, path)

    monkeypatch.setattr(et.Result, "save", late)
    monkeypatch.setattr(tempfile, "tempdir", str(elsewhere))
    assert main(["render", str(SCENE), "-o", str(folder / "a.exr"), "--size", "8x8", "--spp", "4"]) == 1
    place, said = capsys.readouterr().err.rstrip("\n").split("; the render is kept in ")
    assert place == f"error: {folder / 'a.exr'}: the folder {folder} does not exist"
    assert et.render(et.load(SCENE).with_(size=(8, 8)), spp=6, resume=said).spp == 6
