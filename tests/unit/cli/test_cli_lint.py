"""``equaltime lint`` on the command line, and the line of it that ``render`` prints."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from equaltime.cli import main
from equaltime.cli.messages import MOST_LINES

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
    answer, warning, more = capsys.readouterr().out.splitlines()
    assert answer == "Problems in scene.toml that may make the image wrong or slow: 1 warning (open-dielectrics)."
    found = "warning: refracting shapes with gaps: 1; edges with only one triangle: 4"
    assert warning.startswith(f"{found}, at 'pane' (rectangle, {file}:9: pane). You can: ")
    assert more == "-v shows all places, and what equaltime does about them"
    assert main(["lint", str(file), "-D", "power=1", "-D", "glass=dielectric", "-v"]) == 1
    text = capsys.readouterr().out
    assert text.startswith(answer)
    assert f"  at 'pane' (rectangle, {file}:9: pane)\n  equaltime " in text
    assert main(["lint", str(file), "-D", "power=1", "-D", "glass=dielectric", "--json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert (data["warnings"], data["notes"]) == (1, 0)
    assert data["findings"][0]["check"] == "open-dielectrics"
    assert main(["lint", str(file), "-D", "power=1", "-D", "glass=thindielectric"]) == 0
    clean = "No problems in scene.toml (checked: lights, camera, geometry, materials, files).\n"
    assert capsys.readouterr().out == clean


def test_what_readers_mended_is_told_by_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = tmp_path / "mesh.ply"
    mesh.write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    )
    assert main(["lint", str(mesh)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("No problems in mesh.ply that make the image wrong: ")
    assert any(line.startswith("note: ") and "camera" in line for line in lines)
    assert len(lines) <= MOST_LINES


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
    command = f"equaltime lint {file} -D power=1 -D glass=dielectric"
    assert lines == [f"lint: 1 warning (open-dielectrics); see {command}"]
    assert main(shlex.split(command)[1:]) == 1
    assert main([*words, "glass=thindielectric"]) == 0
    assert "lint: " not in capsys.readouterr().err


def test_remarks_on_a_file_are_sentences_of_their_own(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lint", "-v", "windmill"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("note: file-remarks: remarks while reading files: ") for line in lines)
    assert "  of 2 cameras the first is used; -D camera=... takes another of whole, sails" in lines
