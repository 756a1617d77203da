"""What moves: how it is written, where it is at a time, what calls for it, and what does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime.pricing import derive, leave_out
from equaltime.scene import motion, transforms
from equaltime.scene.model import Animation

from ...invariants.shipped import same_bits

Array = NDArray[np.float64]

VIEW = {"look_at": {"origin": [0, -4, 1.5], "target": [0, 0, 0.5], "up": [0, 0, 1]}}
TURNED = [{"rotate": {"axis": [1, 2, 3], "angle": 100}}, {"scale": [0.5, 0.25, 0.5]}, {"translate": [0.5, 0.25, 0.75]}]
KEYS: list[dict[str, Any]] = [
    {"time": 0, "transform": [{"scale": 0.25}, {"translate": [-0.75, 0, 0.5]}]},
    {"time": 0.25, "transform": TURNED},
    {"time": 1, "transform": [{"scale": 0.5}, {"translate": [0.75, 0, 0.5]}]},
]
ROUND: list[dict[str, Any]] = [
    {"time": -1, "transform": [{"scale": 0.25}, {"translate": [-1, 0.5, 1]}]},
    {"time": 0.75, "transform": [{"scale": 0.5}, {"rotate": {"axis": [0, 0, 1], "angle": 90}}]},
]
MIRRORED = [key | {"transform": [{"scale": [1, 1, -1]}, *key["transform"]]} for key in KEYS]


def animated(keys: list[dict[str, Any]]) -> dict[str, Any]:
    return {"animation": keys}


def scene(shutter: tuple[float, float] = (0, 1), **parts: Any) -> et.Scene:
    sensor = {"type": "perspective", "fov": 40, "to_world": [VIEW]}
    opened = sensor | {"shutter_open": shutter[0], "shutter_close": shutter[1]}
    floor = {"type": "rectangle", "to_world": [{"scale": 3}]}
    lamp = {"type": "point", "position": [1, -2, 3], "intensity": 10}
    whole = {"type": "scene", "sensor": opened, "integrator": {"type": "path", "max_depth": 4}}
    return et.load_dict(whole | {"floor": floor, "lamp": lamp} | parts).with_(size=(16, 12))


def rays(count: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(3)
    origins = rng.normal(size=(count, 3)) * 0.5 + [0, -4, 2]
    aims = rng.normal(size=(count, 3)) * [0.7, 0.3, 0.4] + [0, 0, 0.5]
    return origins, (aims - origins) / np.linalg.norm(aims - origins, axis=1, keepdims=True)


def bits(loaded: et.Scene) -> Any:
    renderer = _core.Renderer(loaded.core, _core.Settings(max_depth=4), seed=3, threads=1)
    assert renderer.advance(6)
    return renderer.moments


def test_a_rotation_turns_steadily_and_place_and_scale_change_linearly() -> None:
    first = transforms.parse([{"scale": 2}, {"translate": [1, 2, 3]}])
    last = transforms.parse([{"scale": 4}, {"rotate": {"axis": [1, 1, 0], "angle": 120}}, {"translate": [3, 2, 1]}])
    moving = motion.animation([(10.0, first), (14.0, last)])
    for share in (0.25, 0.5, 0.75):
        turn = {"rotate": {"axis": [1, 1, 0], "angle": 120 * share}}
        place = {"translate": [1 + 2 * share, 2, 3 - 2 * share]}
        expected = transforms.parse([{"scale": 2 + 2 * share}, turn, place])
        np.testing.assert_allclose(motion.pose(moving, 10 + 4 * share), expected, atol=1e-14)
    assert (motion.pose(moving, 10.0) == first).all()
    assert (motion.pose(moving, 9.0) == first).all()
    assert (motion.pose(moving, 15.0) == last).all()


@pytest.mark.parametrize("keys", [KEYS, ROUND, MIRRORED], ids=["three keys", "beyond the shutter", "mirrored"])
@pytest.mark.parametrize("kind", ["cube", "disk", "rectangle", "instance", "sphere", "cylinder"])
def test_a_scene_in_motion_is_at_each_time_the_still_scene_of_that_time(kind: str, keys: list[dict[str, Any]]) -> None:
    if kind in ("sphere", "cylinder"):
        keys = [key for key in keys if key["transform"] is not TURNED and TURNED[1] not in key["transform"]]
    parts: dict[str, Any] = {"it": {"type": kind, "to_world": animated(keys)}}
    if kind == "instance":
        parts["group"] = {"type": "shapegroup", "a": {"type": "cube", "to_world": [{"translate": [0.5, 0, 0]}]}}
        parts["it"] |= {"g": {"type": "ref", "id": "group"}}
    moving = scene(**parts)
    assert moving.core.effects()["motion"]
    origins, directions = rays(4000)
    for time in (0.0, 0.125, 0.25, 0.6, 1.0):
        expected = moving.replaced(motion.at_time(moving.model, time)).core.intersect(origins, directions)
        found = moving.core.intersect(origins, directions, time=time)
        met = found["t"] < np.inf
        same = (found["t"] < np.inf) == (expected["t"] < np.inf)
        near = np.isclose(found["t"], expected["t"], rtol=1e-5)
        assert (~same | (met & ~near)).sum() <= 4, "but for what grazes an edge"
        good = met & same & near
        assert (found["t"][good] < 5).sum() > 200
        np.testing.assert_array_equal(found["front"][good], expected["front"][good])
        np.testing.assert_allclose(found["n"][good], expected["n"][good], atol=2e-5)


def test_dict_toml_and_xml_say_the_same(tmp_path: Path) -> None:
    loaded = scene(it={"type": "cube", "to_world": animated(KEYS)})
    for suffix in ("toml", "xml"):
        file = tmp_path / f"scene.{suffix}"
        loaded.write(file)
        assert et.load(file).digest == loaded.digest
        assert "animation" in file.read_text()
    assert et.load_dict(loaded.to_dict()).digest == loaded.digest
    (tmp_path / "own.xml").write_text(
        '<scene version="3.0.0"><sensor type="perspective"><float name="shutter_close" value="1"/></sensor>'
        '<shape type="sphere"><animation name="to_world"><transform time="0"><translate x="1"/></transform>'
        '<transform time="2"><scale value="2"/></transform></animation></shape></scene>'
    )
    placement = et.load(tmp_path / "own.xml").model.shapes[0].to_world
    assert isinstance(placement, Animation)
    assert placement.times == (0.0, 2.0)
    assert placement.matrices[0][0] == (1.0, 0.0, 0.0, 1.0)
    assert placement.matrices[1][1] == (0.0, 2.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ([KEYS[0]], "it.to_world: an animation needs two keys at least"),
        ([KEYS[2], KEYS[0]], "it.to_world: the times of an animation's keys must increase"),
        ([KEYS[0], MIRRORED[2]], "it.to_world: the keys of an animation must all mirror, or none"),
        (
            [KEYS[0], {"tim": 1, "scale": 2}],
            "it.to_world: a key of an animation is a table with a time and a transform",
        ),
        ([KEYS[0], {"time": 1, "skale": 2}], "it.to_world: unknown transform step 'skale'; did you mean 'scale'"),
        ([KEYS[0], {"time": "soon", "scale": 2}], "it.to_world: expected finite numbers, found 'soon'"),
        ([KEYS[0], {"time": 1, "scale": [1, 0, 1]}], "it.to_world: the transform is singular"),
    ],
)
def test_an_animation_that_is_none_is_refused_at_its_place(keys: list[dict[str, Any]], message: str) -> None:
    with pytest.raises(et.SceneError) as error:
        scene(it={"type": "cube", "to_world": animated(keys)})
    assert message in str(error.value)


def test_what_cannot_move_says_so() -> None:
    with pytest.raises(et.SceneError, match="of a sphere that moves must scale all directions alike"):
        scene(it={"type": "sphere", "to_world": animated(KEYS)})
    with pytest.raises(et.SceneError, match="to_world: must keep lengths"):
        scene(sensor={"type": "perspective", "to_world": animated(ROUND)})
    with pytest.raises(et.SceneError, match="shapes of a group cannot move by themselves; its instances can"):
        scene(g={"type": "shapegroup", "a": {"type": "cube", "to_world": animated(KEYS)}})
    with pytest.raises(et.SceneError, match=r"shutter_close \(0\) must not be before shutter_open \(1\)"):
        scene((1, 0))
    with pytest.raises(et.SceneError, match=r"it: a priority is for what has an inside: meshes and spheres"):
        _ = scene(it={"type": "disk", "priority": 1, "to_world": animated(KEYS)}).core


STILL = {
    "a shutter that closes at once": ((0.25, 0.25), KEYS),
    "motion before the shutter opens": ((2, 3), KEYS),
    "keys that are all the same": ((0, 1), [KEYS[1] | {"time": time} for time in (0, 0.5, 1)]),
}


@pytest.mark.parametrize("name", STILL)
def test_what_does_not_move_calls_for_nothing_and_changes_no_bit(name: str) -> None:
    shutter, keys = STILL[name]
    steps = KEYS[2]["transform"] if shutter == (2, 3) else TURNED
    view = transforms.parse([VIEW])
    sensor = {"type": "perspective", "fov": 40, "shutter_open": shutter[0], "shutter_close": shutter[1]}
    held = sensor | {"to_world": animated([{"time": t, "transform": view.tolist()} for t in (0, 1)])}
    loaded = scene(shutter, it={"type": "cube", "to_world": animated(keys)}, sensor=held)
    plain = scene(shutter, it={"type": "cube", "to_world": steps})
    assert loaded.core.effects() == plain.core.effects()
    assert "motion" not in derive(loaded)
    assert loaded.digest == plain.digest
    assert same_bits(bits(loaded), bits(plain))


def test_motion_is_called_for_by_what_moves_and_left_out_at_the_centre_of_the_shutter() -> None:
    loaded = scene((0, 2), it={"type": "cube", "to_world": animated(KEYS)})
    (reason,) = derive(loaded)["motion"]
    assert str(reason) == "it: shape 'cube'"
    without, _ = leave_out(loaded, et.Strategy.parse("best"), ["motion"])
    assert same_bits(bits(without), bits(scene(it={"type": "cube", "to_world": KEYS[2]["transform"]})))
    assert leave_out(without, et.Strategy.parse("best"), ["motion"])[0] is without


def test_an_animated_scene_whose_shutter_is_never_open_is_told_so() -> None:
    (warning,) = scene((0, 0), it={"type": "cube", "to_world": animated(KEYS)}).warnings
    assert "nothing moves: its shutter opens and closes at 0" in warning
    assert not scene(it={"type": "cube", "to_world": animated(KEYS)}).warnings
    closed = scene((0, 0), it={"type": "cube", "to_world": animated(KEYS)})
    assert closed.with_(size=(4, 4)).warnings == (warning,)
    assert not closed.with_(shutter=(0.5, 0.5)).warnings, "the call chooses the time"


def test_a_scene_may_get_another_shutter() -> None:
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}})
    sensor = scene.with_(shutter=(0.5, 0.75)).model.sensor
    assert (sensor.shutter_open, sensor.shutter_close) == (0.5, 0.75)
    with pytest.raises(et.SceneError, match="must not be before shutter_open"):
        scene.with_(shutter=(1.0, 0.5))
    with pytest.raises(ValueError, match=r"shutter is \(open, close\), found"):
        scene.with_(shutter=(1.0,))  # type: ignore[arg-type]
