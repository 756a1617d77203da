"""Outputs tell of lights whose radiances are further apart than the tests of dim lights hold for."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.rendering.saved import SavedRender

SCENE = """
[integrator]
type = "path"
max_depth = 2
[sensor]
type = "perspective"
to_world = [{{ look_at = {{ origin = [0, 0, 4], target = [0, 0, 0], up = [0, 1, 0] }} }}]
film = {{ type = "hdrfilm", width = 12, height = 12, rfilter = {{ type = "box" }} }}
[sky]
type = "constant"
[ball]
type = "sphere"
bsdf = {{ type = "diffuse", reflectance = 0 }}
emitter = {{ type = "area", radiance = {radiance} }}
"""


def scene(folder: Path, radiance: float) -> Path:
    path = folder / "scene.toml"
    path.write_text(SCENE.format(radiance=radiance))
    return path


def test_a_result_says_that_its_radiances_are_far_apart(tmp_path: Path) -> None:
    apart, together = (et.render(scene(tmp_path, radiance), spp=4) for radiance in (1e-13, 1e-11))
    assert apart.radiance_range == pytest.approx(1e13)
    assert apart.record["radiance_range"] == apart.radiance_range
    assert together.radiance_range == pytest.approx(1e11)
    assert "radiance_range" not in together.record
    apart.save(tmp_path / "a.exr")
    assert SavedRender.read(tmp_path / "a.exr").record["radiance_range"] == apart.radiance_range


FOG = """
[integrator]
type = "volpath"
max_depth = 2
[sensor]
type = "perspective"
to_world = [{ look_at = { origin = [0, 0, 4], target = [0, 0, 0], up = [0, 1, 0] } }]
film = { type = "hdrfilm", width = 12, height = 12, rfilter = { type = "box" } }
[block]
type = "cube"
bsdf = { type = "null" }
interior = { type = "homogeneous", sigma_t = 30, albedo = 0.5 }
[lamp]
type = "point"
position = [-0.9, 0, 0.9]
"""


def test_one_lamp_in_thick_fog_is_no_doubt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fog, output = tmp_path / "fog.toml", tmp_path / "fog.exr"
    fog.write_text(FOG)
    assert main(["render", str(fog), "-o", str(output), "--spp", "4"]) == 0
    assert "apart" not in capsys.readouterr().out
    assert SavedRender.read(output).record["radiance_range"] > 1e12


def test_a_black_image_has_no_range() -> None:
    black = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "integrator": {"type": "depth"}})
    assert et.render(black.with_(size=(4, 4)), spp=1).radiance_range == 1.0


def test_the_commands_say_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outputs = [str(tmp_path / name) for name in ("a.exr", "b.exr")]
    command = ["render", str(scene(tmp_path, 1e-13)), "--spp", "4"]
    said = "the image has radiances 1e+13 times apart, more than 1e+12: light of dim emitters may be missing"
    for seed, output in enumerate(outputs):
        assert main([*command, "-o", output, "--seed", str(seed)]) == 0
        assert said in capsys.readouterr().out
    assert main(["merge", *outputs, "-o", str(tmp_path / "both.exr")]) == 0
    assert "apart" not in capsys.readouterr().out, "the scene is not known"
    assert main([*command, "-o", outputs[0], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["radiance_range"] == pytest.approx(1e13)
    assert main(["info", "-v", outputs[0]]) == 0
    assert "radiance range" in capsys.readouterr().out
    assert main(["render", str(scene(tmp_path, 1e-11)), "-o", outputs[1], "--spp", "4"]) == 0
    assert "apart" not in capsys.readouterr().out
