"""Mitsuba's shape ``merge``: its shapes stand in its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from equaltime.errors import SceneError
from equaltime.scene import Scene, load, load_dict

RED = '<bsdf type="diffuse" id="red"><rgb name="reflectance" value="1 0 0"/></bsdf>'


def read(folder: Path, body: str) -> Scene:
    (folder / "scene.xml").write_text(f'<scene version="3.0.0"><sensor type="perspective"/>\n{body}\n</scene>')
    return load(folder / "scene.xml")


def test_shapes_and_what_they_refer_to_come_in_their_order(tmp_path: Path) -> None:
    body = (
        f'{RED}<shape type="disk"/><shape type="merge" id="all"><shape type="cube"><ref id="red"/></shape>'
        '<shape type="merge"><shape type="sphere"/></shape></shape><shape type="cylinder"/>'
    )
    shapes = read(tmp_path, body).model.shapes
    assert [shape.type for shape in shapes] == ["disk", "cube", "sphere", "cylinder"]
    assert (
        shapes[1]
        == load_dict(
            {
                "type": "scene",
                "sensor": {"type": "perspective"},
                "red": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [1, 0, 0]}},
                "any": {"type": "merge", "it": {"type": "cube", "paint": {"type": "ref", "id": "red"}}},
            }
        ).model.shapes[0]
    )


def test_a_group_may_hold_one(tmp_path: Path) -> None:
    both = '<shape type="merge"><shape type="cube"/><shape type="disk"/></shape>'
    group = f'<shape type="shapegroup" id="g">{both}</shape>'
    (copy,) = read(tmp_path, group + '<shape type="instance"><ref id="g"/></shape>').model.shapes
    assert [part.type for part in copy.shapegroup.shapes] == ["cube", "disk"]  # type: ignore[union-attr]


def test_of_two_the_names_of_parts_may_be_the_same() -> None:
    both = {"type": "merge", "part": {"type": "cube"}}
    loaded = load_dict({"type": "scene", "sensor": {"type": "perspective"}, "a": both, "b": dict(both)})
    assert len(loaded.model.shapes) == 2


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (RED, r"scene\.xml:2: 'merge' cannot contain a bsdf \('diffuse'\): it takes shapes alone"),
        ('<float name="x" value="1"/>', r"scene\.xml:2: unknown parameter 'x' of 'merge', which takes shapes alone"),
    ],
)
def test_anything_but_shapes_is_refused(inside: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=message):
        read(tmp_path, f'<shape type="merge"><shape type="cube"/>{inside}</shape>')
