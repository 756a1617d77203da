"""Which light makes the noise: scenes whose shares are known."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partialmethod
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.quoting import noise_light as module
from equaltime.quoting.law import fit
from equaltime.quoting.light_parts import name_and_place, short_names
from equaltime.quoting.noise_light import LEAST_PATHS, NoiseLight, noise_light
from equaltime.quoting.pilot import Pilot
from equaltime.rendering.core import split_light
from equaltime.scene.scene import smaller
from equaltime.statistics.intervals import Interval

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
INDEPENDENT = et.Strategy.parse("best,sampler=independent,lights=uniform")
PATHS = 52 * 8 * 24 * 24


def point(intensity: float) -> dict[str, Any]:
    return {
        "type": "point",
        "position": [0.1, 0.2, 0.3],
        "intensity": {"type": "rgb", "value": [intensity, intensity, intensity]},
    }


def room(depth: int, **lamps: dict[str, Any]) -> et.Scene:
    """A closed ball, grey within, whose camera looks at its wall."""
    film = {"type": "hdrfilm", "width": 24, "height": 24, "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": 60.0, "film": film}
    wall = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.6, 0.6]}}
    ball = {"type": "sphere", "radius": 3.0, "bsdf": {"type": "twosided", "bsdf": wall}}
    integrator = {"type": "path", "max_depth": depth}
    return et.load_dict({"type": "scene", "integrator": integrator, "camera": camera, "ball": ball, **lamps})


def told(scene: et.Scene, strategy: et.Strategy = INDEPENDENT, seed: int = 0) -> NoiseLight:
    found = noise_light(scene, strategy, PATHS, seed)
    assert found is not None
    return found


def test_of_two_lamps_that_are_picked_in_turn_the_weaker_undoes_noise_of_the_stronger() -> None:
    """One of two is picked by even chance: ``2 a b`` or ``2 c (1 - b)``, whose whole has the variance ``(a - c)²``.

    The covariance of the first with the whole is ``a (a - c)``. With a = 3 c the shares are 3/2 and -1/2.
    """
    found = told(room(2, strong=point(3.0), weak=point(1.0)))
    (strong, weak) = found.kinds["light"].values()
    assert strong.value == pytest.approx(1.5, abs=0.02)
    assert weak.value == pytest.approx(-0.5, abs=0.02)
    assert strong.low - 0.01 < 1.5 < strong.high + 0.01
    for wrong in (9.0 / 4.0, 9.0 / 10.0, 0.75):  # variances alone, over the whole's or over their sum; brightness
        assert not strong.low - 0.01 < wrong < strong.high + 0.01


def test_one_point_light_has_no_noise_but_of_what_it_lights() -> None:
    found = told(room(4, lamp=point(1.0)))
    assert found.indirect.low > 0.98
    assert abs(found.direct.value) < 0.02
    assert found.alone.value < 0.001
    assert found.seen == Interval(0.0, 0.0, 0.0)


def test_paths_cut_at_direct_light_have_no_other_noise() -> None:
    found = told(room(2, strong=point(3.0), weak=point(1.0)))
    assert found.direct.value == pytest.approx(1.0)
    assert found.indirect.value == found.indirect_alone.value == found.common.value == 0.0


def test_shares_of_each_kind_sum_to_one() -> None:
    found = told(et.load(SCENE).with_(size=(24, 24)), et.Strategy())
    for shares in found.kinds.values():
        assert sum(share.value for share in shares.values()) == pytest.approx(1.0)
    assert found.seen.value + found.direct.value + found.indirect.value == pytest.approx(1.0)
    assert found.alone.value + found.indirect_alone.value + found.common.value == pytest.approx(1.0)


def many(scene: et.Scene, repeats: int) -> float:
    """Return the share of paths of length 3 as the definition has it, with the mean of many images for the truth."""
    names, _ = split_light(scene, INDEPENDENT, 0, 0, 2)
    lengths = [i for i, (kind, _) in enumerate(names) if kind == "length"]
    runs = np.stack([split_light(scene, INDEPENDENT, 1000 + seed, 0, 8)[1][:, :, lengths] for seed in range(repeats)])
    whole, part = runs.sum(axis=3), runs[:, :, :, 2]
    apart, denominator = whole - whole.mean(axis=0), whole.mean(axis=0) ** 2 + (0.1 * whole.mean()) ** 2
    return float((part * apart / denominator).sum() / (apart * apart / denominator).sum())


def test_intervals_hold_what_many_repeats_say() -> None:
    """Of 40 intervals 2 may miss: 7 or more have a chance of 1 in 300. Of a share that is wrong by a tenth they do."""
    shine = {"type": "area", "radiance": {"type": "rgb", "value": [3.0, 3.0, 3.0]}}
    lamp = {"type": "sphere", "center": [1.2, 1.0, -1.5], "radius": 0.5, "emitter": shine}
    scene = room(4, lamp=lamp).with_(size=(12, 12))
    true = many(scene, 200)
    assert 0.6 < true < 0.8  # those of length 4 make the rest
    found = [told(scene, seed=8 * seed).kinds["length"]["3"] for seed in range(40)]
    assert sum(not share.low <= true <= share.high for share in found) < 7
    assert sum(not share.low <= 0.9 * true <= share.high for share in found) >= 7


def test_rare_light_leaves_shares_in_doubt_and_even_noise_does_not() -> None:
    assert "heavy tail" in told(et.load(SCENE).with_(size=(16, 16), max_depth=3)).doubt  # edges of the lamp
    assert not told(room(2, strong=point(3.0), weak=point(1.0))).doubt


def test_too_few_paths_tell_nothing() -> None:
    assert noise_light(room(2, lamp=point(1.0)), INDEPENDENT, LEAST_PATHS - 1) is None


@pytest.mark.parametrize("crop", [(0, 0, 400, 200), (130, 30, 260, 110), (399, 199, 1, 1), (0, 50, 400, 1)])
def test_a_large_film_is_made_smaller_with_its_crop(crop: tuple[int, int, int, int]) -> None:
    small = smaller(et.load(SCENE).with_(size=(400, 200), crop=crop), 576)
    x, y, width, height = small.model.sensor.film.crop
    assert width * height <= 1.1 * 576
    scale = small.size[0] / 400
    assert (np.abs(np.array((x, y)) - scale * np.array(crop[:2])) <= 1).all()
    assert (np.abs(np.array((width, height)) - scale * np.array(crop[2:])) <= 1).all()


def remembered(self: Pilot, pilots: list[Pilot], begin: Callable[..., None], *given: Any, **more: Any) -> None:
    pilots.append(self)
    begin(self, *given, **more)


def test_a_quote_takes_the_light_apart_within_its_pilot(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[float] = []
    monkeypatch.setattr(module, "noise_light", lambda scene, strategy, paths, *rest: given.append(paths))
    pilots: list[Pilot] = []
    monkeypatch.setattr(Pilot, "__init__", partialmethod(remembered, pilots, Pilot.__init__))
    scene, pixels = et.load(SCENE).with_(size=(32, 32)), 32 * 32
    for error in (0.05, 0.03, 0.02, 0.3):
        et.quote(scene, error=error)
        assert given[-1] == pilots[-1].left
        assert pilots[-1].taken + given[-1] <= max(8.0, 0.05 * pilots[-1]._work) * pixels + 1e-6
    assert max(given) > 0.1 * pixels
    et.quote(scene, error=0.3, why=False)
    assert len(given) == 4
    et.quote(scene, error=0.3, why=True)
    assert given[-1] == LEAST_PATHS


def test_what_is_left_of_the_samples_follows_from_the_law() -> None:
    errors = {n: Interval(n**-0.5, 0.99 * n**-0.5, 1.01 * n**-0.5) for n in (2, 4, 8, 16)}
    law = fit(errors, {n: 0.1 * n for n in errors}, "independent")
    left = law.samples_left(Interval(0.25, 0.2, 0.3))
    assert left.value == pytest.approx(0.25, rel=0.03)
    assert left.low <= 0.2 * 1.05
    assert left.high >= 0.3 * 0.95
    assert law.samples_left(Interval(0.0, 0.0, 0.1)).value == 0.0


def test_the_command_tells_which_light(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["quote", str(SCENE), "--error", "30%", "--size", "32x32"]
    assert main([*command, "--why", "-v"]) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert "which light indirect 8" in words
    assert "of the samples would do" in words
    assert main([*command, "--why", "--json"]) == 0
    light = json.loads(capsys.readouterr().out)["light"]
    assert set(light["kinds"]) == {"length", "way", "bsdf", "surface", "light"}
    assert any(": tall_box (" in what for what in light["kinds"]["surface"])
    assert 0.5 < light["indirect"]["low"] < light["indirect"]["value"] < light["indirect"]["high"]
    assert main([*command, "--no-why"]) == 0
    assert "which light" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("what", "name", "place"),
    [
        ("environment", "sky", ""),
        ("light 0: sun (/tmp/scene.toml:12)", "sun", "scene.toml:12"),
        ("shape 3: lamp", "lamp", ""),
        ("shape 3: lamp (/tmp/copy (2)/my scene.toml:12)", "lamp", "my scene.toml:12"),
        ("shape 3: lamp (left: 1) (/tmp/a.glb)", "lamp (left: 1)", "a.glb"),
        ("shape 3: lamp (left: 1)", "lamp (left: 1)", ""),
        ("shape 3: lämp) ☃", "lämp) ☃", ""),
    ],
)
def test_a_light_has_its_name_without_an_article(what: str, name: str, place: str) -> None:
    assert name_and_place(what) == (name, place)


def test_elements_with_one_name_are_told_apart_by_their_numbers() -> None:
    parts = ["none", "shape 0: ball (/tmp/a.toml:3)", "shape 2: ball (/tmp/b.toml:9)", "shape 3: floor"]
    assert list(short_names(parts).values()) == ["none", "ball (shape 0)", "ball (shape 2)", "floor"]


def test_a_scene_made_in_memory_has_names_without_places() -> None:
    parts = told(room(2, **{"lamp (left: 1)": point(1.0), "lamp": point(3.0)})).kinds
    assert set(parts["light"]) == {"light 0: lamp (left: 1)", "light 1: lamp"}
    assert not any("(" in what for what in parts["surface"])
