"""Attributes of meshes: their names in PLY files, what becomes of them, and where textures find them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import _core

SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
ROWS = ((0.1, 0.2, 0.3), (0.4, 0.5, 0.6), (0.7, 0.8, 0.9), (1.0, 0.0, 0.25))
RGB = ("r", "g", "b")


def ply(
    path: Path,
    vertex: Sequence[str] = (),
    face: Sequence[str] = (),
    kind: str = "float",
    rows: Sequence[Sequence[float]] = ROWS,
    faces: Sequence[Sequence[int]] = ((0, 1, 2), (0, 2, 3)),
) -> Path:
    """Write a square whose vertices and faces have the numbers of `rows` under these names."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(SQUARE)}"]
    lines += [f"property float {axis}" for axis in "xyz"] + [f"property {kind} {name}" for name in vertex]
    lines += [f"element face {len(faces)}", *(f"property {kind} {name}" for name in face)]
    lines += ["property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(str, (*p, *row[: len(vertex)]))) for p, row in zip(SQUARE, rows, strict=True)]
    lines += [" ".join(map(str, (*rows[i][: len(face)], len(f), *f))) for i, f in enumerate(faces)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("properties", "expected"),
    [
        (RGB, {"color": 3}),
        (("red", "green", "blue"), {"color": 3}),
        (("b", "g", "r"), {"color": 3}),
        (("p_r", "p_g", "p_b"), {"p_color": 3}),
        (("a_b_x", "a_b_y", "a_b_z"), {"a_b": 3}),
        (("p_0", "p_1", "p_2"), {"p": 3}),
        (("p_0",), {"p": 1}),
        (("p_r",), {"p_color": 1}),
        (("p_0", "q_0", "p_1"), {"p": 1, "q": 1}),
        (("p_x", "p_y"), {}),
        (("p_1", "p_0", "p_2"), {"p": 1}),
        (("p", "_0", "p_red"), {}),
        (("r", "g"), {}),
    ],
)
@pytest.mark.parametrize("element", ["vertex", "face"])
def test_names_are_those_of_mitsuba(
    element: str, properties: Sequence[str], expected: dict[str, int], tmp_path: Path
) -> None:
    mesh = _core.read_ply(ply(tmp_path / "a.ply", **{element: properties}))
    assert {name: values.shape[1] for name, values in mesh.attributes.items()} == {
        f"{element}_{name}": width for name, width in expected.items()
    }


def test_colours_may_be_in_any_order(tmp_path: Path) -> None:
    colors = _core.read_ply(ply(tmp_path / "a.ply", ("b", "g", "r"))).attributes["vertex_color"]
    assert np.allclose(colors, np.array(ROWS)[:, ::-1])


def test_alpha_is_not_kept(tmp_path: Path) -> None:
    rows = [(*row, 0.5) for row in ROWS]
    mesh = _core.read_ply(ply(tmp_path / "a.ply", ("red", "green", "blue", "alpha"), rows=rows))
    assert mesh.attributes["vertex_color"] == pytest.approx(np.array(ROWS))


def test_each_triangle_of_a_polygon_has_what_the_face_has(tmp_path: Path) -> None:
    faces = ((0, 1), (0, 1, 2, 3), (0, 0, 2), (1, 2, 3))
    mesh = _core.read_ply(ply(tmp_path / "a.ply", face=RGB, faces=faces))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [1, 2, 3]]
    assert mesh.attributes["face_color"] == pytest.approx(np.array([ROWS[1], ROWS[1], ROWS[3]]))


def test_vertices_that_no_face_uses_go_with_their_attributes(tmp_path: Path) -> None:
    mesh = _core.read_ply(ply(tmp_path / "a.ply", RGB, faces=((1, 2, 3),)))
    assert mesh.attributes["vertex_color"] == pytest.approx(np.array(ROWS[1:]))


def test_what_is_not_finite_becomes_0_and_is_told(tmp_path: Path) -> None:
    rows = [*ROWS[:3], (float("nan"), 1.0, 2e300)]
    mesh = _core.read_ply(ply(tmp_path / "a.ply", RGB, rows=rows, kind="double"))
    assert mesh.attributes["vertex_color"][3].tolist() == [0, 1, 0]
    assert mesh.warnings == ["2 numbers of vertex_color not finite in single precision became 0"]


def lit(path: Path, attribute: dict[str, Any] | None = None, **shape: Any) -> dict[str, Any]:
    """A square that fills the film and shines as its attribute says, so that the image is the attribute."""
    texture = {"type": "mesh_attribute", "name": "vertex_color"} | (attribute or {})
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    square = {"type": "ply", "filename": str(path), "emitter": {"type": "area", "radiance": texture}}
    view = [{"scale": [0.5, 0.5, 1]}, {"look_at": {"origin": [0.5, 0.5, 1], "target": [0.5, 0.5, 0], "up": [0, 1, 0]}}]
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 1},
        "sensor": {"type": "orthographic", "near_clip": 0.1, "film": film, "to_world": view},
        "square": square | shape,
    }


def image(description: dict[str, Any]) -> Any:
    return et.render(description, spp=16).image[::-1]  # rows upwards, as y


def test_faces_are_of_one_colour(tmp_path: Path) -> None:
    seen = image(lit(ply(tmp_path / "a.ply", face=RGB), {"name": "face_color"}))
    assert seen[2, 6] == pytest.approx(ROWS[0])  # x > y
    assert seen[6, 2] == pytest.approx(ROWS[1])


def test_vertices_are_interpolated_and_scaled(tmp_path: Path) -> None:
    seen = image(lit(ply(tmp_path / "a.ply", RGB), {"scale": 2.0}))
    x, y = 6.5 / 8, 2.5 / 8
    expected = (1 - x) * np.array(ROWS[0]) + (x - y) * np.array(ROWS[1]) + y * np.array(ROWS[2])
    assert seen[2, 6] == pytest.approx(2 * expected, rel=0.02)


def test_one_number_is_grey(tmp_path: Path) -> None:
    seen = image(lit(ply(tmp_path / "a.ply", face=["p_0"]), {"name": "face_p"}))
    assert seen[2, 6] == pytest.approx([0.1, 0.1, 0.1])


def test_meshes_have_values_of_their_own_in_groups_too(tmp_path: Path) -> None:
    """One material on two meshes, one of them instanced and mirrored."""
    red, green = (ply(tmp_path / f"{i}.ply", face=RGB, rows=[row] * 4) for i, row in enumerate([(1, 0, 0), (0, 1, 0)]))
    whole = lit(red)
    paint = {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "face_color"}}
    parts = {
        "paint": paint,
        "square": {"type": "ply", "filename": str(red), "bsdf": paint},
        "group": {"type": "shapegroup", "square": {"type": "ply", "filename": str(green), "bsdf": paint}},
        "copy": {
            "type": "instance",
            "shapegroup": {"type": "ref", "id": "group"},
            "to_world": [{"scale": 0.5}, {"translate": [0, 0, 0.1]}],
        },
        "sun": {"type": "directional", "direction": [0, 0, -1], "irradiance": np.pi},
        "integrator": {"type": "direct"},
    }
    seen = image(whole | parts)
    assert seen[1, 1] == pytest.approx([0, 1, 0])
    assert seen[6, 6] == pytest.approx([1, 0, 0])


def test_a_texture_may_multiply_it(tmp_path: Path) -> None:
    board = {"type": "checkerboard", "color0": 0.5, "color1": 0.25, "to_uv": {"scale": [2, 2]}}
    attribute = {"type": "mesh_attribute", "name": "face_color", "times": board}
    whole = lit(ply(tmp_path / "a.ply", face=RGB))
    square = {"type": "ply", "filename": str(tmp_path / "a.ply"), "bsdf": {"type": "diffuse", "reflectance": attribute}}
    sun = {"type": "directional", "direction": [0, 0, -1], "irradiance": np.pi}
    seen = image(whole | {"square": square, "sun": sun, "integrator": {"type": "direct"}})
    assert seen[0, 1] == pytest.approx(0.5 * np.array(ROWS[0]))  # without uvs, squares are of barycentric coordinates
    assert seen[0, 7] == pytest.approx(0.25 * np.array(ROWS[0]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "vertex_colour"}, r"the shape has no attribute 'vertex_colour'; it has 'vertex_color'"),
        ({"name": "color"}, "must begin with 'vertex_' or 'face_'"),
        ({"times": {"type": "checkerboard"}}, "'times' of a 'mesh_attribute' is for parameters of BSDFs"),
    ],
)
def test_what_is_not_there_is_told(change: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(et.SceneError, match=message):
        image(lit(ply(tmp_path / "a.ply", RGB), change))


def test_shapes_that_are_no_meshes_have_none(tmp_path: Path) -> None:
    whole = lit(ply(tmp_path / "a.ply", RGB))
    whole["square"] = {"type": "rectangle", "emitter": whole["square"]["emitter"]}
    with pytest.raises(et.SceneError, match=r"square\.emitter\.radiance: the shape has no attribute 'vertex_color'$"):
        image(whole)
