"""Outputs beside the image: what the integrators ``aov`` and ``depth`` ask for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

import equaltime as et

AOVS = "distance:depth, where:position, n:geo_normal, s:shape_index, p:prim_index"


def scene(integrator: dict[str, Any], **sensor: Any) -> et.Scene:
    film = {"type": "hdrfilm", "width": 8, "height": 6, "rfilter": {"type": "box"}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": integrator,
            "sensor": {"type": "perspective", "fov": 60.0, "film": film} | sensor,
            "lamp": {"type": "constant"},
            "far": {"type": "rectangle", "to_world": [{"scale": 0.8}, {"translate": [0, 0, 4]}]},
            "near": {"type": "cube", "to_world": [{"scale": [0.4, 9, 1]}, {"translate": [-1.2, 0, 4]}]},
        }
    )


def outputs(integrator: dict[str, Any], **sensor: Any) -> dict[str, Any]:
    return dict(et.render(scene(integrator, **sensor), spp=1).aovs)


def test_what_is_asked_for_is_there_and_nothing_else() -> None:
    assert outputs({"type": "path"}) == {}
    triples = [f"{name}.{letter}" for name in ("where", "n") for letter in "XYZ"]
    assert list(outputs({"type": "aov", "aovs": AOVS, "path": {"type": "path"}})) == [
        "distance.T",
        *triples,
        "s.I",
        "p.I",
    ]
    assert list(outputs({"type": "depth"})) == ["depth.T"]


def test_a_wall_is_as_far_as_it_stands() -> None:
    found = outputs({"type": "aov", "aovs": AOVS})
    tangents = np.tan(np.radians(30)) * (1 - 2 * (np.arange(16) + 0.5) / 16)  # of both points of each pixel
    x, y = np.meshgrid(tangents, tangents[2:14])
    expected = (4 * np.sqrt(1 + x**2 + y**2)).reshape(6, 2, 8, 2).mean(axis=(1, 3))
    assert found["distance.T"][2:4, 3:5] == pytest.approx(expected[2:4, 3:5], rel=1e-6)
    assert (found["where.Z"][2:4, 3:5] == 4).all()
    assert (found["s.I"][2:4, 3:5] == 0).all()
    assert (np.abs(found["n.Z"][2:4, 3:5]) == 1).all()
    assert (found["distance.T"][0, :4] == 0).all(), "there is nothing to see"
    assert set(np.unique(found["s.I"][2:4, 6:])) <= {0.0, 0.25, 0.5, 0.75, 1.0}


def test_the_outputs_of_a_crop_are_those_of_the_whole() -> None:
    integrator = {"type": "aov", "aovs": AOVS}
    whole = scene(integrator)
    part = et.render(whole.with_(crop=(2, 1, 4, 3)), spp=1).aovs
    for name, plane in et.render(whole, spp=1).aovs.items():
        assert np.array_equal(part[name], plane[1:4, 2:6])


def test_clips_hide_what_is_beyond_them() -> None:
    assert (outputs({"type": "depth"}, near_clip=3.5)["depth.T"][2:4, 3:5] < 0.7).all()
    assert (outputs({"type": "depth"}, far_clip=3.5)["depth.T"][2:4, 3:5] == 0).all()


def test_parallel_rays_have_equal_depths() -> None:
    film = {"type": "hdrfilm", "width": 8, "height": 8}
    wall = {"type": "rectangle", "to_world": [{"scale": 9}, {"translate": [0, 0, 4]}]}
    camera = {"type": "orthographic", "near_clip": 1.0, "film": film}
    description = {"type": "scene", "integrator": {"type": "depth"}, "sensor": camera, "wall": wall}
    assert et.render(description, spp=1).aovs["depth.T"] == pytest.approx(np.full((8, 8), 3.0), rel=1e-6)


def test_they_are_in_the_file(tmp_path: Path) -> None:
    result = et.render(scene({"type": "aov", "aovs": "a:depth"}), spp=2)
    result.save(tmp_path / "out.exr")
    source = OpenImageIO.ImageInput.open(str(tmp_path / "out.exr"))
    parts = {}
    while source.seek_subimage(len(parts), 0):
        spec = source.spec()
        parts[spec.getattribute("oiio:subimagename")] = source.read_image(len(parts), 0, 0, spec.nchannels, "float")
    assert np.array_equal(parts["aovs"][..., 0], result.aovs["a.T"])


def test_what_cannot_be_written_is_refused_by_name() -> None:
    with pytest.raises(et.SceneError, match=r"'dp_dw' cannot be written beside the image; did you mean 'dp_d[uv]'"):
        outputs({"type": "aov", "aovs": "c:dp_dw"})


def test_a_wall_moves_with_its_texture_coordinates_and_they_from_pixel_to_pixel() -> None:
    """The far wall, four units away, is 1.6 wide; a pixel is 4 tan(30°) · 2 / 8 wide there, and x runs to the left."""
    found = outputs({"type": "aov", "aovs": "u:dp_du, v:dp_dv, x:duv_dx, y:duv_dy"})
    middle = {name: plane[2:4, 3:5] for name, plane in found.items()}
    pixel = 4 * np.tan(np.radians(30)) / 4 / 1.6
    expected = {"u.X": 1.6, "v.Y": 1.6, "x.U": -pixel, "y.V": -pixel}
    assert len(middle) == 10
    for name, plane in middle.items():
        assert plane == pytest.approx(np.full((2, 2), expected.get(name, 0.0)), abs=1e-6), name


LEAVES = {
    "diffuse": ({"type": "diffuse", "reflectance": 0.3}, 0.3),
    "two sides": ({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 0.3}}, 0.3),
    "rough diffuse": ({"type": "roughdiffuse", "reflectance": 0.3}, 0.3),
    "plastic": ({"type": "plastic", "diffuse_reflectance": 0.3}, 0.3),
    "rough plastic": ({"type": "roughplastic", "diffuse_reflectance": 0.3}, 0.3),
    "polarised plastic": ({"type": "pplastic", "diffuse_reflectance": 0.3}, 0.3),
    "principled": ({"type": "principled", "base_color": 0.3, "metallic": 0.5}, 0.3),
    "a mirror": ({"type": "conductor"}, 1.0),
    "a grey mirror": ({"type": "conductor", "specular_reflectance": 0.3}, 0.3),
    "a rough mirror": ({"type": "roughconductor", "alpha": 0.02, "specular_reflectance": 0.3}, 0.3),
    "glass": ({"type": "dielectric"}, 1.0),
    "rough glass": ({"type": "roughdielectric", "alpha": 0.1}, 1.0),
    "a sheet of glass": ({"type": "thindielectric"}, 1.0),
    "a mask": ({"type": "mask", "opacity": 0.2, "bsdf": {"type": "diffuse", "reflectance": 0.3}}, 0.3),
    "nothing": ({"type": "null"}, 0.0),
}


@pytest.mark.parametrize("name", LEAVES)
def test_the_albedo_is_the_colour_of_the_diffuse_part_or_what_is_sent_on_in_all(name: str) -> None:
    bsdf, expected = LEAVES[name]
    wall = {"type": "rectangle", "to_world": [{"look_at": {"origin": [0, 0, 4], "target": [0, 0, 0]}}], "bsdf": bsdf}
    view = {"type": "perspective", "fov": 10.0, "film": {"type": "hdrfilm", "width": 4, "height": 4}}
    integrator = {"type": "aov", "aovs": "a:albedo"}
    found = et.render({"type": "scene", "integrator": integrator, "sensor": view, "wall": wall}, spp=1).aovs
    assert [found[f"a.{c}"][1, 1] for c in "RGB"] == pytest.approx([expected] * 3)


SHINY = {
    "a metal": {"type": "roughconductor", "material": "Au", "alpha": 0.02},
    "a rough metal": {"type": "roughconductor", "alpha": 0.8},
    "rough glass": {"type": "roughdielectric", "alpha": 0.02, "int_ior": 2.0},
    "rough glass from inside": {"type": "roughdielectric", "alpha": 0.3, "int_ior": 1.0, "ext_ior": 1.5},
    "rough plastic": {"type": "roughplastic", "alpha": 0.02, "diffuse_reflectance": 1.0},
    "principled": {"type": "principled", "base_color": 1.0, "metallic": 1.0, "roughness": 0.1, "clearcoat": 1.0},
}


@pytest.mark.parametrize("name", SHINY)
def test_no_albedo_is_above_1_anywhere_on_a_ball(name: str) -> None:
    film = {"type": "hdrfilm", "width": 16, "height": 16}
    view = {"type": "perspective", "fov": 40.0, "film": film, "to_world": [{"translate": [0, 0, -3.5]}]}
    ball = {"type": "sphere", "bsdf": SHINY[name]}
    integrator = {"type": "aov", "aovs": "a:albedo"}
    found = et.render({"type": "scene", "integrator": integrator, "sensor": view, "ball": ball}, spp=1).aovs
    colors = np.stack([found[f"a.{c}"] for c in "RGB"])
    assert colors.max() <= 1.0
    assert colors[:, 4:12, 4:12].min() > 0.2


def leaning(path: Path) -> Path:
    """Write two triangles whose normals and texture coordinates vary."""
    corners = [(-2, -2, 5), (2, -2, 5), (2, 2, 5), (-2, 2, 5)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"vt {0.1 * x} {0.2 * y}" for x, y, _ in corners] + [f"vn {0.3 * x} {0.1 * y} -1" for x, y, _ in corners]
    path.write_text("\n".join([*lines, "f 3/3/3 2/2/2 1/1/1", "f 4/4/4 3/3/3 1/1/1"]) + "\n")
    return path


def test_mitsuba_sees_the_same(tmp_path: Path) -> None:
    """The same distances, normals, texture coordinates and colours, but for the noise of its places on a pixel."""
    mi = pytest.importorskip("mitsuba")
    chosen = mi.variant()
    mi.set_variant("scalar_rgb")
    try:
        aovs = "a:depth, b:albedo, c:uv, d:geo_normal, e:sh_normal, f:position, g:dp_du, h:dp_dv, i:duv_dx, j:duv_dy"
        integrator = {"type": "aov", "aovs": aovs}
        board = {"type": "checkerboard", "to_uv": {"scale": 3}, "color0": 0.2, "color1": 0.7}
        whole = scene(integrator, near_clip=0.5).to_dict() | {
            "mesh": {"type": "obj", "filename": str(leaning(tmp_path / "mesh.obj"))},
            "ball": {"type": "sphere", "center": [1, -0.5, 3], "radius": 0.6, "flip_normals": True},
        }
        whole["far"]["bsdf"] = {"type": "diffuse", "reflectance": board}
        loaded = et.load_dict(whole).with_(size=(32, 24))
        plain = et.scene.export.with_transforms(loaded.to_dict(), mi.ScalarTransform4f)
        instance = mi.load_dict(plain)
        theirs = np.array(mi.render(instance, spp=256))
        names = instance.integrator().aov_names()
    finally:
        if chosen:
            mi.set_variant(chosen)
    ours = et.render(loaded, spp=1).aovs
    assert [*ours] == names[-len(ours) :]
    for channel, (name, plane) in enumerate(ours.items()):
        scale = 16.0 if name[0] in "ij" else 1.0  # Mitsuba's are of a part of a pixel, one over the root of its samples
        difference = np.nan_to_num(
            np.abs(plane - scale * theirs[..., channel - len(ours)])
        )  # it has none where nothing is
        smooth = difference < 0.02 * max(1.0, float(np.abs(plane).max()))
        assert smooth.mean() > 0.5, name  # the other pixels are on an edge, where four points see it coarsely
        assert np.median(difference) < 5e-3, name
