"""A replay is the render's sample: all samples of a pixel, added up in their order, are the pixel, bit by bit."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.cli import main
from equaltime.cli.replay_summary import path_in_short
from equaltime.film.moments import DTYPE, deviations, stored
from equaltime.rendering.brightest import Brightest
from equaltime.rendering.core import make_renderer

from .shipped import FILES, FOLDER, shipped

SAMPLES: Final = 9
SEED: Final = 5
PIXELS: Final = [(0, 0), (12, 8), (7, 13), (23, 4), (15, 10)]
STRATEGIES: Final = [
    *("best,lights=tree,roulette_depth=2", "naive", "best,technique=mixture"),
    *("light", "bsdf", "best,roulette=efficiency,roulette_depth=2"),
]


def test_what_moves_is_called_by_its_name() -> None:
    """It stands in a group of its own; a moving instance comes after those that stand still, whatever the file says."""

    def keys(x: float) -> dict[str, Any]:
        return {"animation": [{"time": time, "translate": [x + 0.1 * time, 0, 0]} for time in (0.0, 1.0)]}

    film = {"type": "hdrfilm", "width": 30, "height": 10}
    view = {"look_at": {"origin": [0, 0, 12], "target": [0, 0, 0], "up": [0, 1, 0]}}
    sensor = {"type": "perspective", "fov": 40.0, "shutter_close": 1.0, "to_world": [view], "film": film}
    part = {"type": "ref", "id": "group"}
    scene = et.load_dict(
        {
            "type": "scene",
            "sensor": sensor,
            "sky": {"type": "constant"},
            "group": {"type": "shapegroup", "part": {"type": "sphere"}},
            "rolls": {"type": "sphere", "to_world": keys(-3.5)},
            "flies": {"type": "instance", "shapegroup": part, "to_world": keys(0.0)},
            "stands": {"type": "instance", "shapegroup": part, "to_world": [{"translate": [3.5, 0, 0]}]},
        }
    )
    middle = [et.replay(scene, pixel=(x, 5), sample=0).vertices[0]["surface"]["name"] for x in (2, 15, 27)]
    assert middle == [
        "'rolls' (sphere, rolls)",
        "sphere, group.part, seen as 'flies' (instance, flies)",
        "sphere, group.part, seen as 'stands' (instance, stands)",
    ]


def welford(samples: list[tuple[float, ...]]) -> list[Any]:
    """Return count, mean and deviation as the film makes them, one operation after the other in float64."""
    pixel = np.zeros((), DTYPE)
    for sample in samples:
        pixel["count"] += 1
        inverse = 1.0 / int(pixel["count"])
        delta, square = np.array(sample) - pixel["mean"], np.square(deviations(pixel))
        pixel["mean"] += delta * inverse
        pixel["deviation"] = stored(np.sqrt(square + (delta * (np.array(sample) - pixel["mean"]) - square) * inverse))
    return told(pixel)


def told(pixel: Any) -> list[Any]:
    return [int(pixel["count"]), pixel["mean"].tolist(), pixel["deviation"].tolist()]


@pytest.mark.parametrize(
    ("file", "strategy"),
    [*((file, "best") for file in (*FILES, "terrain/terrain.toml")), *((FILES[-1], words) for words in STRATEGIES)],
)
def test_replays_of_all_samples_of_a_pixel_are_the_pixel(file: str, strategy: str) -> None:
    scene, chosen = shipped(file), et.Strategy.parse(strategy)
    renderer = make_renderer(scene, chosen, SEED, threads=2)
    renderer.advance(SAMPLES)
    for x, y in PIXELS:
        paths = [et.replay(scene, pixel=(x, y), sample=i, strategy=chosen, seed=SEED) for i in range(SAMPLES)]
        assert all(path.sum == path.radiance and path.first_nonfinite is None for path in paths)
        for replicate in range(2):
            pixel = renderer.moments[replicate, y, x]
            assert told(pixel) == welford([path.radiance for path in paths[replicate::2]])
    assert renderer.moments["mean"].mean() > 0.0


def test_another_sample_and_another_seed_are_other_paths() -> None:
    scene = shipped("cornell-box.toml")
    first = et.replay(scene, pixel=(12, 8), sample=0)
    assert first.vertices != et.replay(scene, pixel=(12, 8), sample=1).vertices
    assert first.vertices != et.replay(scene, pixel=(12, 8), sample=0, seed=1).vertices
    assert first.vertices == et.replay(scene, pixel=(12, 8), sample=0).vertices


def test_a_path_can_be_replayed_without_effects() -> None:
    scene = shipped("cornell-box.toml")
    cut = et.replay(scene, pixel=(12, 8), sample=0, without=["long_paths=2"])
    assert (cut.strategy, len(cut.vertices)) == ("best,truncate=2", 2)
    assert cut.vertices[0]["light"] == et.replay(scene, pixel=(12, 8), sample=0).vertices[0]["light"]


def test_pixels_are_those_of_the_whole_film_and_only_its_crop_has_any() -> None:
    whole, crop = shipped("cornell-box.toml"), shipped("cornell-box.toml", crop=(10, 5, 6, 6))
    assert et.replay(crop, pixel=(12, 8), sample=3).vertices == et.replay(whole, pixel=(12, 8), sample=3).vertices
    with pytest.raises(ValueError, match="pixel 9,8 is not on the film, 6x6 from 10,5"):
        et.replay(crop, pixel=(9, 8), sample=0)


@pytest.mark.parametrize(("pixel", "sample"), [("12,8", 0), ((12,), 0), ((12.5, 8), 0), (12, 0), ((12, 8), -1)])
def test_an_argument_of_another_type_or_out_of_range_is_refused(pixel: Any, sample: Any) -> None:
    with pytest.raises(ValueError, match="must be"):
        et.replay(shipped("cornell-box.toml"), pixel=pixel, sample=sample)


def test_a_path_is_told_in_the_units_and_names_of_the_scene() -> None:
    scene = et.load_dict(
        {
            "type": "scene",
            "sensor": {
                "type": "perspective",
                "to_world": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 1000.0], [0, 0, 0, 1]],
                "fov": 0.1,
                "film": {"type": "hdrfilm", "width": 3, "height": 3, "rfilter": {"type": "box"}},
            },
            "paper": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.5}},
            "far": {"type": "sphere", "center": [0, 0, 3000.0], "radius": 1.0},
            "bulb": {"type": "point", "position": [0, 0, 10.0], "intensity": 200.0},
        }
    )
    path = et.replay(scene, pixel=(1, 1), sample=0)
    first = path.vertices[0]
    assert first["surface"]["name"].startswith("'paper' (rectangle")
    assert first["surface"]["front"]
    x, y, z = first["surface"]["point"]
    assert max(abs(x), abs(y)) < 1
    assert abs(z) < 1e-3
    light, cosine = first["light"], first["light"]["direction"][2]
    assert light["light"]["name"].startswith("'bulb' (point")
    distance = 10.0 / cosine
    assert light["distance"] == pytest.approx(distance, rel=1e-5)
    assert light["radiance"] == pytest.approx([200.0 / distance**2] * 3, rel=1e-5)
    assert light["gathered"] == pytest.approx([200.0 / distance**2 * 0.5 / np.pi * cosine] * 3, rel=1e-5)
    assert (light["pmf"], light["visible"], light["mis_weight"]) == (1.0, 1.0, 1.0)


def luminance(path: et.Replay) -> float:
    return float(np.dot(path.radiance, (0.212671, 0.715160, 0.072169)))


@pytest.mark.parametrize("strategy", ["best", "naive", "best,adaptive=error,sampler=sobol"])
def test_without_a_number_the_brightest_sample_of_the_pixel_is_replayed(strategy: str) -> None:
    scene = shipped("cornell-box.toml")
    for x, y in PIXELS:
        paths = [et.replay(scene, pixel=(x, y), sample=i, strategy=strategy, seed=SEED) for i in range(SAMPLES)]
        light = [luminance(path) for path in paths]
        found = et.replay(scene, pixel=(x, y), spp=SAMPLES, strategy=strategy, seed=SEED)
        assert found.sample == int(np.argmax(light))
        assert found.vertices == paths[found.sample].vertices
        assert found.radiance == paths[found.sample].radiance
        assert found.brightest is not None
        assert (found.brightest.sample, found.brightest.samples) == (found.sample, SAMPLES)
        assert found.brightest.luminance == pytest.approx(max(light), rel=1e-6)
        assert found.brightest.mean_of_others == pytest.approx((sum(light) - max(light)) / (SAMPLES - 1), rel=1e-5)
        assert found.brightest.as_bright == sum(each == pytest.approx(max(light), rel=1e-5) for each in light)
        assert found.brightest.black == light.count(0.0)
        assert str(found.brightest) in str(found)


@pytest.mark.parametrize(("asked", "samples"), [(None, 64), (5, 5)])
def test_as_many_samples_are_looked_at_as_a_render_takes(asked: int | None, samples: int) -> None:
    scene = et.load_dict(
        {
            "type": "scene",
            "sensor": {
                "type": "perspective",
                "film": {"type": "hdrfilm", "width": 2, "height": 2},
                **({} if asked is None else {"sampler": {"type": "independent", "sample_count": asked}}),
            },
            "sky": {"type": "constant"},
        }
    )
    found = et.replay(scene, pixel=(1, 1)).brightest
    assert found is not None
    assert found.samples == samples
    assert et.replay(scene, pixel=(1, 1), sample=0).brightest is None
    with pytest.raises(ValueError, match="give only one of them"):
        et.replay(scene, pixel=(1, 1), sample=0, spp=4)


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (
            Brightest(37, 64, 12.3, 0.3),
            "sample 37 (counted from 0) of the first 64 is the brightest: 41 times the mean of the others",
        ),
        (Brightest(37, 64, 12.3, 0.0, black=63), "is the brightest: luminance 12.3; the other 63 are black"),
        (Brightest(1, 2, 12.3, 0.0, black=1), "is the brightest: luminance 12.3; the other is black"),
        (Brightest(37, 64, 12.3, 0.2, 2, 62), "is one of the 2 brightest: luminance 12.3; the other 62 are black"),
        (Brightest(37, 64, 12.3, 0.3, 2, 10), "is one of the 2 brightest: luminance 12.3; 10 are black"),
        (Brightest(37, 64, 12.3, 0.3, black=33), "is the brightest: luminance 12.3; 33 are black"),
        (Brightest(0, 64, 12.3, 12.3, 64), "the first 64 samples are equally bright (luminance 12.3); sample 0 is"),
        (Brightest(37, 64, 12.3, -0.3), "is the brightest: luminance 12.3, and the mean of the others is -0.3"),
        (Brightest(37, 64, 0.0, 0.0, 64, 64), "the first 64 samples are all black"),
        (Brightest(37, 1, 0.5, float("nan")), "only sample 0 was looked at: luminance 0.5"),
        (Brightest(37, 38, float("nan"), 0.3), "sample 37 (counted from 0) of the first 38 is not a finite number"),
    ],
)
def test_the_brightest_sample_is_compared_in_words(found: Brightest, words: str) -> None:
    assert words in str(found)


def test_a_sample_that_is_not_a_number_counts_as_the_brightest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_core, "Renderer", Faulty)
    found = et.replay(shipped("cornell-box.toml"), pixel=(12, 8), spp=9)
    assert found.brightest is not None
    assert (found.sample, found.brightest.samples) == (1, 2)
    assert np.isnan(found.brightest.luminance)


def test_the_command_prints_the_brightest_sample_first(capsys: pytest.CaptureFixture[str]) -> None:
    file = str(FOLDER / "cornell-box.toml")
    words = ["replay", file, "--pixel", "12,8", "--spp", "32", "--size", "24x16"]
    assert main(words) == 0
    path = et.replay(et.load(file).with_(size=(24, 16)), pixel=(12, 8), spp=32)
    first, second, third = capsys.readouterr().out.splitlines()[:3]
    assert first == str(path.brightest)
    assert second.startswith(f"pixel 12,8, sample {path.sample}, ")
    assert third == path_in_short(path)
    assert main([*words, "--json"]) == 0
    assert path.brightest is not None
    assert json.loads(capsys.readouterr().out)["brightest"] == vars(path.brightest)


def test_the_command_prints_the_path_and_the_same_as_data(capsys: pytest.CaptureFixture[str]) -> None:
    file = str(FOLDER / "cornell-box.toml")
    words = ["replay", file, "--pixel", "12,8", "--sample", "3", "--size", "24x16", "--seed", "5"]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "pixel 12,8, sample 3, seed 5, strategy best" in text
    assert "is the sample" in text
    assert "cornell-box.toml:" in text
    assert "scatters by diffuse" in text
    assert text.count("the camera's ray, from ") == 1
    assert " -0 " not in text
    assert "the camera's ray begins between camera and scene" in text
    assert "primitive: the number of the triangle in its shape" in text
    assert main([*words, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    path = et.replay(et.load(file).with_(size=(24, 16)), pixel=(12, 8), sample=3, seed=5)
    assert data["radiance"] == list(path.radiance) == data["sum"]
    assert len(data["vertices"]) == len(path.vertices) == text.count("\n   throughput ")


def mirror_room(*lights: dict[str, Any]) -> et.Scene:
    """Return a scene whose camera looks into a mirror; the mirror shows a matt wall, ten times as far as it."""

    def wall(z: float, turned: float, bsdf: dict[str, Any]) -> dict[str, Any]:
        place = [{"rotate": {"axis": [0, 1, 0], "angle": turned}}, {"scale": 100.0}, {"translate": [0, 0, z]}]
        return {"type": "rectangle", "to_world": place, "bsdf": {"type": "twosided", "bsdf": bsdf}}

    film = {"type": "hdrfilm", "width": 4, "height": 4}
    view = {"look_at": {"origin": [0, 0, 0], "target": [0, 0, -1], "up": [0, 1, 0]}}
    parts: dict[str, Any] = {
        "sensor": {"type": "perspective", "fov": 10.0, "to_world": [view], "film": film},
        "glossy": wall(-1.0, 0.0, {"type": "conductor"}),
        "matt": wall(9.0, 180.0, {"type": "diffuse"}),
    }
    return et.load_dict({"type": "scene", **parts, **{f"lamp{number}": light for number, light in enumerate(lights)}})


def test_a_line_names_the_surfaces_and_the_light_that_added_most() -> None:
    weak, strong = ({"type": "point", "position": [0, 3, 5], "intensity": power} for power in (1e-3, 1e3))
    path = et.replay(mirror_room(strong), pixel=(2, 2), sample=0)
    parts = [
        vertex["light"]["gathered"] for vertex in path.vertices if vertex["light"] and "gathered" in vertex["light"]
    ]
    share = max(map(sum, parts)) / sum(map(sum, parts))
    said = r"path: glossy -> matt -> lamp0: vertex 2 aims at this light, which adds (.*) % of the sample"
    found = re.fullmatch(said, str(path_in_short(path)))
    assert found is not None
    assert float(found[1]) == pytest.approx(100.0 * share, abs=1.0)
    both = et.replay(mirror_room(weak, strong), pixel=(2, 2), spp=16)
    assert "-> lamp1: " in str(path_in_short(both))
    assert str(path_in_short(et.replay(mirror_room(), pixel=(2, 2), sample=0))).endswith(": no light")


def test_a_light_that_a_path_meets_ends_the_line() -> None:
    panel = {"type": "sphere", "center": [0, 0, -1], "radius": 0.5, "emitter": {"type": "area", "radiance": 3.0}}
    sensor = {"type": "perspective", "fov": 10.0, "film": {"type": "hdrfilm", "width": 4, "height": 4}}
    aim = {"look_at": {"origin": [0, 0, 0], "target": [0, 0, -1], "up": [0, 1, 0]}}
    scene = et.load_dict({"type": "scene", "sensor": {**sensor, "to_world": [aim]}, "panel": panel})
    path = et.replay(scene, pixel=(2, 2), sample=0)
    assert path_in_short(path) == "path: panel: vertex 1 meets this light, which adds 100 % of the sample"


def test_a_path_with_a_number_that_is_not_finite_has_no_line() -> None:
    path = et.replay(mirror_room({"type": "constant"}), pixel=(2, 2), sample=0)
    broken = {**path.vertices[0], "throughput": (float("nan"),) * 3}
    assert path_in_short(replace(path, vertices=(broken, *path.vertices[1:]))) is None


def test_a_surface_without_an_id_is_named_by_its_type_and_file(tmp_path: Path) -> None:
    (mesh := tmp_path / "plate.obj").write_text("v -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n")
    path = et.replay(et.load(mesh, ground=0).with_(size=(3, 3)), pixel=(1, 1), sample=0)
    assert str(path_in_short(path)).startswith("path: obj (plate.obj) -> ")


def test_a_long_path_is_named_by_its_first_and_last_surfaces() -> None:
    path = et.replay(mirror_room({"type": "constant"}), pixel=(2, 2), sample=0)
    first = {**path.vertices[0], "emitter": None, "light": None}
    chain = tuple({**first, "from": number - 1 if number else None} for number in range(20))
    line = str(path_in_short(replace(path, vertices=chain)))
    assert line == f"path: {'glossy -> ' * 4}(12 more){' -> glossy' * 4}: no light"


def test_a_picked_light_adds_the_product_that_the_command_prints() -> None:
    """The pdf contains the probability of the pick: with the probability once more, contributions would differ."""
    path = et.replay(et.load(FOLDER / "veach-mis.toml").with_(size=(64, 36)), pixel=(30, 20), spp=16)
    lights = [(each["left"], each["light"]) for each in path.vertices if each["light"] and each["light"]["sampled"]]
    picked = [(left, light) for left, light in lights if light["visible"] and light["pmf"] < 0.9 and any(light["bsdf"])]
    assert picked
    for left, light in picked:
        factor = light["mis_weight"] * light["visible"] / light["pdf"]
        product = np.array(left) * light["radiance"] * light["bsdf"] * factor
        np.testing.assert_allclose(product, light["gathered"], rtol=1e-5)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--pixel", "24,0", "--sample", "0"], "pixel 24,0 is not on the film, 24x16 from 0,0"),
        (["--pixel", "5", "--sample", "0"], "'5' is no pixel"),
        (["--pixel", "1,1", "--sample", "-1"], "--sample"),
        (["--pixel", "1,1", "--sample", "1", "--spp", "4"], "give --sample for one sample, or --spp"),
    ],
)
def test_what_is_no_sample_is_refused(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(FOLDER / "cornell-box.toml"), "--size", "24x16", *words]) == 2
    assert message in capsys.readouterr().err


class Faulty:
    """The core's renderer, which claims that one sample was not a number: no scene is known that makes it so."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._renderer = RENDERER(*arguments, **options)

    @property
    def nonfinite(self) -> list[tuple[int, int, int]]:
        crop_of_one_pixel = self._renderer.moments.shape[1:] == (1, 1)
        x, y, index = (0, 0, 1) if crop_of_one_pixel else (2, 3, 1)
        return [(x, y, index)] if self._renderer.counters["paths"] > index else []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._renderer, name)


RENDERER = _core.Renderer


def test_a_sample_that_is_not_a_number_names_the_command_that_shows_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(_core, "Renderer", Faulty)
    file = tmp_path / "a scene.toml"
    file.write_text((FOLDER / "cornell-box.toml").read_text() + '\n[hidden]\ntype = "sphere"\nradius = "$r"\n')
    words = ["--size", "24x16", "--seed", "7", "--strategy", "naive", "-D", "r=0.001", "--spp", "2", "-q"]
    assert main(["render", str(file), "-o", str(tmp_path / "out.exr"), "--crop", "10,5,6,6", *words]) == 1
    message = capsys.readouterr().err
    assert "pixel 12,8, sample 1, seed 7" in message
    command = shlex.split(message.split("its path: ")[1])
    assert command[0] == "equaltime"
    assert main(command[1:]) == 0
    assert "pixel 12,8, sample 1, seed 7, strategy naive" in capsys.readouterr().out
