"""Animations of glTF files, played while a shutter is open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.geometry import MeshSurface
from equaltime.scene.model import Animation, Deformation
from equaltime.scene.motion import at_time, pose

from .gltf_files import Builder, one_triangle

HALF = float(np.sqrt(0.5))


def animated(path: str, times: list[float], values: list[list[float]], kind: str = "LINEAR") -> Builder:
    """Return a triangle in a node at (0, 0, 5), itself inside a node that is animated."""
    builder = one_triangle()
    outer = builder.node(children=[0])
    builder.json["nodes"][0]["translation"] = [0, 0, 5]
    builder.json["scenes"] = [{"nodes": [outer]}]
    time, value = builder.accessor(times), builder.accessor(values)
    channel = {"sampler": 0, "target": {"node": outer, "path": path}}
    sampler = {"input": time, "output": value, "interpolation": kind}
    builder.json["animations"] = [{"name": "spin", "channels": [channel], "samplers": [sampler]}]
    return builder


def placement(builder: Builder, folder: Path, **defines: Any) -> Any:
    return et.load(builder.gltf(folder / "a.gltf"), **defines).model.shapes[0].to_world


def test_without_a_shutter_everything_stands_as_in_the_file(tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    loaded = et.load(builder.gltf(tmp_path / "a.gltf"))
    assert not isinstance(loaded.model.shapes[0].to_world, Animation)
    assert any("-D shutter=0.5,0.52 blurs what moves" in warning for warning in loaded.warnings)


@pytest.mark.parametrize("shutter", [(0.25, 0.75), "0.25,0.75"], ids=["numbers", "as on the command line"])
def test_a_translation_moves_what_is_in_the_node(shutter: Any, tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    moving = placement(builder, tmp_path, shutter=shutter)
    assert moving.times[0] == 0.25
    assert moving.times[-1] == 0.75
    np.testing.assert_allclose(pose(moving, 0.5)[:3, 3], [2, 0, 5])
    sensor = et.load(tmp_path / "a.gltf", shutter=shutter).model.sensor
    assert (sensor.shutter_open, sensor.shutter_close) == (0.25, 0.75)


def test_all_instances_of_a_node_move_with_it(tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    attributes = {"TRANSLATION": builder.accessor([[0, 0, 0], [0, 7, 0]])}
    builder.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    shapes = et.load(builder.gltf(tmp_path / "a.gltf"), shutter=(0, 1)).model.shapes
    placements: list[Any] = [shape.to_world for shape in shapes]
    assert [pose(moving, 0.5)[:3, 3].tolist() for moving in placements] == [[2, 0, 5], [2, 7, 5]]


def test_a_rotation_turns_what_is_in_the_node_along_an_arc(tmp_path: Path) -> None:
    builder = animated("rotation", [0, 1], [[0, 0, 0, 1], [0, HALF, 0, HALF]])
    moving = placement(builder, tmp_path, shutter=(0, 1))
    for time in (0.0, 0.25, 0.4, 1.0):
        angle = 0.5 * np.pi * time
        expected = [5 * np.sin(angle), 0, 5 * np.cos(angle)]
        np.testing.assert_allclose(pose(moving, time)[:3, 3], expected, atol=0.01)


def test_steps_hold_and_splines_bend(tmp_path: Path) -> None:
    stepped = placement(animated("scale", [0, 0.5], [[1, 1, 1], [2, 2, 2]], "STEP"), tmp_path, shutter=(0, 1))
    assert pose(stepped, 0.4999)[0, 0] == pytest.approx(1)
    assert pose(stepped, 0.5001)[0, 0] == pytest.approx(2)
    flat = [[0.0, 0, 0], [1, 0, 0], [0, 0, 0]]
    values = [[0.0, 0, 0], [0, 0, 0], [0, 0, 0], *flat]
    bent = placement(animated("translation", [0, 1], values, "CUBICSPLINE"), tmp_path, shutter=(0, 1))
    assert pose(bent, 0.25)[0, 3] == pytest.approx(3 * 0.25**2 - 2 * 0.25**3, abs=1e-3)


def test_lights_that_move_are_told_to_stand(tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    builder.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    builder.json["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    told = "lights do not move: they stand as when the shutter opens (nodes[0])"
    path = builder.gltf(tmp_path / "a.gltf")
    assert told in et.load(path, shutter=(0, 1)).warnings
    assert told not in et.load(path, time=0.5).warnings


@pytest.mark.parametrize("defines", [{"time": "0.25"}, {"time": 0.25}, {"shutter": (0.25, 0.25)}])
def test_a_still_shows_one_moment(defines: dict[str, Any], tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    loaded = et.load(builder.gltf(tmp_path / "a.gltf"), **defines)
    to_world = loaded.model.shapes[0].to_world
    assert not isinstance(to_world, Animation)
    np.testing.assert_allclose(np.array(to_world)[:3, 3], [1, 0, 5])
    assert not loaded.core.effects()["motion"]
    assert not any("nothing moves" in warning for warning in loaded.warnings)


def test_a_still_bends_meshes_as_they_are_then(tmp_path: Path) -> None:
    loaded = et.load(morphing([0, 1], [0, 0, 1, 1]).gltf(tmp_path / "a.gltf"), time=0.25)
    assert loaded.model.shapes[0].filename == "a.gltf#/animations/0/0.25/nodes/0/primitives/0"
    assert not loaded.core.effects()["motion"]


def test_a_file_without_animations_is_the_same_at_all_times(tmp_path: Path) -> None:
    loaded = et.load(one_triangle().gltf(tmp_path / "a.gltf"), time=3)
    assert "the file has no animations: it is the same at all times" in loaded.warnings


@pytest.mark.parametrize(
    ("defines", "message"),
    [
        ({"time": "late"}, "'time' must be a time in seconds, such as 1.5, found 'late'"),
        ({"time": (1, 2)}, "'time' must be a time in seconds, such as 1.5"),
        ({"time": 1, "shutter": (0, 1)}, "give either 'time', for a still, or 'shutter', for motion blur, not both"),
        ({"shutter": "soon"}, "'shutter' must be two times in seconds, such as 0.5,0.54, found 'soon'"),
        ({"shutter": (1, 0)}, "'shutter' must be two times in seconds"),
        ({"shutter": (0, 1), "animation": "spun"}, "the file has no animation 'spun'; did you mean 'spin'"),
    ],
)
def test_what_is_no_shutter_is_told(defines: dict[str, Any], message: str, tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    with pytest.raises(et.SceneError) as error:
        placement(builder, tmp_path, **defines)
    assert message in str(error.value)


def test_a_choice_that_would_change_nothing_is_refused(tmp_path: Path) -> None:
    still, moving = one_triangle().glb(tmp_path / "a.glb"), animated("scale", [0, 1], [[1, 1, 1], [2, 2, 2]])
    with pytest.raises(et.SceneError, match="the file has no camera 'front'"):
        et.load(still, camera="front")
    with pytest.raises(et.SceneError, match="the file has no animation 'spin'"):
        et.load(still, animation="spin", time=0.5)
    with pytest.raises(et.SceneError, match="'animation' needs a time: add -D time="):
        et.load(moving.gltf(tmp_path / "a.gltf"), animation="spin")


def test_times_that_do_not_increase_are_told(tmp_path: Path) -> None:
    builder = animated("translation", [1, 1], [[0, 0, 0], [4, 0, 0]])
    with pytest.raises(et.SceneError, match=r"channels\[0\]: the times of an animation must be finite and increase"):
        placement(builder, tmp_path, shutter=(0, 1))


def test_what_is_played_of_several_is_told(tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    builder.json["animations"] *= 2
    told = "of 2 animations the first is played; -D animation=... takes another of spin, spin"
    assert told in et.load(builder.gltf(tmp_path / "a.gltf"), time=1).warnings
    assert told not in et.load(tmp_path / "a.gltf", time=1, animation=1).warnings
    builder.json["animations"][0]["channels"] *= 2
    told = "'translation' of a node has several channels: the last is used (animations[0].channels[1])"
    assert told in et.load(builder.gltf(tmp_path / "b.gltf"), time=1).warnings


def test_a_channel_without_times_is_told(tmp_path: Path) -> None:
    builder = animated("translation", [0], [[0, 0, 0]])
    for accessor in builder.json["accessors"][-2:]:
        accessor["count"] = 0
    with pytest.raises(et.SceneError, match=r"animations\[0\].channels\[0\]: needs at least one time"):
        placement(builder, tmp_path, time=0)


def test_rotations_of_four_zeros_are_none_and_told(tmp_path: Path) -> None:
    builder = animated("rotation", [0, 1], [[0, 0, 0, 0], [0, 0, 1, 0]])
    builder.json["nodes"][0]["rotation"] = [0, 0, 0, 0]
    attributes = {"ROTATION": builder.accessor([[0, 0, 0, 0]])}
    builder.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    loaded = et.load(builder.gltf(tmp_path / "a.gltf"), time=0.5)
    turned = np.array(loaded.model.shapes[0].to_world)  # half of a half turn, from none
    np.testing.assert_allclose(turned[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
    (told,) = (warning for warning in loaded.warnings if "counts as none" in warning)
    assert all(place in told for place in ("animations[0].channels[0]", "nodes[0]", "EXT_mesh_gpu_instancing"))


# -- meshes that are bent -------------------------------------------------------------------------------------------


def morphing(times: list[float], weights: list[float], kind: str = "LINEAR", **material: Any) -> Builder:
    """Return a triangle with two morph targets, one up by 1 and one to the side by 2, whose weights are animated."""
    builder = Builder()
    targets = [{"POSITION": builder.accessor([move] * 3)} for move in ([0, 0, 1], [2, 0, 0])]
    more = {"material": builder.add("materials", material)} if material else {}
    mesh = builder.mesh(targets=targets, NORMAL=[[0, 0, 1]] * 3, **more)
    builder.json["meshes"][mesh]["weights"] = [0.25, 0]
    builder.node(mesh=mesh, translation=[0, 0, 5])
    channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    sampler = {"input": builder.accessor(times), "output": builder.accessor(weights), "interpolation": kind}
    builder.json["animations"] = [{"channels": [channel], "samplers": [sampler]}]
    return builder


def first_vertex(loaded: et.Scene, time: float) -> list[float]:
    """Return where the first vertex of the first shape, which was modelled at the origin, is at a time."""
    surface = next(iter(loaded.replaced(at_time(loaded.model, time)).surfaces()))
    assert isinstance(surface, MeshSurface)
    return np.round(surface.vertices[0], 6).tolist()


def test_weights_of_a_node_stand_for_those_of_its_mesh(tmp_path: Path) -> None:
    builder = morphing([0, 1], [0, 0, 1, 1])
    assert first_vertex(et.load(builder.gltf(tmp_path / "a.gltf")), 0) == [0, 0, 5.25]
    builder.json["nodes"][0]["weights"] = [0, 0.5]
    loaded = et.load(builder.gltf(tmp_path / "b.gltf"))
    assert first_vertex(loaded, 0) == [1, 0, 5]
    assert loaded.model.shapes[0].filename == "b.gltf#/nodes/0/primitives/0"


def test_weights_that_are_animated_bend_a_mesh_while_the_shutter_is_open(tmp_path: Path) -> None:
    loaded = et.load(morphing([0, 1], [0, 0, 1, 1]).gltf(tmp_path / "a.gltf"), shutter=(0.25, 0.75))
    filename = loaded.model.shapes[0].filename
    assert isinstance(filename, Deformation)
    assert filename.times == (0.25, 0.75), "straight, so that two poses say all"
    assert filename.filenames[1] == "a.gltf#/animations/0/0.75/nodes/0/primitives/0"
    for time in (0.25, 0.5, 0.6):
        assert first_vertex(loaded, time) == [2 * time, 0, 5 + time]
    assert loaded.core.effects()["motion"]


def test_keys_and_steps_of_weights_within_the_shutter_count(tmp_path: Path) -> None:
    bent = et.load(morphing([0, 0.5, 1], [0, 0, 1, 0, 0, 0]).gltf(tmp_path / "a.gltf"), shutter=(0, 1))
    assert [first_vertex(bent, time)[2] for time in (0, 0.25, 0.5, 0.75)] == [5, 5.5, 6, 5.5]
    stepped = morphing([0, 0.5], [0, 0, 1, 0], "STEP").gltf(tmp_path / "b.gltf")
    assert [first_vertex(et.load(stepped, shutter=(0, 1)), time)[2] for time in (0.4, 0.5)] == [5, 6]
    still = et.load(stepped, shutter=(0.75, 1))
    assert still.model.shapes[0].filename == "b.gltf#/animations/0/0.75/nodes/0/primitives/0"
    assert not still.core.effects()["motion"]


@pytest.mark.parametrize("visible", [True, False])
def test_joints_that_move_bend_the_mesh_of_their_skin(tmp_path: Path, visible: bool) -> None:
    builder = Builder()
    joint = builder.node(rotation=[0, 0, 0, 1], extensions={"KHR_node_visibility": {"visible": visible}})
    builder.json["extensionsUsed"] = ["KHR_node_visibility"]
    builder.add("skins", {"joints": [joint]})
    ends = {"JOINTS_0": builder.accessor([[0, 0, 0, 0]] * 3, "u1"), "WEIGHTS_0": [[1, 0, 0, 0]] * 3}
    builder.node(mesh=builder.mesh([[1, 0, 0], [2, 0, 0], [1, 1, 0]], **ends), skin=0)
    times, turns = builder.accessor([0, 1]), builder.accessor([[0, 0, 0, 1], [0, 0, HALF, HALF]])
    channel = {"sampler": 0, "target": {"node": joint, "path": "rotation"}}
    builder.json["animations"] = [{"channels": [channel], "samplers": [{"input": times, "output": turns}]}]
    loaded = et.load(builder.gltf(tmp_path / "a.gltf"), shutter=(0, 1))
    for time in (0.0, 0.25, 0.5, 1.0):
        angle = 0.5 * np.pi * time
        np.testing.assert_allclose(first_vertex(loaded, time), [np.cos(angle), np.sin(angle), 0], atol=1e-6)
    assert first_vertex(et.load(tmp_path / "a.gltf"), 0) == [1, 0, 0]


def test_what_is_bent_is_the_same_as_toml_and_as_xml_with_files_of_its_own(tmp_path: Path) -> None:
    loaded = et.load(morphing([0, 1], [0, 0, 1, 1]).gltf(tmp_path / "a.gltf"), shutter=(0, 1)).with_(size=(8, 6))
    loaded.write(tmp_path / "a.toml")
    assert et.load(tmp_path / "a.toml").digest == loaded.digest
    _, *files = loaded.write(tmp_path / "a.xml")
    assert len(files) == 2
    image, again = (et.render(scene, spp=4).image for scene in (loaded, et.load(tmp_path / "a.xml")))
    assert image.any()
    assert (again == image).all()


def test_what_glows_keeps_its_form_and_that_is_told(tmp_path: Path) -> None:
    builder = morphing([0, 1], [0, 0, 1, 1], emissiveFactor=[1, 1, 1])
    loaded = et.load(builder.gltf(tmp_path / "a.gltf"), shutter=(0.5, 1))
    assert first_vertex(loaded, 1) == [1, 0, 5.5]
    assert any("emitting meshes do not deform: the first pose is kept" in w for w in loaded.warnings)


def test_a_matrix_stays_where_only_weights_are_animated(tmp_path: Path) -> None:
    builder = morphing([0, 1], [0, 0, 1, 0])
    del builder.json["nodes"][0]["translation"]
    builder.json["nodes"][0]["matrix"] = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 5, 1]
    assert first_vertex(et.load(builder.gltf(tmp_path / "a.gltf"), time=0.5), 0) == [3, 0, 5.5]
    sampler = {"input": builder.accessor([0, 1]), "output": builder.accessor([[0, 0, 0], [0, 8, 0]])}
    builder.json["animations"][0]["samplers"].append(sampler)
    builder.json["animations"][0]["channels"].append({"sampler": 1, "target": {"node": 0, "path": "translation"}})
    moved = et.load(builder.gltf(tmp_path / "a.gltf"), time=0.5)
    assert first_vertex(moved, 0) == [0, 4, 0.5]
    assert "the matrix of a node that an animation moves is not used (nodes[0])" in moved.warnings


def test_weights_that_are_too_few_are_told(tmp_path: Path) -> None:
    file = morphing([0, 1], [0, 0, 1]).gltf(tmp_path / "a.gltf")
    with pytest.raises(et.SceneError, match="expected 4 finite values for 2 times, found 3"):
        et.load(file, shutter=(0, 1))


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("animations/3/0.5/nodes/0/primitives/0", r"animations\[3\]: there is no such animation"),
        ("animations/0/soon/nodes/0/primitives/0", "has no primitive"),
        ("animations/0/1e999/nodes/0/primitives/0", "or no time inf"),
    ],
)
def test_a_pose_that_is_none_is_told(inside: str, message: str, tmp_path: Path) -> None:
    file = morphing([0, 1], [0, 0, 1, 1]).gltf(tmp_path / "a.gltf")
    shape = {"type": "gltf", "filename": f"{file}#/{inside}"}
    with pytest.raises(et.SceneError, match=message):
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "it": shape})


def test_all_frames_of_an_animation_have_one_camera(tmp_path: Path) -> None:
    """The camera that is added has everything in view at every time, also where the mesh goes."""
    path = animated("translation", [0, 1], [[0, 0, 0], [40, 0, 0]]).gltf(tmp_path / "a.gltf")
    cameras = [et.load(path, time=time).model.sensor.to_world for time in (0.0, 0.5, 1.0)]
    assert cameras[0] == cameras[1] == cameras[2]
    away = float(np.linalg.norm(np.array(cameras[0])[:3, 3] - np.array(et.load(path).model.sensor.to_world)[:3, 3]))
    assert away > 20.0
