"""Small files that would become large: they are refused at once, with their place."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import pytest

import equaltime as et

SECONDS = 2.0
HEAD = "<scene version='3.0.0'><sensor type='perspective'/>"


def _refused(path: Path, content: str) -> str:
    path.write_text(content)
    started = process_time()
    with pytest.raises(et.SceneError) as caught:
        et.load(path)
    assert process_time() - started < SECONDS
    return str(caught.value)


@pytest.mark.parametrize(
    ("tag", "plugin", "leaf", "number"),
    [
        ("bsdf", "blendbsdf", "diffuse", "weight"),
        ("phase", "blendphase", "isotropic", "weight"),
    ],
)
def test_references_that_double_with_each_level(tmp_path: Path, tag: str, plugin: str, leaf: str, number: str) -> None:
    levels = [f"<{tag} type='{leaf}' id='n0'/>"]
    for level in range(40):
        twice = f"<ref id='n{level}'/>" * 2
        levels.append(f"<{tag} type='{plugin}' id='n{level + 1}'><float name='{number}' value='0.5'/>{twice}</{tag}>")
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}{''.join(levels)}</scene>")
    assert "bomb.xml:1: with all references followed these are" in message


def test_values_that_double_with_each_default(tmp_path: Path) -> None:
    defaults = ["<default name='v0' value='0.5'/>"]
    defaults += [f"<default name='v{k + 1}' value='$v{k}$v{k}'/>" for k in range(40)]
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}{''.join(defaults)}</scene>")
    assert "the variables of the scene stand for more than" in message


def test_includes_that_double_with_each_level(tmp_path: Path) -> None:
    for level in range(14):
        twice = f"<include filename='f{level + 1}.xml'/>" * 8
        (tmp_path / f"f{level}.xml").write_text(f"<scene version='3.0.0'>{twice}</scene>")
    (tmp_path / "f14.xml").write_text("<scene version='3.0.0'/>")
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}<include filename='f0.xml'/></scene>")
    assert "included again and again" in message


def test_what_many_shapes_share_is_no_bomb(tmp_path: Path) -> None:
    shapes = "<shape type='sphere'><ref id='m'/></shape>" * 300
    material = "<bsdf type='twosided' id='m'><bsdf type='diffuse'/></bsdf>"
    path = tmp_path / "shared.xml"
    path.write_text(f"{HEAD}{material}{shapes}</scene>")
    model = et.load(path).model
    assert len(model.shapes) == 300
    assert sum(node.kind == "bsdf" for node in model.nodes()) == 2  # what is used often is visited once


def test_copies_that_no_data_places(tmp_path: Path) -> None:
    accessor = {"componentType": 5126, "count": 900_000, "type": "VEC3"}
    gpu = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}
    scene = {
        "asset": {"version": "2.0"},
        "extensionsUsed": list(gpu),
        "accessors": [accessor, {**accessor, "count": 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}}]}],
        "nodes": [{"mesh": 0, "extensions": gpu}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    assert "900000 copies without data" in _refused(tmp_path / "bomb.gltf", json.dumps(scene))


def _doubled(leaf: Any, join: Callable[[Any], Any]) -> Any:
    for _ in range(40):
        leaf = join(leaf)
    return leaf


@pytest.mark.parametrize(
    "part",
    [
        _doubled({"type": "diffuse"}, lambda bsdf: {"type": "blendbsdf", "weight": 0.5, "a": bsdf, "b": bsdf}),
        _doubled({"type": "diffuse"}, lambda bsdf: {"type": "blendbsdf", "weight": 0.5, "bsdfs": [bsdf, bsdf]}),
        {"type": "sphere", "center": _doubled([1.0], lambda numbers: [numbers, numbers])},
        {"type": "sphere", "to_world": _doubled([1.0], lambda numbers: [numbers, numbers])},
    ],
    ids=["objects", "lists of objects", "numbers", "steps"],
)
def test_dictionaries_and_lists_that_share_parts(part: dict[str, Any]) -> None:
    started = process_time()
    with pytest.raises(
        et.SceneError, match=r"dictionaries and lists are used again and again; the limit for this"
    ) as e:
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "part": part})
    assert process_time() - started < SECONDS
    assert len(str(e.value)) < 1000
