"""Faces of many corners as triangles: concave ones cover what they outline, convex ones are the fans that they were."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from equaltime._core import MeshData, read_obj, read_ply

Points = Sequence[Sequence[float]]
Reals = NDArray[np.float64]

STAR: Points = [
    (math.cos(0.3 + k * math.pi / 5) * (1.0, 0.4)[k % 2], math.sin(0.3 + k * math.pi / 5) * (1.0, 0.4)[k % 2], 0.0)
    for k in range(10)
]
DART: Points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (0, -0.5, 0), (-1, 1, 0)]
NOTCH: Points = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 0.25, 0), (0, 2, 0)]
RING: Points = [  # a square with a square hole: the edge that joins both is passed twice
    *[(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (0, 0, 0)],
    *[(1, 1, 0), (1, 3, 0), (3, 3, 0), (3, 1, 0), (1, 1, 0)],
]
BOW: Points = [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)]


def as_obj(path: Path, *faces: Points) -> MeshData:
    lines = [f"v {x!r} {y!r} {z!r}" for face in faces for x, y, z in face]
    first = 1
    for face in faces:
        lines.append("f " + " ".join(str(first + k) for k in range(len(face))))
        first += len(face)
    path.write_text("\n".join(lines) + "\n")
    return read_obj(path)


def as_ply(path: Path, face: Points) -> MeshData:
    header = ["ply", "format ascii 1.0", f"element vertex {len(face)}", *(f"property double {c}" for c in "xyz")]
    header += ["element face 1", "property list int int vertex_indices", "end_header"]
    rows = [" ".join(map(repr, point)) for point in face]
    path.write_text("\n".join([*header, *rows, " ".join(map(str, (len(face), *range(len(face)))))]) + "\n")
    return read_ply(path)


def vectors(mesh: Any) -> Reals:
    """Return half the cross product of two edges of each triangle (M, 3): its normal, as long as its area."""
    corners = mesh.vertices[mesh.faces]
    return np.asarray(0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def outlined(face: Points) -> Reals:
    """Return the area vector of an outline: the shoelace formula in space."""
    points = np.asarray(face, dtype=np.float64)
    return np.asarray(0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0))


def covers_once(mesh: Any, face: Points) -> bool:
    """Tell whether the triangles together are as large as the outline: a part that is covered twice counts twice."""
    areas = np.linalg.norm(vectors(mesh), axis=1)
    return math.isclose(areas.sum(), np.linalg.norm(outlined(face)), rel_tol=1e-9)


def turned(face: Points, by: int) -> Points:
    return [*face[by:], *face[:by]]


@pytest.mark.parametrize("face", [STAR, DART, NOTCH, RING], ids=["star", "dart", "notch", "ring"])
@pytest.mark.parametrize("read", [as_obj, as_ply])
def test_a_concave_face_covers_its_outline_whichever_corner_is_first(face: Points, read: Any, tmp_path: Path) -> None:
    for by in range(len(face)):
        mesh = read(tmp_path / "a.mesh", turned(face, by))
        assert covers_once(mesh, face)
        assert (vectors(mesh) @ outlined(face) > 0.0).all(), "all look to the side of the face"
        assert mesh.warnings == []


def test_the_area_of_a_fan_would_show() -> None:
    """The fan of the star, as it was once, covers 1.23 times its outline: the test above would reject it."""
    fan = type("Fan", (), {"vertices": np.array(STAR), "faces": np.array([(0, k, k + 1) for k in range(1, 9)])})
    assert not covers_once(fan, STAR)


@pytest.mark.parametrize("corners", [4, 5, 6, 9, 40])
@pytest.mark.parametrize("read", [as_obj, as_ply])
def test_a_convex_face_is_a_fan(corners: int, read: Any, tmp_path: Path) -> None:
    face = [(math.cos(t), math.sin(t), 0.25 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, corners, False)]
    mesh = read(tmp_path / "a.mesh", face)
    assert mesh.faces.tolist() == [[0, k, k + 1] for k in range(1, corners - 1)]


def test_a_corner_on_a_straight_edge_changes_no_fan(tmp_path: Path) -> None:
    """Rounded to digits, it is a little inside or outside."""
    face = [(0, 1.7, 0), (0, 0, 0), (3, 0, 1), (3, 1, 1), (3, 3, 1), (1, 3, 1 / 3), (0, 3, 0)]
    assert as_obj(tmp_path / "a.obj", face).faces.tolist() == [[0, k, k + 1] for k in range(1, 6)]


def test_a_face_that_crosses_itself_stays_a_fan_and_is_told_with_the_others(tmp_path: Path) -> None:
    mesh = as_obj(tmp_path / "a.obj", DART, BOW, BOW)
    told = "line 15: 'f' crosses itself, or has thousands of corners, and stays a fan of triangles (first of 2)"
    assert mesh.warnings == [told]
    assert mesh.faces[-4:].tolist() == [[5, 6, 7], [5, 7, 8], [9, 10, 11], [9, 11, 12]]
    (told,) = as_ply(tmp_path / "a.ply", BOW).warnings
    assert told.startswith("face 0 (counted from 0) crosses itself")


def test_five_points_of_a_star_in_one_line_are_told(tmp_path: Path) -> None:
    """Its outline turns to the left at each corner, twice round."""
    pentagram = [(math.cos(0.8 * math.pi * k), math.sin(0.8 * math.pi * k), 0.0) for k in range(5)]
    assert len(as_obj(tmp_path / "a.obj", pentagram).warnings) == 1


def test_a_comb_of_many_thousand_corners_takes_no_minutes(tmp_path: Path) -> None:
    teeth = 20000
    comb = [*((k, k % 2, 0) for k in range(teeth)), (teeth - 1, -1, 0), (0, -1, 0)]
    mesh = as_obj(tmp_path / "a.obj", comb)
    assert "stays a fan" in mesh.warnings[0]


def test_the_corners_of_a_face_keep_their_uvs(tmp_path: Path) -> None:
    lines = [f"v {x} {y} {z}\nvt {x} {y}" for x, y, z in DART]
    (tmp_path / "a.obj").write_text("\n".join(lines) + "\nf 1/1 2/2 3/3 4/4 5/5\n")
    mesh = read_obj(tmp_path / "a.obj")
    assert mesh.uvs is not None
    assert np.array_equal(mesh.uvs, mesh.vertices[:, :2])


@st.composite
def outlines(draw: st.DrawFn) -> Reals:
    """Draw a face that is seen whole from one point within, in any plane, of any size, anywhere, bent a little."""
    count = draw(st.integers(4, 24))
    angles = (np.arange(count) + np.array(draw(st.lists(st.floats(0.0, 0.8), min_size=count, max_size=count)))) / count
    radii = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=count, max_size=count)))
    flat = radii * np.exp(2j * np.pi * angles)
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    bent = draw(st.sampled_from([0.0, 1e-6])) * random.normal(size=count)
    face = np.column_stack([flat.real, flat.imag, bent]) @ axes + draw(st.sampled_from([0.0, 3.0]))
    return np.asarray(face * 2.0 ** draw(st.integers(-200, 200)))


@settings(max_examples=200, deadline=None)
@given(face=outlines())
def test_any_face_seen_from_within_covers_its_outline(face: Reals, tmp_path_factory: pytest.TempPathFactory) -> None:
    mesh = as_obj(tmp_path_factory.mktemp("face") / "a.obj", face.tolist())
    scale = np.abs(face).max()
    corners = mesh.vertices[mesh.faces] / scale
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert areas.sum() == pytest.approx(np.linalg.norm(outlined((face - face[0]) / scale)), rel=1e-4)
    assert not [told for told in mesh.warnings if "fan" in told]
