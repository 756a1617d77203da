"""Every number of a scene, replaced by ones that nobody means (FUZZ, G9): it is refused with its place, or rendered."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
import pytest

import equaltime as et
from equaltime import _core

from ..statistical.worlds import build

Place = tuple[str | int, ...]

NO_NUMBERS: Final = (math.nan, math.inf, -math.inf)
EXTREME: Final = (0.0, -0.0, 1e-40, -1e-40, 1e-38, 1e38, -1e38, 1e300)
WHOLE: Final = (-1, 0, 2**31, 2**63)
VIEW: Final = {"look_at": {"origin": [0.5, -4.0, 2.0], "target": [0.1, 0.2, 0.3], "up": [0.0, 0.0, 1.0]}}
FILM: Final = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "gaussian", "stddev": 0.5}}
CAMERA: Final[dict[str, Any]] = {
    "type": "thinlens",
    "fov": 40.0,
    "near_clip": 0.1,
    "far_clip": 100.0,
    "aperture_radius": 0.01,
    "focus_distance": 4.0,
    "to_world": [VIEW],
    "film": FILM,
}
COLOUR: Final = {"type": "rgb", "value": [0.2, 0.5, 0.8]}
PARTS: Final[dict[str, dict[str, Any]]] = {
    "camera": {"ball": {"type": "sphere", "center": [0.1, 0.2, 0.3], "radius": 0.5}, "sky": {"type": "constant"}},
    "shapes": {
        "tube": {"type": "cylinder", "p0": [0.0, 0.0, -1.0], "p1": [0.0, 0.5, 1.0], "radius": 0.3},
        "floor": {"type": "rectangle", "to_world": [{"rotate": {"axis": [1.0, 2.0, 3.0], "angle": 40.0}}]},
        "disk": {"type": "disk", "to_world": [{"scale": [0.5, 2.0, 1.0]}, {"translate": [1.0, 0.0, 0.5]}]},
        "sun": {"type": "directional", "direction": [0.5, 0.1, -1.0], "irradiance": 2.0},
    },
    "lights": {
        "floor": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": COLOUR}},
        "lamp": {"type": "sphere", "center": [0.0, 0.0, 2.0], "emitter": {"type": "area", "radiance": COLOUR}},
        "point": {"type": "point", "position": [1.0, 1.0, 1.0], "intensity": COLOUR},
        "spot": {"type": "spot", "cutoff_angle": 30.0, "beam_width": 20.0, "intensity": 4.0, "to_world": [VIEW]},
        "sky": {"type": "constant", "radiance": 0.5},
    },
    "materials": {
        "glass": {"type": "sphere", "bsdf": {"type": "roughdielectric", "alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0}},
        "metal": {"type": "rectangle", "bsdf": {"type": "roughconductor", "alpha": 0.2, "eta": 0.2, "k": 3.0}},
        "paint": {
            "type": "disk",
            "bsdf": {"type": "principled", "base_color": COLOUR, "roughness": 0.3, "metallic": 0.2, "clearcoat": 0.5},
        },
        "lacquer": {
            "type": "cylinder",
            "bsdf": {
                "type": "blendbsdf",
                "weight": 0.4,
                "a": {"type": "diffuse"},
                "b": {"type": "plastic", "int_ior": 1.4},
            },
        },
        "sky": {"type": "constant"},
    },
    "media": {
        "fog": {
            "type": "sphere",
            "bsdf": {"type": "null"},
            "interior": {
                "type": "homogeneous",
                "sigma_t": 2.0,
                "albedo": 0.8,
                "phase": {"type": "hg", "g": 0.3},
            },
        },
        "sky": {"type": "constant"},
    },
}


def scene_of(part: str) -> dict[str, Any]:
    return {"type": "scene", "integrator": {"type": "path", "max_depth": 6}, "sensor": CAMERA, **PARTS[part]}


def numbers(tree: Any, place: Place = ()) -> Iterator[tuple[Place, float]]:
    """Yield where numbers stand, and which."""
    if isinstance(tree, dict):
        for name, value in tree.items():
            yield from numbers(value, (*place, name))
    elif isinstance(tree, list):
        for index, value in enumerate(tree):
            yield from numbers(value, (*place, index))
    elif isinstance(tree, int | float):
        yield place, tree


def changed(tree: dict[str, Any], place: Place, number: float) -> dict[str, Any]:
    """Return the scene with one number replaced."""
    tree = copy.deepcopy(tree)
    inner: Any = tree
    for step in place[:-1]:
        inner = inner[step]
    inner[place[-1]] = number
    return tree


def rendered(tree: dict[str, Any]) -> bool:
    """Return whether the scene is rendered; not refused, nor ended with a sample or a pixel that no file can hold."""
    try:
        image = et.render(et.load_dict(tree), spp=2, threads=1).image
    except (et.SceneError, et.NonFiniteSample):
        return False
    except et.RenderError as error:
        if "more than an image of float32 can hold" not in str(error):
            raise
        return False
    assert np.isfinite(image).all()
    return True


@pytest.mark.parametrize("part", PARTS)
def test_G09_what_is_no_number_is_refused_anywhere(part: str) -> None:  # noqa: N802
    tree = scene_of(part)
    assert rendered(tree), "the twin: the scene itself is not"
    places = [place for place, _ in numbers(tree)]
    taken = [(place, bad) for place in places for bad in NO_NUMBERS if rendered(changed(tree, place, bad))]
    assert len(places) > 15
    assert taken == []


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.filterwarnings("ignore:the picture is black")
def test_G09_extreme_numbers_are_refused_or_rendered_without_a_nan(part: str) -> None:  # noqa: N802
    tree, took = scene_of(part), 0
    for place, number in numbers(tree):
        for extreme in WHOLE if isinstance(number, int) else EXTREME:
            took += rendered(changed(tree, place, extreme))
    assert took > 30


@pytest.mark.parametrize("index", [-1, 3, 2**31, 2**32 - 1])
def test_G09_a_face_of_vertices_that_are_not_there_is_refused(index: int) -> None:  # noqa: N802
    def corners(*last: int) -> _core.Scene:
        return build(lambda b: b.add_mesh(np.eye(3), [[0, 1, *last]], front=None, back=None, radiance=None))

    assert corners(2).triangles == 1
    with pytest.raises((ValueError, TypeError, OverflowError)):
        corners(index)
