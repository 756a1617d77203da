"""OBJ: one reader for faces, materials and libraries; what a file says is used, told with its line, or refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from equaltime._core import MeshData, MeshError, obj_name, read_obj, read_obj_by_material

CORNERS = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
Write = Callable[[bytes], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def written(content: bytes) -> Path:
        (tmp_path / "a.obj").write_bytes(content)
        return tmp_path / "a.obj"

    return written


def told(mesh: MeshData) -> list[str]:
    return [warning for warning in mesh.warnings if warning.startswith("line ")]


PARTS = CORNERS + b"f 1 2 3\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 2 3 4\n"


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r", b"\f\n", b"\v\r\n", b" \t\n"])
def test_parts_do_not_depend_on_line_ends(end: bytes, write: Write) -> None:
    parts = read_obj_by_material(write(PARTS.replace(b"\n", end)))
    assert {name: len(mesh.faces) for name, mesh in parts.items()} == {b"": 1, b"a": 2, b"b": 1}
    assert list(parts) == [b"", b"a", b"b"]


@pytest.mark.parametrize("ends", [(b"\n", b"\r"), (b"\r", b"\n"), (b"\r\n", b"\r"), (b"\n", b"\r\n")])
def test_line_ends_may_be_mixed(ends: tuple[bytes, bytes], write: Write) -> None:
    """Joined files have several. A statement behind a comment is lost if the end of the comment is not seen."""
    lines = b"# made by hand\n# in two parts\n".replace(b"\n", ends[0]) + PARTS.replace(b"\n", ends[1])
    parts = read_obj_by_material(write(lines))
    assert {name: len(mesh.faces) for name, mesh in parts.items()} == {b"": 1, b"a": 2, b"b": 1}


def test_a_material_without_a_name_loses_no_face(write: Write) -> None:
    path = write(CORNERS + b"usemtl a\nf 1 2 3\nusemtl\nf 1 3 4\nusemtl \t\nf 2 3 4\n")
    parts = read_obj_by_material(path)
    assert sum(len(mesh.faces) for mesh in parts.values()) == len(read_obj(path).faces) == 3
    assert told(parts[b""]) == ["line 7: 'usemtl' has no name: the faces after it have no material (first of 2)"]


@pytest.mark.parametrize("words", [b"# part C:\\a\\", b"g C:\\a\\", b"o a\\", b"usemtl a\\", b"mtllib c:\\lib\\"])
def test_no_backslash_continues_a_comment_or_a_name(words: bytes, write: Write) -> None:
    mesh = read_obj(write(CORNERS.replace(b"v 1 1", words + b"\nv 1 1") + b"f 1 2 3\n"))
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]


def test_a_backslash_continues_numbers(write: Write) -> None:
    text = b"v 0 0 0\nv 1 \\\n0 0\nv 1 1 0\nf 1 \\\n 2 \\\r\n 3 # the end \\\nv 5 5 5\n\\\nf 1 2 3\\"
    mesh = read_obj(write(text))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 1, 2]]
    assert mesh.warnings == []


@pytest.mark.parametrize("line", [b"\\f 1 2 3", b"\\ f 1 2 3", b"\\  \t"])
def test_a_backslash_that_begins_a_line_is_told(line: bytes, write: Write) -> None:
    assert len(told(read_obj(write(CORNERS + line + b"\nf 1 2 3\n")))) == 1


@pytest.mark.parametrize("text", [b"mtllib a.mtl\n", b"v 9 9 9\n", b"usemtl a\n"])
def test_a_byte_order_mark_is_no_part_of_the_first_word(text: bytes, write: Write) -> None:
    mesh = read_obj(write(b"\xef\xbb\xbf" + text + CORNERS + b"f -4 -3 -2\n"))
    assert mesh.warnings == []
    assert mesh.files == ([(b"a.mtl", 1)] if text.startswith(b"mtllib") else [])


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_is_refused(encoding: str, write: Write) -> None:
    with pytest.raises(MeshError, match=r"a\.obj:1: the text is in UTF-16"):
        read_obj(write(("\ufeff" + PARTS.decode()).encode(encoding)))


@pytest.mark.parametrize(
    ("rest", "name"),
    [
        (b"  dark red \t", b"dark red"),
        (b"M\xf6bel", b"M\xf6bel"),
        ("Möbel".encode(), "Möbel".encode()),
        (b"Material_#25", b"Material_#25"),
        (b"Material #25", b"Material #25"),
        (b"Material #25 # red", b"Material #25"),
        (b"C#", b"C#"),
        (b"#red", b"#red"),
        (b"red # the door", b"red"),
        (b"red #the door", b"red"),
        (b"# nothing", b""),
        (b"#", b""),
        (b"", b""),
        (b"red\\", b"red\\"),
        (b'"red"', b'"red"'),
    ],
)
def test_names_are_bytes_and_a_comment_is_a_word_of_its_own(rest: bytes, name: bytes, write: Write) -> None:
    assert obj_name(rest) == name
    assert list(read_obj_by_material(write(CORNERS + b"usemtl " + rest + b"\nf 1 2 3\n"))) == [name]


def test_libraries_are_named_with_their_lines_as_they_stand(write: Write) -> None:
    path = write(b"mtllib a.mtl b.mtl\n" + CORNERS + b"mtllib my lib.mtl # mine\nMTLLIB\tc.mtl\nf 1 2 3\n")
    files = [(b"a.mtl b.mtl", 1), (b"my lib.mtl # mine", 6), (b"c.mtl", 7)]
    assert read_obj(path).files == files
    assert read_obj_by_material(path)[b""].files == files


def test_words_are_known_in_any_case(write: Write) -> None:
    text = CORNERS.upper() + b"VT 0 0\nVN 0 0 1\nUseMtl a\nF 1/1/1 2/1/1 3/1/1\n"
    assert list(read_obj_by_material(write(text))) == [b"a"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b"l 1 2", "'l' is not rendered: a line has no surface"),
        (b"p 1", "'p' is not rendered: a point has no surface"),
        (b"curv 0 1 1 2", "'curv' is not rendered: curves and surfaces are not read"),
        (b"call other.obj", "'call' is not followed: other files are not read"),
        (b"usemap wood", "'usemap' is not used: images come from materials"),
        (b"blah 1 2", "'blah' is no statement of OBJ that is read"),
        (b"vn 0 0 1 5", "'vn' has more words than are read"),
        (b"vt 0 0 0.5", "'vt' has a third number, which is for solid textures"),
        (b"vt 0 0 0 0", "'vt' has more words than are read"),
        (b"v 0 0 0 0.5", "'v' has a weight, which is for curves and surfaces"),
        (b"v 0 0 0 0.5 0.5", "'v' has more words than are read"),
        (b"v 0 0 0 red", "'v' has more words than are read"),
        (b"#MRGB ffffffff", "'#MRGB' has colours in the way of ZBrush, which are not read"),
    ],
)
def test_what_is_not_used_is_told_in_one_line_with_its_first_place(line: bytes, message: str, write: Write) -> None:
    once = read_obj(write(CORNERS + line + b"\nf 1 2 3\n"))
    assert told(once) == [f"line 5: {message}"]
    thrice = read_obj(write(CORNERS + (line + b"\n") * 3 + b"f 1 2 3\n"))
    assert told(thrice) == [f"line 5: {message} (first of 3)"]


@pytest.mark.parametrize(
    "line", [b"o a", b"g a b", b"s 1", b"lod 1", b"vp 0 1", b"v 0 0 0 1", b"vt 0 0 0", b"# a", b"", b" \t", b"mg 1 2"]
)
def test_what_has_no_meaning_for_the_picture_is_silent(line: bytes, write: Write) -> None:
    assert read_obj(write(CORNERS + line + b"\nf 1 2 3\n")).warnings == []


@pytest.mark.parametrize("groups", [b"s off\n", b"s 0\n", b"s 1\nf 1 2 3\ns 2\n", b"s 1\nf 1 2 3\ns off\n"])
def test_smoothing_that_is_not_done_is_told_where_normals_do_not_decide(groups: bytes, write: Write) -> None:
    assert "'s' is not used" in told(read_obj(write(CORNERS + groups + b"f 1 3 4\n")))[0]
    with_normals = CORNERS + b"vn 0 0 1\n" + groups.replace(b"1 2 3", b"1//1 2//1 3//1") + b"f 1//1 3//1 4//1\n"
    assert told(read_obj(write(with_normals))) == []


def test_a_file_that_is_broken_all_over_is_told_in_few_lines(write: Write) -> None:
    lines = b"".join(b"word%d\n" % k for k in range(1000))
    warnings = read_obj(write(CORNERS + lines + b"f 1 2 3\n")).warnings
    assert len(warnings) == 31
    assert warnings[-1] == "and 970 more statements of other kinds are not used"


def test_colours_of_vertices_are_read(write: Write) -> None:
    mesh = read_obj(write(b"v 9 9 9 1 1 1\nv 0 0 0 0.8 0.1 0\nv 1 0 0 0 1 0 1\nv 1 1 0 0.2 0.3 0.4\nf 2 3 4\n"))
    assert mesh.attributes["vertex_color"].tolist() == [[0.8, 0.1, 0], [0, 1, 0], [0.2, 0.3, 0.4]]
    assert mesh.full == {"vertex_color": 1.0}
    assert mesh.warnings == []


def test_colours_in_whole_numbers_are_bytes_only_where_one_is_more_than_1(write: Write) -> None:
    bright = read_obj(write(b"v 0 0 0 255 0 1\nv 1 0 0 0 51 0\nv 1 1 0 1 1 1\nf 1 2 3\n"))
    assert np.allclose(bright.attributes["vertex_color"] * 255, [[255, 0, 1], [0, 51, 0], [1, 1, 1]])
    assert told(bright) == ["line 1: 'v' has colours in whole numbers to 255, which are divided by it"]
    plain = read_obj(write(b"v 0 0 0 1 0 1\nv 1 0 0 0 1 0\nv 1 1 0 1 1 1\nf 1 2 3\n"))
    assert plain.attributes["vertex_color"].tolist() == [[1, 0, 1], [0, 1, 0], [1, 1, 1]]
    beyond = read_obj(write(b"v 0 0 0 1.5 0 1\nv 1 0 0 0 2 0\nv 1 1 0 1 1 1\nf 1 2 3\n"))
    assert beyond.attributes["vertex_color"].max() == 2.0


def test_a_vertex_without_a_colour_is_grey_where_others_have_one(write: Write) -> None:
    mesh = read_obj(write(b"v 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nf 1 2 3\n"))
    assert mesh.attributes["vertex_color"].tolist() == [[0.5] * 3, [1, 0, 0], [0.5] * 3]
    assert told(mesh) == ["line 1: 'v' has no colour and is grey (first of 2)"]


def test_an_alpha_is_told_unless_it_is_1(write: Write) -> None:
    mesh = read_obj(write(b"v 0 0 0 1 0 0 0.5\nv 1 0 0 1 0 0 1\nv 1 1 0 1 0 0 1\nf 1 2 3\n"))
    assert told(mesh) == ["line 1: 'v' has an alpha, which is not used"]


def test_a_material_without_area_is_told_and_the_others_are_read(write: Write) -> None:
    parts = read_obj_by_material(write(CORNERS + b"usemtl a\nf 1 1 2\nusemtl b\nf 1 2 3\n"))
    assert list(parts) == [b"b"]
    assert told(parts[b"b"]) == ["line 6: 'a' is a material without area: all its faces are degenerate"]
    with pytest.raises(MeshError, match="all its faces are degenerate"):
        read_obj_by_material(write(CORNERS + b"usemtl a\nf 1 1 2\n"))


@pytest.mark.parametrize(
    ("word", "shown"), [("Möbel".encode(), "Möbel"), (b"M\xf6bel", "M\ufffdbel"), (b"a\x01b", "a?b")]
)
def test_words_are_told_in_utf_8_as_far_as_they_are(word: bytes, shown: str, write: Write) -> None:
    assert told(read_obj(write(CORNERS + word + b"\nf 1 2 3\n"))) == [
        f"line 5: '{shown}' is no statement of OBJ that is read"
    ]
