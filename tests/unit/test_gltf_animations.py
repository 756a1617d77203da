"""Animations of glTF files, played while a shutter is open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.model import Animation
from equaltime.scene.motion import pose

from .gltf_files import Builder, one_triangle

HALF = float(np.sqrt(0.5))


def animated(path: str, times: list[float], values: list[list[float]], kind: str = "LINEAR") -> Builder:
    """Return a triangle in a node at (0, 0, 5), itself inside a node that is animated."""
    builder = one_triangle()
    outer = builder.node(children=[0])
    builder.json["nodes"][0]["translation"] = [0, 0, 5]
    builder.json["scenes"] = [{"nodes": [outer]}]
    time, value = builder.accessor(times), builder.accessor(values)
    channel = {"sampler": 0, "target": {"node": outer, "path": path}}
    sampler = {"input": time, "output": value, "interpolation": kind}
    builder.json["animations"] = [{"name": "spin", "channels": [channel], "samplers": [sampler]}]
    return builder


def placement(builder: Builder, folder: Path, **defines: Any) -> Any:
    return et.load(builder.gltf(folder / "a.gltf"), **defines).model.shapes[0].to_world


def test_without_a_shutter_everything_stands_as_in_the_file(tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    loaded = et.load(builder.gltf(tmp_path / "a.gltf"))
    assert not isinstance(loaded.model.shapes[0].to_world, Animation)
    assert any("-D shutter=0,0.02 opens a shutter" in warning for warning in loaded.warnings)


@pytest.mark.parametrize("shutter", [(0.25, 0.75), "0.25,0.75"], ids=["numbers", "as on the command line"])
def test_a_translation_moves_what_is_in_the_node(shutter: Any, tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    moving = placement(builder, tmp_path, shutter=shutter)
    assert moving.times[0] == 0.25
    assert moving.times[-1] == 0.75
    np.testing.assert_allclose(pose(moving, 0.5)[:3, 3], [2, 0, 5])
    sensor = et.load(tmp_path / "a.gltf", shutter=shutter).model.sensor
    assert (sensor.shutter_open, sensor.shutter_close) == (0.25, 0.75)


def test_a_rotation_turns_what_is_in_the_node_along_an_arc(tmp_path: Path) -> None:
    builder = animated("rotation", [0, 1], [[0, 0, 0, 1], [0, HALF, 0, HALF]])
    moving = placement(builder, tmp_path, shutter=(0, 1))
    for time in (0.0, 0.25, 0.4, 1.0):
        angle = 0.5 * np.pi * time
        expected = [5 * np.sin(angle), 0, 5 * np.cos(angle)]
        np.testing.assert_allclose(pose(moving, time)[:3, 3], expected, atol=0.01)


def test_steps_hold_and_splines_bend(tmp_path: Path) -> None:
    stepped = placement(animated("scale", [0, 0.5], [[1, 1, 1], [2, 2, 2]], "STEP"), tmp_path, shutter=(0, 1))
    assert pose(stepped, 0.4999)[0, 0] == pytest.approx(1)
    assert pose(stepped, 0.5001)[0, 0] == pytest.approx(2)
    flat = [[0.0, 0, 0], [1, 0, 0], [0, 0, 0]]
    values = [[0.0, 0, 0], [0, 0, 0], [0, 0, 0], *flat]
    bent = placement(animated("translation", [0, 1], values, "CUBICSPLINE"), tmp_path, shutter=(0, 1))
    assert pose(bent, 0.25)[0, 3] == pytest.approx(3 * 0.25**2 - 2 * 0.25**3, abs=1e-3)


@pytest.mark.parametrize(
    ("defines", "message"),
    [
        ({"shutter": "soon"}, "'shutter' must be two times in seconds, such as 0.5,0.54, found 'soon'"),
        ({"shutter": (1, 0)}, "'shutter' must be two times in seconds"),
        ({"shutter": (0, 1), "animation": "spun"}, "the file has no animation 'spun'; did you mean 'spin'"),
    ],
)
def test_what_is_no_shutter_is_told(defines: dict[str, Any], message: str, tmp_path: Path) -> None:
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    with pytest.raises(et.SceneError) as error:
        placement(builder, tmp_path, **defines)
    assert message in str(error.value)


def test_times_that_do_not_increase_are_told(tmp_path: Path) -> None:
    builder = animated("translation", [1, 1], [[0, 0, 0], [4, 0, 0]])
    with pytest.raises(et.SceneError, match=r"animations\[0\].channels\[0\]: the times of an animation must increase"):
        placement(builder, tmp_path, shutter=(0, 1))
