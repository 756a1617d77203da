"""Names of a glTF file's materials, nodes and lights: a scene written as TOML or XML keeps them."""

from __future__ import annotations

from pathlib import Path

import pytest

import equaltime as et
from equaltime.scene.gltf.ids import Ids

from .gltf_files import TRIANGLE, Builder, one_triangle


def named(material: str | None, *nodes: str | None) -> Builder:
    """Return triangles of one material, in nodes with these names."""
    builder = one_triangle(**({"doubleSided": True} if material is None else {"name": material}))
    builder.json["nodes"] = [{"mesh": 0} | ({} if name is None else {"name": name}) for name in nodes]
    return builder


def test_materials_and_nodes_keep_their_names(tmp_path: Path) -> None:
    model = et.load(named("window glass", "left", "right", "left").gltf(tmp_path / "a.gltf")).model
    assert [shape.id for shape in model.shapes] == ["left", "right", "left_2"]
    assert {shape.bsdf.id for shape in model.shapes} == {"window glass"}  # type: ignore[union-attr]
    assert [emitter.id for emitter in model.emitters] == ["sky", "sun"]


def test_what_has_no_name_is_numbered(tmp_path: Path) -> None:
    (shape,) = et.load(named(None, None).gltf(tmp_path / "a.gltf")).model.shapes
    assert (shape.id, shape.bsdf.id) == (None, "material_0")  # type: ignore[union-attr]


def test_a_mesh_names_what_its_node_does_not(tmp_path: Path) -> None:
    builder = named("red", None)
    builder.json["meshes"][0]["name"] = "hull"
    assert [shape.id for shape in et.load(builder.gltf(tmp_path / "a.gltf")).model.shapes] == ["hull"]


def test_lights_keep_the_names_of_their_nodes(tmp_path: Path) -> None:
    builder = one_triangle()
    builder.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional", "name": "star"}]}}
    for name in ({"name": "noon"}, {}):
        builder.node(extensions={"KHR_lights_punctual": {"light": 0}}, **name)
    scene = et.load(builder.gltf(tmp_path / "a.gltf"))
    assert [emitter.id for emitter in scene.model.emitters] == ["noon", "star"]


def test_copies_of_a_large_mesh_keep_their_names(tmp_path: Path) -> None:
    builder = Builder()
    mesh = builder.mesh(TRIANGLE, [0, 1, 2] * 40_000, material=builder.add("materials", {"name": "red"}))
    builder.json["meshes"][mesh]["name"] = "leaf"
    for name in ("one", "two"):
        builder.node(mesh=mesh, name=name)
    shapes = et.load(builder.gltf(tmp_path / "a.gltf")).model.shapes
    assert [(shape.type, shape.id) for shape in shapes] == [("instance", "one"), ("instance", "two")]


@pytest.mark.parametrize(
    "name",
    [
        *("a.b", "type", "default", "scene", "sun", "integrator", "sensor", "ground"),
        *(
            "$x",
            "${y}",
            "a\nb",
            'say "no"',
            "it's",
            "ünï ☃",
            " ",
            "",
            "x" * 3000,
            "[t]",
            "a#b",
            "<&>",
            "\\",
            "\x01",
            "\ud800",
        ),
    ],
)
@pytest.mark.parametrize("suffix", ["toml", "xml"])
def test_any_name_can_be_written_and_read(name: str, suffix: str, tmp_path: Path) -> None:
    """The same name stands for a material and for two shapes. Meshes become PLY files beside XML."""
    scene = et.load(named(name, name, name).gltf(tmp_path / "a.gltf"))
    scene.write(tmp_path / f"b.{suffix}")
    again = et.load(tmp_path / f"b.{suffix}")
    assert (again.digest == scene.digest) == (suffix == "toml")
    shapes, before = again.model.shapes, scene.model.shapes
    assert [shape.bsdf.model_copy(update={"id": None}) for shape in shapes] == [  # type: ignore[union-attr]
        shape.bsdf.model_copy(update={"id": None})  # type: ignore[union-attr]
        for shape in before
    ]


def test_ids_differ() -> None:
    ids = Ids()
    assert [ids.take(name) for name in ("a", "a", "a_2", "a", "a_2")] == ["a", "a_2", "a_2_2", "a_3", "a_2_3"]


def test_very_many_equal_names_take_no_time() -> None:
    ids = Ids()
    assert len({ids.take("a") for _ in range(100_000)}) == 100_000


def test_names_that_are_numbered_already_are_passed_over() -> None:
    ids = Ids()
    for number in range(2, 50_000):
        ids.take(f"a_{number}")
    assert [ids.take("a"), ids.take("a"), ids.take("a")] == ["a", "a_50000", "a_50001"]
