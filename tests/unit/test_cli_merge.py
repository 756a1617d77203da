"""``equaltime merge``: what it does not write over."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main

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
