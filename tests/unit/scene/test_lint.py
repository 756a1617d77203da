"""``equaltime lint``: each hazard in the smallest scene that has it, and beside it one that has not."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

import equaltime as et
from equaltime.scene.lint import Finding, lint

SHIPPED = Path(__file__).parents[3] / "scenes"
CUBE = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
SIDES = [
    *([1, 3, 2], [1, 4, 3], [5, 6, 7], [5, 7, 8], [1, 2, 6], [1, 6, 5]),
    *([2, 3, 7], [2, 7, 6], [3, 4, 8], [3, 8, 7], [4, 1, 5], [4, 5, 8]),
]
"""Outward, counted from 1."""
Vertices = list[list[float]] | list[list[int]]


def moved(vertices: Vertices, by: float = 0.0, size: float = 1.0) -> list[list[float]]:
    return [[size * c + by for c in v] for v in vertices]


@pytest.fixture
def obj(tmp_path: Path) -> Callable[..., dict[str, Any]]:
    def write(vertices: Vertices, faces: list[list[int]], **shape: Any) -> dict[str, Any]:
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.obj"
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
        path.write_text("\n".join([*lines, *("f " + " ".join(map(str, face)) for face in faces)]) + "\n")
        return {"type": "obj", "filename": str(path), "face_normals": True, **shape}

    return write


def scene(light: dict[str, Any] | None = None, camera: float = 10.0, **parts: Any) -> et.Scene:
    view = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, camera], [0, 0, 0, 1]]
    film = {"type": "hdrfilm", "width": 8, "height": 8}
    sensor = {"type": "perspective", "to_world": view, "film": film}
    return et.load_dict({"type": "scene", "view": sensor, "light": light or {"type": "constant"}, **parts})


def found(subject: et.Scene) -> dict[str, Finding]:
    return {finding.check: finding for finding in lint(subject)}


GLASS = {"type": "dielectric"}


def test_a_clean_scene_has_no_hazards(obj: Callable[..., dict[str, Any]]) -> None:
    bulb = {"type": "area", "radiance": 3.0}
    clean = scene(
        box=obj(CUBE, SIDES),
        glass=obj(moved(CUBE, 4.0), SIDES, bsdf=GLASS),
        ball={"type": "sphere", "center": [-4, 0, 0], "bsdf": {"type": "roughconductor"}},
        lamp={
            "type": "rectangle",
            "to_world": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -6], [0, 0, 0, 1]],
            "emitter": bulb,
        },
    )
    assert found(clean) == {}


@pytest.mark.parametrize(
    "file", ["cornell-box.toml", "veach-mis.toml", "montelight/complex.toml", "terrain/terrain.toml"]
)
def test_the_shipped_scenes_are_clean(file: str) -> None:
    assert found(et.load(SHIPPED / file)) == {}


def test_triangles_that_rounding_leaves_without_area_are_counted_as_the_core_drops_them(
    obj: Callable[..., dict[str, Any]],
) -> None:
    far = [*CUBE, [1e6, 0, 0], [1e6 + 1e-3, 0, 0], [1e6, 1e-3, 1e-3]]
    subject = scene(box=obj(far, [*SIDES, [9, 10, 11]]))
    finding = found(subject)["degenerate-triangles"]
    assert (finding.severity, finding.count) == ("note", 1)
    assert subject.core.dropped_triangles == 1
    lost = scene(box=obj(CUBE, SIDES), dust=obj(far[8:], [[1, 2, 3]]))
    assert found(lost)["degenerate-triangles"].severity == "warning"
    assert "dust" in found(lost)["degenerate-triangles"].where[0]


def test_triangles_that_rounding_tilts_are_slivers(obj: Callable[..., dict[str, Any]]) -> None:
    def needle(height: float) -> dict[str, Finding]:
        return found(
            scene(box=obj(CUBE, SIDES), needle=obj([[2, 0, 0], [3, 0, 0], [2.5, height, height]], [[1, 2, 3]]))
        )

    assert needle(1e-6)["sliver-triangles"].severity == "warning"
    assert needle(1e-3) == {}
    mostly_sound = [*CUBE, [1, 1, 1], [-1, 1, 1], [0, 1 + 1e-6, 1]]
    assert found(scene(box=obj(mostly_sound, [*SIDES, [9, 10, 11]])))["sliver-triangles"].severity == "note"


def test_shading_normals_against_the_faces_are_told(tmp_path: Path) -> None:
    def shaded(sign: int, flat: bool = False) -> dict[str, Finding]:
        path = tmp_path / f"{sign}.obj"
        path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 {sign}\nf 1//1 2//1 3//1\n")
        return found(scene(sheet={"type": "obj", "filename": str(path), "face_normals": flat}))

    assert shaded(-1)["normals-against-faces"].severity == "warning"
    assert shaded(1) == {}
    assert shaded(-1, flat=True) == {}


def test_faces_that_lie_on_others_are_counted(obj: Callable[..., dict[str, Any]]) -> None:
    red = {"type": "diffuse", "reflectance": [0.5, 0.1, 0.1]}
    turned = [face[1:] + face[:1] for face in SIDES]
    same = found(scene(one=obj(CUBE, SIDES), other=obj(CUBE, turned)))["coincident-faces"]
    assert (same.severity, same.count, len(same.where)) == ("note", 12, 2)
    unlike = found(scene(one=obj(CUBE, SIDES), other=obj(CUBE, SIDES, bsdf=red)))["coincident-faces"]
    assert unlike.severity == "warning"
    assert found(scene(one=obj(CUBE, SIDES), other=obj(moved(CUBE, 3.0), SIDES))) == {}


def test_a_closed_shape_that_is_inside_out_is_told_unless_the_camera_or_the_scene_is_within(
    obj: Callable[..., dict[str, Any]],
) -> None:
    inward = [[a, c, b] for a, b, c in SIDES]
    both = {"type": "twosided", "bsdf": {"type": "diffuse"}}
    assert found(scene(box=obj(CUBE, inward)))["inverted-shapes"].severity == "warning"
    assert found(scene(box=obj(CUBE, inward, bsdf=GLASS)))["inverted-shapes"].count == 1
    assert found(scene(ball={"type": "sphere", "flip_normals": True}))["inverted-shapes"].count == 1
    assert found(scene(box=obj(CUBE, inward, bsdf=both))) == {}
    assert found(scene(box=obj(CUBE, inward), camera=0.5)) == {}
    assert found(scene(room=obj(moved(CUBE, size=3.0), inward), ball={"type": "sphere"})) == {}
    assert found(scene(box=obj(CUBE, inward[:-1]))) == {}


def test_glass_with_a_gap_is_told_and_what_several_shapes_close_together_is_not(
    obj: Callable[..., dict[str, Any]],
) -> None:
    gap = found(scene(box=obj(CUBE, SIDES[:-1], bsdf=GLASS)))["open-dielectrics"]
    assert (gap.severity, gap.count) == ("warning", 3)
    assert found(scene(pane={"type": "rectangle", "bsdf": GLASS}))["open-dielectrics"].count == 4
    assert found(scene(pane={"type": "rectangle", "bsdf": {"type": "thindielectric"}})) == {}
    parts = {"lid": obj(CUBE, SIDES[:2], bsdf=GLASS), "pot": obj(CUBE, SIDES[2:], bsdf=GLASS)}
    assert found(scene(**parts)) == {}


def test_what_rounds_coarsely_far_from_the_camera_is_told(obj: Callable[..., dict[str, Any]]) -> None:
    speck = moved(CUBE, 1e5)
    assert found(scene(near=obj(CUBE, SIDES), far=obj(speck, SIDES)))["coarse-shapes"].severity == "warning"
    assert found(scene(near=obj(CUBE, SIDES), far=obj(moved(CUBE, 1e3), SIDES))) == {}


def test_a_file_written_far_from_its_origin_in_single_precision_is_told(obj: Callable[..., dict[str, Any]]) -> None:
    back = [[1, 0, 0, -1e5], [0, 1, 0, -1e5], [0, 0, 1, -1e5], [0, 0, 0, 1]]
    assert "coarse-files" in found(scene(box=obj(moved(CUBE, 1e5), SIDES, to_world=back)))
    exact = moved(CUBE, 1e5, 1.0 + 1e-6)
    assert "coarse-files" not in found(scene(box=obj(exact, SIDES, to_world=back)))


def test_dark_lights_are_notes_and_a_scene_without_light_a_warning() -> None:
    dark = {"type": "constant", "radiance": 0.0}
    black = found(scene(light=dark, ball={"type": "sphere"}))
    assert black["dark-lights"].severity == "note"
    assert black["no-light"].severity == "warning"
    assert "no-light" not in found(scene(light=dark, ball={"type": "sphere", "emitter": {"type": "area"}}))


def test_a_flat_light_with_nothing_before_it_is_turned_away() -> None:
    def lamp(kind: str, flip: bool) -> dict[str, Finding]:
        place = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 20], [0, 0, 0, 1]]
        shape = {"type": kind, "to_world": place, "flip_normals": flip, "emitter": {"type": "area"}}
        return found(scene(ball={"type": "sphere"}, lamp=shape))

    def on_floor(height: float) -> dict[str, Finding]:
        turned = [[1e3, 0, 0, 0], [0, 1e3, 0, 0], [0, 0, 1e3, height], [0, 0, 0, 1]]
        shape = {"type": "rectangle", "to_world": turned, "flip_normals": True, "emitter": {"type": "area"}}
        return found(scene(floor={"type": "disk"}, lamp=shape))

    assert "lights-turned-away" in on_floor(0.0)
    assert on_floor(1e-4) == {}
    for kind in ("rectangle", "disk"):
        assert lamp(kind, flip=True)["lights-turned-away"].severity == "warning", kind
        assert lamp(kind, flip=False) == {}, kind


def test_lights_without_extent_and_smooth_glass_leave_caustics_out() -> None:
    def lit(place: float, bsdf: dict[str, Any]) -> dict[str, Finding]:
        point = {"type": "point", "position": [0, 0, place]}
        return found(scene(light=point, ball={"type": "sphere", "bsdf": bsdf}, floor={"type": "disk"}))

    assert lit(0.5, GLASS)["lights-behind-glass"].severity == "warning"
    assert lit(5.0, GLASS)["caustics-left-out"].severity == "note"
    assert lit(5.0, {"type": "conductor"})["caustics-left-out"].severity == "note"
    assert lit(5.0, {"type": "roughdielectric"}) == {}
    assert "caustics-left-out" in lit(5.0, {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.5})


def test_a_light_inside_a_glass_mesh_is_behind_glass(obj: Callable[..., dict[str, Any]]) -> None:
    def at(x: float) -> dict[str, Finding]:
        return found(scene(light={"type": "point", "position": [x, 0.1, 0.2]}, box=obj(CUBE, SIDES, bsdf=GLASS)))

    assert "lights-behind-glass" in at(0.3)
    assert "lights-behind-glass" not in at(1.3)


@pytest.mark.parametrize("kind", ["sphere", "rectangle", "disk", "cylinder", "cube"])
def test_a_lamp_inside_smooth_glass_is_noisy(kind: str, obj: Callable[..., dict[str, Any]]) -> None:
    def at(x: float, bsdf: dict[str, Any] = GLASS, camera: float = 10.0, radiance: float = 1.0) -> dict[str, Finding]:
        place = [{"scale": 0.1}, {"translate": [x, 0.1, 0.2]}]
        lamp = {"type": kind, "to_world": place, "emitter": {"type": "area", "radiance": radiance}}
        return found(scene(lamp=lamp, glass={"type": "sphere", "bsdf": bsdf}, camera=camera))

    assert at(0.3)["lamps-in-glass"].severity == "note"
    assert "lamp" in at(0.3)["lamps-in-glass"].where[0]
    for other in (
        at(1.3),  # beside the glass
        at(0.95),  # half in the glass
        at(0.3, {"type": "roughdielectric"}),
        at(0.3, {"type": "mask", "bsdf": GLASS}),
        at(0.3, {"type": "diffuse"}),
        at(0.3, camera=0.9),
        at(0.3, radiance=0.0),
    ):
        assert "lamps-in-glass" not in other
    lamp = {"type": "sphere", "radius": 0.1, "emitter": {"type": "area"}}
    assert "lamps-in-glass" in found(scene(lamp=lamp, glass=obj(CUBE, SIDES, bsdf=GLASS)))
    assert "lamps-in-glass" not in found(scene(lamp=lamp, glass=obj(CUBE, SIDES[1:], bsdf=GLASS)))


def test_a_light_inside_what_lets_nothing_out_is_enclosed(obj: Callable[..., dict[str, Any]]) -> None:
    def at(x: float, camera: float = 10.0, bsdf: str = "twosided") -> dict[str, Finding]:
        side = {"type": "diffuse"} if bsdf == "twosided" else {}
        box = obj(CUBE, SIDES, bsdf={"type": bsdf, **({"bsdf": side} if side else {})})
        return found(scene(light={"type": "point", "position": [x, 0.1, 0.2]}, box=box, camera=camera))

    assert at(0.3)["lights-enclosed"].severity == "warning"
    assert at(1.3) == {}
    assert at(0.3, camera=0.5) == {}
    assert "lights-enclosed" not in at(0.3, bsdf="thindielectric")


def test_a_camera_inside_of_what_shows_it_its_back_is_told(obj: Callable[..., dict[str, Any]]) -> None:
    inward = [[a, c, b] for a, b, c in SIDES]
    assert found(scene(box=obj(CUBE, SIDES), camera=0.5))["camera-enclosed"].severity == "warning"
    assert found(scene(ball={"type": "sphere"}, camera=0.5))["camera-enclosed"].count == 1
    assert found(scene(box=obj(CUBE, inward), camera=0.5)) == {}
    assert found(scene(box=obj(CUBE, SIDES, bsdf=GLASS), camera=0.5)) == {}
    assert found(scene(box=obj(CUBE, SIDES))) == {}


@pytest.mark.parametrize("type", ["diffuse", "roughdiffuse"])
def test_surfaces_that_reflect_everything_are_told_where_paths_have_no_limit(type: str) -> None:
    white = {"type": "sphere", "bsdf": {"type": type, "reflectance": 1.0}}
    assert found(scene(ball=white))["white-surfaces"].severity == "note"
    assert found(scene(ball=white).with_(max_depth=8)) == {}
    assert found(scene(ball={"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 0.9}})) == {}


def test_texels_beyond_what_a_factor_may_be_are_counted(tmp_path: Path) -> None:
    def textured(texel: float) -> dict[str, Finding]:
        image = np.full((4, 4, 3), 0.5, np.float32)
        image[1, 2] = texel
        path = tmp_path / f"{texel}.exr"
        write(path, image)
        texture = {"type": "bitmap", "filename": str(path)}
        return found(scene(ball={"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": texture}}))

    finding = textured(1.5)["textures-out-of-range"]
    assert (finding.severity, finding.count) == ("warning", 1)
    assert "from 0.5 to 1.5" in finding.what
    assert textured(-0.5)["textures-out-of-range"].count == 1
    assert textured(1.0) == {}


@pytest.mark.parametrize("scale", [1.0, 4.0, -1.0])
def test_values_of_a_mesh_beyond_what_a_factor_may_be_are_counted(tmp_path: Path, scale: float) -> None:
    rows = [f"{x} {y} 0 {0.25 * i} 0 0" for i, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1)))]
    names = [*(f"property float {name}" for name in ("x", "y", "z", "r", "g", "b"))]
    head = ["ply", "format ascii 1.0", "element vertex 4", *names, "element face 2"]
    text = [*head, "property list uchar int vertex_indices", "end_header", *rows, "3 0 1 2", "3 0 2 3"]
    (tmp_path / "a.ply").write_text("\n".join(text) + "\n")
    colors = {"type": "mesh_attribute", "name": "vertex_color", "scale": scale}
    bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colors}}
    subject = scene(wall={"type": "ply", "filename": str(tmp_path / "a.ply"), "bsdf": bsdf})
    told = [line for line in subject.warnings if "used as reflectance, which lies in [0, 1]" in line]
    if scale == 1.0:
        assert (found(subject), told) == ({}, [])
        return
    count = 2 if scale == 4.0 else 3
    assert found(subject)["textures-out-of-range"].count == count
    assert len(told) == 1
    assert f"a.ply: used as reflectance, which lies in [0, 1]: {count} values of vertex_color are outside" in told[0]


@pytest.mark.parametrize(("texel", "told"), [(1.5, True), (-0.5, True), (1.0, False), (0.0, False)])
def test_texels_beyond_what_a_factor_may_be_are_told_when_a_scene_is_loaded(
    tmp_path: Path, texel: float, told: bool
) -> None:
    image = np.full((4, 4, 3), 0.5, np.float32)
    image[1, 2, 0] = texel
    write(tmp_path / "a.exr", image)
    texture = {"type": "bitmap", "filename": str(tmp_path / "a.exr")}
    wall = {"type": "sphere", "bsdf": {"type": "mask", "bsdf": {"type": "diffuse", "reflectance": texture}}}
    warnings = scene(ball=wall).warnings
    least, most = sorted((0.5, texel))
    expected = f"1 texels are outside; all values range from {least:g} to {most:g}"
    assert [line for line in warnings if expected in line] == list(warnings)
    assert len(warnings) == told


def write(path: Path, image: np.ndarray[Any, np.dtype[np.float32]]) -> None:
    output = OpenImageIO.ImageOutput.create(str(path))
    output.open(str(path), OpenImageIO.ImageSpec(image.shape[1], image.shape[0], 3, "float"))
    output.write_image(image)
    output.close()


def test_what_the_readers_of_files_mended_is_a_note(obj: Callable[..., dict[str, Any]]) -> None:
    mended = found(scene(box=obj(CUBE, [*SIDES, [1, 1, 2]])))["file-remarks"]
    assert (mended.severity, mended.count) == ("note", 1)
    assert "1 degenerate face was dropped" in mended.where[0]


def test_a_quick_look_leaves_large_meshes_alone_and_raises_no_false_alarm(obj: Callable[..., dict[str, Any]]) -> None:
    side = 90
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-1, 1, side)] * 2))
    grid = np.arange(side * side).reshape(side, side) + 1
    a, b, c, d = (part.ravel() for part in (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    field = obj(np.stack([x, y, 0 * x], 1).tolist(), faces.tolist(), bsdf=GLASS)
    lamp = {"type": "rectangle", "flip_normals": True, "emitter": {"type": "area"}}
    lamp["to_world"] = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 20], [0, 0, 0, 1]]
    subject = scene(field=field, lamp=lamp)
    assert "open-dielectrics" in found(subject)
    begin = time.perf_counter()
    assert lint(subject, fast=True) == ()
    assert time.perf_counter() - begin < 0.05


@pytest.mark.parametrize("body", ["a sphere", "a cube", "a mesh"])
def test_a_camera_in_a_medium_that_it_does_not_name_is_told(obj: Callable[..., dict[str, Any]], body: str) -> None:
    fog = {"type": "homogeneous", "sigma_t": 0.5}
    filled = {"bsdf": {"type": "null"}, "interior": fog}
    shapes = {
        "a sphere": {"type": "sphere", "radius": 3.0, **filled},
        "a cube": {"type": "cube", "to_world": np.diag([3.0, 3.0, 3.0, 1.0]).tolist(), **filled},
        "a mesh": obj(moved(CUBE, size=3.0), SIDES, **filled),
    }
    volpath = {"integrator": {"type": "volpath"}, "body": shapes[body]}
    finding = found(scene(camera=2.0, **volpath))["camera-in-medium"]
    assert finding.severity == "note"
    assert "body" in finding.where[0]
    assert "camera-in-medium" not in found(scene(camera=3.5, **volpath)), "outside"
    assert "camera-in-medium" not in found(scene(camera=2.0, **{**volpath, "integrator": {"type": "path"}})), "unseen"
    named = scene(camera=2.0, **volpath).to_dict()
    named["view"]["medium"] = fog
    assert "camera-in-medium" not in found(et.load_dict(named)), "named"


def test_lights_whose_radiances_are_too_far_apart_are_told() -> None:
    def lamp(radiance: float, x: float) -> dict[str, Any]:
        return {"type": "sphere", "center": [x, 0, 0], "emitter": {"type": "area", "radiance": radiance}}

    assert "radiance-range" not in found(scene({"type": "constant", "radiance": 1.0}, one=lamp(1e-11, 0.0)))
    apart = found(scene({"type": "constant", "radiance": 1.0}, one=lamp(1e-13, 0.0), two=lamp(0.0, 5.0)))
    assert apart["radiance-range"].severity == "warning"
    assert apart["radiance-range"].count == 1
    assert "1e+13" in apart["radiance-range"].what
    points = [{"type": "point", "position": [x, 3, 0], "intensity": i} for x, i in ((0, 1.0), (1, 1e-14))]
    told = found(scene({"type": "constant", "radiance": 1e-9}, one=points[0], two=points[1]))
    assert "intensity" in told["radiance-range"].what


def test_a_sky_of_texels_too_far_apart_is_told(tmp_path: Path) -> None:
    for ratio in (1e11, 1e13):
        pixels = np.ones((4, 8, 3), dtype=np.float32)
        pixels[1, 2] = ratio
        out = OpenImageIO.ImageOutput.create(str(tmp_path / "sky.exr"))
        assert out.open(str(tmp_path / "sky.exr"), OpenImageIO.ImageSpec(8, 4, 3, "float"))
        assert out.write_image(pixels)
        out.close()
        sky = {"type": "envmap", "filename": str(tmp_path / "sky.exr")}
        assert ("radiance-range" in found(scene(sky))) == (ratio > 1e12)
