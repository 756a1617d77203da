"""PLY: colours count by their type, images and uvs of corners are used, and what is not used is told with its line."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

import equaltime as et
from equaltime._core import MeshData, MeshError, read_ply
from equaltime.images import image_files as images
from equaltime.scene import model as m

SQUARE: Final = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
CODES: Final = {
    **{"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I"},
    **{"float": "f", "double": "d"},
}
LARGEST: Final = {
    **{"char": 127, "uchar": 255, "short": 32767, "ushort": 65535, "int": 2**31 - 1, "uint": 2**32 - 1},
    **{"float": 1, "double": 1},
}
ADDED = "the file is only a mesh"
Properties = Sequence[tuple[str, str]]


def ply(
    path: Path,
    vertex: Properties = (),
    values: Sequence[float] = (),
    *,
    face: Properties = (),
    face_values: Sequence[Any] = (),
    header: Sequence[str] = (),
    order: str = "",
    after: bytes = b"",
) -> Path:
    """Write a square: all its vertices have the same further values, and so has its face; in binary with an `order`."""
    kind = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    lines = ["ply", f"format {kind} 1.0", *header, "element vertex 4", *(f"property float {c}" for c in "xyz")]
    lines += [f"property {type_} {name}" for type_, name in vertex]
    lines += ["element face 1", "property list uchar int vertex_indices"]
    lines += [f"property {type_} {name}" for type_, name in face]
    lines.append("end_header\n")
    rows = [(*point, *values) for point in SQUARE]
    listed = [item for value in face_values for item in (value if isinstance(value, tuple) else (value,))]
    if not order:
        body = "".join(" ".join(map(str, row)) + "\n" for row in [*rows, (4, 0, 1, 2, 3, *listed)]).encode()
    else:
        codes = order + "fff" + "".join(CODES[type_] for type_, _ in vertex)
        body = b"".join(struct.pack(codes, *row) for row in rows) + struct.pack(f"{order}B4i", 4, 0, 1, 2, 3)
        for (type_, _), value in zip(face, face_values, strict=True):
            body += struct.pack(f"{order}B{len(value) - 1}{CODES[type_.split()[-1]]}", *value)
    path.write_bytes("\n".join(lines).encode() + body + after)
    return path


def rgb(type_: str) -> list[tuple[str, str]]:
    return [(type_, name) for name in ("red", "green", "blue")]


def seen(path: Path) -> tuple[Any, list[str]]:
    """Return the reflectance of the bare mesh, and what is told of it."""
    scene = et.load(path)
    (shape,) = [shape for shape in scene.model.shapes if isinstance(shape, m.Ply)]
    assert isinstance(shape.bsdf, m.TwoSided)
    told = [warning for warning in scene.warnings if not warning.startswith(ADDED)]
    return shape.bsdf.bsdf[0].reflectance, told  # type: ignore[union-attr]


def color(path: Path) -> list[float]:
    """Return the colour of the first vertex of a bare mesh, as a surface of the scene has it."""
    reflectance, _ = seen(path)
    assert isinstance(reflectance, m.MeshAttribute)
    row: list[float] = reflectance.numbers(read_ply(path).attributes[reflectance.name])[0].tolist()
    return row


@pytest.mark.parametrize("type_", CODES)
@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("share", [0.0, 0.2, 1.0])
def test_a_colour_is_its_share_of_the_largest_value_of_its_type(
    type_: str, order: str, share: float, tmp_path: Path
) -> None:
    value = share if type_ in ("float", "double") else round(share * LARGEST[type_])
    path = ply(tmp_path / "a.ply", rgb(type_), (value, 0, 0), order=order)
    assert color(path) == pytest.approx([value / LARGEST[type_], 0, 0], rel=1e-6)
    assert seen(path)[1] == []


def test_a_dark_file_stays_dark(tmp_path: Path) -> None:
    """The largest number of a file says nothing about its type."""
    assert color(ply(tmp_path / "a.ply", rgb("uchar"), (1, 1, 0))) == pytest.approx([1 / 255, 1 / 255, 0])
    assert color(ply(tmp_path / "a.ply", rgb("ushort"), (255, 1, 0))) == pytest.approx([255 / 65535, 1 / 65535, 0])


@pytest.mark.parametrize(("value", "shown"), [(1.0001, 1.0), (255.0, 1.0), (-0.5, 0.0)])
def test_what_is_beyond_is_cut_and_told(value: float, shown: float, tmp_path: Path) -> None:
    path = ply(tmp_path / "a.ply", rgb("float"), (value, 0.2, 0.2))
    assert color(path) == pytest.approx([shown, 0.2, 0.2])
    assert seen(path)[1] == ["a.ply: vertex_color has values outside [0, 1], which are clamped"]
    cut = et.render(et.load(path).with_(size=(16, 12)), spp=4).image
    path = ply(tmp_path / "b.ply", rgb("float"), (shown, 0.2, 0.2))
    assert np.array_equal(et.render(et.load(path).with_(size=(16, 12)), spp=4).image, cut)


def test_channels_of_several_types_are_brought_to_one(tmp_path: Path) -> None:
    path = ply(tmp_path / "a.ply", [("uchar", "red"), ("float", "green"), ("ushort", "blue")], (51, 0.4, 65535))
    assert color(path) == pytest.approx([0.2, 0.4, 1.0])


@pytest.mark.parametrize(
    "names", [("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")]
)
@pytest.mark.parametrize("element", ["vertex", "face"])
def test_colours_have_these_names(names: Sequence[str], element: str, tmp_path: Path) -> None:
    properties = [("uchar", name) for name in names]
    if element == "vertex":
        path = ply(tmp_path / "a.ply", properties, (51, 102, 255))
    else:
        path = ply(tmp_path / "a.ply", face=properties, face_values=(51, 102, 255))
    assert color(path) == pytest.approx([0.2, 0.4, 1.0])
    assert seen(path)[1] == []


@pytest.mark.parametrize("type_", ["uchar", "float"])
def test_within_a_scene_numbers_are_taken_as_they_are(type_: str, tmp_path: Path) -> None:
    mesh = read_ply(ply(tmp_path / "a.ply", rgb(type_), (1, 0, 1)))
    assert mesh.attributes["vertex_color"][0].tolist() == [1, 0, 1]
    assert mesh.full == {"vertex_color": LARGEST[type_]}


def test_properties_and_elements_that_are_not_used_are_told(tmp_path: Path) -> None:
    vertex = [*rgb("uchar"), ("uchar", "alpha"), ("float", "quality"), ("float", "s"), ("float", "t"), ("float", "u")]
    header = ["element edge 1", "property int vertex1", "comment nothing", "obj_info nothing", "element none 0"]
    path = ply(tmp_path / "a.ply", vertex, (0, 0, 0, 9, 0.5, 0, 0, 0), face=[("int", "flags")], face_values=(1,))
    text = path.read_text().replace("element vertex", "\n".join([*header, "element vertex"]))
    path.write_text(text.replace("end_header\n", "end_header\n7\n"))
    assert read_ply(path).warnings == [
        "line 3: 'edge' is an element that is not used",
        "line 15: 'alpha' is a property that is not used",
        "line 16: 'quality' is a property that is not used",
        "line 19: 'u' is a property that is not used",
        "line 22: 'flags' is a property that is not used",
    ]


def test_lists_that_are_not_used_are_told(tmp_path: Path) -> None:
    face = [("list uchar int", "vertex_index"), ("list uchar uchar", "rgb")]
    mesh = read_ply(ply(tmp_path / "a.ply", face=face, face_values=((3, 0, 1, 2), (3, 255, 0, 0))))
    assert len(mesh.faces) == 2
    assert mesh.warnings == [
        f"line {k}: '{name}' is a property that is not used" for k, (_, name) in enumerate(face, 9)
    ]


def test_attributes_that_a_bare_mesh_does_not_use_are_told(tmp_path: Path) -> None:
    properties = [*rgb("uchar"), ("float", "heat_0")]
    path = ply(tmp_path / "a.ply", properties, (51, 0, 0, 7), face=rgb("uchar"), face_values=(0, 0, 0))
    assert sorted(seen(path)[1]) == ["a.ply: face_color is not used", "a.ply: vertex_heat is not used"]


@pytest.mark.parametrize(
    ("order", "after", "told"),
    [
        ("", b"1 2 3\n", "line 15: text after the last element is not read"),
        ("", b"\n \n", None),
        ("<", b"1234", "4 bytes after the last element are not read"),
    ],
)
def test_what_stands_behind_the_last_element_is_told(
    order: str, after: bytes, told: str | None, tmp_path: Path
) -> None:
    mesh = read_ply(ply(tmp_path / "a.ply", order=order, after=after))
    assert mesh.warnings == ([told] if told else [])


def test_words_that_follow_a_statement_of_the_header_are_told(tmp_path: Path) -> None:
    path = ply(tmp_path / "a.ply")
    path.write_text(path.read_text().replace("property float z", "property float z up"))
    assert read_ply(path).warnings == ["line 6: 'property' has more words than are read"]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_a_mark_change_nothing(end: str, tmp_path: Path) -> None:
    path = ply(tmp_path / "a.ply", rgb("uchar"), (51, 0, 0))
    path.write_bytes(("\ufeff" + path.read_text().replace("\n", end)).encode())
    mesh = read_ply(path)
    assert (len(mesh.faces), mesh.warnings) == (2, [])


def test_a_comment_ends_at_any_line_end(tmp_path: Path) -> None:
    path = ply(tmp_path / "a.ply")
    path.write_bytes(path.read_bytes().replace(b"property float x", b"comment a\rproperty float x"))
    assert read_ply(path).vertices[:, 0].tolist() == [-1, 1, 1, -1]


def picture(path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 255, (8, 8, 3), dtype=np.uint8)
    images.write(path, "png", [images.Layer(("R", "G", "B"), pixels, {})])


UV: Final = ((0, 0), (1, 0), (1, 1), (0, 1))


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("name", ["t.png", "my t.png"])
def test_an_image_that_a_comment_names_is_used(order: str, name: str, tmp_path: Path) -> None:
    picture(tmp_path / name)
    uvs = (8, *(x for uv in UV for x in uv))
    path = ply(
        tmp_path / "a.ply",
        face=[("list uchar float", "texcoord")],
        face_values=(uvs,),
        header=[f"comment TextureFile {name}"],
        order=order,
    )
    reflectance, told = seen(path)
    assert isinstance(reflectance, m.Bitmap)
    assert reflectance.filename == name
    assert told == []
    (tmp_path / "a.mtl").write_text(f"newmtl m\nmap_Kd {name}\n")
    rows = [f"v {x} {y} {z}" for x, y, z in SQUARE] + [f"vt {u} {v}" for u, v in UV]
    (tmp_path / "a.obj").write_text("\n".join(["mtllib a.mtl", *rows, "usemtl m", "f 1/1 2/2 3/3 4/4\n"]))
    by_obj = et.render(et.load(tmp_path / "a.obj").with_(size=(16, 12)), spp=4).image
    assert np.array_equal(et.render(et.load(path).with_(size=(16, 12)), spp=4).image, by_obj)


@pytest.mark.parametrize(
    ("vertex", "header", "told"),
    [
        ((), ["comment TextureFile t.png"], "a.ply:3: the image 't.png' is not used: the mesh has no uvs"),
        (("s", "t"), ["comment TextureFile g.png"], "a.ply:3: the image 'g.png' is left out: no such file"),
        (("s", "t"), ["comment TextureFile t.png"] * 2, "a.ply:4: an image after the first is not used"),
        (("s", "t", *"rgb"), ["comment TextureFile t.png"], "a.ply: vertex_color is not used"),
    ],
)
def test_an_image_that_is_not_used_is_told(
    vertex: Sequence[str], header: Sequence[str], told: str, tmp_path: Path
) -> None:
    picture(tmp_path / "t.png")
    path = ply(tmp_path / "a.ply", [("float", name) for name in vertex], [0.5] * len(vertex), header=header)
    assert seen(path)[1] == [told]


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_vertices_have_one_uv_for_each_that_corners_give_them(order: str, tmp_path: Path) -> None:
    face = [("list uchar float", "texcoord")]
    uvs = (8, 0, 0, 1, 0, 1, 1, 0, 1)
    mesh = read_ply(ply(tmp_path / "a.ply", face=face, face_values=(uvs,), order=order))
    assert mesh.uvs is not None
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]


def wedges(path: Path, second: str) -> MeshData:
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property float s\nproperty float t\nproperty uchar r\nproperty uchar g\nproperty uchar b\nelement face 2\n"
        "property list uchar float texcoord\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 9 9 1 2 3\n1 0 0 9 9 4 5 6\n1 1 0 9 9 7 8 9\n0 1 0 9 9 0 0 0\n"
        f"6 0 0 1 0 1 1 3 0 1 2\n{second} 3 0 2 3\n"
    )
    return read_ply(path)


def test_faces_share_vertices_whose_uvs_are_the_same(tmp_path: Path) -> None:
    mesh = wedges(tmp_path / "a.ply", "6 0 0 0.5 0.5 0 1")
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 3, 4]]
    assert mesh.vertices[[2, 3]].tolist() == [[1, 1, 0], [1, 1, 0]]
    assert mesh.uvs is not None
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0.5, 0.5], [0, 1]]
    assert mesh.attributes["vertex_color"].tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9], [7, 8, 9], [0, 0, 0]]
    assert mesh.warnings == [
        "line 7: 's' is a property that is not used",
        "line 8: 't' is a property that is not used",
    ]


@pytest.mark.parametrize("second", ["0", "4 0 0 1 1", "8 0 0 1 1 0 0 1 1"])
def test_a_face_without_two_numbers_for_each_corner_has_no_uvs(second: str, tmp_path: Path) -> None:
    mesh = wedges(tmp_path / "a.ply", second)
    assert mesh.warnings[-1] == "3 vertices have no usable uv and got (0, 0)"


def test_a_vertex_that_is_not_finite_keeps_its_number_when_corners_have_uvs(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    wedges(path, "6 0 0 0.5 0.5 0 1")
    path.write_text(path.read_text().replace("0 1 0 9 9 0 0 0", "0 nan 0 9 9 0 0 0"))
    with pytest.raises(MeshError, match=r"a\.ply:19: vertex 3 \(counted from 0\) is not finite"):
        read_ply(path)
