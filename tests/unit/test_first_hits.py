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
    with pytest.raises(et.SceneError, match="integrator: the output 'albedo' of 'aov' is not supported yet"):
        outputs({"type": "aov", "aovs": "c:albedo"})


def test_mitsuba_sees_the_same_distances() -> None:
    mi = pytest.importorskip("mitsuba")
    chosen = mi.variant()
    mi.set_variant("scalar_rgb")
    try:
        loaded = scene({"type": "aov", "aovs": "a:depth"}, near_clip=0.5)
        plain = et.scene.export.with_transforms(loaded.to_dict(), mi.ScalarTransform4f)
        theirs = np.array(mi.render(mi.load_dict(plain), spp=256))[..., -1]
    finally:
        if chosen:
            mi.set_variant(chosen)
    ours = et.render(loaded, spp=1).aovs["a.T"]
    assert ours[2:4, 3:5] == pytest.approx(theirs[2:4, 3:5], rel=2e-3)  # noise of the places on a slanted distance
