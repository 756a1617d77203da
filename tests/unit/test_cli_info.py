"""``equaltime info`` tells what is in a scene."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from equaltime.cli import main

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


def test_it_counts_plugins_and_what_is_shared_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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
    assert "substitutions" not in told


def test_it_tells_the_sizes_of_files(capsys: pytest.CaptureFixture[str]) -> None:
    terrain = Path(__file__).parents[2] / "scenes" / "terrain"
    assert main(["info", str(terrain / "terrain.toml"), "--json"]) == 0
    files = {Path(name).name: size for name, size in json.loads(capsys.readouterr().out)["files"].items()}
    assert files == {name: (terrain / name).stat().st_size for name in ("terrain.ply", "venice_sunset.exr")}
