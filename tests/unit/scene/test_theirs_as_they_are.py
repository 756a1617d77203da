"""What Mitsuba 3 loads although a number in it makes little sense, or something is missing: read as it means there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import SceneError
from equaltime.scene import model

CAMERA = {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 8}}
SKY = {"type": "constant"}
HALF = {"type": "diffuse"}


def read(**parts: Any) -> et.Scene:
    return et.load_dict({"type": "scene", "sensor": CAMERA, **parts})


def test_a_scene_without_a_sensor_is_seen_from_before_it() -> None:
    loaded = et.load_dict({"type": "scene", "ball": {"type": "sphere", "center": [5, 1, 2], "radius": 3}, "sky": SKY})
    sensor = loaded.model.sensor
    assert isinstance(sensor, model.Perspective)
    assert sensor.fov == 45.0
    distance = 3.0 / np.tan(np.radians(22.5))
    assert np.allclose(sensor.to_world, [[1, 0, 0, 5], [0, 1, 0, 1], [0, 0, 1, -1 - distance], [0, 0, 0, 1]])
    assert loaded.size == (768, 576)
    assert loaded.warnings == ("the scene has no sensor: a camera that sees the whole scene is added",)


def test_it_has_instances_and_meshes_of_files_in_view(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 4 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "s.xml").write_text(
        '<scene version="3.0.0"><shape type="obj"><string name="filename" value="m.obj"/></shape>'
        '<shape type="shapegroup" id="g"><shape type="disk"/></shape><shape type="instance"><ref id="g"/>'
        '<transform name="to_world"><translate x="-4" z="-3"/></transform></shape></scene>'
    )
    sensor = et.load(tmp_path / "s.xml").model.sensor
    assert isinstance(sensor, model.Perspective)
    distance = 4.5 / np.tan(np.radians(22.5))
    assert np.allclose(np.array(sensor.to_world)[:3, 3], [-0.5, 0.0, -3.0 - distance])


def test_it_sees_what_moves_where_that_is_at_its_time() -> None:
    keys = [{"time": t, "transform": [{"translate": [10 * t, 0, 0]}]} for t in (-10, 10)]
    moving = {"type": "cube", "to_world": {"animation": keys}}
    assert seen_from(ball=moving) == seen_from(ball={"type": "cube"})
    group = {"type": "shapegroup", "id": "g", "a": {"type": "cube"}}
    copy = {"type": "instance", "shapegroup": {"type": "ref", "id": "g"}, "to_world": {"animation": keys}}
    assert seen_from(group=group, copy=copy) == seen_from(ball={"type": "cube"})


def seen_from(**parts: Any) -> list[float]:
    """Return where the camera is that a scene without one gets."""
    sensor = et.load_dict({"type": "scene", "sky": SKY, **parts}).model.sensor
    assert isinstance(sensor, model.Perspective)
    return [float(row[3]) for row in np.array(sensor.to_world)[:3]]


def test_a_shape_that_is_refused_is_all_that_is_wrong() -> None:
    with pytest.raises(SceneError) as refused:
        et.load_dict({"type": "scene", "sky": SKY, "hair": {"type": "bsplinecurve"}})
    assert "bsplinecurve" in str(refused.value)
    assert "sensor" not in str(refused.value)


def test_a_scene_of_nothing_is_still_refused() -> None:
    with pytest.raises(SceneError, match="the scene has no sensor; expected one of type 'perspective'"):
        et.load_dict({"type": "scene", "sky": SKY})


@pytest.mark.parametrize("kind", ["path", "volpath"])
@pytest.mark.filterwarnings("ignore:the picture is black")
def test_paths_of_no_segment_see_nothing(kind: str) -> None:
    lamp = {"type": "rectangle", "to_world": [{"translate": [0, 0, 3]}], "emitter": {"type": "area"}}
    loaded = read(integrator={"type": kind, "max_depth": 0}, sky=SKY, lamp=lamp)
    assert loaded.warnings == ("integrator.max_depth: a max_depth of 0 sees nothing: the image is black",)
    assert not et.render(loaded, spp=4).image.any()
    assert et.render(loaded.with_(max_depth=1), spp=4).image.any()


@pytest.mark.parametrize(("given", "cut"), [(-0.5, 0.0), (1.5, 1.0)])
def test_weights_and_opacities_are_cut(given: float, cut: float) -> None:
    mask = {"type": "mask", "opacity": given, "bsdf": HALF}
    blend = {"type": "blendbsdf", "weight": given, "bsdf": [HALF, {"type": "null"}]}
    loaded = read(a={"type": "sphere", "bsdf": mask}, b={"type": "sphere", "bsdf": blend})
    first, second = (shape.bsdf for shape in loaded.model.shapes if isinstance(shape, model.Sphere))
    assert isinstance(first, model.Mask)
    assert isinstance(second, model.BlendBsdf)
    assert (first.opacity, second.weight) == (cut, cut)
    assert loaded.warnings == (
        f"a.bsdf.opacity: opacity is cut to {cut:g}, as in Mitsuba, from {given:g}",
        f"b.bsdf.weight: weight is cut to {cut:g}, as in Mitsuba, from {given:g}",
    )


def test_constant_spectra_are_cut_too() -> None:
    spectrum = {"type": "spectrum", "value": 1.5}
    loaded = read(a={"type": "sphere", "bsdf": {"type": "mask", "opacity": spectrum, "bsdf": HALF}})
    assert loaded.warnings == ("a.bsdf.opacity: opacity is cut to 1, as in Mitsuba, from 1.5",)


def test_colours_for_them_are_not_as_mitsuba_refuses_them_too() -> None:
    with pytest.raises(SceneError, match=r"must lie in \[0, 1\]"):
        read(a={"type": "sphere", "bsdf": {"type": "mask", "opacity": [1.5, 1.5, 1.5], "bsdf": HALF}})


def test_an_attribute_of_a_shape_that_nothing_looks_at_is_passed_over() -> None:
    """Mitsuba takes every texture there for an attribute, but mesh_attribute looks up names of vertices and faces."""
    squares = {"type": "checkerboard"}
    loaded = read(a={"type": "sphere", "vertex_color": squares})
    assert loaded.warnings == ("a.vertex_color: the texture 'checkerboard' of the shape has no effect: ignored",)
    assert loaded.model.shapes == read(a={"type": "sphere"}).model.shapes
    looking = {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "vertex_color"}}
    with pytest.raises(SceneError, match="'sphere' cannot contain a texture"):
        read(a={"type": "sphere", "vertex_color": squares, "bsdf": looking})
    with pytest.raises(SceneError, match="'sphere' cannot contain a texture"):
        read(a={"type": "sphere", "reflectance": squares})


def test_a_beam_beyond_its_cone_fills_it() -> None:
    loaded = read(a={"type": "spot", "cutoff_angle": 20, "beam_width": 30})
    (spot,) = loaded.model.emitters
    assert isinstance(spot, model.Spot)
    assert spot.beam == 20.0
    said = "a.beam_width: beam_width is larger than cutoff_angle: the intensity is constant in the cone"
    assert loaded.warnings == (said,)
