"""Groups of surfaces whose shares of the noise are measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.quoting.surface_groups import MOST, SurfaceGroups


def scene(materials: list[str]) -> et.Scene:
    """Make a scene with a ball of each of these materials; an empty name is a ball without any."""
    world: dict[str, Any] = {"type": "scene", "sensor": {"type": "perspective"}}
    for name in materials:
        if name:
            world[name] = {"type": "diffuse", "id": name}
    for number, name in enumerate(materials):
        bsdf = {"bsdf": {"type": "ref", "id": name}} if name else {}
        world[f"ball_{number}"] = {"type": "sphere", "center": [number, 0, 0], "radius": 0.4, **bsdf}
    return et.load_dict(world)


def test_a_few_shapes_are_a_group_each() -> None:
    groups = SurfaceGroups.of(scene(["red", "red", ""]))
    assert groups.of_shape == (0, 1, 2)
    assert [name.split()[:3] for name in groups.names] == [["shape", f"{i}:", f"ball_{i}"] for i in range(3)]


def test_a_shape_that_moves_is_one_group() -> None:
    keys = [{"time": t, "transform": [{"translate": [0.0, t, 0.0]}]} for t in (0.0, 1.0)]
    moving = {f"ball_{i}": {"type": "sphere", "to_world": {"animation": keys}} for i in range(MOST)}
    world = {"type": "scene", "sensor": {"type": "perspective"}, **moving}
    groups = SurfaceGroups.of(et.load_dict(world).with_(shutter=(0.0, 1.0)))
    assert groups.of_shape == (*range(MOST), *range(MOST))
    assert groups.names[-1] == f"shape {MOST - 1}: ball_{MOST - 1}"


def test_shapes_of_a_material_are_a_group_where_shapes_are_many() -> None:
    materials = [*["red"] * 3, *["blue"] * MOST, ""]
    groups = SurfaceGroups.of(scene(materials))
    assert [name.split()[2] for name in groups.names] == ["blue", "red", f"ball_{3 + MOST}"]
    assert groups.of_shape == (*[1] * 3, *[0] * MOST, 2)


@pytest.mark.parametrize(("more", "last"), [(0, "material"), (1, "others"), (5, "others")])
def test_the_least_common_materials_are_one_group_where_materials_are_many(more: int, last: str) -> None:
    names = [f"m{i}" for i in range(MOST + more)]
    groups = SurfaceGroups.of(scene([*names, *names[: MOST - 1]]))
    assert len(groups.names) == MOST
    assert groups.names[-1].split()[0] == last
    assert groups.of_shape[: MOST - 1] == tuple(range(MOST - 1))
    assert set(groups.of_shape[MOST - 1 : MOST + more]) == {MOST - 1}


def test_parts_of_an_obj_file_have_the_names_of_their_materials(tmp_path: Path) -> None:
    vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    (tmp_path / "m.obj").write_text(f"mtllib m.mtl\n{vertices}usemtl red\nf 1 2 3\nusemtl blue\nf 1 2 4\n")
    (tmp_path / "m.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    names = SurfaceGroups.of(et.load(tmp_path / "m.obj")).names
    assert [name.split()[2] for name in names[:2]] == ["red", "blue"]
