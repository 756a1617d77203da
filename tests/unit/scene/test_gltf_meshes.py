"""Meshes of glTF files: accessors of every kind, primitive modes and attributes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene.geometry import MeshSurface

from .gltf_files import SQUARE, TRIANGLE, Builder, surfaces

FAN = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
STRIP = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]


def normals_of_faces(surface: MeshSurface) -> NDArray[np.float64]:
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    result: NDArray[np.float64] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return result


@pytest.mark.parametrize("dtype", ["u1", "u2", "u4"])
def test_indices_of_every_type_name_vertices(tmp_path: Path, dtype: str) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(SQUARE))
    builder.json["meshes"][0]["primitives"][0]["indices"] = builder.accessor([0, 1, 2, 2, 3, 0], dtype)
    (surface,) = surfaces(builder, tmp_path)
    assert surface.faces.tolist() == [[0, 1, 2], [2, 3, 0]]


@pytest.mark.parametrize("dtype", ["i2", "f4"])
def test_indices_must_be_unsigned_integers(tmp_path: Path, dtype: str) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh())
    builder.json["meshes"][0]["primitives"][0]["indices"] = builder.accessor([0, 1, 2], dtype)
    with pytest.raises(et.SceneError, match="expected unsigned integers"):
        et.load(builder.glb(tmp_path / "a.glb"))


@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize(
    ("mode", "points", "faces"),
    [
        (4, FAN, [[0, 1, 2]]),
        (5, STRIP, [[0, 1, 2], [1, 3, 2]]),
        (6, FAN, [[1, 2, 0], [2, 3, 0]]),
    ],
)
def test_lists_strips_and_fans_wind_alike(
    tmp_path: Path, mode: int, points: list[list[float]], faces: list[list[int]], indexed: bool
) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(points, indices=range(len(points)) if indexed else None, mode=mode))
    (surface,) = surfaces(builder, tmp_path)
    assert surface.faces.tolist() == faces
    assert np.allclose(normals_of_faces(surface), (0, 0, 1))


def test_indices_that_make_no_triangle_are_counted(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(FAN))
    scene = et.load(builder.glb(tmp_path / "a.glb"))
    assert any("1 of its 4 indices make no triangle" in warning for warning in scene.warnings)


@pytest.mark.parametrize(("mode", "name"), [(0, "points"), (1, "lines"), (2, "line loop"), (3, "line strip")])
def test_points_and_lines_are_told_and_left_out(tmp_path: Path, mode: int, name: str) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh())
    builder.node(mesh=builder.mesh(FAN, mode=mode))
    scene = et.load(builder.glb(tmp_path / "a.glb"))
    assert len(scene.model.shapes) == 1
    assert any(warning.startswith(f"{name} are not drawn (meshes[1].primitives[0]") for warning in scene.warnings)


def test_interleaved_attributes_are_taken_apart(tmp_path: Path) -> None:
    builder = Builder()
    rows = np.array([[*p, 0, 0, 1, *uv] for p, uv in zip(TRIANGLE, ([0, 0], [1, 0], [0, 1]), strict=True)], "<f4")
    view = builder.view(rows.tobytes(), byteStride=32)
    fields: dict[str, Any] = {"bufferView": view, "componentType": 5126, "count": 3}
    position = builder.add("accessors", {**fields, "type": "VEC3"})
    normal = builder.add("accessors", {**fields, "type": "VEC3", "byteOffset": 12})
    uv = builder.add("accessors", {**fields, "type": "VEC2", "byteOffset": 24})
    builder.node(mesh=builder.mesh(POSITION=position, NORMAL=normal, TEXCOORD_0=uv))
    (surface,) = surfaces(builder, tmp_path)
    assert surface.vertices.tolist() == TRIANGLE
    assert surface.normals is not None
    assert surface.normals.tolist() == [[0, 0, 1]] * 3
    assert surface.uvs is not None
    assert surface.uvs.tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize("based", [True, False])
def test_sparse_values_replace_those_of_the_array_or_zeros(tmp_path: Path, based: bool) -> None:
    builder = Builder()
    sparse = {
        "count": 2,
        "indices": {"bufferView": builder.view(np.array([1, 2], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": builder.view(np.array([[5, 0, 0], [0, 5, 0]], "<f4").tobytes())},
    }
    position = builder.accessor(np.array(TRIANGLE) + 1.0, sparse=sparse)
    if not based:
        del builder.json["accessors"][position]["bufferView"]
    builder.node(mesh=builder.mesh(POSITION=position))
    (surface,) = surfaces(builder, tmp_path)
    assert surface.vertices.tolist() == [[1, 1, 1] if based else [0, 0, 0], [5, 0, 0], [0, 5, 0]]


def test_a_sparse_index_beyond_the_array_is_told(tmp_path: Path) -> None:
    builder = Builder()
    sparse = {
        "count": 1,
        "indices": {"bufferView": builder.view(b"\x03"), "componentType": 5121},
        "values": {"bufferView": builder.view(bytes(12))},
    }
    builder.node(mesh=builder.mesh(POSITION=builder.accessor(TRIANGLE, sparse=sparse)))
    with pytest.raises(et.SceneError, match=r"accessors\[0\].sparse.indices: element 3 does not exist"):
        et.load(builder.glb(tmp_path / "a.glb"))


@pytest.mark.parametrize(
    ("dtype", "stored", "expected"),
    [("u1", 255, 1.0), ("u1", 51, 0.2), ("u2", 65535, 1.0), ("i1", -127, -1.0), ("i1", -128, -1.0), ("i2", 32767, 1.0)],
)
def test_normalised_integers_become_fractions(tmp_path: Path, dtype: str, stored: int, expected: float) -> None:
    builder = Builder()
    uv = builder.accessor([[stored, 0]] * 3, dtype, normalized=True)
    builder.node(mesh=builder.mesh(TEXCOORD_0=uv))
    (surface,) = surfaces(builder, tmp_path)
    assert surface.uvs is not None
    assert surface.uvs[0, 0] == pytest.approx(expected, abs=1e-15)


def test_quantized_positions_are_numbers_as_they_are(tmp_path: Path) -> None:
    builder = Builder()
    builder.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    builder.node(mesh=builder.mesh(POSITION=builder.accessor(TRIANGLE, "i2")), scale=[0.5, 0.5, 0.5])
    (surface,) = surfaces(builder, tmp_path)
    assert surface.vertices.tolist() == [[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]]


def test_a_mesh_without_normals_is_flat(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(SQUARE, indices=[0, 1, 2, 2, 3, 0]))
    (surface,) = surfaces(builder, tmp_path)
    assert surface.normals is None


@pytest.mark.parametrize("normals", [False, True])
def test_a_mirrored_mesh_shows_the_same_side(tmp_path: Path, normals: bool) -> None:
    """A negative scale turns the winding over, which the specification undoes."""
    builder = Builder()
    given = {"NORMAL": [[0, 0, 1]] * 4} if normals else {}
    builder.node(mesh=builder.mesh(SQUARE, indices=[0, 1, 2, 2, 3, 0], **given), scale=[-1, 1, 1])
    (surface,) = surfaces(builder, tmp_path)
    assert np.allclose(normals_of_faces(surface), (0, 0, 1))
    assert (surface.normals is not None) == normals


def test_morph_targets_are_added_by_the_weights_of_the_mesh(tmp_path: Path) -> None:
    builder = Builder()
    target = {"POSITION": builder.accessor([[0, 0, 1], [0, 0, 1], [0, 0, 1]])}
    mesh = builder.mesh(targets=[target, target])
    builder.json["meshes"][mesh]["weights"] = [0.5, 0.25]
    builder.node(mesh=mesh)
    (surface,) = surfaces(builder, tmp_path)
    assert surface.vertices[:, 2].tolist() == [0.75] * 3


def test_attributes_of_another_length_are_told(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(NORMAL=[[0, 0, 1]]))
    with pytest.raises(et.SceneError, match=r"attributes.NORMAL: has 1 values for 3 positions"):
        et.load(builder.glb(tmp_path / "a.glb"))


def test_normals_and_texture_coordinates_that_are_no_numbers_are_replaced_and_counted(tmp_path: Path) -> None:
    builder = Builder()
    normals = [[0, 0, 1], [np.nan, 0, 0], [0, 0, 1]]
    builder.node(mesh=builder.mesh(TRIANGLE, NORMAL=normals, TEXCOORD_0=[[0.5, 0.5], [1, 1], [0, np.inf]]))
    (surface,) = surfaces(builder, tmp_path)
    assert surface.normals == pytest.approx(np.array([[0, 0, 1]] * 3))
    assert surface.uvs is not None
    assert np.isfinite(surface.uvs).all()
    told = "\n".join(et.load(tmp_path / "a.glb").warnings)
    assert "1 normals are not finite: those of the faces around are taken" in told
    assert "1 texture coordinates are not finite: (0, 0) is taken" in told
