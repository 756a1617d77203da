"""What becomes of each mesh file that trimesh collected for being odd: read as it stands, read with a counted warning,
or refused with its place. A cube is 12 triangles, however its file says so.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

from equaltime._core import MeshData, MeshError, read_obj, read_ply

DATA = Path(__file__).parents[1] / "data" / "meshes"

READ: Final[dict[str, tuple[int, int, str, str]]] = {
    # vertices, faces, what it has besides, warnings separated by "; "
    "BoxTextured.ply": (24, 12, "normals uvs", ""),
    "box.obj": (24, 12, "normals uvs", ""),
    "cube.OBJ": (8, 12, "", ""),
    "cube_blender_uv.ply": (24, 12, "normals uvs", ""),
    "cube_blender_uv_meshlab.ply": (24, 12, "uvs", ""),
    "cube_compressed.obj": (24, 12, "normals", ""),
    "jacked.obj": (8, 12, "uvs", ""),
    "joined_tetrahedra.obj": (15, 8, "normals", ""),
    "metadata.ply": (4, 2, "", "line 9: 'face_type' is a property that is not used"),
    "mirror.ply": (143, 286, "", ""),
    "multi.ply": (4, 2, "uvs", ""),
    "nancolor.obj": (8, 12, "", "3 numbers of vertex_color not finite"),
    "negative_indices.obj": (24, 12, "normals uvs", ""),
    "not_convex.obj": (288, 96, "", ""),
    "notenoughindices.obj": (3, 1, "", "1 degenerate face was dropped"),
    "obj_with_no_face_in_chunk.obj": (3, 1, "", ""),
    "plane.ply": (4, 2, "normals uvs", ""),
    "plane_tri.ply": (4, 2, "normals uvs", ""),
    "polygonfaces.obj": (5, 3, "", ""),
    "singlevn.obj": (4, 2, "normals uvs", ""),
    "tet.ply": (4, 4, "", ""),
    "textured_tetrahedron.obj": (6, 4, "normals uvs", ""),
    "two_objects.obj": (12, 16, "", ""),
    "wallhole.obj": (83, 57, "normals uvs", "line 4: 'usemtl' has no name; 9 degenerate faces were dropped"),
}
REFUSED: Final = {
    "cubevt.obj": ":61: vt 24 does not exist: the file has 0",
    "empty.obj": ": the mesh is empty: it has no faces",
    "empty.ply": ": the mesh is empty: the file has no vertices",
    "face_in_group_name.obj": ": the mesh is empty: it has no faces",
    "face_in_group_name_mid_file.obj": ":5: vn 4 does not exist: the file has 0",
    "points_ascii.ply": ": the mesh is empty: the file has no faces",
    "points_ascii_with_lists.ply": ": the mesh is empty: the file has no faces",
    "points_bin.ply": ": the mesh is empty: the file has no faces",
    "points_emptyascii.ply": ": the mesh is empty: the file has no faces",
}


def read(path: Path) -> MeshData:
    return read_ply(path) if path.suffix == ".ply" else read_obj(path)


def test_the_table_holds_every_file() -> None:
    meshes = {path.name for path in DATA.iterdir() if path.suffix.lower() in (".obj", ".ply")}
    assert meshes == READ.keys() | REFUSED.keys()
    assert len(meshes) == 33


@pytest.mark.parametrize("name", READ)
def test_a_mesh_is_read(name: str) -> None:
    vertices, faces, has, warning = READ[name]
    mesh = read(DATA / name)
    assert (len(mesh.vertices), len(mesh.faces)) == (vertices, faces)
    assert (mesh.normals is not None, mesh.uvs is not None) == ("normals" in has, "uvs" in has)
    expected = warning.split("; ") if warning else []
    assert len(mesh.warnings) == len(expected)
    assert all(text in told for text, told in zip(expected, mesh.warnings, strict=True))


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_mesh_is_refused_with_its_place(name: str) -> None:
    with pytest.raises(MeshError) as error:
        read(DATA / name)
    assert str(error.value) == f"{DATA / name}{REFUSED[name]}"
