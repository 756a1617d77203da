"""Cameras and lights of glTF files, and those that are added where there are none."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene import bare_mesh
from equaltime.scene import model as m
from equaltime.scene.geometry import MeshSurface
from equaltime.scene.gltf import reader

from .gltf_files import TRIANGLE, Builder, one_triangle


def with_camera(camera: dict[str, Any], **node: Any) -> Builder:
    builder = one_triangle()
    builder.node(camera=builder.add("cameras", camera), **node)
    return builder


def with_light(light: dict[str, Any], **node: Any) -> Builder:
    builder = one_triangle()
    builder.json["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    builder.node(extensions={"KHR_lights_punctual": {"light": 0}}, **node)
    return builder


def loaded(builder: Builder, folder: Path, **defines: object) -> et.Scene:
    return et.load(builder.glb(folder / "a.glb"), **defines)


def sensor(builder: Builder, folder: Path) -> m.Sensor:
    return loaded(builder, folder).model.sensor


def emitter(builder: Builder, folder: Path) -> m.FreeEmitter:
    (found,) = loaded(builder, folder).model.emitters
    return found


PERSPECTIVE = {"type": "perspective", "perspective": {"yfov": math.pi / 2, "znear": 0.1, "aspectRatio": 2.0}}


# -- cameras ----------------------------------------------------------------------------------------------------------


def test_a_perspective_camera_keeps_its_vertical_field_of_view(tmp_path: Path) -> None:
    found = sensor(with_camera(PERSPECTIVE), tmp_path)
    assert isinstance(found, m.Perspective)
    assert (found.film.width, found.film.height) == (768, 384)
    assert math.tan(math.radians(found.x_fov) / 2) == pytest.approx(2.0)
    assert (found.near_clip, found.far_clip) == (0.1, None)


def test_a_tall_image_is_tall(tmp_path: Path) -> None:
    camera = {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1, "zfar": 10.0, "aspectRatio": 0.5}}
    found = sensor(with_camera(camera), tmp_path)
    assert (found.film.width, found.film.height, found.far_clip) == (384, 768, 10)


def test_cameras_look_along_minus_z_with_x_to_the_right(tmp_path: Path) -> None:
    """Mitsuba's camera space has +z forwards and +x to the left."""
    to_world = m.as_array(sensor(with_camera(PERSPECTIVE, translation=[1, 2, 3]), tmp_path).to_world)
    assert to_world.tolist() == [[-1, 0, 0, 1], [0, 1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]


def test_a_turned_camera_looks_along_its_own_axis(tmp_path: Path) -> None:
    half = math.sqrt(0.5)
    to_world = m.as_array(sensor(with_camera(PERSPECTIVE, rotation=[0, half, 0, half]), tmp_path).to_world)
    assert np.allclose(to_world[:3, :3], [[0, 0, -1], [0, 1, 0], [1, 0, 0]])


def test_scale_and_shear_of_a_cameras_node_do_not_count(tmp_path: Path) -> None:
    scaled = sensor(with_camera(PERSPECTIVE, scale=[2, 3, 4], translation=[1, 2, 3]), tmp_path)
    assert np.allclose(scaled.to_world, sensor(with_camera(PERSPECTIVE, translation=[1, 2, 3]), tmp_path).to_world)


def test_an_orthographic_camera_sees_xmag_to_either_side(tmp_path: Path) -> None:
    camera = {"type": "orthographic", "orthographic": {"xmag": 3.0, "ymag": 1.5, "znear": 0.0, "zfar": 10.0}}
    found = sensor(with_camera(camera), tmp_path)
    assert isinstance(found, m.Orthographic)
    assert np.allclose(np.linalg.norm(np.array(found.to_world)[:3, :3], axis=0), (3, 3, 1))
    assert (found.film.width, found.film.height) == (768, 384)


@pytest.mark.parametrize(
    ("camera", "expected"),
    [
        ({"type": "perspective"}, r"cameras\[0\]: needs 'perspective'"),
        ({"type": "orthographic"}, r"cameras\[0\]: needs 'orthographic'"),
        ({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}}, r"xmag and ymag must not be 0"),
        ({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}}, r"cameras\[0\].perspective.yfov"),
        ({"type": "fisheye"}, r"cameras\[0\].type: expected 'perspective' or 'orthographic', found 'fisheye'"),
    ],
)
def test_a_wrong_camera_is_told(tmp_path: Path, camera: dict[str, Any], expected: str) -> None:
    with pytest.raises(et.SceneError, match=expected):
        sensor(with_camera(camera), tmp_path)


def test_one_of_several_cameras_may_be_chosen(tmp_path: Path) -> None:
    builder = with_camera(PERSPECTIVE, name="front")
    builder.node(camera=0, name="side", translation=[7, 0, 0])
    scene = loaded(builder, tmp_path)
    assert scene.model.sensor.to_world[0][3] == 0
    assert "of 2 cameras the first is used; -D camera=... takes another of front, side" in scene.warnings
    assert loaded(builder, tmp_path, camera="side").model.sensor.to_world[0][3] == 7
    assert loaded(builder, tmp_path, camera="1").model.sensor.to_world[0][3] == 7
    with pytest.raises(et.SceneError, match=r"the file has no camera 'sid'; did you mean 'side'\?"):
        loaded(builder, tmp_path, camera="sid")


def test_a_view_takes_the_place_of_the_files_cameras(tmp_path: Path) -> None:
    builder = with_camera(PERSPECTIVE, translation=[0, 0, 5])
    from_behind = loaded(builder, tmp_path, view="back")
    assert from_behind.model.sensor.to_world[2][3] < 0 < loaded(builder, tmp_path).model.sensor.to_world[2][3]
    assert not any("camera" in warning for warning in from_behind.warnings)
    with pytest.raises(et.SceneError, match="'view' must be front, right, back or left"):
        loaded(builder, tmp_path, view="top")
    with pytest.raises(et.SceneError, match="both choose the camera"):
        loaded(builder, tmp_path, view="back", camera=0)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("middle", [0.0, 10.0])
def test_an_added_camera_has_everything_in_view(tmp_path: Path, size: float, middle: float) -> None:
    builder = Builder()
    random = np.random.default_rng(3)
    points = (random.uniform(-1, 1, (30, 3)) * (3, 1, 0.2) + middle) * size
    builder.node(mesh=builder.mesh(points))
    scene = loaded(builder, tmp_path)
    assert any("a camera" in w or "has no camera" in w for w in scene.warnings)
    found = scene.model.sensor
    assert isinstance(found, m.Perspective)
    local = np.linalg.inv(m.as_array(found.to_world)) @ np.column_stack([points, np.ones(30)]).T
    half = math.tan(math.radians(found.x_fov) / 2)
    x, y, z = local[:3]
    assert (z > 0).all()
    assert np.abs(x / z).max() < half
    assert np.abs(y / z).max() < half * found.film.height / found.film.width
    filled = max(np.abs(x / z).max() / half, np.abs(y / z).max() / half / 0.75)
    assert filled > 0.7


@pytest.mark.parametrize(("width", "height", "framed"), [(40.0, 0.0, False), (4.0, 0.0, True), (40.0, 3.0, True)])
def test_a_wide_ground_of_the_file_is_not_framed(width: float, height: float, framed: bool, tmp_path: Path) -> None:
    """A ground twice as wide as the model counts, and so does a wide plane above it, such as a ceiling."""
    builder = Builder()
    builder.node(mesh=builder.mesh([(-1, 0, 0), (1, 0, 0), (0, 2, 0)]))
    alone = loaded(builder, tmp_path).model.sensor
    w = width / 2
    builder.node(mesh=builder.mesh([(-w, height, w), (w, height, w), (w, height, -w)]))
    scene = loaded(builder, tmp_path, view="front")
    assert (scene.model.sensor == alone) is not framed
    assert any("own ground is far wider" in line for line in scene.warnings) is not framed


def test_vertices_that_no_triangle_uses_are_not_in_view(tmp_path: Path) -> None:
    views = []
    for stray in ([], [[1e6, -1e6, 1e6]]):
        builder = Builder()
        builder.node(mesh=builder.mesh([*TRIANGLE, *stray], indices=[0, 1, 2]))
        views.append(loaded(builder, tmp_path).model.sensor)
    assert views[0] == views[1]


# -- lights -----------------------------------------------------------------------------------------------------------


def test_a_point_light_has_its_candela(tmp_path: Path) -> None:
    found = emitter(
        with_light({"type": "point", "intensity": 10, "color": [1, 0.5, 0]}, translation=[1, 2, 3]), tmp_path
    )
    assert isinstance(found, m.Point)
    assert (found.world_position, found.intensity) == ((1, 2, 3), (10, 5, 0))


def test_a_directional_light_shines_along_minus_z(tmp_path: Path) -> None:
    half = math.sqrt(0.5)
    found = emitter(with_light({"type": "directional", "intensity": 3}, rotation=[-half, 0, 0, half]), tmp_path)
    assert isinstance(found, m.Directional)
    assert found.world_direction == pytest.approx((0, -1, 0))
    assert found.irradiance == (3, 3, 3)


def test_a_spot_has_its_cones(tmp_path: Path) -> None:
    spot = {"innerConeAngle": 0.2, "outerConeAngle": 0.5}
    found = emitter(with_light({"type": "spot", "intensity": 5, "spot": spot}, translation=[0, 4, 0]), tmp_path)
    assert isinstance(found, m.Spot)
    assert (found.beam, found.cutoff_angle) == pytest.approx((math.degrees(0.2), math.degrees(0.5)))
    assert np.allclose(np.array(found.to_world)[:3, 2:], [[0, 0], [0, 4], [-1, 0]])


def test_the_default_spot_opens_by_a_quarter_of_a_half_turn(tmp_path: Path) -> None:
    found = emitter(with_light({"type": "spot"}), tmp_path)
    assert isinstance(found, m.Spot)
    assert (found.beam, found.cutoff_angle) == pytest.approx((0, 45))


def test_the_widest_spot_in_float32_is_a_hemisphere(tmp_path: Path) -> None:
    found = emitter(with_light({"type": "spot", "spot": {"outerConeAngle": 1.5707963705062866}}), tmp_path)
    assert isinstance(found, m.Spot)
    assert found.cutoff_angle == 90.0


@pytest.mark.parametrize(
    ("inner", "told"), [(0.3, "falls linearly"), (0.5, ""), (0.7, "the inner cone of a spot is wider than the outer")]
)
def test_a_spot_says_how_its_light_falls_between_its_cones(inner: float, told: str, tmp_path: Path) -> None:
    spot = {"innerConeAngle": inner, "outerConeAngle": 0.5}
    scene = loaded(with_light({"type": "spot", "spot": spot}), tmp_path)
    (found,) = (emitter for emitter in scene.model.emitters if isinstance(emitter, m.Spot))
    assert found.beam == pytest.approx(math.degrees(min(inner, 0.5)))
    notes = [warning for warning in scene.warnings if "of a spot" in warning]
    assert [told in note for note in notes] == [True] * bool(told)


def test_a_spot_that_is_closed_is_no_light(tmp_path: Path) -> None:
    scene = loaded(with_light({"type": "spot", "spot": {"outerConeAngle": 0}}), tmp_path)
    assert any("gives no light" in warning for warning in scene.warnings)
    assert not any(isinstance(emitter, m.Spot) for emitter in scene.model.emitters)


def test_a_node_that_names_no_light_is_told(tmp_path: Path) -> None:
    builder = with_light({"type": "point"})
    builder.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 1
    with pytest.raises(
        et.SceneError, match=r"KHR_lights_punctual.light: expected the index of one of 1 lights, found 1"
    ):
        loaded(builder, tmp_path)


def test_a_file_without_lights_gets_a_sky_and_a_sun(tmp_path: Path) -> None:
    scene = loaded(one_triangle(), tmp_path)
    assert any(
        warning.startswith("the file has no light: a sky of radiance 0.5 and a sun") for warning in scene.warnings
    )
    sky, sun = scene.model.emitters
    assert isinstance(sky, m.Constant)
    assert sky.radiance == (0.5, 0.5, 0.5)
    assert isinstance(sun, m.Directional)
    assert sun.irradiance == (1.5, 1.5, 1.5)


def test_glowing_surfaces_get_them_too_unless_they_are_left_out(tmp_path: Path) -> None:
    builder = one_triangle(emissiveFactor=[1, 1, 1])
    scene = loaded(builder, tmp_path)
    assert any("no lights except emitting surfaces" in warning for warning in scene.warnings)
    assert len(scene.model.emitters) == 2
    assert loaded(builder, tmp_path, sky=0).model.emitters == ()


def test_a_sky_may_be_added_to_lights(tmp_path: Path) -> None:
    builder = with_light({"type": "point"})
    assert len(loaded(builder, tmp_path).model.emitters) == 1
    _point, sky = loaded(builder, tmp_path, sky="0.25").model.emitters
    assert isinstance(sky, m.Constant)
    assert sky.radiance == (0.25, 0.25, 0.25)


def test_animations_are_told_not_to_play(tmp_path: Path) -> None:
    builder = one_triangle()
    builder.json |= {"animations": [{}]}
    assert any("animations are not played" in warning for warning in loaded(builder, tmp_path).warnings)


@pytest.mark.parametrize("angle", ["0.5", 30])
def test_the_added_sun_may_be_soft(angle: object, tmp_path: Path) -> None:
    """It is as far as that of a mesh by itself, and gives the same light as the directional one."""
    scene = loaded(one_triangle(), tmp_path, sun_angle=angle)
    (sky,) = scene.model.emitters
    assert isinstance(sky, m.Constant)
    found = scene.model.shapes[-1]
    assert isinstance(found, m.Sphere)
    assert found.emitter is not None
    sine = math.sin(math.radians(float(str(angle))))
    assert found.emitter.radiance == pytest.approx((1.5 / (math.pi * sine**2),) * 3)


@pytest.mark.parametrize(
    ("defines", "message"),
    [
        ({"sun_angle": 46}, "'sun_angle' must be a number from 0.1 to 45, found 46"),
        ({"up": "x"}, "'up' must be y or z, found 'x'"),
        ({"crease_angle": -1}, "'crease_angle' must be a number from 0 to 180, found -1"),
        ({"face_normals": "no"}, "'face_normals' must be true or false, found 'no'"),
    ],
)
def test_a_definition_of_a_mesh_by_itself_is_checked_alike(
    defines: dict[str, object], message: str, tmp_path: Path
) -> None:
    with pytest.raises(et.SceneError, match=message):
        loaded(one_triangle(), tmp_path, **defines)


def test_every_definition_of_a_mesh_by_itself_is_one_of_a_gltf_file() -> None:
    assert set(bare_mesh.DEFINITIONS) <= set(reader.DEFINITIONS)


def test_a_soft_sun_needs_a_sun(tmp_path: Path) -> None:
    builder = with_light({"type": "point"})
    with pytest.raises(et.SceneError, match="'sun_angle' needs a sun, but the file has its own lights"):
        loaded(builder, tmp_path, sun_angle=5)
    assert len(loaded(builder, tmp_path, sun_angle=5, sun=1).model.shapes) == 2


def test_the_added_sun_shines_from_the_side_of_the_view(tmp_path: Path) -> None:
    for view, direction in (("front", (0.5, -1, -0.8)), ("back", (-0.5, -1, 0.8))):
        _sky, sun = loaded(one_triangle(), tmp_path, view=view).model.emitters
        assert isinstance(sun, m.Directional)
        assert sun.direction == direction


def test_a_file_whose_z_is_up_can_be_stood_up(tmp_path: Path) -> None:
    """+z becomes +y, and -y, the front, becomes +z; lights and cameras turn with the meshes."""
    builder = with_light({"type": "point"}, translation=[1, 2, 3])
    scene = loaded(builder, tmp_path, up="z")
    found = next(emitter for emitter in scene.model.emitters if isinstance(emitter, m.Point))
    assert found.world_position == pytest.approx((1, 3, -2))
    (mesh,) = (surface for surface in scene.surfaces() if isinstance(surface, MeshSurface))
    (lying,) = (surface for surface in loaded(builder, tmp_path).surfaces() if isinstance(surface, MeshSurface))
    assert np.allclose(mesh.vertices, lying.vertices @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]])


@pytest.mark.parametrize(("defines", "count"), [({}, None), ({"crease_angle": 89}, 6), ({"crease_angle": 91}, 4)])
def test_edges_of_meshes_without_normals_may_be_smooth(
    defines: dict[str, float], count: int | None, tmp_path: Path
) -> None:
    """Two triangles that meet at 90 degrees; as the format says, they are flat."""
    builder = Builder()
    builder.node(mesh=builder.mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], indices=[0, 1, 2, 1, 0, 3]))
    (mesh,) = (surface for surface in loaded(builder, tmp_path, **defines).surfaces())
    assert isinstance(mesh, MeshSurface)
    assert mesh.normals is None if count is None else (mesh.normals is not None and len(mesh.normals) == count)
    (flat,) = loaded(builder, tmp_path, face_normals=True, **defines).surfaces()
    assert isinstance(flat, MeshSurface)
    assert flat.normals is None


def test_strengths_of_a_studio_may_be_colours(tmp_path: Path) -> None:
    scene = loaded(one_triangle(), tmp_path, ground="#fff", sky="#00f", sun="#ff0000")
    sky, sun = scene.model.emitters
    assert isinstance(sky, m.Constant)
    assert isinstance(sun, m.Directional)
    assert (sky.radiance, sun.irradiance) == ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    assert any(isinstance(shape, m.Disk) for shape in scene.model.shapes)


def test_a_strength_of_0_that_takes_nothing_away_is_told(tmp_path: Path) -> None:
    lit = with_light({"type": "directional"})
    ground = "-D ground=0 changes nothing: none is added to glTF, and the file's own stays"
    light = "-D sky=0; -D sun=0: no light is added, and those of the file stay"
    assert {ground, light} <= {*loaded(lit, tmp_path, ground=0, sky=0, sun=0).warnings}
    assert not {ground, light} & {*loaded(lit, tmp_path, ground=0.5, sky=0.1, sun=0).warnings}


@pytest.mark.parametrize("name", ["ground", "sky", "sun"])
def test_a_strength_that_is_no_number_is_told_with_what_may_be_given(name: str, tmp_path: Path) -> None:
    with pytest.raises(
        et.SceneError, match=f"'{name}' must be a number .* or a colour such as #20c040, found '0.2,0.4,0.2'"
    ):
        loaded(one_triangle(), tmp_path, **{name: "0.2,0.4,0.2"})


@pytest.mark.parametrize(
    ("given", "told"), [("0", "-D ground=0 changes"), ("#804020", "-D ground= adds a ground below")]
)
def test_the_way_to_leave_out_the_own_ground_is_told(given: str, told: str) -> None:
    way = "to leave out the file's own ground, 'equaltime convert' the file to TOML and delete [table_2] there"
    assert [told in line for line in et.load("windmill", ground=given).warnings if line.endswith(way)] == [True]
    assert not any(way in line for line in et.load("windmill").warnings)


def test_an_unknown_definition_names_all_and_the_way_to_a_material() -> None:
    known = "animation, camera, crease_angle, face_normals, ground, .*, sun_angle, time, up or view"
    way = "'equaltime convert' writes a TOML file in which materials can be changed"
    with pytest.raises(et.SceneError, match=f"uses the definition 'ball'; expected {known}; {way}"):
        et.load("windmill", ball="#ff0000")
