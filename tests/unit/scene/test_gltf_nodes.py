"""Nodes of glTF files: where they put meshes, and skins that their joints carry."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene import model as m

from .gltf_files import TRIANGLE, Builder, surfaces

# -- skins ------------------------------------------------------------------------------------------------------------


def skinned(joints: list[list[int]], weights: list[list[float]]) -> Builder:
    """Return a triangle with a skin of two joints: one turned by 90 degrees about z, one moved up by ten."""
    builder = Builder()
    half = math.sqrt(0.5)
    builder.node(rotation=[0, 0, half, half])
    builder.node(translation=[0, 10, 0])
    bind = np.eye(4)
    bind[3, 0] = -1.0  # columns: both joints were modelled at (1, 0, 0)
    matrices = builder.accessor([bind.ravel()] * 2, type="MAT4")
    builder.add("skins", {"joints": [0, 1], "inverseBindMatrices": matrices})
    mesh = builder.mesh(JOINTS_0=builder.accessor(joints, "u1"), WEIGHTS_0=weights, NORMAL=[[1, 0, 0]] * 3)
    builder.node(mesh=mesh, skin=0, translation=[100, 100, 100])  # which does not count
    return builder


def test_joints_carry_the_vertices_of_a_skin(tmp_path: Path) -> None:
    builder = skinned([[0, 1, 0, 0]] * 3, [[1, 0, 0, 0], [0, 1, 0, 0], [0.5, 0.5, 0, 0]])
    (surface,) = surfaces(builder, tmp_path)
    # (0, 0, 0) is (-1, 0, 0) for its joint; (1, 0, 0) its origin; (0, 1, 0) is (-1, 1, 0) for both
    assert np.allclose(surface.vertices, [[0, -1, 0], [0, 10, 0], [(-1 - 1) / 2, (-1 + 11) / 2, 0]])
    assert surface.normals is not None
    assert np.allclose(surface.normals[:2], [[0, 1, 0], [1, 0, 0]])


def test_weights_count_relative_to_their_sum(tmp_path: Path) -> None:
    builder = skinned([[0, 1, 0, 0]] * 3, [[0, 0.5, 0, 0]] * 3)
    (surface,) = surfaces(builder, tmp_path)
    assert np.allclose(surface.vertices, np.array(TRIANGLE) + np.array([-1, 10, 0]))


@pytest.mark.parametrize("weight", [0, math.nan, math.inf, -1])
def test_vertices_without_weights_go_with_their_first_joint_which_is_told(tmp_path: Path, weight: float) -> None:
    builder = skinned([[1, 0, 0, 0]] * 3, [[weight, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]])
    (surface,) = surfaces(builder, tmp_path)
    assert np.allclose(surface.vertices, np.array(TRIANGLE) + np.array([-1, 10, 0]))
    told = "nodes[2]: 2 vertices have no weights of joints: their first joint carries them"
    assert any(told in warning for warning in et.load(tmp_path / "a.glb").warnings)


def test_a_joint_that_does_not_exist_is_told(tmp_path: Path) -> None:
    with pytest.raises(et.SceneError, match=r"nodes\[2\].skin: a vertex names joint 2, but there are 2"):
        et.load(skinned([[2, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3).glb(tmp_path / "a.glb"))


def test_a_skin_needs_joints_and_weights(tmp_path: Path) -> None:
    builder = skinned([[0, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3)
    del builder.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"]
    with pytest.raises(et.SceneError, match="JOINTS_0 without WEIGHTS_0"):
        et.load(builder.glb(tmp_path / "a.glb"))


# -- nodes ----------------------------------------------------------------------------------------------------------


def world(builder: Builder, folder: Path) -> list[list[float]]:
    """Return where the point (1, 2, 3) of each mesh stands, rounded."""
    return [np.round(surface.vertices[0], 9).tolist() for surface in surfaces(builder, folder)]


def point(builder: Builder) -> int:
    return builder.mesh([[1, 2, 3], [2, 2, 3], [1, 3, 3]])


def test_translation_rotation_and_scale_apply_in_reverse(tmp_path: Path) -> None:
    builder = Builder()
    half = math.sqrt(0.5)
    builder.node(mesh=point(builder), translation=[10, 0, 0], rotation=[0, 0, half, half], scale=[2, 3, 4])
    assert world(builder, tmp_path) == [[10 - 6, 2, 12]]


def test_a_matrix_is_stored_by_columns(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=point(builder), matrix=[0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1])
    assert world(builder, tmp_path) == [[8, 21, 33]]


def test_children_stand_in_the_space_of_their_parents(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    child = builder.node(mesh=mesh, translation=[1, 0, 0])
    middle = builder.node(children=[child], scale=[2, 2, 2])
    builder.node(children=[middle], translation=[0, 100, 0])
    assert world(builder, tmp_path) == [[4, 104, 6]]


def test_a_chain_of_thousands_of_nodes_is_no_recursion(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=point(builder), translation=[1, 0, 0])
    for i in range(2_000):
        builder.node(children=[i], translation=[1, 0, 0])
    assert world(builder, tmp_path) == [[2_002, 2, 3]]


def test_the_scene_says_which_nodes_are_there(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    builder.node(mesh=mesh)
    builder.node(mesh=mesh, translation=[1, 0, 0])
    builder.json |= {"scenes": [{"nodes": [0]}, {"nodes": [1], "name": "second"}], "scene": 1}
    assert world(builder, tmp_path) == [[2, 2, 3]]
    path = tmp_path / "a.glb"
    assert [s.to_world[0][3] for s in et.load(path, scene="0").model.shapes] == [0]
    assert [s.to_world[0][3] for s in et.load(path, scene="second").model.shapes] == [1]
    with pytest.raises(et.SceneError, match="the file has no scene 'third'"):
        et.load(path, scene="third")


def test_what_is_not_visible_is_left_out_with_its_children(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    hidden = {"KHR_node_visibility": {"visible": False}}
    builder.node(mesh=mesh, translation=[1, 0, 0])
    builder.node(mesh=mesh, children=[0], extensions=hidden)
    builder.node(mesh=mesh, translation=[5, 0, 0], extensions={"KHR_node_visibility": {"visible": True}})
    builder.json["extensionsUsed"] = ["KHR_node_visibility"]
    assert world(builder, tmp_path) == [[6, 2, 3]]


def test_children_that_a_scene_lists_too_are_there_once(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    builder.json["nodes"] = [{"translation": [1, 0, 0], "children": [1]}, {"children": [2]}, {"mesh": mesh}]
    builder.json["scenes"] = [{"nodes": [2, 0, 1]}]
    assert world(builder, tmp_path) == [[2, 2, 3]]
    scene = et.load(builder.glb(tmp_path / "a.glb"))
    assert any("children of others" in warning and "scenes[0].nodes" in warning for warning in scene.warnings)


def test_joints_that_are_hidden_carry_all_the_same(tmp_path: Path) -> None:
    builder = skinned([[0, 1, 0, 0]] * 3, [[0, 1, 0, 0]] * 3)
    (seen,) = surfaces(builder, tmp_path)
    for joint in builder.json["nodes"][:2]:
        joint["extensions"] = {"KHR_node_visibility": {"visible": False}}
    builder.json["extensionsUsed"] = ["KHR_node_visibility"]
    (surface,) = surfaces(builder, tmp_path)
    assert np.array_equal(surface.vertices, seen.vertices)


def test_nodes_with_two_parents_and_rings_are_refused(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    builder.json["nodes"] = [{"mesh": mesh, "children": [1]}, {"children": [0]}]
    builder.json["scenes"] = [{"nodes": [0]}]
    ring = r"nodes\[0\]: the node is, or hangs below, its own descendant"
    for scenes in ([{"nodes": [0]}], [{"nodes": [0, 1]}], []):
        builder.json["scenes"] = scenes
        with pytest.raises(et.SceneError, match=ring):
            et.load(builder.glb(tmp_path / "a.glb"))
    builder.json["nodes"] = [{"children": [1, 2]}, {"children": [0]}, {"mesh": mesh}]
    builder.json["scenes"] = [{"nodes": [2]}]
    with pytest.raises(et.SceneError, match=ring):
        et.load(builder.glb(tmp_path / "a.glb"))
    builder.json["nodes"] = [{"mesh": mesh}, {"children": [0]}]
    builder.json["scenes"] = [{"nodes": [0]}]
    with pytest.raises(et.SceneError, match=r"scenes\[0\].nodes: node 0 is no root: it is a child of node 1"):
        et.load(builder.glb(tmp_path / "a.glb"))
    builder.json["nodes"] = [{"mesh": mesh}, {"children": [0]}, {"children": [0]}]
    with pytest.raises(et.SceneError, match=r"nodes\[2\].children: node 0 already has a parent, node 1"):
        et.load(builder.glb(tmp_path / "a.glb"))


def test_what_is_scaled_to_nothing_is_left_out(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    builder.node(mesh=mesh)
    builder.node(mesh=mesh, scale=[0, 0, 0])
    builder.node(mesh=mesh, scale=[1, 0, 0])
    scene = et.load(builder.glb(tmp_path / "a.glb"))
    assert len(scene.model.shapes) == 1
    assert any("scaled to nothing" in warning and "nodes[1], nodes[2]" in warning for warning in scene.warnings)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_what_is_scaled_to_nothing_along_one_axis_is_flat_and_seen(tmp_path: Path, axis: int, sign: int) -> None:
    """It looks like a thing that is scaled to nearly nothing."""
    half = math.sqrt(0.5)
    transforms: list[list[list[float]]] = []
    for least in (0.0, 2e-8):
        scale = [2.0, 2.0, 2.0]
        scale[axis], scale[axis - 1] = least, 2.0 * sign
        builder = Builder()
        mesh = point(builder)
        turned = builder.node(mesh=mesh, rotation=[half, 0, 0, half])
        builder.node(mesh=mesh, scale=scale)
        builder.node(children=[turned], scale=scale)
        scene = et.load(builder.glb(tmp_path / "a.glb"))
        assert not [warning for warning in scene.warnings if "scaled" in warning]
        transforms.append([shape.to_world for shape in scene.model.shapes])
    assert np.allclose(transforms[0], transforms[1], rtol=1e-12, atol=0.0)
    assert (np.linalg.det(np.array(transforms[0])) * sign > 0.0).all()


def test_a_matrix_that_flattens_along_one_axis_is_seen(tmp_path: Path) -> None:
    builder = Builder()
    mesh = point(builder)
    for axis in range(3):
        matrix = np.eye(4) * 3.0
        matrix[3, 3], matrix[axis] = 1.0, 0.0
        builder.node(mesh=mesh, matrix=matrix.ravel().tolist())
    found = np.array([shape.to_world for shape in et.load(builder.glb(tmp_path / "a.glb")).model.shapes])
    assert np.allclose(np.linalg.det(found), 27e-8)


def test_instances_stand_in_the_space_of_their_node(tmp_path: Path) -> None:
    builder = Builder()
    attributes = {
        "TRANSLATION": builder.accessor([[0, 0, 0], [5, 0, 0]]),
        "SCALE": builder.accessor([[1, 1, 1], [2, 2, 2]]),
    }
    extension = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    builder.node(mesh=point(builder), translation=[0, 0, 100], extensions=extension)
    assert world(builder, tmp_path) == [[1, 2, 103], [7, 4, 106]]


def test_instances_of_unequal_counts_are_told(tmp_path: Path) -> None:
    builder = Builder()
    attributes = {"TRANSLATION": builder.accessor([[0, 0, 0]]), "SCALE": builder.accessor([[1, 1, 1], [2, 2, 2]])}
    builder.node(mesh=point(builder), extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    with pytest.raises(et.SceneError, match=r"nodes\[0\].extensions.EXT_mesh_gpu_instancing: expected .* 1 and 2"):
        et.load(builder.glb(tmp_path / "a.glb"))


def crowd(builder: Builder, mesh: int, count: int) -> Builder:
    """Let a mesh stand `count` times in a row, every second one mirrored."""
    for i in range(count):
        builder.node(mesh=mesh, translation=[3 * i, 0, 0], scale=[1 if i % 2 else -1, 1, 1])
    return builder


def test_many_copies_of_much_are_instances_of_a_group(tmp_path: Path) -> None:
    builder = Builder()
    mesh = builder.mesh(np.tile(TRIANGLE, (20_000, 1)), NORMAL=[[0, 0, 1]] * 60_000)
    scene = et.load(crowd(builder, mesh, 3).glb(tmp_path / "a.glb"))
    first, *others = scene.model.shapes
    assert isinstance(first, m.Instance)
    assert all(isinstance(shape, m.Instance) and shape.shapegroup is first.shapegroup for shape in others)
    (member,) = first.shapegroup.shapes
    assert isinstance(member, m.Gltf)
    assert [shape.to_world[0][:1] + shape.to_world[0][3:] for shape in scene.model.shapes] == [(-1, 0), (1, 3), (-1, 6)]


@pytest.mark.parametrize("material", [{}, {"emissiveFactor": [1, 1, 1]}])
def test_few_copies_and_those_that_shine_are_shapes_of_their_own(tmp_path: Path, material: dict[str, Any]) -> None:
    builder = Builder()
    points = np.tile(TRIANGLE, (20_000, 1)) if material else TRIANGLE
    mesh = builder.mesh(points, material=builder.add("materials", material))
    scene = et.load(crowd(builder, mesh, 3).glb(tmp_path / "a.glb"))
    assert all(isinstance(shape, m.Gltf) for shape in scene.model.shapes)
