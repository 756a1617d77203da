"""A mesh file as a scene: its materials become diffuse, and what it lacks is added and told."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.cli import main
from equaltime.images import image_files as images
from equaltime.scene import model as m
from equaltime.scene import studio
from equaltime.scene.geometry import MeshSurface

SQUARES = """mtllib a.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
vt 0 0
f 1/1 2/1 3/1
usemtl dark red
f 1/1 3/1 4/1
usemtl wood
usemtl dark red
f 5/1 6/1 7/1
usemtl lost
f 1/1 2/1 7/1
"""
MATERIALS = """# a library
newmtl dark red
Kd 0.5 0.1 2
Ks 1 1 1
newmtl wood
Kd 0.2 0.3 0.4
map_Kd wood.png
newmtl grey
Kd 0.25
"""


def written(folder: Path, mesh: str = SQUARES, materials: str | None = MATERIALS) -> Path:
    (folder / "a.obj").write_text(mesh)
    if materials is not None:
        (folder / "a.mtl").write_text(materials)
    return folder / "a.obj"


def reflectances(scene: et.Scene) -> list[Any]:
    shapes = [shape for shape in scene.model.shapes if isinstance(shape, m.Obj | m.Ply)]
    return [shape.bsdf.bsdf[0].reflectance for shape in shapes if isinstance(shape.bsdf, m.TwoSided)]


def test_a_material_says_which_faces_are_read(tmp_path: Path) -> None:
    path = written(tmp_path)
    assert [len(_core.read_obj(path, name).faces) for name in (None, "", "dark red", "lost")] == [4, 1, 2, 1]
    with pytest.raises(_core.MeshError, match="it has no faces"):
        _core.read_obj(path, "wood")


def test_each_material_with_faces_is_a_shape_of_its_colour(tmp_path: Path) -> None:
    scene = et.load(written(tmp_path))
    assert [shape.material for shape in scene.model.shapes if isinstance(shape, m.Obj)] == ["", "dark red", "lost"]
    grey = (0.5, 0.5, 0.5)
    assert reflectances(scene) == [grey, (0.5, 0.1, 1.0), grey]
    assert scene.core.triangles == 4  # the ground is a disk, the sun a sphere
    assert scene.warnings == (
        "a.mtl:3: 'Kd' is cut to [0, 1]",
        "a.mtl:4: 'Ks' is not used: gloss comes from Pr and Pm alone",
        "a.obj: the material 'lost' is in no library: its faces are matt, of reflectance 0.5",
        "the file is only a mesh: a camera, a sky, a sun and a ground are added; -D view=back shows its back, -D up=z "
        "if it lies on its back; also -D sky=, sun=, sun_angle=, ground=",
    )


@pytest.mark.parametrize("options", ["", "-s 2 2 1 -o 0.5 0 ", "-clamp on -bm 1 "])
def test_an_image_is_a_bitmap_whatever_options_it_has(options: str, tmp_path: Path) -> None:
    images.write(tmp_path / "oak.png", "png", [images.Layer(("R", "G", "B"), np.zeros((2, 2, 3), np.uint8), {})])
    path = written(tmp_path, SQUARES.replace("dark red", "wood"), MATERIALS.replace("wood.png", f"{options}oak.png"))
    assert [getattr(r, "filename", None) for r in reflectances(et.load(path))] == [None, "oak.png", None]


def test_without_a_library_all_is_grey(tmp_path: Path) -> None:
    scene = et.load(written(tmp_path, materials=None))
    assert reflectances(scene) == [(0.5, 0.5, 0.5)]
    assert "a.obj:1: the materials of 'a.mtl' are left out: No such file or directory" in scene.warnings


def test_an_obj_within_a_scene_has_the_materials_of_the_scene(tmp_path: Path) -> None:
    """As in Mitsuba, whose default is a diffuse grey."""
    mesh = {"type": "obj", "filename": str(written(tmp_path))}
    (shape,) = et.load_dict({"type": "scene", "camera": {"type": "perspective"}, "a": mesh}).model.shapes
    assert isinstance(shape, m.Obj)
    assert shape.bsdf is None


@pytest.mark.parametrize(
    ("kind", "values", "scale"), [("float", (0.5, 0.25, 0), 1.0), ("uchar", (127, 63, 0), 1 / 255)]
)
def test_a_ply_has_the_colours_of_its_vertices(
    kind: str, values: tuple[float, ...], scale: float, tmp_path: Path
) -> None:
    path = tmp_path / "a.ply"
    header = ["ply", "format ascii 1.0", "element vertex 3", *(f"property float {c}" for c in "xyz")]
    header += [*(f"property {kind} {c}" for c in ("red", "green", "blue")), "element face 1"]
    header += ["property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(map(str, (*p, *values))) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0))]
    path.write_text("\n".join([*header, *rows, "3 0 1 2"]) + "\n")
    assert reflectances(et.load(path)) == [m.MeshAttribute(name="vertex_color", scale=scale)]


def test_everything_is_in_view_and_lit(tmp_path: Path) -> None:
    """Without a ground and a sun, edges are the sky, and the mesh fills one direction, up to a margin of 9 %."""
    scene = et.load(written(tmp_path), ground=0, sun=0).with_(size=(192, 144))
    image = et.render(scene, spp=4).image
    edges = (image[0], image[-1], image[:, 0], image[:, -1])
    assert all(edge == pytest.approx(0.3, rel=1e-3) for edge in edges)
    seen = np.abs(image[..., 0] - 0.3) > 0.01
    assert max(seen.any(axis=0).mean(), seen.any(axis=1).mean()) > 0.9


@pytest.mark.parametrize(
    ("defines", "added"),
    [
        ({"ground": 0}, "a camera, a sky and a sun are added;"),
        ({"ground": 0, "sky": 0, "sun": "#000000"}, "a camera is added;"),
    ],
)
def test_parts_of_strength_0_are_not_called_added(defines: dict[str, object], added: str, tmp_path: Path) -> None:
    assert f"the file is only a mesh: {added} -D view=" in et.load(written(tmp_path), **defines).warnings[-1]


def test_a_wide_ground_of_the_mesh_is_not_framed(tmp_path: Path) -> None:
    wide = "v -50 0 50\nv 50 0 50\nv 0 0 -50\nusemtl wood\nf 8 9 10\n"
    scene = et.load(written(tmp_path, SQUARES + wide))
    assert scene.model.sensor == et.load(written(tmp_path)).model.sensor
    assert any(line.endswith("the camera frames all else") for line in scene.warnings)


@pytest.mark.parametrize("view", studio.VIEWS)
def test_the_sun_casts_a_soft_shadow_on_an_even_ground(view: str, tmp_path: Path) -> None:
    """In the open, the ground sends out what sky and sun send to it, its reflectance of both; shadows are darker."""
    scene = et.load(written(tmp_path), view=view).with_(size=(64, 48))
    image = et.render(scene, spp=64, strategy="best,adaptive=none").image[..., 1]
    cosine = 1.0 / math.hypot(0.5, 1.0, 0.8)
    assert image[0].mean() == pytest.approx(0.6 * (0.3 + 2.2 * cosine / math.pi), rel=0.01)
    assert image.min() < 0.5 * image[0].mean()


@pytest.mark.parametrize("angle", [0.1, 45])
def test_the_size_of_the_sun_does_not_change_its_light(angle: float, tmp_path: Path) -> None:
    scene = et.load(written(tmp_path), sky=0, sun_angle=angle).with_(size=(64, 48))
    image = et.render(scene, spp=64, strategy="best,adaptive=none").image[..., 1]
    assert image[0].mean() == pytest.approx(0.6 * 2.2 / math.hypot(0.5, 1.0, 0.8) / math.pi, rel=0.01)


def test_a_larger_sun_casts_a_softer_shadow(tmp_path: Path) -> None:
    """More pixels of the ground see a part of the sun: neither all of it, as in the open, nor nothing."""
    path, partly = written(tmp_path, ROOF.format("", "", "")), []
    for angle in (1, 20):
        scene = et.load(path, sky=0, sun_angle=angle, face_normals=True).with_(size=(64, 48), max_depth=2)
        image = et.render(scene, spp=64, strategy="best,adaptive=none").image[..., 1]
        lit = image[0].mean()
        partly.append(((image > 0.2 * lit) & (image < 0.8 * lit)).mean())
    assert partly[1] > 2.0 * partly[0]


def test_a_mesh_whose_z_is_up_stands_as_if_its_y_were_up(tmp_path: Path) -> None:
    """The studio does not notice the difference: both pictures have the same bits."""
    lying = re.sub(
        r"^v (\S+) (\S+) (\S+)$", lambda found: f"v {found[1]} {-float(found[3])} {found[2]}", SQUARES, flags=re.M
    )
    pictures = []
    for name, text, up in (("y", SQUARES, "y"), ("z", lying, "z")):
        (tmp_path / name).mkdir()
        scene = et.load(written(tmp_path / name, text), up=up, view="right").with_(size=(32, 24))
        pictures.append(et.render(scene, spp=4).image)
    assert np.array_equal(pictures[0], pictures[1])


ROOF = "{}v 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 0 -1\nv 1 0 -1\n{}f 1 3 4 2\n{}f 1 2 6 5\n"
"""Two slopes that share a ridge; with places for statements at the beginning and before each face."""
HARD = (
    "a.obj: without normals: edges of more than 40 degrees are hard, others smooth; -D crease_angle=180 smooths all, "
    "-D face_normals=true makes all hard"
)


def low(roof: str) -> str:
    """Return the roof with slopes that meet at 33 degrees instead of 90."""
    return roof.replace(" 1 0\n", " 0.3 0\n")


def groups_are_told(scene: et.Scene) -> bool:
    return any("'s' is not used" in line for line in scene.warnings)


def is_flat(scene: et.Scene) -> bool:
    roof = next(surface for surface in scene.surfaces() if isinstance(surface, MeshSurface))
    return roof.normals is None


@pytest.mark.parametrize(
    ("statements", "flat"),
    [
        (("", "", ""), False),
        (("", "s off\n", ""), True),
        (("# an export\n  S 0 # flat\r\n", "", "s\toff\n"), True),
        (("", "s 1\n", "s off\n"), False),
        (("", "s off\n", "s 1\n"), False),
        (("", "", "s off\n"), False),
    ],
)
def test_edges_are_hard_where_the_file_switches_smoothing_off(
    statements: tuple[str, str, str], flat: bool, tmp_path: Path
) -> None:
    path = written(tmp_path, low(ROOF.format(*statements)))
    scene = et.load(path)
    assert is_flat(scene) is flat
    assert HARD not in scene.warnings
    assert groups_are_told(scene) is (any(statements) and not flat)
    for wanted in (True, False, "true", "false"):
        scene = et.load(path, face_normals=wanted)
        assert is_flat(scene) is (wanted in (True, "true"))
        assert groups_are_told(scene) is (any(statements) and not is_flat(scene))


@pytest.mark.parametrize("flat", [True, False])
def test_groups_of_a_mesh_within_a_scene_are_told_unless_it_is_flat(flat: bool, tmp_path: Path) -> None:
    """In a scene file Mitsuba's rule binds: faces are smooth, whatever the file says."""
    path = written(tmp_path, ROOF.format("", "s off\n", ""))
    mesh = {"type": "obj", "filename": str(path), "face_normals": flat}
    scene = et.load_dict({"type": "scene", "camera": {"type": "perspective"}, "a": mesh})
    assert is_flat(scene) is flat
    assert groups_are_told(scene) is not flat


def test_the_normals_of_a_file_count_whatever_its_smoothing_groups(tmp_path: Path) -> None:
    faces = "vn 0 1 0\ns off\nf 1//1 3//1 4//1 2//1\nf 1//1 2//1 6//1 5//1\n"
    scene = et.load(written(tmp_path, ROOF.format("", "", "").split("f ", 1)[0] + faces))
    assert not is_flat(scene)
    assert HARD not in scene.warnings


@pytest.mark.parametrize(
    ("height", "shared", "hard"), [(1.0, True, True), (0.3, True, False), (0.0, True, False), (1.0, False, True)]
)
def test_edges_beyond_the_crease_angle_are_hard(height: float, shared: bool, hard: bool, tmp_path: Path) -> None:
    """Slopes that meet at 90 and at 33 degrees, a plain, and slopes that do not share the vertices of their ridge."""
    roof = ROOF.format("", "", "").replace(" 1 0\n", f" {height} 0\n")
    if not shared:
        roof = roof.replace("f 1 2 6 5", f"v 0 {height} 0\nv 1 {height} 0\nf 7 8 6 5")
    scene = et.load(written(tmp_path, roof))
    assert hard_edges(scene) is hard
    assert (HARD in scene.warnings) is hard


def hard_edges(scene: et.Scene) -> bool:
    """Tell whether a vertex of the mesh has several normals."""
    mesh = next(surface for surface in scene.surfaces() if isinstance(surface, MeshSurface))
    assert mesh.normals is not None
    both = np.column_stack([mesh.vertices, mesh.normals]).round(9)
    return len(np.unique(both, axis=0)) > len(np.unique(mesh.vertices, axis=0))


def cylinder(sides: int, rings: int) -> str:
    """Return the OBJ text of a cylinder with caps, without normals."""
    turns = [2.0 * math.pi * side / sides for side in range(sides)]
    points = [(math.cos(turn), ring / rings, -math.sin(turn)) for ring in range(rings + 1) for turn in turns]
    faces = [[*range(sides, 0, -1)], [*range(rings * sides + 1, (rings + 1) * sides + 1)]]
    for low in range(1, rings * sides + 1, sides):
        for side in range(sides):
            first, second = low + side, low + (side + 1) % sides
            faces.append([first, second, second + sides, first + sides])
    lines = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {' '.join(map(str, face))}" for face in faces]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("sides", [4, 12, 64])
def test_a_mesh_may_have_round_parts_and_hard_edges(sides: int, tmp_path: Path) -> None:
    """A box is hard everywhere; a cylinder of at least ten sides is round, and has flat caps with hard rims."""
    path = written(tmp_path, cylinder(sides, 1))
    scene = et.load(path)
    assert HARD in scene.warnings
    (mesh,) = (surface for surface in scene.surfaces() if isinstance(surface, MeshSurface))
    assert mesh.normals is not None
    flat = np.abs(mesh.normals[:, 1]) > 0.5
    expected = mesh.vertices * (1.0, 0.0, 1.0) if sides > 4 else np.sign(mesh.normals.round(9)) * math.sqrt(0.5)
    np.testing.assert_allclose(np.abs(mesh.normals[flat]), np.tile((0.0, 1.0, 0.0), (2 * sides, 1)), atol=1e-9)
    np.testing.assert_allclose(mesh.normals[~flat], expected[~flat], atol=1e-6)


@pytest.mark.parametrize("angle", [29.0, 31.0])
def test_the_crease_angle_is_that_between_faces(angle: float, tmp_path: Path) -> None:
    """The sides of a cylinder of twelve meet at 30 degrees."""
    scene = et.load(written(tmp_path, cylinder(12, 1)), crease_angle=angle)
    (mesh,) = (surface for surface in scene.surfaces() if isinstance(surface, MeshSurface))
    assert len(mesh.vertices) == 2 * 12 * (3 if angle < 30.0 else 2)
    assert HARD not in scene.warnings


def test_a_crease_angle_of_180_degrees_smooths_all(tmp_path: Path) -> None:
    assert not hard_edges(et.load(written(tmp_path, cylinder(4, 1)), crease_angle=180))


def test_a_box_by_itself_loses_no_light(tmp_path: Path) -> None:
    """Under a uniform sky a convex grey surface is as bright as half of the sky, on all of its faces."""
    defines = {"sky": 1.0, "sun": 0, "ground": 0}
    box = et.load(written(tmp_path, cylinder(4, 1)), **defines).with_(size=(24, 18), transparent=True)
    image = et.render(box, spp=256, strategy="naive,adaptive=none").image[9, 12]
    np.testing.assert_allclose(image[:3], 0.5, rtol=0.02)


def test_strengths_may_be_colours(tmp_path: Path) -> None:
    path = written(tmp_path)
    model = et.load(path, ground="#808080", sky="#ff0000", sun="#00ff00").model
    ground, sun = model.shapes[-2:]
    assert isinstance(ground, m.Disk)
    assert isinstance(ground.bsdf, m.Diffuse)
    assert ground.bsdf.reflectance == pytest.approx((0.215861,) * 3, abs=1e-6)
    assert [emitter.radiance for emitter in model.emitters if isinstance(emitter, m.Constant)] == [(1.0, 0.0, 0.0)]
    assert isinstance(sun, m.Sphere)
    assert sun.emitter is not None
    assert sun.emitter.radiance == pytest.approx((0.0, 1.0 / (math.pi * math.sin(math.radians(5.0)) ** 2), 0.0))
    assert len(et.load(path, ground="#000", sky="#000", sun="#000").model.shapes) == len(model.shapes) - 2
    with pytest.raises(et.SceneError, match="'sky': expected '#' and six hexadecimal digits"):
        et.load(path, sky="#12")


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e6])
def test_the_studio_is_as_large_as_the_mesh(size: float, tmp_path: Path) -> None:
    images = []
    for factor in (1.0, size):
        points = "".join(f"v {x * factor!r} {y * factor!r} 0\n" for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
        scene = et.load(written(tmp_path, points + "f 1 2 3\n")).with_(size=(16, 12))
        images.append(et.render(scene, spp=256, strategy="mis,adaptive=none").image)
    np.testing.assert_allclose(images[0].mean(), images[1].mean(), rtol=0.01)


def test_a_mesh_around_which_no_studio_can_stand_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        et.SceneError, match=r"a\.obj: the mesh reaches to 1e\+308; no coordinate may be beyond 1e\+300"
    ):
        et.load(written(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 1e308\nf 1 2 3\n"))
    assert et.load(written(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 1e300\nf 1 2 3\n")).model.shapes


@pytest.mark.parametrize(
    ("defines", "message"),
    [
        ({"view": "bakc"}, "'view' must be front, right, back or left, found 'bakc'; did you mean 'back'"),
        ({"view": "top"}, "'view' must be front, right, back or left, found 'top'"),
        ({"up": "x"}, "'up' must be y or z, found 'x'"),
        ({"face_normals": "ture"}, "'face_normals' must be true or false, found 'ture'; did you mean 'true'"),
        ({"sun_angle": "0"}, "'sun_angle' must be a number from 0.1 to 45, found '0'"),
        ({"sun_angle": 46}, "'sun_angle' must be a number from 0.1 to 45, found 46"),
        ({"crease_angle": 181}, "'crease_angle' must be a number from 0 to 180, found 181"),
        ({"ground": 1.5}, "'ground' must be a number from 0 to 1 or a colour such as #20c040, found 1.5"),
        ({"sun": "bright"}, "'sun' must be a number of at least 0 or a colour such as #20c040, found 'bright'"),
        ({"skye": 1}, "nothing in the scene uses the definition 'skye'; did you mean 'sky'"),
    ],
)
def test_a_definition_that_makes_no_sense_is_refused(defines: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(et.SceneError, match=re.escape(message)):
        et.load(written(tmp_path), **defines)


def test_a_part_is_exported_as_a_mesh_of_its_own(tmp_path: Path) -> None:
    scene = et.load(written(tmp_path))
    et.scene.export.convert(scene.model, scene.assets, tmp_path / "b.xml")
    again = et.load(tmp_path / "b.xml")
    assert "usemtl" not in (tmp_path / "b.xml").read_text()
    assert [shape.type for shape in again.model.shapes] == [*["ply"] * 3, "disk", "sphere"]
    for before, after in list(zip(scene.surfaces(), again.surfaces(), strict=True))[:3]:
        assert isinstance(before, MeshSurface)
        assert isinstance(after, MeshSurface)
        assert np.array_equal(before.vertices, after.vertices)
        assert np.array_equal(before.uvs, after.uvs)  # type: ignore[arg-type]


def test_a_damaged_mesh_is_refused_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(et.SceneError, match=r"a\.obj:1: expected a number"):
        et.load(written(tmp_path, "v 0 0 x\n"))


def test_the_command_renders_it(tmp_path: Path) -> None:
    output = tmp_path / "out.png"
    assert main(["render", str(written(tmp_path)), "-o", str(output), "--spp", "1", "--size", "16x12", "-q"]) == 0
    assert output.exists()


def test_what_is_wrong_with_a_mesh_names_its_file_once(tmp_path: Path) -> None:
    for text, told in (("v 0 0 0\nf 1 2 3\n", "{}:2: vertex 3 does not exist"), ("", "{}: the mesh is empty")):
        file = tmp_path / "bad.obj"
        file.write_text(text)
        with pytest.raises(et.SceneError) as error:
            et.load(file)
        assert str(error.value).startswith(told.format(file))
