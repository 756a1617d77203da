"""The mesh readers as Python sees them: arrays, errors, files from elsewhere, and files that nobody wrote."""

from __future__ import annotations

import gc
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from equaltime._core import MeshData, MeshError, read_obj, read_ply

DATA = Path(__file__).parents[1] / "data" / "meshes"
SQUARE = np.array([[0.1, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
PLY_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
}


def ply_bytes(
    vertex_type: str, count_type: str, index_type: str, order: str, vertices: NDArray[np.float64] = SQUARE
) -> bytes:
    """A square as one polygon, in any types and byte order that PLY has."""
    endian = {"<": "little", ">": "big"}[order]
    properties = "".join(f"property {vertex_type} {axis}\n" for axis in "xyz")
    header = (
        f"ply\nformat binary_{endian}_endian 1.0\nelement vertex {len(vertices)}\n{properties}"
        f"element face 1\nproperty list {count_type} {index_type} vertex_indices\nend_header\n"
    )
    count = np.array([4]).astype(order + PLY_TYPES[count_type])
    corners = np.arange(4).astype(order + PLY_TYPES[index_type])
    return (
        header.encode()
        + vertices.astype(order + PLY_TYPES[vertex_type]).tobytes()
        + count.tobytes()
        + corners.tobytes()
    )


def read(path: Path) -> MeshData:
    return read_ply(path) if path.suffix == ".ply" else read_obj(path)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("vertex_type", PLY_TYPES)
def test_every_scalar_type_of_ply_is_read(tmp_path: Path, vertex_type: str, order: str) -> None:
    path = tmp_path / "square.ply"
    for integer in [name for name in PLY_TYPES if name not in ("float", "double")]:
        path.write_bytes(ply_bytes(vertex_type, integer, integer, order, np.round(3 * SQUARE)))
        mesh = read_ply(path)
        np.testing.assert_array_equal(mesh.vertices, np.round(3 * SQUARE))
        np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


def test_arrays_have_their_types_cannot_be_written_and_outlive_the_mesh(tmp_path: Path) -> None:
    path = tmp_path / "square.ply"
    path.write_bytes(ply_bytes("double", "uchar", "int", "<"))
    mesh = read_ply(str(path))
    vertices, faces = mesh.vertices, mesh.faces
    assert vertices.dtype == np.float64
    assert faces.dtype == np.uint32
    assert mesh.normals is None
    assert mesh.uvs is None
    assert mesh.warnings == []
    assert not vertices.flags.writeable
    assert not vertices.flags.owndata  # the reader's own buffer, not a copy of it
    del mesh
    gc.collect()
    np.testing.assert_array_equal(vertices, SQUARE)
    np.testing.assert_array_equal(faces, [[0, 1, 2], [0, 2, 3]])


def test_an_error_is_a_value_error_whatever_bytes_the_path_and_the_file_have(tmp_path: Path) -> None:
    path = tmp_path / "m\udcffsh.obj"
    path.write_bytes(b"v 0 0 \xff\xfe\n")
    with pytest.raises(ValueError, match=r"sh\.obj:1: expected a number, found '��'"):
        read_obj(path)


def test_a_huge_declared_count_costs_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "huge.ply"
    path.write_bytes(ply_bytes("float", "int", "int", "<").replace(b"vertex 4\n", b"vertex 4000000000\n"))
    with pytest.raises(
        MeshError, match=r"declares 4000000000 elements 'vertex' of at least 12 bytes, but only \d+ bytes follow"
    ):
        read_ply(path)


def test_other_threads_run_while_a_mesh_is_read(tmp_path: Path) -> None:
    path = tmp_path / "long.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 500_000)
    done, ticks = threading.Event(), 0
    reader = threading.Thread(target=lambda: (read_obj(path), done.set()))
    reader.start()
    while not done.wait(0.001):
        ticks += 1
    reader.join()
    assert ticks >= 3


def test_a_mesh_of_half_a_million_triangles_keeps_every_value(tmp_path: Path) -> None:
    """More than one window of the file, so that records fall across its edge."""
    n = 500
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    vertices = np.stack([x, y, np.sin(9 * x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
    faces = (corner + np.array([0, 1, n, 1, n + 1, n])).reshape(-1, 3)
    header = (
        f"ply\nformat binary_big_endian 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\n"
        f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), dtype=[("count", "u1"), ("corners", ">i4", 3)])
    records["count"], records["corners"] = 3, faces
    (tmp_path / "grid.ply").write_bytes(header.encode() + vertices.astype(">f8").tobytes() + records.tobytes())
    lines = [f"v {a!r} {b!r} {c!r}" for a, b, c in vertices.tolist()] + [
        f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()
    ]
    (tmp_path / "grid.obj").write_text("\n".join(lines))
    mesh = read_ply(tmp_path / "grid.ply")
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, faces)
    mesh = read_obj(tmp_path / "grid.obj")
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], vertices[faces])


@settings(max_examples=300, deadline=None)
@given(
    name=st.sampled_from(sorted(path.name for path in DATA.glob("*.[op]*"))),
    changes=st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.binary(max_size=8), st.integers(0, 8)), max_size=5
    ),
)
def test_any_file_is_read_or_refused(
    name: str, changes: list[tuple[float, bytes, int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    content = (DATA / name).read_bytes()
    for at, put, cut in changes:
        place = int(at * len(content))
        content = content[:place] + put + content[place + cut :]
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(content)
    try:
        mesh = read(path)
    except MeshError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.max() < len(mesh.vertices)
    assert mesh.normals is None or (np.isfinite(mesh.normals).all() and len(mesh.normals) == len(mesh.vertices))
    assert mesh.uvs is None or (np.isfinite(mesh.uvs).all() and len(mesh.uvs) == len(mesh.vertices))
