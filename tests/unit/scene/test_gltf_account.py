"""The account of glTF files: what nobody reads is told, one line a kind, and what is read is not."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.gltf import MAPPING, account
from equaltime.scene.gltf.schema import DOCUMENT, UNREADABLE
from equaltime.scene.lint import lint

from .gltf_files import Builder, one_triangle, surfaces
from .gltf_materials import loaded, textured

ALWAYS = ("the file has no light", "the file has no camera")
Json = dict[str, Any]


def told(builder: Builder, folder: Path) -> list[str]:
    return [line for line in loaded(builder, folder).warnings if not line.startswith(ALWAYS)]


def test_a_file_of_which_all_is_read_has_nothing_to_tell(tmp_path: Path) -> None:
    builder = one_triangle(name="plain", pbrMetallicRoughness={"baseColorFactor": [1, 0.5, 0.25, 1]})
    builder.json["asset"] |= {"generator": "a test", "copyright": "nobody"}
    builder.json["accessors"][0] |= {"min": [0, 0, 0], "max": [1, 1, 0], "name": "corners"}
    builder.json["bufferViews"][0] |= {"target": 34962, "name": "bytes"}
    builder.json |= {"scenes": [{"nodes": [0], "name": "all"}], "scene": 0}
    assert told(builder, tmp_path) == []


PROPERTIES: dict[str, tuple[Callable[[Json], Any], str]] = {
    "of the file": (lambda d: d.update(skies=[1]), "skies is not used"),
    "of a node": (lambda d: d["nodes"][0].update(visible=False), "nodes[].visible is not used (nodes[0])"),
    "of an accessor": (
        lambda d: d["accessors"][0].update(offset=[1, 2, 3]),
        "accessors[].offset is not used (accessors[0])",
    ),
    "of a material": (
        lambda d: d["materials"][0]["pbrMetallicRoughness"].update(clearcoat=1),
        "materials[].pbrMetallicRoughness.clearcoat is not used (materials[0].pbrMetallicRoughness)",
    ),
    "of an extension that is read": (
        lambda d: d["materials"][0].update(extensions={"KHR_materials_ior": {"ior": 1.4, "dispersion": 1.0}}),
        "materials[].extensions.KHR_materials_ior.dispersion is not used (materials[0].extensions.KHR_materials_ior)",
    ),
    "an extension": (
        lambda d: d["materials"][0].update(extensions={"KHR_materials_iridescence": {"iridescenceFactor": 1}}),
        "the extension 'KHR_materials_iridescence' is not used (materials[0])",
    ),
    "an extension where none is read": (
        lambda d: d["meshes"][0].update(extensions={"KHR_materials_ior": {}}),
        "the extension 'KHR_materials_ior' is not used (meshes[0])",
    ),
    "extras": (lambda d: d["meshes"][0].update(extras={"targetNames": []}), "extras are not used (meshes[0])"),
    "a part": (
        lambda d: d["materials"].append({"name": "spare"}),
        "some materials are not used: nothing refers to them (materials[1])",
    ),
    "a node of no scene": (
        lambda d: d.update(scenes=[{"nodes": [0]}], nodes=[*d["nodes"], {"mesh": 0}]),
        "some nodes are not used: nothing refers to them (nodes[1])",
    ),
    "a scene": (
        lambda d: d.update(scenes=[{"nodes": [0]}, {"nodes": [0]}]),
        "one of 2 scenes is shown; -D scene=... takes another",
    ),
}


@pytest.mark.parametrize("name", PROPERTIES)
def test_what_nobody_reads_is_told_with_its_place(tmp_path: Path, name: str) -> None:
    change, expected = PROPERTIES[name]
    builder = one_triangle(pbrMetallicRoughness={})
    digest = loaded(builder, tmp_path).digest
    change(builder.json)
    assert told(builder, tmp_path) == [expected]
    assert loaded(builder, tmp_path).digest == digest or name == "of an extension that is read"


def test_many_of_a_kind_are_one_line_with_the_first_places(tmp_path: Path) -> None:
    builder = Builder()
    mesh = builder.mesh()
    for i in range(50):
        builder.node(mesh=mesh, translation=[i, 0, 0], extras={"number": i})
    assert told(builder, tmp_path) == ["extras are not used (nodes[0], nodes[1], nodes[2] and 47 more)"]


@pytest.mark.parametrize("name", ["TEXCOORD_3", "COLOR_1", "_CUSTOM", "TANGENT", "JOINTS_0"])
def test_attributes_that_nobody_looks_at_are_told(tmp_path: Path, name: str) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(**{name: builder.accessor(np.ones((3, 4)), type="VEC4")}))
    assert told(builder, tmp_path) == [f"the attribute {name} is not used (meshes[0].primitives[0])"]


def test_the_texture_coordinates_that_a_texture_uses_are_not_told(tmp_path: Path) -> None:
    use = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}}
    builder = textured(np.zeros((2, 2, 3), np.uint8), tmp_path, **use)
    attributes = builder.json["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"]
    assert told(builder, tmp_path) == ["the attribute TEXCOORD_0 is not used (meshes[0].primitives[0])"]


def test_texture_coordinates_that_are_missing_are_told_and_0(tmp_path: Path) -> None:
    builder = textured(np.zeros((2, 2, 3), np.uint8), tmp_path, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    del builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]
    message = "the textures of the material need TEXCOORD_0, which is missing: all vertices get (0, 0)"
    assert f"{message} (meshes[0].primitives[0])" in told(builder, tmp_path)
    (surface,) = surfaces(builder, tmp_path)
    assert surface.uvs is not None
    assert not surface.uvs.any()


def test_attributes_of_copies_that_nobody_looks_at_are_told(tmp_path: Path) -> None:
    builder = one_triangle()
    attributes = {"TRANSLATION": builder.accessor([[0, 0, 0]]), "_COLOR": builder.accessor([[1, 0, 0]])}
    builder.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    assert told(builder, tmp_path) == ["the attribute _COLOR of copies is not used (nodes[0])"]


def test_attributes_of_morph_targets_that_nobody_looks_at_are_told(tmp_path: Path) -> None:
    builder = one_triangle()
    moved = builder.accessor(np.zeros((3, 3)))
    builder.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": moved, "TANGENT": moved, "COLOR_0": moved}]
    expected = ["TANGENT of morph targets", "COLOR_0 of morph targets"]
    lines = [f"the attribute {name} is not used (meshes[0].primitives[0])" for name in expected]
    assert sorted(told(builder, tmp_path)) == sorted(lines)


def test_weights_that_are_not_one_for_each_morph_target_are_told(tmp_path: Path) -> None:
    builder = one_triangle()
    builder.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": builder.accessor(np.ones((3, 3)))}] * 2
    builder.json["meshes"][0]["weights"], builder.json["nodes"][0]["weights"] = [0.5], [1, 1, 1]
    expected = "expected a weight for each of 2 morph targets, found"
    assert told(builder, tmp_path) == [
        f"{expected} 1: the others are 0 (meshes[0].weights)",
        f"{expected} 3: the last are not used (nodes[0].weights)",
    ]
    builder.json["meshes"][0]["weights"], builder.json["nodes"][0]["weights"] = [0.5, 0], [1, 1]
    assert told(builder, tmp_path) == []


def test_a_key_that_stands_twice_is_told(tmp_path: Path) -> None:
    text = json.dumps({**one_triangle().document(), "buffers": [{"byteLength": 36, "uri": "a.bin"}]})
    (tmp_path / "a.bin").write_bytes(one_triangle().binary)
    (tmp_path / "a.gltf").write_text(text.replace('"mesh": 0', '"mesh": 7, "mesh": 0'))
    expected = "an object of the JSON has 'mesh' more than once: the last counts"
    assert expected in et.load(tmp_path / "a.gltf").warnings


def test_lint_names_what_is_told(tmp_path: Path) -> None:
    builder = one_triangle(pbrMetallicRoughness={})
    builder.json["materials"][0]["sparkle"] = 1
    (finding,) = [found for found in lint(loaded(builder, tmp_path)) if found.check == "file-remarks"]
    assert "materials[].sparkle is not used (materials[0])" in finding.where


def test_a_reader_without_an_account_is_caught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The power of these tests: a walk that skips what no table lists finds nothing."""
    walk = account.walk
    monkeypatch.setattr(account, "walk", lambda rule, value: (e for e in walk(rule, value) if e[0] is not None))
    change, expected = PROPERTIES["of a node"]
    builder = one_triangle(pbrMetallicRoughness={})
    change(builder.json)
    assert expected not in told(builder, tmp_path)


def listed(rule: Any) -> Iterator[str]:
    """Iterate over the names of all properties that a rule of the schema lists."""
    for name, inner in getattr(rule, "fields", {}).items():
        yield name
        yield from listed(inner)
    if hasattr(rule, "item"):
        yield from listed(rule.item)


def test_the_table_of_what_becomes_of_each_property_is_complete() -> None:
    page = (Path(account.__file__).parent / "README.md").read_text()
    names = {name for name in listed(DOCUMENT) if not name.startswith(("KHR_", "EXT_", "extensions"))}
    assert {"byteStride", "thicknessFactor", "wrapS"} <= names
    assert [name for name in sorted(names) if f"`{name}`" not in page] == []
    extensions = {name for name in listed(DOCUMENT) if name.startswith(("KHR_", "EXT_"))} | {*MAPPING, *UNREADABLE}
    assert [name for name in sorted(extensions) if f"| {name} |" not in page and f" {name}" not in page] == []
