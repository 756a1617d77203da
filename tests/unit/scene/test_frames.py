"""Frames of an animation: their numbers, files and times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.frame_scenes import frames_of
from equaltime.scene.frames import MOST_FRAMES, Frame, frame_files, frame_pattern, parse_frames
from equaltime.scene.motion import pose

from .gltf_files import one_triangle
from .test_gltf_animations import animated

STANDING = """
[sensor]
type = "perspective"

[sky]
type = "constant"

[ball]
type = "sphere"
"""
KEYS = """
[[ball.to_world.animation]]
time = 0
transform = [{ translate = [0, 0, 5] }]

[[ball.to_world.animation]]
time = 2
transform = [{ translate = [4, 0, 5] }]
"""


@pytest.mark.parametrize(
    ("text", "numbers"),
    [("7", (7,)), ("0-3", (0, 1, 2, 3)), ("0-7:3", (0, 3, 6)), ("9, 1-2,2", (1, 2, 9)), ("5-5", (5,))],
)
def test_frames_are_ranges_and_numbers(text: str, numbers: tuple[int, ...]) -> None:
    assert parse_frames(text) == numbers


@pytest.mark.parametrize(
    ("text", "message"),
    [
        *(("", "expected frames such as 0-47"), ("a", "found 'a'"), ("-1", "found '-1'"), ("1.5", "found '1.5'")),
        *(("3-1", "a last one after it"), ("0-4:0", "a step of at least 1"), ("0-9999999999", "a last one after it")),
        ("0-999999999", f"more than {MOST_FRAMES:,} frames"),
    ],
)
def test_what_are_no_frames_is_told(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        parse_frames(text)


def test_files_have_the_numbers_of_their_frames() -> None:
    assert frame_files(Path("a/f.exr"), (3, 12345)) == (Path("a/f_0003.exr"), Path("a/f_12345.exr"))
    assert frame_files(Path("a/f-##.b.png"), (3,)) == (Path("a/f-03.b.png"),)
    with pytest.raises(ValueError, match=r"one group of #, found more in #-#\.exr"):
        frame_files(Path("#-#.exr"), (1,))


@pytest.mark.parametrize(
    ("name", "number", "pattern"),
    [
        *(("film_0012.exr", 12, "film_####.exr"), ("f-3.exr", 3, "f-#.exr"), ("f_12345.exr", 12345, "f_#####.exr")),
        *(("12-0012-v12.exr", 12, "12-####-v12.exr"), ("a112.exr", 12, "a1##.exr"), ("0000.exr", 0, "####.exr")),
    ],
)
def test_the_name_of_a_frame_s_file_tells_which_name_was_asked_for(name: str, number: int, pattern: str) -> None:
    assert frame_pattern(name, number) == pattern
    assert frame_files(Path(pattern), [number]) == (Path(name),)


@pytest.mark.parametrize(
    ("name", "pattern"),
    [("best.exr", "best_####.exr"), ("f_0123.exr", "f_0123_####.exr"), ("#0012.exr", "_0012_####.exr")],
)
def test_a_name_without_the_frame_s_number_gets_it(name: str, pattern: str) -> None:
    assert frame_pattern(name, 12) == pattern


def test_a_frame_begins_at_its_number_over_the_rate() -> None:
    assert Frame(12, 24.0, 0.0).shutter == (0.5, 0.5)
    assert Frame(12, 24.0, 0.5).shutter == (0.5, 12.5 / 24.0)


@pytest.mark.parametrize("blur", [0.0, 0.5])
def test_a_scene_of_toml_moves_from_frame_to_frame(blur: float, tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(STANDING + KEYS)
    frames = [Frame(number, 2.0, blur) for number in (0, 1, 4)]
    scenes = list(frames_of(path, frames, {}))
    assert [scene.model.sensor.shutter_open for scene in scenes] == [0.0, 0.5, 2.0]
    assert [scene.model.sensor.shutter_close for scene in scenes] == [frame.shutter[1] for frame in frames]
    assert [scene.core.effects()["motion"] for scene in scenes] == [blur > 0.0, blur > 0.0, False]
    assert len({scene.digest for scene in scenes}) == 3


@pytest.mark.parametrize("blur", [0.0, 0.5])
def test_a_gltf_file_moves_from_frame_to_frame(blur: float, tmp_path: Path) -> None:
    path = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]]).gltf(tmp_path / "a.gltf")
    scenes = frames_of(path, [Frame(number, 4.0, blur) for number in (0, 1)], {})
    places = [pose(scene.model.shapes[0].to_world, 0.0)[0, 3] for scene in scenes]
    np.testing.assert_allclose(places, [0, 1])


def test_the_camera_of_all_frames_sees_copies_and_the_whole_way(tmp_path: Path) -> None:
    """A triangle goes 4 to the right; copies of a second node stand up to 40 to the right."""
    builder = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]])
    copies = {"attributes": {"TRANSLATION": builder.accessor([[0, 0, 0], [40, 0, 0]])}}
    last = builder.node(mesh=0, extensions={"EXT_mesh_gpu_instancing": copies})
    builder.json["scenes"][0]["nodes"].append(last)
    builder.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    scenes = list(frames_of(builder.gltf(tmp_path / "a.gltf"), [Frame(number, 4.0, 0.0) for number in (0, 4)], {}))
    cameras = [np.asarray(scene.model.sensor.to_world) for scene in scenes]
    np.testing.assert_array_equal(cameras[0], cameras[1])
    for x in (0.0, 40.0):
        seen = np.linalg.inv(cameras[0]) @ (x, 0.0, 0.0, 1.0)
        half = np.tan(np.radians(scenes[0].model.sensor.fov) / 2.0) * np.array([4 / 3, 1.0])
        assert np.all(np.abs(seen[:2]) < half * seen[2])


def test_a_scene_knows_its_frame_until_it_gets_another_shutter(tmp_path: Path) -> None:
    (toml := tmp_path / "a.toml").write_text(STANDING + KEYS)
    gltf = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]]).gltf(tmp_path / "a.gltf")
    frame = Frame(1, 4.0, 0.5)
    for path, defines in ((toml, {}), (gltf, {"view": "left"})):
        (scene,) = frames_of(path, [frame], defines)
        assert scene.with_(size=(4, 3)).frame == frame
        assert scene.with_(shutter=(0.0, 0.0)).frame is None
        assert scene.defines == defines


def test_frames_of_what_stands_still_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(STANDING)
    with pytest.raises(
        et.SceneError, match=r"nothing in the scene is animated: .* convert again with -D shutter=0,LAST"
    ):
        next(frames_of(path, [Frame(0, 24.0, 0.0)], {}))


def test_an_example_moves_under_its_name() -> None:
    scenes = list(frames_of("windmill", [Frame(0), Frame(12)], {}))
    assert len({scene.digest for scene in scenes}) == 2


def test_the_frames_alone_choose_the_time(tmp_path: Path) -> None:
    path = one_triangle().gltf(tmp_path / "a.gltf")
    with pytest.raises(et.SceneError, match="the frames choose the time: leave 'time' out"):
        next(frames_of(path, [Frame(0, 24.0, 0.0)], {"time": 1}))


def test_frames_outside_the_animation_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(STANDING + KEYS)
    told = "the animation lasts from 0 s to 2 s: frame 9 and 1 other, outside that time, stand still"
    scenes = list(frames_of(path, [Frame(8, 4.0), Frame(9, 4.0), Frame(10, 4.0)], {}))
    assert told in scenes[0].warnings
    assert (
        next(frames_of(path, [Frame(9, 4.0, 1.0)], {}))
        .warnings[-1]
        .endswith("frame 9, outside that time, stands still")
    )
    assert not any(
        "animation lasts" in line for line in next(frames_of(path, [Frame(0, 4.0), Frame(8, 4.0)], {})).warnings
    )


def test_a_gltf_file_tells_that_its_animation_is_over(tmp_path: Path) -> None:
    gltf = animated("translation", [0, 1], [[0, 0, 0], [4, 0, 0]]).gltf(tmp_path / "a.gltf")
    told = "the animation ends at 1 s: later times show its end"
    scenes = list(frames_of(gltf, [Frame(0, 4.0), Frame(4, 4.0), Frame(5, 4.0)], {}))
    assert [told in scene.warnings for scene in scenes] == [False, False, True]
