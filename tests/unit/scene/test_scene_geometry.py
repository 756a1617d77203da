"""Surfaces in world space: where they are and which way they face, as in Mitsuba 3.9.1."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from equaltime.errors import SceneError
from equaltime.scene import load_dict, meshes
from equaltime.scene.geometry import (
    CylinderSurface,
    DiskSurface,
    MeshSurface,
    QuadSurface,
    SphereSurface,
    Surface,
    surface,
)

IDENTITY = np.eye(4)
MIRROR_X, MIRROR_Z = np.diag([-1.0, 1.0, 1.0, 1.0]), np.diag([1.0, 1.0, -1.0, 1.0])
QUAD = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"


def place(**shape: Any) -> Surface:
    scene = load_dict({"type": "scene", "sensor": {"type": "perspective"}, "it": shape})
    return surface(scene.model.shapes[0], scene.assets)


def face_normals(mesh: MeshSurface) -> np.ndarray:
    p = mesh.vertices[mesh.faces]
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def front_z(placed: Surface) -> float:
    """The z of the front side's normal, of a surface in the plane z = 0 or at the top of a solid."""
    if isinstance(placed, MeshSurface):
        top = placed.vertices[placed.faces].mean(axis=1)[:, 2].argmax()
        return round(float(face_normals(placed)[top, 2]), 12)
    if isinstance(placed, QuadSurface):
        return front_z(placed.mesh())
    if isinstance(placed, SphereSurface):
        return -1.0 if placed.flip_normals else 1.0
    normal = np.linalg.inv(placed.to_world[:3, :3])[2]  # the inverse transpose of +z
    return float(-normal[2] if placed.flip_normals else normal[2])


# Measured with Mitsuba 3.9.1: the side that an area light shines from, towards +z or -z.
@pytest.mark.parametrize(
    ("shape", "unmoved", "mirrored_x", "mirrored_z"),
    [
        ("rectangle", 1, 1, -1),
        ("disk", 1, 1, -1),
        ("cube", 1, 1, 1),
        ("sphere", 1, -1, -1),
        ("with normals", 1, 1, -1),
        ("with face normals", 1, -1, 1),
        ("without normals", 1, -1, 1),
    ],
)
@pytest.mark.parametrize("flip", [False, True])
def test_the_front_side_is_mitsubas(
    tmp_path: Path, shape: str, unmoved: int, mirrored_x: int, mirrored_z: int, flip: bool
) -> None:
    (tmp_path / "n.obj").write_text(QUAD + "vn 0 0 1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n")
    (tmp_path / "plain.obj").write_text(QUAD + "f 1 2 3\nf 1 3 4\n")
    description: dict[str, Any] = {"type": shape}
    if "normals" in shape:
        file = tmp_path / ("plain.obj" if "without" in shape else "n.obj")
        description = {"type": "obj", "filename": str(file), "face_normals": "face" in shape}
    for to_world, expected in ((IDENTITY, unmoved), (MIRROR_X, mirrored_x), (MIRROR_Z, mirrored_z)):
        placed = place(**description, to_world=to_world, flip_normals=flip)
        assert front_z(placed) == (-expected if flip else expected), to_world
        if isinstance(placed, MeshSurface) and placed.normals is not None:
            assert placed.normals[0] @ face_normals(placed)[0] == pytest.approx(1.0)


def test_a_cube_has_twelve_triangles_that_face_outwards() -> None:
    cube = place(type="cube", to_world=[{"scale": [1, 2, 3]}, {"rotate": {"axis": [1, 1, 0], "angle": 33}}])
    assert isinstance(cube, MeshSurface)
    assert cube.faces.shape == (12, 3)
    assert cube.normals is None
    centers = cube.vertices[cube.faces].mean(axis=1)
    assert (np.einsum("ij,ij->i", face_normals(cube), centers) > 0).all()
    p = cube.vertices[cube.faces]
    areas = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(8 * (1 * 2 + 2 * 3 + 3 * 1))


def test_a_rectangle_is_two_triangles_of_its_corners() -> None:
    quad = place(type="rectangle", to_world=[{"scale": [2, 3, 1]}, {"translate": [0, 0, 5]}])
    assert isinstance(quad, QuadSurface)
    mesh = quad.mesh()
    assert mesh.vertices.tolist() == [[-2, -3, 5], [2, -3, 5], [2, 3, 5], [-2, 3, 5]]
    assert mesh.sides is quad.sides


def test_a_sphere_is_moved_by_its_transform_after_its_own_center_and_radius() -> None:
    steps = [{"scale": 2}, {"rotate": {"axis": [0, 0, 1], "angle": 90}}, {"translate": [1, 0, 0]}]
    sphere = place(type="sphere", center=[1, 0, 0], radius=3, to_world=steps)
    assert isinstance(sphere, SphereSurface)
    assert sphere.center == pytest.approx([1, 2, 0])
    assert sphere.radius == pytest.approx(6)


def test_a_sphere_is_not_stretched_as_in_mitsuba() -> None:
    steps = [{"scale": [2, 3, 5]}, {"rotate": {"axis": [1, 2, 3], "angle": 50}}, {"translate": [1, 0, 0]}]
    sphere = place(type="sphere", radius=3, to_world=steps)
    assert isinstance(sphere, SphereSurface)
    assert sphere.center == pytest.approx([1, 0, 0])
    assert sphere.radius == pytest.approx(6)
    scene = load_dict({"type": "scene", "sensor": {"type": "perspective"}, "a": {"type": "sphere", "to_world": steps}})
    assert scene.warnings == ("a: a sphere is not stretched, as in Mitsuba: its radius is scaled as along x, to 2",)


@pytest.mark.parametrize(
    "bsdf",
    [
        {"type": "diffuse", "reflectance": {"type": "checkerboard"}},
        {"type": "roughconductor", "alpha_u": 0.1, "alpha_v": 0.2},
        {"type": "twosided", "it": {"type": "principled", "anisotropic": 0.5}},
    ],
)
def test_a_stretched_sphere_that_looks_at_its_azimuth_is_refused(bsdf: dict[str, Any]) -> None:
    with pytest.raises(SceneError, match="to_world of a sphere with textures or anisotropy must scale all directions"):
        place(type="sphere", to_world=[{"scale": [1, 1, 2]}], bsdf=bsdf)


def test_a_cylinder_may_be_stretched_along_its_axis() -> None:
    steps = [{"scale": [2, 5, 2]}, {"rotate": {"axis": [1, 2, 3], "angle": 50}}]
    tube = place(type="cylinder", p0=[0, 0, 0], p1=[0, 3, 0], radius=0.5, to_world=steps)
    assert isinstance(tube, CylinderSurface)
    assert tube.radius == pytest.approx(1)
    assert np.linalg.norm(tube.end - tube.base) == pytest.approx(15)
    with pytest.raises(SceneError, match="to_world of a cylinder must scale all directions across its axis alike"):
        place(type="cylinder", p0=[0, 0, 0], p1=[0.01, 3, 0], to_world=steps)
    with pytest.raises(SceneError, match="to_world of a cylinder must scale all directions across its axis") as error:
        place(type="cylinder", p0=[0, 0, 0], p1=[1, 0, 0], to_world=steps)
    assert "needs a mesh" in str(error.value)


def test_a_disk_keeps_its_transform() -> None:
    disk = place(type="disk", to_world=MIRROR_X, flip_normals=True)
    assert isinstance(disk, DiskSurface)
    assert disk.to_world.tolist() == MIRROR_X.tolist()
    assert disk.flip_normals


# -- meshes ----------------------------------------------------------------------------------------------------------


def test_normals_are_moved_by_the_inverse_transpose(tmp_path: Path) -> None:
    slope = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    (tmp_path / "m.obj").write_text("v 0 0 1\nv 1 0 0\nv 0 1 1\nvn 1 0 1\nf 1//1 2//1 3//1\n")
    mesh = place(type="obj", filename=str(tmp_path / "m.obj"), to_world=np.diag([4.0, 1.0, 1.0, 1.0]))
    assert isinstance(mesh, MeshSurface)
    expected = slope / [4.0, 1.0, 1.0]
    assert mesh.normals == pytest.approx(np.tile(expected / np.linalg.norm(expected), (3, 1)))
    assert face_normals(mesh)[0] == pytest.approx(mesh.normals[0])


def test_a_mesh_without_normals_becomes_smooth_as_in_mitsuba() -> None:
    # Mitsuba 3.9.1's vertex normals of this mesh, the last face of which has no area
    vertices = np.array([[0.2, -0.1, 0.4], [1.1, 0.3, 0.2], [0.4, 1.2, -0.3], [-0.6, 0.8, 0.5], [1.0, 1.3, 0.9]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2], [0, 0, 1]], dtype=np.uint32)
    expected = np.array(
        [
            [0.25452539, 0.42783812, 0.86727810],
            [-0.47346348, 0.11677207, 0.87303871],
            [-0.20492879, 0.15065382, 0.96711296],
            [0.49496958, 0.35168889, 0.79455644],
            [-0.81116730, -0.38763750, 0.43788674],
        ]
    )
    assert meshes.smooth_normals(vertices, faces) == pytest.approx(expected, abs=1e-6)


@given(power=st.integers(-300, 300))
def test_smooth_normals_do_not_depend_on_scale(power: int) -> None:
    vertices = np.array([[0.2, -0.1, 0.4], [1.1, 0.3, 0.2], [0.4, 1.2, -0.3], [-0.6, 0.8, 0.5]])
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    assert (meshes.smooth_normals(vertices * 2.0**power, faces) == meshes.smooth_normals(vertices, faces)).all()


def test_a_vertex_without_area_around_it_gets_some_unit_normal() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]])
    normals = meshes.smooth_normals(vertices, np.array([[0, 1, 2]], dtype=np.uint32))
    assert normals.tolist() == [[1, 0, 0]] * 4


def test_a_normal_without_length_is_replaced_by_a_smooth_one(tmp_path: Path) -> None:
    text = QUAD + "vn 0 0 1\nvn 0 0 0\nf 1//1 2//2 3//1\nf 1//1 3//1 4//2\n"
    (tmp_path / "m.obj").write_text(text)
    for to_world, z in ((IDENTITY, 1.0), (MIRROR_X, 1.0), (MIRROR_Z, -1.0)):
        mesh = place(type="obj", filename=str(tmp_path / "m.obj"), to_world=to_world)
        assert isinstance(mesh, MeshSurface)
        assert mesh.normals is not None
        assert np.abs(mesh.normals - [0, 0, z]).max() == 0.0


def test_a_flipped_mesh_turns_its_faces_and_its_normals(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(QUAD + "f 1 2 3 4\n")
    ways = [place(type="obj", filename=str(tmp_path / "m.obj"), flip_normals=flip) for flip in (False, True)]
    assert all(isinstance(mesh, MeshSurface) and mesh.normals is not None for mesh in ways)
    assert [front_z(mesh) for mesh in ways] == [1, -1]
    assert [mesh.normals[0].tolist() for mesh in ways] == [[0, 0, 1], [0, 0, -1]]


def test_texture_coordinates_of_an_obj_are_turned_upside_down_unless_it_says_otherwise(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0.25\nvt 0 1\nf 1/1 2/2 3/3\n")
    file = str(tmp_path / "m.obj")
    turned, plain = place(type="obj", filename=file), place(type="obj", filename=file, flip_tex_coords=False)
    assert isinstance(turned, MeshSurface)
    assert isinstance(plain, MeshSurface)
    assert plain.uvs.tolist() == [[0, 0.25], [1, 0.25], [0, 1]]
    assert turned.uvs.tolist() == [[0, 0.75], [1, 0.75], [0, 0]]


def test_a_transform_that_takes_vertices_to_infinity_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ValueError, match="to_world takes point 1 to infinity"):
        place(type="obj", filename=str(tmp_path / "m.obj"), to_world=np.diag([1e200, 1e200, 1e200, 1.0]))
