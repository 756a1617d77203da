"""The same description means the same to Mitsuba 3; these tests need the extra `peers`."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equaltime.scene import load, load_dict, surfaces
from equaltime.scene.geometry import MeshSurface

mitsuba = pytest.importorskip("mitsuba")
mitsuba.set_variant("scalar_rgb")

SCENES = Path(__file__).parents[3] / "scenes"
MESH = "v -1 -1 0\nv 1 -1 0.5\nv 1 1 0\nv -1 1 0.25\nv 0 0 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 1 3 2\n"
NORMALS = "vn 0 0 1\nvn 1 0 1\nvn 0 1 1\nf 1//1 2//2 5//3\nf 2//2 3//3 5//1\n"


def transform() -> Any:
    made = mitsuba.ScalarTransform4f()
    return made.translate([1, 2, 3]).rotate([1, 2, 3], 40).scale([2, 0.5, -1])


@pytest.mark.parametrize("name", ["cornell-box", "veach-mis"])
def test_rays_meet_the_same_surfaces(name: str) -> None:
    file = SCENES / "mitsuba" / name / "scene.xml"
    ours, theirs = load(file, integrator="path"), mitsuba.load_file(str(file), integrator="path")
    rng = np.random.default_rng(1)
    box = theirs.bbox()
    origins = rng.uniform(np.array(box.min), np.array(box.max), (500, 3))
    directions = rng.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hits = ours.core.intersect(origins, directions)
    for origin, direction, t in zip(origins, directions, hits["t"], strict=True):
        expected = theirs.ray_intersect(mitsuba.Ray3f(origin.tolist(), direction.tolist())).t
        assert t == pytest.approx(expected, rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("face_normals", [False, True])
@pytest.mark.parametrize("text", [MESH, MESH + NORMALS])
def test_meshes_are_placed_and_shaded_alike(tmp_path: Path, text: str, face_normals: bool) -> None:
    (tmp_path / "m.obj").write_text(text)
    shape = {"type": "obj", "filename": str(tmp_path / "m.obj"), "to_world": transform(), "face_normals": face_normals}
    scene = load_dict({"type": "scene", "sensor": {"type": "perspective"}, "it": shape})
    (ours,) = surfaces(scene.model, scene.assets)
    assert isinstance(ours, MeshSurface)
    theirs = mitsuba.traverse(mitsuba.load_dict(shape))
    positions = np.array(theirs["vertex_positions"]).reshape(-1, 3)
    corners = positions[np.array(theirs["faces"]).reshape(-1, 3)]
    assert np.sort(ours.vertices[ours.faces], axis=1) == pytest.approx(np.sort(corners, axis=1), abs=1e-5)
    expected = np.array(theirs["vertex_normals"]).reshape(-1, 3)
    assert (ours.normals is None) == (len(expected) == 0)
    if ours.normals is not None and text == MESH:
        assert ours.normals == pytest.approx(expected, abs=1e-5)


SENSORS: list[dict[str, Any]] = [
    {"fov": 40.0},
    {"fov": 40.0, "fov_axis": "y"},
    {"fov": 40.0, "fov_axis": "diagonal"},
    {"fov": 40.0, "fov_axis": "smaller"},
    {"fov": 40.0, "fov_axis": "larger"},
    {"focal_length": "35mm"},
    {},
]


@pytest.mark.parametrize("parameters", SENSORS)
@pytest.mark.parametrize("size", [(64, 32), (32, 64), (48, 48)])
def test_fields_of_view_agree(parameters: dict[str, Any], size: tuple[int, int]) -> None:
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "crop_width": 10, "crop_height": 20}
    sensor = {"type": "perspective", "film": film, **parameters}
    theirs = mitsuba.traverse(mitsuba.load_dict(sensor))["x_fov"]
    ours = load_dict({"type": "scene", "sensor": sensor}).model.sensor.x_fov
    assert ours == pytest.approx(float(np.array(theirs).item()), rel=1e-6)


def test_look_at_agrees() -> None:
    view = {"origin": [1, 2, 3], "target": [-4, 0.5, 2], "up": [0.1, 1, 0.2]}
    theirs = mitsuba.ScalarTransform4f().look_at(**view)
    for to_world in (theirs, [{"look_at": view}]):
        sensor = load_dict({"type": "scene", "sensor": {"type": "perspective", "to_world": to_world}}).model.sensor
        assert np.array(sensor.to_world) == pytest.approx(np.array(theirs.matrix), abs=1e-6)
