"""The JSON schema for editors: all that is shipped agrees with it, and mistakes do not."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from equaltime.cli import main
from equaltime.scene import load
from equaltime.scene.model import PLUGINS
from equaltime.scene.schema import scene_schema

SCENES = Path(__file__).parents[3] / "scenes"
TEXTS = {
    path.relative_to(SCENES).as_posix(): text
    for path in sorted(SCENES.rglob("*.toml"))
    if "[sensor]" in (text := path.read_text())
}
BLOCKS = re.findall(r"^```toml\n(.*?)^```", (SCENES / "README.md").read_text(), re.DOTALL | re.MULTILINE)
TEXTS |= {f"README, block {number}": block for number, block in enumerate(BLOCKS)}


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    schema = scene_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("name", TEXTS)
def test_scenes_agree_with_the_schema(name: str, validator: jsonschema.Draft202012Validator) -> None:
    assert [error.message for error in validator.iter_errors(tomllib.loads(TEXTS[name]))] == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"a": {"type": "spere"}},
        {"a": {"radius": 1}},
        {"a": {"type": "sphere", "radius": "wide"}},
        {"a": {"type": "sphere", "center": [1, 2]}},
        {"a": {"type": "sphere", "radus": 1}},
        {"a": {"type": "diffuse", "reflectanse": 1}},
        {"a": {"type": "diffuse", "reflectance": [1, 2, 3, 4]}},
        {"a": {"type": "diffuse", "reflectance": {"type": "bitmap"}}},
        {"a": {"type": "diffuse", "reflectance": {"type": "sphere"}}},
        {"a": {"type": "mask", "opacity": [0.1, 0.2], "bsdf": "b"}},
        {"a": {"type": "roughplastic", "distribution": "phong"}},
        {"a": {"type": "disk", "to_world": [{"turn": 3}]}},
        {"sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 0}}},
        {"include": 3},
        {"a": {"type": "diffuse", "reflectance": {"type": "constvolume", "value": 0.5}}},
        {"m": {"type": "merge", "paint": {"type": "diffuse"}}},
        {"m": {"type": "merge", "radius": 2}},
        {"c": {"type": "cube", "interior": {"type": "homogeneous", "sigma_s": "thick"}}},
    ],
)
def test_mistakes_do_not(wrong: dict[str, Any], validator: jsonschema.Draft202012Validator) -> None:
    assert not validator.is_valid(wrong)


def test_variables_and_names_may_stand_where_values_do(validator: jsonschema.Draft202012Validator) -> None:
    ball = {"type": "sphere", "radius": "$r", "bsdf": "red", "to_world": [{"scale": "$s"}]}
    assert validator.is_valid({"ball": ball, "red": {"type": "diffuse", "reflectance": "wood"}})
    assert validator.is_valid({"way": {"type": "$integrator"}})


READ = {
    "a merge": '[m]\ntype = "merge"\na = { type = "cube" }\nb = { type = "merge", all = [{ type = "disk" }] }',
    "a merge of names": '[c]\ntype = "cube"\n[m]\ntype = "merge"\na = { type = "ref", id = "c" }',
    "a merge in a group": '[g]\ntype = "shapegroup"\nshapes = [{ type = "merge", a = { type = "cube" } }]\n'
    '[i]\ntype = "instance"\nshapegroup = "g"',
    "a medium by its parts": '[c]\ntype = "cube"\n'
    'interior = { type = "homogeneous", sigma_s = 1, sigma_a = [1, 2, 3] }',
    "a medium of volumes": '[v]\ntype = "constvolume"\nvalue = 0.5\n'
    '[c]\ntype = "cube"\n[c.interior]\ntype = "homogeneous"\nalbedo = { type = "ref", id = "v" }\n'
    'sigma_t = { type = "constvolume", value = { type = "rgb", value = [1, 2, 3] } }\n'
    'phase = { type = "blendphase", weight = { type = "constvolume", value = 0.5 }, a = { type = "hg" }, '
    'b = { type = "rayleigh" } }',
    "a grey where a number stands": '[c]\ntype = "cube"\n'
    'bsdf = { type = "mask", opacity = { type = "rgb", value = [0.5, 0.5, 0.5] }, any = { type = "diffuse" } }',
    "three numbers for one": '[c]\ntype = "cube"\n'
    'bsdf = { type = "mask", opacity = [0.5, 0.5, 0.5], any = [{ type = "diffuse" }] }',
    "a matrix of variables": '[default]\nx = 2\n[c]\ntype = "cube"\n'
    'to_world = [["$x", 0, 0, 0], [0, "$x", 0, 0], [0, 0, "$x", 0], [0, 0, 0, 1]]',
    "a place that is a variable": '[default]\np = [1, 2, 3]\n[l]\ntype = "point"\nposition = "$p"',
    "objects in a list": '[[lights]]\ntype = "point"\n[[lights]]\ntype = "constant"',
    "a name at the top": '[c]\ntype = "cube"\n[again]\ntype = "ref"\nid = "c"',
}


@pytest.mark.parametrize("name", READ)
def test_what_is_read_agrees_with_it(name: str, validator: jsonschema.Draft202012Validator, tmp_path: Path) -> None:
    text = f'{READ[name]}\n[sensor]\ntype = "perspective"\n'
    (tmp_path / "scene.toml").write_text(text)
    assert load(tmp_path / "scene.toml").core.film_shape
    assert [error.message for error in validator.iter_errors(tomllib.loads(text))] == []


def test_every_plugin_and_parameter_has_words_and_a_place(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    described = json.loads(capsys.readouterr().out)["$defs"]
    for name, plugin in PLUGINS.items():
        table = described[f"{plugin.kind}.{name}"]
        assert table["properties"]["type"] == {"const": name}
        assert plugin.model_fields.keys() <= table["properties"].keys()
        assert table["description"].endswith(".")
