"""Loading scenes from files: the shipped ones, meshes, fingerprints, and changed copies."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equaltime import SceneError
from equaltime.experiments.model.reader import is_experiment
from equaltime.scene import Scene, load, load_dict
from equaltime.scene import model as m
from equaltime.scene.geometry import MeshSurface, QuadSurface, SphereSurface

ROOT = Path(__file__).parents[3]
SCENES = ROOT / "scenes"
OTHERS = ROOT.parent / "shared" / "scenes"
"""Scenes of other people that are not part of the project; tests that want them are skipped without."""

BALL = {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 0.25}}


def scene(**objects: Any) -> Scene:
    return load_dict({"type": "scene", "sensor": {"type": "perspective"}, **objects})


# -- shipped scenes --------------------------------------------------------------------------------------------------


def defines(file: Path) -> dict[str, str]:
    return {"integrator": "path"} if file.suffix == ".xml" else {}


FILES = [*sorted(path for path in SCENES.rglob("*.toml") if not is_experiment(path)), *sorted(SCENES.rglob("*.xml"))]


@pytest.mark.parametrize("file", FILES, ids=str)
def test_every_shipped_scene_loads_builds_and_says_how_many_samples_it_wants(file: Path) -> None:
    loaded = load(file, **defines(file))
    assert loaded.source == file
    assert loaded.core.lights > 0
    if file.parent.name != "hard":  # there shapes call for nothing, or are seen more than once
        assert loaded.core.shapes == len(loaded.model.shapes)
    assert loaded.spp or file.parent.name in ("experiments", "hard")  # there the experiment or the case says it
    assert not loaded.warnings


def test_the_example_of_the_readme_is_a_scene(tmp_path: Path) -> None:
    example = (SCENES / "README.md").read_text().split("```toml\n")[1].split("```")[0]
    (tmp_path / "example.toml").write_text(example)
    loaded = load(tmp_path / "example.toml", width=640)
    assert loaded.size == (640, 240)
    assert loaded.core.lights == 1


@pytest.mark.parametrize("name", ["cornell-box", "veach-mis"])
def test_the_toml_scene_is_the_mitsuba_scene_in_other_words(name: str) -> None:
    ours = load(SCENES / f"{name}.toml")
    theirs = load(SCENES / "mitsuba" / name / "scene.xml", integrator="path", resx=ours.size[0], resy=ours.size[1])
    for mine, other in zip(sorted(map(summary, places(ours))), sorted(map(summary, places(theirs))), strict=True):
        assert np.array(mine) == pytest.approx(np.array(other), abs=2e-4)
    a, b = ours.model.sensor, theirs.model.sensor
    assert np.array(a.to_world) == pytest.approx(np.array(b.to_world), abs=2e-6)
    assert (a.x_fov, a.film.size, a.film.rfilter) == (b.x_fov, b.film.size, b.film.rfilter)
    assert ours.max_depth == theirs.max_depth


def places(loaded: Scene) -> list[MeshSurface | SphereSurface]:
    placed = [it.mesh() if isinstance(it, QuadSurface) else it for it in loaded.surfaces()]
    return [it for it in placed if isinstance(it, MeshSurface | SphereSurface)]


def summary(placed: MeshSurface | SphereSurface) -> list[float]:
    """Where a surface is, what it reflects and what it emits, without the order of its vertices."""
    if isinstance(placed, SphereSurface):
        place = [*placed.center, *placed.center, placed.radius]
    else:
        p = placed.vertices[placed.faces]
        area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
        place = [*placed.vertices.min(axis=0), *placed.vertices.max(axis=0), area]
    bsdf = placed.sides.front
    colors = [*bsdf.reflectance] if isinstance(bsdf, m.Diffuse) else [0.0] * 3
    if isinstance(bsdf, m.RoughConductor):
        colors = [bsdf.alpha + bsdf.eta[0], bsdf.k[0], bsdf.specular_reflectance[0]]
    return [round(float(x), 6) for x in (*place, *colors, *(placed.sides.radiance or (0, 0, 0)))]


@pytest.mark.parametrize("name", ["simple", "complex"])
def test_montelights_camera_is_the_original_one(name: str) -> None:
    loaded = load(SCENES / "montelight" / f"{name}.toml")
    sensor, (width, height) = loaded.model.sensor, loaded.size
    to_world, half = np.array(sensor.to_world), np.tan(np.radians(sensor.x_fov) / 2)
    forward = np.array([0, -0.042612, -1]) / np.linalg.norm([0, -0.042612, -1])
    cx = np.array([0.5135 * width / height, 0, 0])
    cy = np.cross(cx, forward) / np.linalg.norm(np.cross(cx, forward)) * 0.5135
    for x, y in ((0, 0), (width, 0), (30, 200), (width, height)):
        original = cx * (x / width - 0.5) + cy * (y / height - 0.5) + forward  # y counts upwards
        local = [half * (1 - 2 * x / width), half * (2 * y / height - 1) * height / width, 1]  # +x is left in the image
        assert to_world[:3, :3] @ local == pytest.approx(original, abs=1e-12)
    assert to_world[:3, 3].tolist() == [50, 52, 295.6]
    assert (sensor.near_clip, sensor.film.rfilter) == (140.0, m.Tent())


def test_montelights_lamp_can_be_made_small() -> None:
    file = SCENES / "montelight" / "simple.toml"
    assert [load(file, **define).model.shapes[-1].radius for define in ({}, {"light_radius": 1.5})] == [8.5, 1.5]


def test_montelights_red_wall_is_on_the_left_of_the_image() -> None:
    loaded = load(SCENES / "montelight" / "simple.toml")
    left = np.array(loaded.model.sensor.to_world)[:3, 0]  # camera space: +x is left in the image
    origin = np.array([50, 40, 100.0])
    hits = loaded.core.intersect([origin, origin], [left, -left])
    assert [loaded.model.shapes[i].id for i in hits["shape"]] == ["left_wall", "right_wall"]
    assert hits["p"][:, 0] == pytest.approx([1, 99], abs=0.01)


@pytest.mark.skipif(not OTHERS.exists(), reason="the scenes of other people are not here")
@pytest.mark.parametrize("name", ["cornell-box", "veach-mis"])
def test_the_shipped_copies_are_the_originals(name: str) -> None:
    for file in ("scene.xml", "LICENSE.txt"):
        assert (SCENES / "mitsuba" / name / file).read_bytes() == (OTHERS / "mitsuba" / name / file).read_bytes()


@pytest.mark.skipif(not OTHERS.exists(), reason="the scenes of other people are not here")
def test_a_scene_with_many_meshes_loads() -> None:
    loaded = load(OTHERS / "mitsuba" / "veach-bidir" / "scene.xml", integrator="path")
    assert loaded.core.triangles > 10_000


@pytest.mark.skipif(not OTHERS.exists(), reason="the scenes of other people are not here")
@pytest.mark.parametrize("name", ["cornell-box", "staircase2-modern-hall", "veach-bidir", "veach-mis"])
def test_scenes_of_other_people_are_read(name: str) -> None:
    assert load(OTHERS / "mitsuba" / name / "scene.xml", integrator="path").model.shapes


# -- files -----------------------------------------------------------------------------------------------------------


def test_files_are_looked_for_beside_the_scene(tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    file = tmp_path / "scene.toml"
    file.write_text('[sensor]\ntype = "perspective"\n[mesh]\ntype = "obj"\nfilename = "models/m.obj"\n')
    assert load(file).core.triangles == 1


def test_a_scene_file_that_cannot_be_read_is_one_clear_error(tmp_path: Path) -> None:
    for path, problem in (
        (tmp_path / "no.toml", f"{tmp_path}/no.toml: cannot be read: No such file or directory"),
        (
            tmp_path / "no.blend",
            f"{tmp_path}/no.blend: unknown kind of scene file; expected .toml, .xml, .gltf, .glb, .obj or .ply; "
            "export it from Blender as glTF (File > Export > glTF 2.0, .glb)",
        ),
    ):
        with pytest.raises(SceneError) as error:
            load(path)
        assert str(error.value) == problem


PLY = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
PLY += "element face 1\nproperty list uchar int vertex_index\nend_header\n"


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("nan.ply", PLY + "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "vertex 1"),
        ("short.ply", PLY + "0 0 0\n1 0 0\n", "short.ply"),
        ("index.ply", PLY + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "7"),
        ("empty.ply", "", "empty.ply"),
        ("empty.obj", "", "empty.obj"),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "points.obj"),
        ("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "9"),
    ],
)
def test_a_broken_mesh_is_reported_with_its_place_and_path(tmp_path: Path, name: str, text: str, problem: str) -> None:
    (tmp_path / name).write_text(text)
    file = tmp_path / "scene.toml"
    file.write_text(f'[sensor]\ntype = "perspective"\n\n[mesh]\ntype = "{name[-3:]}"\nfilename = "{name}"\n')
    with pytest.raises(SceneError) as error:
        load(file)
    (found,) = error.value.problems
    assert found.place == f"{file}:6: mesh.filename"
    assert str(tmp_path / name) in found.message
    assert problem in found.message


def test_a_file_that_changes_after_loading_is_refused(tmp_path: Path) -> None:
    mesh = tmp_path / "m.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    loaded = scene(it={"type": "obj", "filename": str(mesh)})
    assert loaded.core.triangles == 1
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n")
    with pytest.raises(SceneError, match="has changed since the scene was loaded"):
        _ = loaded.with_(max_depth=3).core


def test_what_the_core_refuses_is_a_scene_error_with_the_place_of_the_shape() -> None:
    vanishing = {"type": "rectangle", "to_world": [{"scale": [1e-60, 1e-60, 1]}]}
    with pytest.raises(SceneError, match=r"^small: a rectangle needs an area"):
        _ = scene(ball=BALL, small=vanishing).core


# -- changed copies --------------------------------------------------------------------------------------------------


def test_another_size_keeps_everything_else() -> None:
    loaded = load(SCENES / "cornell-box.toml")
    other = loaded.with_(size=(32, 16))
    assert (other.size, other.max_depth, other.spp, other.source) == ((32, 16), 30, 64, loaded.source)
    assert other.model.shapes == loaded.model.shapes
    assert other.core.film_shape == (16, 32)
    assert loaded.size == (256, 256)


def test_a_crop_is_a_part_of_the_whole_film() -> None:
    loaded = load(SCENES / "cornell-box.toml").with_(crop=(10, 20, 30, 40))
    assert loaded.size == (256, 256)
    assert loaded.core.film_shape == (40, 30)
    assert loaded.with_(size=(64, 64)).core.film_shape == (64, 64)


def test_another_path_length_makes_a_path_integrator_of_any_other() -> None:
    loaded = scene(integrator={"type": "direct"})
    assert loaded.max_depth == 2
    assert loaded.with_(max_depth=5).max_depth == 5
    assert loaded.with_(max_depth=-1).model.integrator.type == "path"


def test_a_scene_remembers_the_path_length_of_its_file() -> None:
    loaded = load(SCENES / "cornell-box.toml")
    cut = loaded.with_(max_depth=2)
    assert (loaded.own_max_depth, cut.max_depth, cut.own_max_depth) == (30, 2, 30)
    again = cut.with_(size=(8, 8)).with_(max_depth=5).with_(crop=(0, 0, 4, 4))
    assert (again.max_depth, again.own_max_depth) == (5, 30)
    back = again.with_(max_depth=30)
    assert (back.max_depth, back.own_max_depth) == (30, 30)
    assert loaded.with_(size=(8, 8)).own_max_depth == 30
    assert scene(integrator={"type": "direct"}).with_(max_depth=-1).own_max_depth == 2


def test_the_path_length_that_the_file_asks_for_changes_no_fingerprint() -> None:
    deep, cut = (scene(integrator={"type": "path", "max_depth": depth}) for depth in (8, 2))
    assert deep.with_(max_depth=2).digest == cut.digest
    assert deep.with_(max_depth=2).with_(max_depth=8).digest == deep.digest


def test_a_size_or_a_crop_that_is_the_scenes_own_changes_no_digest() -> None:
    """So a render by the command that `info` prints, which names the size, can be merged with the original."""
    loaded = scene()
    width, height = loaded.size
    assert loaded.with_(size=(width, height)).digest == loaded.digest
    assert loaded.with_(crop=(0, 0, width, height)).digest == loaded.digest
    assert loaded.with_(crop=(0, 0, width - 1, height)).digest != loaded.digest
    assert loaded.with_(size=(width + 1, height)).digest != loaded.digest


def test_the_field_of_view_along_y_follows_another_size() -> None:
    loaded = load_dict({"type": "scene", "sensor": {"type": "perspective", "fov": 40, "fov_axis": "y"}})
    assert loaded.with_(size=(10, 10)).model.sensor.x_fov == pytest.approx(40)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"size": (0, 10)}, "width: must be more than 0, found 0"),
        ({"size": (10**9, 10**9)}, "would need 112 EB of memory"),
        ({"crop": (250, 0, 20, 20)}, "the crop window, 20x20 from \\(250, 0\\), does not fit into the film of 256x256"),
        ({"max_depth": -2}, "max_depth: must be at least -1, found -2"),
    ],
)
def test_a_change_that_makes_no_sense_is_a_scene_error(change: dict[str, Any], problem: str) -> None:
    with pytest.raises(SceneError, match=problem):
        load(SCENES / "cornell-box.toml").with_(**change)


# -- fingerprints ----------------------------------------------------------------------------------------------------


def test_a_fingerprint_does_not_depend_on_spelling_names_or_what_cannot_change_the_image() -> None:
    loaded = scene(ball=BALL)
    assert loaded.digest == scene(other={**BALL, "bsdf": "m"}, m=BALL["bsdf"]).digest
    sensor = {"type": "perspective", "sampler": {"type": "stratified", "sample_count": 16}}
    film = {"type": "hdrfilm", "pixel_format": "rgba", "component_format": "float32"}
    assert loaded.digest == scene(ball=BALL, sensor={**sensor, "film": film}).digest
    assert loaded.digest == scene(ball=BALL, integrator={"type": "path", "rr_depth": 9}).digest


@pytest.mark.parametrize(
    "change",
    [
        {"ball": {**BALL, "radius": 1.0000000000000002}},
        {"ball": {**BALL, "bsdf": {"type": "diffuse", "reflectance": 0.2}}},
        {"ball": BALL, "sky": {"type": "constant"}},
        {"ball": BALL, "integrator": {"type": "path", "max_depth": 3}},
        {"ball": BALL, "sensor": {"type": "perspective", "fov": 40}},
        {},
    ],
)
def test_a_fingerprint_depends_on_all_that_can_change_the_image(change: dict[str, Any]) -> None:
    assert scene(**change).digest != scene(ball=BALL).digest


def test_a_fingerprint_depends_on_the_content_of_files_not_on_their_names(tmp_path: Path) -> None:
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    for name, text in (("a", triangle), ("b", triangle), ("c", triangle.replace("1 0 0", "2 0 0"))):
        (tmp_path / f"{name}.obj").write_text(text)
    a, b, c = (scene(it={"type": "obj", "filename": str(tmp_path / f"{name}.obj")}).digest for name in "abc")
    assert a == b != c
    assert len(a) == 64
