"""Numbers that make little sense, and that Mitsuba 3 takes nevertheless: images without noise of theirs and ours."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import equaltime as et

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.usefixtures("scalar_mitsuba")

FLOAT = 1e-5


def scene(bsdf: dict[str, Any], depth: int) -> dict[str, Any]:
    """Return a sheet before a wall, in sunlight from the camera: what is seen of either depends on no random number."""
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    behind = mi.ScalarTransform4f().translate([0, 0, 5]).scale(9.0) @ turned
    return {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": depth},
        "sensor": {"type": "orthographic", "film": film},
        "sheet": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f().translate([0, 0, 2]).scale(3.0) @ turned,
            "bsdf": bsdf,
        },
        "wall": {"type": "rectangle", "to_world": behind, "bsdf": paint(0.5)},
        "sun": {"type": "directional", "direction": [0, 0, 1], "irradiance": 3.0},
    }


def paint(reflectance: float) -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": reflectance}


def mean(image: Any) -> float:
    found = np.asarray(image, dtype=np.float64)
    assert np.ptp(found) <= FLOAT * found.max()
    return float(found.mean())


@pytest.mark.parametrize(
    ("bsdf", "twin"),
    [
        ({"type": "mask", "opacity": 1.5, "bsdf": paint(0.25)}, {"type": "mask", "opacity": 0.0, "bsdf": paint(0.25)}),
        ({"type": "mask", "opacity": -0.5, "bsdf": paint(0.25)}, paint(0.25)),
        ({"type": "blendbsdf", "weight": 1.5, "a": paint(0.25), "b": paint(0.75)}, paint(0.25)),
        ({"type": "blendbsdf", "weight": -0.5, "a": paint(0.25), "b": paint(0.75)}, paint(0.75)),
    ],
)
def test_weights_beyond_their_range_are_those_at_its_ends(bsdf: dict[str, Any], twin: dict[str, Any]) -> None:
    theirs = mean(mi.render(mi.load_dict(scene(bsdf, 2)), spp=16))
    assert mean(et.render(et.load_dict(scene(bsdf, 2)), spp=16).image) == pytest.approx(theirs, rel=FLOAT)
    assert mean(et.render(et.load_dict(scene(twin, 2)), spp=16).image) != pytest.approx(theirs, rel=0.1)


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_paths_of_no_segment_are_black() -> None:
    assert mean(mi.render(mi.load_dict(scene(paint(0.5), 0)), spp=4)) == 0.0
    assert mean(et.render(et.load_dict(scene(paint(0.5), 0)), spp=4).image) == 0.0
