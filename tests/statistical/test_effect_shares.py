"""The price list is right: on scenes where the share of the variance, or the change, is known in closed form."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.quoting.light_parts import LightParts, measure_parts
from equaltime.quoting.pairs import Versus, change_of, products, run_in_turn, share_of
from equaltime.scene.effects.kinds import derive
from equaltime.statistics.intervals import Interval

PIXELS = 24
STRATEGY = et.Strategy.parse("best,sampler=independent,lights=uniform")
REPEATS, SAMPLES = 24, 32


def facing_camera(**objects: Any) -> et.Scene:
    """A camera that sees the unit square of z = 0 by parallel rays."""
    film = {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "rfilter": {"type": "box"}}
    look = np.diag([-1.0, 1.0, -1.0, 1.0])
    look[2, 3] = 2.0
    sensor = {"type": "orthographic", "to_world": look.tolist(), "film": film}
    return et.load_dict({"type": "scene", "integrator": {"type": "path", "max_depth": 4}, "sensor": sensor, **objects})


def lamp_of_squares_behind_a_veil(bright: float = 3.0) -> et.Scene:
    """Half of every pixel is `bright`, half is 1; half of the light is taken by a black veil."""
    squares = {
        "type": "checkerboard",
        "color0": [bright] * 3,
        "color1": [1.0] * 3,
        "to_uv": np.diag([PIXELS, PIXELS, 1.0, 1.0]).tolist(),
    }
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0] * 3}}
    above = np.eye(4)
    above[2, 3] = 0.5
    return facing_camera(
        lamp={"type": "rectangle", "bsdf": black, "emitter": {"type": "area", "radiance": squares}},
        veil={"type": "rectangle", "to_world": above.tolist(), "bsdf": {"type": "mask", "opacity": 0.5, "bsdf": black}},
    )


def two_suns() -> et.Scene:
    """One light sends three times what the other does; either is picked half of the time."""
    return facing_camera(
        floor={"type": "rectangle", "bsdf": {"type": "diffuse"}},
        strong={"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "rgb", "value": [3.0] * 3}},
        weak={"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "rgb", "value": [1.0] * 3}},
    )


@pytest.fixture(scope="module")
def without_texture() -> Versus:
    scene = lamp_of_squares_behind_a_veil()
    whole, less = run_in_turn(scene, STRATEGY, {"": ("textures",)}, REPEATS, SAMPLES, threads=1)
    return Versus.of(whole, less[""])


@pytest.fixture(scope="module")
def by_light() -> LightParts:
    return measure_parts(two_suns(), STRATEGY, REPEATS, SAMPLES, threads=1)


def covers(interval: Interval, truth: float) -> bool:
    return interval.low <= truth <= interval.high


def test_the_share_of_a_texture_is_that_of_the_closed_form(without_texture: Versus) -> None:
    """Let T be the lamp, 3 or 1, and B what the veil lets pass, 0 or 1: Cov(B (T - 2), B T) = 1/2, Var(B T) = 3/2."""
    share = without_texture.variance
    assert covers(share, 1.0 / 3.0)
    assert share.high - share.low < 0.06


def test_a_share_without_means_taken_off_is_found_wrong() -> None:
    """The same with products for covariances is 1/5: the test above would not pass it."""
    scene = lamp_of_squares_behind_a_veil()
    whole, less = run_in_turn(scene, STRATEGY, {"": ("textures",)}, REPEATS, 1, threads=1)
    part, one = whole.images - less[""].images, np.ones_like(whole.images[0])
    wrong = np.trace(products(part, whole.images, one)) / np.trace(products(whole.images, whole.images, one))
    assert abs(wrong - 0.2) < 0.02
    share = Versus.of(whole, less[""]).variance
    assert not covers(share, wrong)


def test_a_scene_a_little_different_is_found_to_be_so(without_texture: Versus) -> None:
    """With 3.3 for 3 the share is 0.38."""
    m, v = 0.5 * (3.3 + 1.0), (0.5 * (3.3 - 1.0)) ** 2
    assert not covers(without_texture.variance, v / (v + 0.5 * m * m))


def test_shares_of_lights_are_those_of_the_closed_form_though_one_is_negative(by_light: LightParts) -> None:
    """Of lights a and b, each picked half of the time, Var = (a - b)² and Cov(part of a, whole) = a (a - b).

    Either part is a multiple of the whole less a constant: these shares have no spread.
    """
    strong, weak = by_light.shares("light").values()
    assert strong.value == pytest.approx(1.5, abs=1e-6)
    assert weak.value == pytest.approx(-0.5, abs=1e-6)


def test_a_light_a_tenth_brighter_is_found_to_be_so(by_light: LightParts) -> None:
    strong, _ = by_light.shares("light").values()
    assert strong.value != pytest.approx(3.3 / (3.3 - 1.0), abs=0.05)


@pytest.mark.parametrize("kind", ["length", "way", "bsdf", "light"])
def test_shares_sum_to_one(by_light: LightParts, kind: str) -> None:
    assert sum(share.value for share in by_light.shares(kind).values()) == pytest.approx(1.0)


def test_the_change_without_an_environment_is_that_of_the_closed_form() -> None:
    """A floor under a sky of 0.1 π and a directional light of 1: without the sky the image is 10/11 of what it was."""
    scene = facing_camera(
        floor={"type": "rectangle", "bsdf": {"type": "diffuse"}},
        sun={"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "rgb", "value": [math.pi] * 3}},
        sky={"type": "constant", "radiance": {"type": "rgb", "value": [0.1] * 3}},
    )
    whole, less = run_in_turn(scene, STRATEGY, {"": ("environment",)}, REPEATS, SAMPLES, threads=1)
    change, expected = Versus.of(whole, less[""]).change, (1.0 / 11.0) / math.sqrt(1.01)
    assert covers(change, expected)
    assert change.high - change.low < 0.1 * expected
    assert not covers(change, 1.1 * expected)
    assert list(derive(scene)) == ["point_lights", "environment", "lens", "many_lights", "long_paths"]


def test_intervals_of_shares_cover_in_95_percent_of_cases() -> None:
    """Of Gaussian images: 400 cases, of which 95 % are 380 ± 4.4; fewer than 363 or more than 395 are a false alarm of
    one in ten thousand. An interval half as wide is found out."""
    random = np.random.default_rng(7)
    covered = narrow = 0
    for _ in range(400):
        part = random.normal(size=(REPEATS, 6, 6, 3))
        whole = 1.0 + part + math.sqrt(2.0) * random.normal(size=part.shape)
        one = np.ones_like(whole[0])
        share = share_of(products(part, whole, one), products(whole, whole, one))
        half = 0.25 * (share.high - share.low)
        covered += covers(share, 1.0 / 3.0)
        narrow += abs(share.value - 1.0 / 3.0) <= half
    assert 363 <= covered <= 395
    assert narrow < 330


def test_the_change_of_nothing_but_noise_is_not_told_from_zero() -> None:
    noise = np.random.default_rng(3).normal(size=(REPEATS, 16, 16, 3))
    change = change_of(products(noise, noise, np.ones_like(noise[0])), samples=16)
    assert change.low == 0.0
    assert change.value < 0.1


@pytest.mark.slow
def test_intervals_of_a_real_scene_cover_what_many_runs_agree_on() -> None:
    """Of 100 price lists of six short runs of the Cornell box, 95 ± 2.2 cover the mean of all.

    Fewer than 87 are a false alarm of one in 3000. Intervals a third as wide are found out.
    """
    scene = et.load(Path(__file__).parents[2] / "scenes" / "cornell-box.toml").with_(size=(16, 16))
    found: dict[str, list[Interval]] = {"change": [], "variance": [], "share": [], "cut": []}
    for seed in range(0, 100_000, 1000):
        whole, less = run_in_turn(scene, et.Strategy(), {"": ("long_paths=3",)}, 6, 4, seed=seed, threads=1)
        versus = Versus.of(whole, less[""])
        parts = measure_parts(scene, et.Strategy(), 6, 4, seed=seed + 500, threads=1)
        found["change"].append(versus.change)
        found["variance"].append(versus.variance)
        found["share"].append(parts.share("length", lambda what: int(what.split()[0]) > 3))
        found["cut"].append(parts.truncated()[3])
    for name, intervals in found.items():
        truth = float(np.mean([interval.value for interval in intervals]))
        assert sum(covers(interval, truth) for interval in intervals) >= 87, name
        narrow = [abs(i.value - truth) <= (i.high - i.low) / 6.0 for i in intervals]
        assert sum(narrow) < 87, name
