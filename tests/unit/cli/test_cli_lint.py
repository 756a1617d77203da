"""``equaltime lint`` on the command line, and the line of it that ``render`` prints."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from equaltime.cli import main

SCENE = """
[view]
type = "perspective"
to_world = [{ look_at = { origin = [0, 0, 9], target = [0, 0, 0], up = [0, 1, 0] } }]
film = { type = "hdrfilm", width = 8, height = 8 }
[sky]
type = "constant"
radiance = "$power"
[pane]
type = "rectangle"
bsdf = { type = "$glass" }
"""


def test_the_command_ends_with_1_for_warnings_and_0_for_notes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    assert main(["lint", str(file), "-D", "power=1", "-D", "glass=dielectric"]) == 1
    text = capsys.readouterr().out
    assert "warning: open-dielectrics: refracting shapes that do not close: 1; edges of one triangle alone: 4" in text
    assert f"at 'pane' (rectangle, {file}:9: pane)" in text
    assert text.rstrip().endswith("1 warning (open-dielectrics)")
    assert main(["lint", str(file), "-D", "power=1", "-D", "glass=dielectric", "--json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert (data["warnings"], data["notes"]) == (1, 0)
    assert data["findings"][0]["check"] == "open-dielectrics"
    assert main(["lint", str(file), "-D", "power=1", "-D", "glass=thindielectric"]) == 0
    assert capsys.readouterr().out == "nothing found\n"


def test_a_name_that_is_taken_twice_is_an_error_of_loading(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(SCENE.replace('{ type = "$glass" }', '{ type = "diffuse", id = "sky" }'))
    assert main(["lint", str(file), "-D", "power=1"]) == 2
    assert "the name 'sky' is already taken" in capsys.readouterr().err


def test_render_says_it_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    words = ["render", str(file), "-o", str(tmp_path / "out.exr"), "--spp", "1", "-D", "power=1", "-D"]
    assert main([*words, "glass=dielectric"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("lint: ")]
    assert lines == [f"lint: 1 warning (open-dielectrics); see equaltime lint {file}"]
    assert main([*words, "glass=thindielectric"]) == 0
    assert "lint: " not in capsys.readouterr().err
