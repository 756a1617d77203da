"""Numbers that would take rays beyond what Embree takes (G23) are refused at load, and never end the process."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import equaltime as et

BALL = {"type": "sphere", "center": [0.0, 0.0, 4.0]}
FILM = {"type": "hdrfilm", "width": 4, "height": 4}
GROUP = {"type": "shapegroup", "part": {"type": "sphere"}}


def scene(sensor: dict[str, Any] | None = None, **parts: Any) -> et.Scene:
    camera = {"type": "perspective", "film": FILM} | (sensor or {})
    return et.load_dict({"type": "scene", "sensor": camera, "sky": {"type": "constant"}, "ball": BALL} | parts)


def instance(*scale: float) -> dict[str, Any]:
    to_world = [{"scale": list(scale)}, {"translate": [0.0, 0.0, 4.0]}]
    return {
        "group": GROUP,
        "copy": {"type": "instance", "shapegroup": {"type": "ref", "id": "group"}, "to_world": to_world},
    }


@pytest.mark.parametrize(
    ("sensor", "parts", "words"),
    [
        ({"near_clip": 1e20, "far_clip": 1e21}, {}, "near_clip of the sensor"),
        ({"near_clip": 1e155, "far_clip": 1e300}, {}, "near_clip of the sensor"),
        ({"type": "orthographic", "near_clip": 1e20, "far_clip": 1e21}, {}, "near_clip of the sensor"),
        ({"type": "orthographic", "to_world": [{"scale": [1, 1, 1e-308]}]}, {}, "makes its axis too short"),
        ({"type": "orthographic", "to_world": [{"scale": [1, 1, 1e-200]}]}, {}, "makes its axis too short"),
        ({}, instance(1e-38, 1e-38, 1e-38), "copy: to_world of an instance makes the group more than 10"),
        ({}, instance(1.0, 1e-25, 1.0), "copy: to_world of an instance makes the group more than 10"),
        ({}, instance(1.0, 1.0, 1.0) | {"far": {"type": "sphere", "center": [0.0, 1e30, 0.0]}}, "copy: to_world"),
    ],
)
def test_G23_what_would_take_rays_too_far_is_refused_with_its_place(  # noqa: N802
    sensor: dict[str, Any], parts: dict[str, Any], words: str
) -> None:
    with pytest.raises(et.SceneError, match=words):
        et.render(scene(sensor, **parts), spp=2, threads=1)


@pytest.mark.parametrize(
    ("sensor", "parts"),
    [
        ({"near_clip": 1e9, "far_clip": 1e10}, {}),
        ({"type": "orthographic", "to_world": [{"scale": [1, 1, 1e-9]}]}, {}),
        ({}, instance(1e-9, 1e-9, 1e-9)),
        ({}, {"far": {"type": "sphere", "center": [0.0, 1e17, 0.0]}}),
    ],
)
def test_G23_the_twin_what_is_far_but_not_too_far_is_rendered(  # noqa: N802
    sensor: dict[str, Any], parts: dict[str, Any]
) -> None:
    assert np.isfinite(et.render(scene(sensor, **parts), spp=2, threads=1).image).all()


@pytest.mark.parametrize("index", [1e-19, 1e-4, 1e12, 1.8e19])
@pytest.mark.parametrize("kind", ["dielectric", "roughdielectric", "plastic", "roughplastic"])
def test_G23_an_index_of_refraction_that_no_direction_survives_is_refused(kind: str, index: float) -> None:  # noqa: N802
    with pytest.raises(et.SceneError, match="int_ior"):
        scene(ball=BALL | {"bsdf": {"type": kind, "int_ior": index}})


@pytest.mark.parametrize("index", [1e-3, 1e3])
@pytest.mark.parametrize("kind", ["dielectric", "roughdielectric", "plastic", "roughplastic"])
def test_G23_the_largest_and_least_index_are_rendered(kind: str, index: float) -> None:  # noqa: N802
    whole = scene(ball=BALL | {"bsdf": {"type": kind, "int_ior": index, "ext_ior": 1 / index}})
    assert np.isfinite(et.render(whole, spp=8, threads=1).image).all()
