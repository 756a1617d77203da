"""An OBJ file by itself: its libraries and images are found, and what they say of materials is seen or told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.images import image_files as images
from equaltime.scene import model as m

SQUARE = b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = b"f 1/1 2/2 3/3 4/4\n"
RED = (0.8, 0.1, 0.1)
ADDED = "the file is only a mesh"


def load(folder: Path, mesh: bytes, **libraries: bytes) -> et.Scene:
    for name, content in libraries.items():
        (folder / f"{name}.mtl").write_bytes(content)
    (folder / "a.obj").write_bytes(mesh)
    return et.load(folder / "a.obj")


def square(folder: Path, library: bytes, *, mesh: bytes = b"") -> et.Scene:
    return load(folder, mesh or b"mtllib a.mtl\n" + SQUARE + b"usemtl m\n" + FACE, a=b"newmtl m\n" + library)


def picture(path: Path) -> Path:
    path.parent.mkdir(exist_ok=True)
    pixels = np.random.default_rng(1).integers(0, 255, (8, 8, 3), dtype=np.uint8)
    images.write(path, "png", [images.Layer(("R", "G", "B"), pixels, {})])
    return path


def shapes(scene: et.Scene) -> list[m.Obj]:
    return [shape for shape in scene.model.shapes if isinstance(shape, m.Obj)]


def reflectances(scene: et.Scene) -> list[Any]:
    bsdfs = [shape.bsdf.bsdf if isinstance(shape.bsdf, m.Mask) else shape.bsdf for shape in shapes(scene)]
    return [bsdf.bsdf[0].reflectance for bsdf in bsdfs if isinstance(bsdf, m.TwoSided)]  # type: ignore[union-attr]


def told(scene: et.Scene) -> list[str]:
    return [warning for warning in scene.warnings if not warning.startswith(ADDED)]


@pytest.mark.parametrize("mark", [b"\xef\xbb\xbf", b""])
@pytest.mark.parametrize(
    "name", [b"M\xf6bel", "Möbel_木".encode(), b"Material_#25", b"Material #25", b"#5", b"a\\", b"m # c"]
)
def test_a_material_is_found_by_the_same_bytes(mark: bytes, name: bytes, tmp_path: Path) -> None:
    library = mark + b"newmtl " + name + b"\nKd 0.8 0.1 0.1\n"
    scene = load(tmp_path, mark + b"mtllib a.mtl\n" + SQUARE + b"usemtl " + name + b"\n" + FACE, a=library)
    assert reflectances(scene) == [RED]
    assert told(scene) == []


def test_names_that_look_alike_in_two_encodings_are_two(tmp_path: Path) -> None:
    latin, utf8 = "Möbel".encode("latin-1"), "Möbel".encode()
    library = b"newmtl " + latin + b"\nKd 1 0 0\nnewmtl " + utf8 + b"\nKd 0 1 0\n"
    parts = b"usemtl " + latin + b"\nf 1 2 3\nusemtl " + utf8 + b"\nf 1 3 4\n"
    scene = load(tmp_path, b"mtllib a.mtl\n" + SQUARE + parts, a=library)
    assert reflectances(scene) == [(1, 0, 0), (0, 1, 0)]
    assert scene.core.triangles == 2


def test_a_material_in_latin_1_can_be_written_to_toml(tmp_path: Path) -> None:
    library = b"newmtl M\xf6bel\nKd 0.8 0.1 0.1\n"
    scene = load(tmp_path, b"mtllib a.mtl\n" + SQUARE + b"usemtl M\xf6bel\nf 1 2 3\nusemtl b\nf 1 3 4\n", a=library)
    et.scene.export.convert(scene.model, scene.assets, tmp_path / "b.toml")
    again = et.load(tmp_path / "b.toml")
    assert [shape.material for shape in shapes(again)] == ["Möbel", "b"]
    assert again.core.triangles == 2


@pytest.mark.parametrize("used", [b'"m"', b"m", b"m #2"])
@pytest.mark.parametrize("defined", [b'"m"', b"m"])
def test_quotes_and_a_number_in_a_comment_do_not_hide_a_material(used: bytes, defined: bytes, tmp_path: Path) -> None:
    library = b"newmtl " + defined + b"\nKd 0.8 0.1 0.1\n"
    scene = load(tmp_path, b"mtllib a.mtl\n" + SQUARE + b"usemtl " + used + b"\n" + FACE, a=library)
    assert reflectances(scene) == [RED]


@pytest.mark.parametrize(
    "statement",
    [
        b"mtllib a.mtl",
        b"mtllib  a.mtl \t",
        b"mtllib b.mtl a.mtl",
        b"mtllib a.mtl b.mtl",
        b"mtllib b.mtl\nmtllib a.mtl",
        b'mtllib "a.mtl"',
        b"mtllib a.mtl # the colours",
        b"MTLLIB .\\a.mtl",
        b'mtllib b.mtl "a.mtl"',
    ],
)
def test_libraries_are_found(statement: bytes, tmp_path: Path) -> None:
    library = b"newmtl m\nKd 0.8 0.1 0.1\n"
    scene = load(tmp_path, statement + b"\n" + SQUARE + b"usemtl m\n" + FACE, a=library, b=b"newmtl z\nKd 0 0 0\n")
    assert reflectances(scene) == [RED]
    assert told(scene) == []


@pytest.mark.parametrize("name", ["my colours.mtl", "a #2.mtl", "a#2.mtl", "my a.mtl b.mtl"])
def test_a_library_whose_name_has_blanks_is_one_file(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("newmtl m\nKd 0.8 0.1 0.1\n")
    scene = load(tmp_path, f"mtllib {name}\n".encode() + SQUARE + b"usemtl m\n" + FACE)
    assert reflectances(scene) == [RED]


def test_a_library_that_is_not_there_is_told_with_its_line(tmp_path: Path) -> None:
    scene = load(
        tmp_path, b"# a\nmtllib gone.mtl a.mtl\n" + SQUARE + b"usemtl m\n" + FACE, a=b"newmtl m\nKd 0.8 0.1 0.1\n"
    )
    assert reflectances(scene) == [RED]
    assert told(scene) == ["a.obj:2: the materials of 'gone.mtl' are left out: No such file or directory"]


def test_materials_that_no_library_has_are_told(tmp_path: Path) -> None:
    parts = b"usemtl a\nf 1 2 3\nusemtl z\nf 1 3 4\n"
    in_none = "a.obj: no library has the materials of the file: they have no colours"
    assert told(load(tmp_path, SQUARE + parts)) == [in_none]
    assert told(load(tmp_path, b"mtllib a.mtl\n" + SQUARE + parts, a=b"# empty\n")) == [in_none]
    assert told(load(tmp_path, b"mtllib\n" + SQUARE + parts)) == ["a.obj:1: 'mtllib' names no file", in_none]
    utf_16 = load(tmp_path, b"mtllib a.mtl\n" + SQUARE + parts, a="newmtl a\n".encode("utf-16"))
    left_out = "the materials of 'a.mtl' are left out: the text is in UTF-16: save it in UTF-8 or ASCII"
    assert told(utf_16) == [f"a.obj:1: {left_out}", in_none]
    missing = told(load(tmp_path, b"mtllib a.mtl\n" + SQUARE + parts, a=b"newmtl z\nKd 1 1 1\n"))
    assert missing == ["a.obj: the material 'a' is in no library: its faces are matt, of reflectance 0.5"]


def test_of_two_definitions_the_last_counts_and_is_told(tmp_path: Path) -> None:
    mesh = b"mtllib a.mtl b.mtl\n" + SQUARE + b"usemtl m\n" + FACE
    scene = load(tmp_path, mesh, a=b"newmtl m\nKd 1 1 1\n", b=b"newmtl m\nKd 0.8 0.1 0.1\n")
    assert reflectances(scene) == [RED]
    assert told(scene) == ["b.mtl:1: the material 'm' is defined in 'a.mtl' too: the last one counts"]


@pytest.mark.parametrize(
    ("name", "statement"),
    [
        ("t.png", b"map_Kd t.png"),
        ("t.png", b"map_kd\tt.png"),
        ("t.png", b"map_Kd t.png # wood"),
        ("t.png", b'map_Kd "t.png"'),
        ("my t.png", b"map_Kd my t.png"),
        ("my t.png", b'map_Kd -s 1 1 1 "my t.png"'),
        ("t #2.png", b"map_Kd t #2.png"),
        ("7.png", b"map_Kd 7.png"),
        ("sub/t.png", b"map_Kd sub\\t.png"),
    ],
)
def test_images_are_found(name: str, statement: bytes, tmp_path: Path) -> None:
    picture(tmp_path / name)
    scene = square(tmp_path, statement + b"\n")
    assert [texture.filename for texture in reflectances(scene)] == [name]
    assert told(scene) == []


def test_an_image_stands_beside_its_library_or_beside_the_mesh(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "a.mtl").write_text("newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n")
    picture(tmp_path / "lib" / "a.png")
    picture(tmp_path / "b.png")
    parts = b"usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n"
    scene = load(tmp_path, b"mtllib lib/a.mtl\n" + SQUARE + parts)
    assert [texture.filename for texture in reflectances(scene)] == ["lib/a.png", "b.png"]


@pytest.mark.parametrize(
    ("options", "scale", "offset"),
    [
        (b"-s 2 2 1", (2, 2), (0, 0)),
        (b"-s 2 3 1 -o 0.25 0.5 0", (2, 3), (0.25, 0.5)),
        (b"-o 0 0.25 0", (1, 1), (0, 0.25)),
    ],
)
def test_scale_and_offset_of_an_image_are_those_of_uvs(
    options: bytes, scale: tuple[float, float], offset: tuple[float, float], tmp_path: Path
) -> None:
    picture(tmp_path / "t.png")
    by_option = square(tmp_path, b"map_Kd " + options + b" t.png\n")
    first = et.render(by_option.with_(size=(32, 24)), spp=4).image
    uvs = "".join(
        f"vt {u * scale[0] + offset[0]} {v * scale[1] + offset[1]}\n" for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))
    )
    mesh = b"mtllib a.mtl\n" + SQUARE[: SQUARE.index(b"vt")] + uvs.encode() + b"usemtl m\n" + FACE
    by_hand = square(tmp_path, b"map_Kd t.png\n", mesh=mesh)
    assert et.render(by_hand.with_(size=(32, 24)), spp=4).image == pytest.approx(first, abs=1e-4)
    assert told(by_option) == []
    plain = et.render(square(tmp_path, b"map_Kd t.png\n").with_(size=(32, 24)), spp=4).image
    assert np.abs(plain - first).max() > 0.01


def test_an_image_may_be_clamped(tmp_path: Path) -> None:
    picture(tmp_path / "t.png")
    (texture,) = reflectances(square(tmp_path, b"map_Kd -clamp on t.png\n"))
    assert texture.wrap_mode == "clamp"


@pytest.mark.parametrize(
    ("library", "message"),
    [
        (b"map_Kd gone.png\n", "a.mtl:2: the image 'gone.png' is left out: no such file"),
        (b"Kd 0.5 0.5 0.5\nmap_Kd t.png\n", "a.mtl:1: 'Kd' is not used beside an image"),
        (b"d 0.5\nmap_d t.png\n", "a.mtl:1: 'd' is not used beside an image"),
        (b"d 0\n", "a.mtl:1: a material is wholly transparent: nothing is seen of it"),
    ],
)
def test_what_is_left_out_of_a_material_is_told(library: bytes, message: str, tmp_path: Path) -> None:
    picture(tmp_path / "t.png")
    assert message in told(square(tmp_path, library))


def test_an_image_without_texture_coordinates_gives_way_to_the_colour(tmp_path: Path) -> None:
    picture(tmp_path / "t.png")
    mesh = b"mtllib a.mtl\n" + SQUARE + b"usemtl m\nf 1 2 3 4\n"
    scene = square(tmp_path, b"Kd 0.8 0.1 0.1\nmap_Kd t.png\n", mesh=mesh)
    assert reflectances(scene) == [RED]
    assert told(scene) == ["a.mtl:3: 'map_Kd' is not used: the faces of the material have no vt"]


@pytest.mark.parametrize("library", [b"d 0.25\n", b"Tr 0.75\n"])
def test_what_is_not_opaque_lets_light_through(library: bytes, tmp_path: Path) -> None:
    (shape,) = shapes(square(tmp_path, b"Kd 0.8 0.1 0.1\n" + library))
    assert isinstance(shape.bsdf, m.Mask)
    assert shape.bsdf.opacity == 0.25
    picture(tmp_path / "t.png")
    (shape,) = shapes(square(tmp_path, b"map_d t.png\n"))
    assert isinstance(shape.bsdf, m.Mask)
    assert isinstance(shape.bsdf.opacity, m.Bitmap)
    assert shape.bsdf.opacity.raw


@pytest.mark.parametrize(
    ("library", "roughness", "metallic"),
    [(b"Pr 0.25\nPm 1\n", 0.25, 1.0), (b"pm 0.5\n", 0.5, 0.5), (b"Pr 1\n", 1.0, 0.0)],
)
def test_roughness_and_metalness_make_a_principled_bsdf(
    library: bytes, roughness: float, metallic: float, tmp_path: Path
) -> None:
    scene = square(tmp_path, b"Kd 0.8 0.1 0.1\n" + library)
    (shape,) = shapes(scene)
    assert isinstance(shape.bsdf, m.TwoSided)
    assert shape.bsdf.bsdf == (m.Principled(base_color=RED, roughness=roughness, metallic=metallic),)
    assert told(scene) == []
    picture(tmp_path / "t.png")
    (shape,) = shapes(square(tmp_path, b"Pr 0.5\nmap_Pr t.png\n"))
    assert isinstance(shape.bsdf, m.TwoSided)
    assert isinstance(shape.bsdf.bsdf[0], m.Principled)
    assert isinstance(shape.bsdf.bsdf[0].roughness, m.Bitmap)
    assert shape.bsdf.bsdf[0].roughness.raw


def test_what_emits_is_seen(tmp_path: Path) -> None:
    scene = square(tmp_path, b"Kd 0 0 0\nKe 4 2 1\n")
    (shape,) = shapes(scene)
    assert shape.emitter is not None
    assert shape.emitter.radiance == (4, 2, 1)
    middle = et.render(scene.with_(size=(32, 24)), spp=4).image[12, 16]
    assert middle == pytest.approx([4, 2, 1], rel=1e-3)
    picture(tmp_path / "t.png")
    (shape,) = shapes(square(tmp_path, b"Ke 1 1 1\nmap_Ke t.png\nd 0.5\n"))
    assert shape.emitter is not None
    assert isinstance(shape.emitter.radiance, m.Bitmap)
    assert et.render(square(tmp_path, b"Ke 1 1 1\nmap_Ke t.png\nd 0.5\n").with_(size=(8, 6)), spp=1).image.max() > 0


def colored(face: bytes, first: bytes = b"0.8 0.1 0.1") -> bytes:
    rows = (b"v -1 -1 0", b"v 1 -1 0", b"v 1 1 0", b"v -1 1 0")
    return b"".join(row + b" " + first + b"\n" for row in rows) + face


def test_colours_of_vertices_are_seen_where_the_material_has_none(tmp_path: Path) -> None:
    scene = load(tmp_path, colored(b"f 1 2 3 4\n"))
    assert reflectances(scene) == [m.MeshAttribute(name="vertex_color")]
    assert told(scene) == []
    of_vertices = et.render(scene.with_(size=(16, 12)), spp=4).image
    plain = load(tmp_path, b"mtllib a.mtl\n" + SQUARE + b"usemtl m\nf 1 2 3 4\n", a=b"newmtl m\nKd 0.8 0.1 0.1\n")
    assert et.render(plain.with_(size=(16, 12)), spp=4).image == pytest.approx(of_vertices, rel=1e-5)


def test_a_colour_of_a_material_comes_before_those_of_vertices(tmp_path: Path) -> None:
    parts = b"usemtl m\nf 1 2 3\nusemtl plain\nf 1 3 4\n"
    scene = load(tmp_path, b"mtllib a.mtl\n" + colored(parts), a=b"newmtl m\nKd 0 1 0\nnewmtl plain\nKs 0 0 0\n")
    assert reflectances(scene) == [(0, 1, 0), m.MeshAttribute(name="vertex_color")]
    assert told(scene) == ["a.obj: vertex_color is not used"]


def test_colours_beyond_1_are_cut_and_told(tmp_path: Path) -> None:
    scene = load(tmp_path, colored(b"f 1 2 3 4\n", b"1.5 0.1 -0.1"))
    assert reflectances(scene) == [m.MeshAttribute(name="vertex_color", cut=True)]
    assert told(scene) == ["a.obj: vertex_color has values outside [0, 1], which are clamped"]
    cut = et.render(scene.with_(size=(16, 12)), spp=4).image
    whole = load(tmp_path, colored(b"f 1 2 3 4\n", b"1 0.1 0"))
    assert np.array_equal(et.render(whole.with_(size=(16, 12)), spp=4).image, cut)


def test_a_library_that_is_no_file_is_told(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    assert told(load(tmp_path, b"mtllib lib\n" + SQUARE + FACE)) == [
        "a.obj:1: the materials of 'lib' are left out: not a regular file"
    ]
