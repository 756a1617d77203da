"""A scene that equaltime has read and hands to Mitsuba is, for Mitsuba, the scene that was there in the first place."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene.export import PlainWriter
from equaltime.scene.export.plain import mitsuba_dict, with_transforms

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.usefixtures("scalar_mitsuba")

from .feature_scenes import SCENES  # noqa: E402

XML = Path(__file__).parents[2] / "scenes" / "mitsuba"
TOLERANCE = 1e-5
"""For what single precision makes of the same matrix by another way."""
OTHER_ORDER = ("many lights of unlike power", "hidden emitters")
"""Their lights stand in another order in the model, so that the same numbers choose others."""


def as_mitsuba(scene: et.Scene) -> Any:
    plain = json.loads(json.dumps(mitsuba_dict(scene.model, scene.assets)))
    integrator = PlainWriter(str).node(scene.model.integrator)
    return mi.load_dict(with_transforms(plain, mi.ScalarTransform4f) | {"integrator": integrator})


def image(scene: Any) -> NDArray[np.float64]:
    return np.array(mi.render(scene, seed=1, spp=4), dtype=np.float64)


def difference(ours: et.Scene, theirs: Callable[[], Any]) -> float:
    """Return the mean difference of both images, of the same random numbers, over the mean radiance.

    Mitsuba leaves the order of its lights to chance, and so which of them a random number chooses: until two loaded
    scenes have the same order, they are loaded again.
    """
    least = math.inf
    for _ in range(20):
        first, second = image(as_mitsuba(ours)), image(theirs())
        least = min(least, float(np.abs(first - second).mean() / max(second.mean(), 1e-9)))
        if least < TOLERANCE:
            break
    return least


@pytest.mark.parametrize("name", [name for name in SCENES if name not in OTHER_ORDER])
def test_mitsuba_sees_the_same_scene_as_in_the_dictionary(name: str, tmp_path: Path) -> None:
    description = SCENES[name](tmp_path)
    assert difference(et.load_dict(description), lambda: mi.load_dict(description)) < TOLERANCE


@pytest.mark.parametrize("name", ["cornell-box", "veach-mis"])
def test_mitsuba_sees_the_same_scene_as_in_the_file(name: str) -> None:
    path, defines = XML / name / "scene.xml", {"integrator": "path", "resx": 32, "resy": 24}
    assert difference(et.load(path, **defines), lambda: mi.load_file(str(path), **defines)) < TOLERANCE


@pytest.mark.parametrize("name", [name for name in SCENES if name not in OTHER_ORDER])
def test_mitsuba_reads_the_xml_that_is_written(name: str, tmp_path: Path) -> None:
    scene = et.load_dict(SCENES[name](tmp_path))
    scene.write(tmp_path / "written.xml")
    assert difference(scene, lambda: mi.load_file(str(tmp_path / "written.xml"))) < TOLERANCE


@pytest.mark.parametrize("name", ["cornell-box", "veach-mis"])
def test_mitsuba_sees_the_same_scene_in_a_file_that_was_read_and_written(name: str, tmp_path: Path) -> None:
    path, defines = XML / name / "scene.xml", {"integrator": "path", "resx": 32, "resy": 24}
    scene = et.load(path, **defines)
    scene.write(tmp_path / "written.xml")
    assert difference(scene, lambda: mi.load_file(str(tmp_path / "written.xml"))) < TOLERANCE


def test_a_slightly_darker_lamp_would_be_seen() -> None:
    """The power twin: a part in a thousand of one colour of one light is far more than what is allowed."""
    description = SCENES["a mirror"](Path())
    darker = SCENES["a mirror"](Path())
    lamp = next(part for part in darker.values() if isinstance(part, dict) and part.get("type") == "sphere")
    lamp["emitter"]["radiance"]["value"][0] *= 0.999
    assert difference(et.load_dict(description), lambda: mi.load_dict(darker)) > TOLERANCE


def test_equal_materials_are_written_once() -> None:
    wall = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.3}}
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "one": wall, "other": wall})
    written = mitsuba_dict(scene.model, scene.assets)
    assert [node["type"] for node in written.values() if isinstance(node, dict)].count("diffuse") == 1
