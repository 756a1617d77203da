"""Mitsuba's serialized meshes: what is read, and that no file makes the reader believe or crash."""

from __future__ import annotations

import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from equaltime import SceneError
from equaltime._core import MeshError
from equaltime.scene import load_dict
from equaltime.scene.serialized import read_serialized

Array = NDArray[np.float64]
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
NORMALS, UVS, COLORS, SINGLE, DOUBLE = 1, 2, 8, 0x1000, 0x2000


def stream(
    flags: int = SINGLE, version: int = 4, vertices: Array = SQUARE, count: int | None = None, faces: int | None = None
) -> bytes:
    """One mesh with its header; counts may lie."""
    real = "<f8" if flags & DOUBLE else "<f4"
    content = struct.pack("<I", flags) + (b"a square\0" if version == 4 else b"")
    content += struct.pack("<QQ", len(vertices) if count is None else count, len(FACES) if faces is None else faces)
    content += vertices.astype(real).tobytes()
    for flag, width in ((NORMALS, 3), (UVS, 2), (COLORS, 3)):
        if flags & flag:
            content += np.tile([0.25, 0.5, 1.0][:width], (len(vertices), 1)).astype(real).tobytes()
    content += FACES.astype("<u4").tobytes()
    return struct.pack("<HH", 0x041C, version) + zlib.compress(content)


def several(*meshes: bytes, version: int = 4) -> bytes:
    """Meshes with the table of where they begin."""
    begins = np.cumsum([0, *(len(mesh) for mesh in meshes)])[:-1]
    table = begins.astype("<u8" if version == 4 else "<u4").tobytes()
    return b"".join(meshes) + table + struct.pack("<I", len(meshes))


@pytest.mark.parametrize("version", [3, 4])
@pytest.mark.parametrize("precision", [SINGLE, DOUBLE, 0])
@pytest.mark.parametrize("extra", [0, NORMALS, UVS, NORMALS | UVS | COLORS])
def test_every_kind_of_mesh_is_read(tmp_path: Path, version: int, precision: int, extra: int) -> None:
    path = tmp_path / "mesh.serialized"
    path.write_bytes(several(stream(precision | extra, version), version=version))
    mesh = read_serialized(path, 0)
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces, FACES)
    assert (mesh.normals is not None, mesh.uvs is not None) == (bool(extra & NORMALS), bool(extra & UVS))
    if mesh.normals is not None:
        np.testing.assert_array_equal(mesh.normals, np.tile([0.25, 0.5, 1.0], (4, 1)))
    assert {name: values.tolist() for name, values in mesh.attributes.items()} == (
        {"vertex_color": [[0.25, 0.5, 1.0]] * 4} if extra & COLORS else {}
    )


@pytest.mark.parametrize("version", [3, 4])
def test_shape_index_says_which_mesh(tmp_path: Path, version: int) -> None:
    path = tmp_path / "mesh.serialized"
    path.write_bytes(several(*(stream(version=version, vertices=SQUARE * k) for k in (1, 2, 3)), version=version))
    for index in range(3):
        np.testing.assert_array_equal(read_serialized(path, index).vertices, SQUARE * (index + 1))
    with pytest.raises(MeshError, match="shape_index 3 does not exist: the file has 3 meshes"):
        read_serialized(path, 3)
    shapes = {f"s{k}": {"type": "serialized", "filename": str(path), "shape_index": k} for k in range(3)}
    scene = load_dict({"type": "scene", "sensor": {"type": "perspective"}, **shapes})
    assert (scene.core.shapes, scene.core.triangles) == (3, 6)


def test_the_only_mesh_of_a_file_needs_no_table(tmp_path: Path) -> None:
    path = tmp_path / "mesh.serialized"
    path.write_bytes(stream())
    assert len(read_serialized(path, 0).faces) == 2


BAD = {
    "": "byte offset 0: no serialized mesh begins here",
    "nothing like it": "byte offset 0: no serialized mesh begins here",
    "version": "byte offset 0: version 5 of the format is unknown; 3 and 4 are read",
    "huge": r"1200000000000 bytes of vertices are declared, more than the file can hold",
    "many faces": "the data end within the triangles",
    "few faces": "a triangle names vertex|the data end within",
    "cut": "the data end within the",
    "damaged": "the compressed data are damaged within the",
    "out of range": "a triangle names vertex 3: the mesh has 3, counted from 0|a triangle names vertex",
    "nameless": "the data end within the name",
}


@pytest.mark.parametrize(
    ("flag", "told"), [(0x10, "flat faces is not used"), (0x44, "the flags 0x44 are unknown and not used")]
)
def test_flags_that_are_not_used_are_told(tmp_path: Path, flag: int, told: str) -> None:
    path = tmp_path / "a.serialized"
    path.write_bytes(stream(SINGLE))
    assert read_serialized(path, 0).warnings == []
    path.write_bytes(stream(SINGLE | flag))
    (warning,) = read_serialized(path, 0).warnings
    assert told in warning


def bad(kind: str) -> bytes:
    good = stream()
    return {
        "": b"",
        "nothing like it": b"ply\n" + good,
        "version": struct.pack("<HH", 0x041C, 5) + good[4:],
        "huge": stream(count=100_000_000_000),
        "many faces": stream(faces=3),
        "few faces": stream(count=5),
        "cut": good[:-20],
        "damaged": good[:20] + bytes([good[20] ^ 255]) + good[21:],
        "out of range": stream(count=3),
        "nameless": good[:4] + zlib.compress(struct.pack("<I", SINGLE) + b"x" * 100),
    }[kind]


@pytest.mark.parametrize("kind", BAD)
def test_a_malformed_file_is_one_error(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "mesh.serialized"
    path.write_bytes(bad(kind))
    with pytest.raises(MeshError, match=BAD[kind]) as error:
        read_serialized(path, 0)
    assert str(error.value).startswith(f"{path}: ")


def test_a_scene_names_the_place_of_a_malformed_file(tmp_path: Path) -> None:
    (tmp_path / "mesh.serialized").write_bytes(b"")
    shape = {"type": "serialized", "filename": str(tmp_path / "mesh.serialized")}
    with pytest.raises(SceneError, match=r"m\.filename: .*no serialized mesh begins here"):
        load_dict({"type": "scene", "sensor": {"type": "perspective"}, "m": shape})


def test_what_a_file_declares_costs_no_memory(tmp_path: Path) -> None:
    """Within what zlib could hold, so that only the missing data show it."""
    path = tmp_path / "mesh.serialized"
    padding = np.random.default_rng(1).bytes(200_000)
    path.write_bytes(stream(count=15_000_000) + padding)
    tracemalloc.start()
    with pytest.raises(MeshError, match="the data end within the vertices"):
        read_serialized(path, 0)
    assert tracemalloc.get_traced_memory()[1] < 8_000_000
    tracemalloc.stop()


@settings(max_examples=150, deadline=None)
@given(at=st.floats(0, 1, exclude_max=True), put=st.binary(max_size=8), cut=st.integers(0, 8), index=st.integers(0, 2))
def test_any_file_is_read_or_refused(
    at: float, put: bytes, cut: int, index: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    content = several(stream(NORMALS | UVS), stream())
    place = int(at * len(content))
    path = tmp_path_factory.getbasetemp() / "any.serialized"
    path.write_bytes(content[:place] + put + content[place + cut :])
    try:
        mesh = read_serialized(path, index)
    except MeshError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.max() < len(mesh.vertices)
