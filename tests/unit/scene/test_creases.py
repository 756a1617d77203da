"""The crease angle of shapes in a scene: which vertices are split, and what becomes of all else that they have."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.geometry import MeshSurface

BOOK = """v 0 1 0
v 1 1 0
v 0 0 1
v 1 0 1
v 0 0 -1
v 1 0 -1
vt 0 0
vt 1 0
vt 0 1
vt 1 1
f 1/1 3/3 4/4 2/2
f 1/1 2/2 6/4 5/3
"""
"""Two pages that meet at 90 degrees along the vertices 1 and 2."""


def placed(path: Path, **fields: Any) -> MeshSurface:
    shape = {"type": path.suffix[1:], "filename": str(path), **fields}
    scene = et.load_dict({"type": "scene", "camera": {"type": "perspective"}, "a": shape})
    (surface,) = scene.surfaces()
    assert isinstance(surface, MeshSurface)
    return surface


def book(folder: Path, text: str = BOOK) -> Path:
    (folder / "book.obj").write_text(text)
    return folder / "book.obj"


def test_a_mesh_without_the_field_is_smooth_as_in_mitsuba(tmp_path: Path) -> None:
    smooth, wide = placed(book(tmp_path)), placed(book(tmp_path), crease_angle=91.0)
    for name in ("vertices", "faces", "normals", "uvs"):
        assert np.array_equal(getattr(smooth, name), getattr(wide, name))


def test_a_hard_edge_splits_its_vertices_with_their_texture_coordinates(tmp_path: Path) -> None:
    smooth, hard = placed(book(tmp_path)), placed(book(tmp_path), crease_angle=89.0)
    assert (len(smooth.vertices), len(hard.vertices)) == (6, 8)
    assert np.array_equal(smooth.vertices[smooth.faces], hard.vertices[hard.faces])
    assert smooth.uvs is not None
    assert hard.uvs is not None
    assert np.array_equal(smooth.uvs[smooth.faces], hard.uvs[hard.faces])
    assert hard.normals is not None
    for face in range(4):
        side = 1.0 if face < 2 else -1.0
        np.testing.assert_allclose(hard.normals[hard.faces[face]], np.tile((0, 0.5**0.5, side * 0.5**0.5), (3, 1)))


def test_a_seam_of_the_texture_is_no_edge(tmp_path: Path) -> None:
    """The second page has other texture coordinates, and so other vertices at the same places."""
    mesh = placed(
        book(tmp_path, BOOK.replace("2 6/4 5/3", "2 6/4 5/3").replace("f 1/1 2/2 6", "f 1/2 2/1 6")), crease_angle=91.0
    )
    assert len(mesh.vertices) == 8
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals[mesh.vertices[:, 1] == 1.0], np.tile((0, 1, 0), (4, 1)), atol=1e-12)


@pytest.mark.parametrize("fields", [{"face_normals": True}, {"face_normals": True, "crease_angle": 40.0}])
def test_flat_faces_need_no_creases(fields: dict[str, Any], tmp_path: Path) -> None:
    mesh = placed(book(tmp_path), **fields)
    assert mesh.normals is None
    assert len(mesh.vertices) == 6


def test_normals_of_a_file_count_more_than_the_crease_angle(tmp_path: Path) -> None:
    text = BOOK.replace("f ", "vn 0 1 0\nf ", 1)
    for old in ("1/1 ", "2/2 ", "3/3 ", "4/4 ", "6/4 ", "2/2\n", "5/3\n"):
        text = text.replace(old, f"{old[:-1]}/1{old[-1]}")
    mesh = placed(book(tmp_path, text), crease_angle=10.0)
    assert mesh.normals is not None
    assert (mesh.normals == (0.0, 1.0, 0.0)).all()


def test_an_edge_of_three_faces_and_faces_wound_against_each_other_are_hard(tmp_path: Path) -> None:
    plain = BOOK.replace("v 0 1 0", "v 0 0 0").replace("v 1 1 0", "v 1 0 0")
    assert len(placed(book(tmp_path, plain), crease_angle=40.0).vertices) == 6
    third = plain.replace("vt 0 0", "v 0 1 0\nv 1 1 0\nvt 0 0") + "f 1/1 2/2 8/4 7/3\n"
    assert len(placed(book(tmp_path, third), crease_angle=180.0).vertices) == 12
    against = plain.replace("f 1/1 2/2 6/4 5/3", "f 5/3 6/4 2/2 1/1")
    assert len(placed(book(tmp_path, against), crease_angle=40.0).vertices) == 8


def test_scenes_without_a_crease_angle_keep_their_digest(tmp_path: Path) -> None:
    digests = []
    for fields in ({}, {"crease_angle": None}, {"crease_angle": 40.0}, {"crease_angle": 91.0}):
        shape = {"type": "obj", "filename": str(book(tmp_path)), **{k: v for k, v in fields.items() if v is not None}}
        scene = et.load_dict({"type": "scene", "camera": {"type": "perspective"}, "a": shape})
        digests.append(scene.digest)
    assert len(set(digests)) == 3


def test_mitsuba_gets_the_normals_in_a_file(tmp_path: Path) -> None:
    """Mitsuba does not know the field, so that XML names a PLY file with the normals, and the colours of faces."""
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 2\nproperty list uchar int vertex_indices\nproperty float r\nproperty float g\n"
    header += "property float b\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 1 0 0\n3 1 0 3 0 0.5 0\n"
    path = tmp_path / "a.ply"
    path.write_text(header)
    shape = {"type": "ply", "filename": str(path), "crease_angle": 40.0}
    scene = et.load_dict({"type": "scene", "camera": {"type": "perspective"}, "a": shape})
    et.scene.export.convert(scene.model, scene.assets, tmp_path / "b.xml")
    assert "crease" not in (tmp_path / "b.xml").read_text().replace("crease-40.ply", "")
    (ours,), (theirs,) = scene.surfaces(), et.load(tmp_path / "b.xml").surfaces()
    assert isinstance(ours, MeshSurface)
    assert isinstance(theirs, MeshSurface)
    for name in ("vertices", "faces", "normals"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=1e-7)
    assert np.array_equal(ours.attributes["face_color"], theirs.attributes["face_color"])
    et.scene.export.convert(scene.model, scene.assets, tmp_path / "b.toml")
    assert "crease_angle = 40.0" in (tmp_path / "b.toml").read_text()


@pytest.mark.parametrize(("angle", "told"), [(181.0, "180"), (-1.0, "0"), ("wide", "number")])
def test_an_angle_that_makes_no_sense_is_refused(angle: object, told: str, tmp_path: Path) -> None:
    with pytest.raises(et.SceneError, match=f"crease_angle.*{told}"):
        placed(book(tmp_path), crease_angle=angle)


def test_a_mesh_that_deforms_has_no_crease_angle(tmp_path: Path) -> None:
    path = book(tmp_path)
    keys = {"animation": [{"time": 0, "filename": str(path)}, {"time": 1, "filename": str(path)}]}
    with pytest.raises(et.SceneError, match="crease_angle would split each pose"):
        placed(path, filename=keys, crease_angle=40.0)
