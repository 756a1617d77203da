"""`equaltime selftest`: its cases pass, would fail if the image were a little wrong, and are told as promised."""

from __future__ import annotations

import dataclasses
import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.cli import main
from equaltime.errors import PeerError
from equaltime.hardcases import cases, selftest
from equaltime.hardcases.cases import CASES, Case, load_case, scenes_folder
from equaltime.hardcases.judge import MOST_ULP, judge_bits, judge_same, judge_value, limit_of
from equaltime.hardcases.subjects import MitsubaSubject, OurSubject
from equaltime.hardcases.units import in_units
from equaltime.rendering.session import Session

QUICK_IDS = ["G2", "G3", "G10", "G11", "G13", "G14", "G17", "S1", "S3", "S7", "S16", "T8"]
QUICK_NAMES = ["ball in a lamp 1e6 wide", "instance scaled -1e-3 … 1e3"]
QUICK = [case for case in CASES if case.id in QUICK_IDS or case.name in QUICK_NAMES]
LIMIT = limit_of(len(CASES))


def noise(mean: float, spread: float, seeds: int = 16) -> list[NDArray[np.float32]]:
    rng = np.random.default_rng(3)
    return [rng.normal(mean, spread, (8, 8, 3)).astype(np.float32) for _ in range(seeds)]


@pytest.mark.parametrize("case", QUICK, ids=lambda case: f"{case.id} {case.name}")
def test_quick_cases_pass(case: Case) -> None:
    outcome = OurSubject().outcome(case)
    assert outcome.passed, outcome


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.id} {case.name}")
def test_each_case_passes_and_an_image_a_twentieth_off_would_not(case: Case) -> None:
    outcome = OurSubject().outcome(case)
    assert outcome.passed, outcome
    assert outcome.resolution is None or outcome.resolution < 0.05
    if case.expected:
        wrong = OurSubject().outcome(dataclasses.replace(case, expected=1.05 * case.expected))
        assert not wrong.passed, wrong


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.id} {case.name}")
def test_each_case_has_a_scene_that_says_where_it_is_from_and_what_it_stresses(case: Case) -> None:
    text = (scenes_folder() / case.scene).read_text()
    assert load_case(case).size[0] <= 32
    assert "Origin" in text or "Made for equaltime" in text or "Bitterli" in text
    assert case.id in text or not case.scene.startswith("hard/")


def test_each_hard_scene_is_used_and_goes_with_the_package() -> None:
    root = Path(__file__).parents[2]
    files = {path.relative_to(root / "scenes").as_posix() for path in (root / "scenes" / "hard").iterdir()}
    used = {case.scene for case in CASES}
    assert {name for name in files if name.endswith(".toml")} == {scene for scene in used if scene.startswith("hard/")}
    assert "install(DIRECTORY scenes DESTINATION equaltime" in (root / "CMakeLists.txt").read_text()
    assert all((scenes_folder() / scene).is_file() for scene in used)


def test_names_tell_cases_apart() -> None:
    assert len({(case.id, case.name) for case in CASES}) == len(CASES)
    with pytest.raises(ValueError, match=r"no case 'G33'; did you mean 'G3'"):
        selftest(only=["G33"])


def test_a_bias_beyond_the_resolution_is_seen_and_noise_is_not() -> None:
    """False alarm: 0.1 % for all cases, some 2e-5 for this one."""
    outcome = judge_value(noise(1.0, 0.1), 1.0, LIMIT)
    assert outcome.passed
    assert outcome.kind == "z"
    assert outcome.resolution is not None
    assert outcome.resolution < 0.02
    assert not judge_value(noise(1.0, 0.1), 1.0 + 2 * outcome.resolution, LIMIT).passed, "the twin"


def test_images_without_noise_are_looked_at_pixel_by_pixel() -> None:
    image = np.full((8, 8, 3), 0.1, np.float32)
    assert judge_value([image, image], 0.1, LIMIT).passed
    dark = image.copy()
    dark[3, 5, 1] *= 1.0 - 3e-6
    assert judge_value([dark, dark], 0.1, LIMIT).score > MOST_ULP, "the twin: one channel of one pixel"
    assert not judge_value([1e-30 * image, 1e-30 * image], 0.0, LIMIT).passed, "nothing but 0 is 0"
    assert not judge_value(noise(1.0, 9.0, seeds=2), 0.0, LIMIT).passed, "with however much noise"


def test_bits_and_expectations_are_compared() -> None:
    first = noise(1.0, 0.1)
    assert judge_bits(first[0], first[0].copy()).passed
    assert not judge_bits(first[0], np.nextafter(first[0], np.float32(2))).passed
    assert not judge_bits(np.zeros_like(first[0]), -np.zeros_like(first[0])).passed
    other = noise(1.0, 0.1, seeds=24)
    assert judge_same(first, other, LIMIT).passed
    assert not judge_same(first, [np.float32(1.03) * image for image in other], LIMIT).passed


def test_units_scale_lights_cameras_and_shapes_and_what_is_no_power_of_two_is_seen() -> None:
    view = {"look_at": {"origin": (0.5, -4, 2), "target": (0, 0, 0), "up": (0, 0, 1)}}
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    camera = {"type": "thinlens", "aperture_radius": 0.1, "focus_distance": 4, "fov": 40, "to_world": [view]}
    spot = {"type": "spot", "intensity": 5, "to_world": [{"look_at": {"origin": (1, 1, 3), "target": (0, 0, 0)}}]}
    scene = et.load_dict(
        {
            "type": "scene",
            "camera": camera | {"film": film, "near_clip": 1.0, "far_clip": 100.0},
            "floor": {"type": "rectangle", "bsdf": {"type": "diffuse"}},
            "ball": {"type": "sphere", "radius": 0.4, "center": [0.2, -0.1, 0.3]},
            "bulb": {"type": "point", "position": [0.3, -0.8, 2.0], "intensity": [3, 4, 5]},
            "spot": spot,
            "sun": {"type": "directional", "direction": [1, 1, -1], "irradiance": 0.2},
            "sky": {"type": "constant", "radiance": 0.1},
        }
    )
    plain = et.render(scene, spp=4).image
    for length, light in ((-20, 40), (20, -40)):
        other = et.render(in_units(scene, 2.0**length, 2.0**light), spp=4).image
        assert judge_bits(plain, np.ldexp(other, -light)).passed
    assert not judge_bits(plain, et.render(in_units(scene, 3.0), spp=4).image).passed, "the twin"


def test_the_command_ends_with_1_if_a_case_fails(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["selftest", "--only", "G13", "--only", "S3"]) == 0
    answer, more = capsys.readouterr().out.splitlines()
    assert answer.startswith("2 of 2 hard cases passed, none failed (")
    assert more.startswith("-v shows all cases")
    assert main(["selftest", "--only", "G13", "-v"]) == 0
    assert "sun at 0.01°" in capsys.readouterr().out
    wrong = tuple(dataclasses.replace(case, expected=1.0) if case.id == "G13" else case for case in CASES)
    monkeypatch.setattr(cases, "CASES", wrong)
    assert main(["selftest", "--only", "G13", "--only", "S3"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("1 of 2 hard cases passed, 1 failed (")
    assert [line.split()[0] for line in lines[1:-1]] == ["case", "G13"]
    assert main(["selftest", "--only", "G13", "--only", "S3", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [(case["id"], case["pass"]) for case in told["cases"]] == [("G13", False), ("S3", True)]
    assert {"name", "expected", "got", "score", "limit", "stresses", "seconds"} <= told["cases"][0].keys()
    assert told["passed"] is False
    assert told["machine"]["cpu"]
    assert told["build"]["core_sha256"]
    assert main(["selftest", "--only", "G33"]) == 2
    assert main(["selftest", "--peer", "cycles"]) == 2


def test_what_a_renderer_raises_fails_its_case() -> None:
    lost = dataclasses.replace(CASES[0], scene="hard/nowhere.toml")
    outcome = OurSubject().outcome(lost)
    assert not outcome.passed
    assert outcome.got is None
    assert "nowhere" in outcome.note


def test_ctrl_c_ends_it_and_fails_no_case(monkeypatch: pytest.MonkeyPatch) -> None:
    part = dataclasses.replace(et.render(load_case(CASES[0]).with_(size=(4, 4)), spp=2), stopped_by="interrupt")
    monkeypatch.setattr(Session, "run", lambda _: part)
    with pytest.raises(KeyboardInterrupt):
        OurSubject().outcome(CASES[0])


@pytest.mark.skipif(find_spec("mitsuba") is None, reason="needs mitsuba")
def test_a_peer_is_asked_for_the_same_images() -> None:
    report = selftest(only=["G13", "C1"], peer="mitsuba", threads=1)
    assert report.peer is not None
    assert report.peer.startswith("Mitsuba 3.")
    found = {case.case.name: case.theirs for case in report.cases}
    sun = found.pop("sun at 0.01°")
    assert sun is not None
    assert sun.got == pytest.approx(1.7453e-4, rel=0.01)
    assert set(found.values()) == {None}, "nobody else promises bits"


@pytest.mark.skipif(find_spec("mitsuba") is not None, reason="needs no mitsuba")
def test_a_peer_that_is_not_there_is_told() -> None:
    with pytest.raises(PeerError, match=r"Mitsuba.*pip install .*\[peers\]"):
        MitsubaSubject().start()
