"""Lamps smaller than a pixel: how they are found, against renders of them alone, and what renders may lack.

A z-test here rejects beyond 4.9 standard errors: of 1100 numbers, by chance in one run of a thousand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.film import lamps as lamps_module
from equaltime.film.error import PixelStatistics, image_error
from equaltime.film.lamps import Lamps
from equaltime.film.parts_of_merge import statistics_of
from equaltime.film.sums import lamps_in_sight
from equaltime.film.unseen import Unseen
from equaltime.rendering.core import core_settings, make_renderer
from equaltime.strategy import Strategy

from ..scene.limits import limits_that_hold

Floats = NDArray[np.float64]
SIDE, Z_LIMIT = 12, 4.9
ALONE = Strategy.parse("bsdf,sampler=independent")


def bulbs(radius: float = 0.06, **more: Any) -> dict[str, Any]:
    """Return a scene of three lamps, of which one is half behind a screen, and one seen by its edge."""
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}}
    ball = {"type": "sphere", "radius": radius}
    return {
        "type": "scene",
        "sensor": {"type": "perspective", "fov": 40, "film": film},
        "red": {**ball, "center": [0.3, 0.21, 4], "emitter": {"type": "area", "radiance": [40.0, 10.0, 5.0]}},
        "white": {**ball, "center": [-0.7, -0.4, 5], "emitter": {"type": "area", "radiance": 7.0}},
        "panel": {
            "type": "rectangle",
            "to_world": [{"rotate": {"axis": [0, 1, 0], "angle": 150}}, {"scale": 0.2}, {"translate": [0.6, -0.6, 3]}],
            "emitter": {"type": "area", "radiance": 3.0},
        },
        "screen": {"type": "rectangle", "to_world": [{"scale": 0.2}, {"translate": [-0.75, -0.25, 4.0]}]},
        **more,
    }


def sensor(rfilter: str = "box", **more: Any) -> dict[str, Any]:
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": rfilter}}
    return {"sensor": {"type": "perspective", "fov": 40, "film": film, **more}}


SCENES = {
    "pinhole": {},
    "lens": sensor(type="thinlens", aperture_radius=0.1, focus_distance=3.0),
    "tent": sensor("tent"),
    "gaussian": sensor("gaussian"),
    "mitchell": sensor("mitchell"),
    "clipped": sensor(near_clip=3.96),
    "shifted": sensor(principal_point_offset_x=0.1, principal_point_offset_y=-0.15),
    "sky": {"sky": {"type": "constant", "radiance": 0.1}},
}


def worst(scene: dict[str, Any], other: dict[str, Any]) -> float:
    """Return the largest z of what lamps of a scene are said to add to pixels, against samples of another scene."""
    loaded, rendered = (et.load_dict(s).with_(max_depth=1) for s in (scene, other))
    said = np.zeros((2, SIDE * SIDE, 3))
    made_of = np.ones((SIDE * SIDE, 1))
    pixels, moments, points = lamps_in_sight(loaded.core, core_settings(loaded, ALONE), 3, 1 << 19)
    said[:, pixels], made_of[pixels, 0] = np.moveaxis(moments, 1, 0), points
    mean, squares = said
    samples = 1 << 14
    renderer = make_renderer(rendered, ALONE, 1, 1)
    renderer.advance(samples)
    rare = np.maximum(squares - np.square(mean), squares / samples) / samples  # one sample that meets it, at least
    noise = np.sqrt(rare + 4.0 * np.square(mean) / made_of)
    return float(
        (np.abs(mean - renderer.moments["mean"].mean(axis=0).reshape(-1, 3)) / np.where(noise > 0.0, noise, 1e-9)).max()
    )


@pytest.mark.parametrize("name", SCENES)
def test_lamps_are_what_samples_see_of_them(name: str) -> None:
    assert worst(bulbs(**SCENES[name]), bulbs(**SCENES[name])) < Z_LIMIT


@pytest.mark.parametrize("name", SCENES)
def test_lamps_a_little_larger_are_seen_to_be_others(name: str) -> None:
    assert worst(bulbs(**SCENES[name]), bulbs(radius=0.065, **SCENES[name])) > Z_LIMIT


@pytest.mark.parametrize(
    "what",
    [
        {"integrator": {"type": "path", "hide_emitters": True}},
        {"sensor": {"type": "orthographic", "film": bulbs()["sensor"]["film"]}},
        {name: {"type": "sphere", "center": [0, 0, 5]} for name in ("red", "white", "panel")},
    ],
    ids=["hidden", "orthographic", "none"],
)
def test_where_no_lamp_can_be_seen_or_none_is_looked_for_there_is_nothing(what: dict[str, Any]) -> None:
    scene = et.load_dict(bulbs(**what))
    assert lamps_in_sight(scene.core, core_settings(scene, ALONE), 0, 64)[0].size == 0


def test_lamps_of_a_quarter_of_a_pixel_or_more_and_skies_are_no_small_ones() -> None:
    for scene in (
        bulbs(radius=0.5),
        bulbs(**{**SCENES["sky"], "red": {"type": "sphere"}, "white": {"type": "sphere"}}),
    ):
        loaded = et.load_dict({**scene, "panel": {"type": "sphere"}})
        found = Lamps.of(loaded.core, core_settings(loaded, ALONE), 0, 1, mirrors=False)
        assert SIDE * SIDE // 2 + SIDE // 2 + 1 not in found.pixels


def test_a_crop_sees_the_lamps_of_its_part() -> None:
    film = {**bulbs()["sensor"]["film"], "rfilter": {"type": "tent"}}
    part = {**film, "crop_offset_x": 2, "crop_offset_y": 3, "crop_width": 7, "crop_height": 5}
    whole, crop = (
        Lamps.of(scene.core, core_settings(scene, ALONE), 0, 1, mirrors=False).channels(*scene.core.film_shape)
        for scene in (et.load_dict(bulbs(sensor={"type": "perspective", "fov": 40, "film": f})) for f in (film, part))
    )
    assert crop.any()
    np.testing.assert_array_equal(crop, whole[3:8, 2:9])


BRIGHT, SHARE, PICTURE = 400.0, 1.0 / 4000.0, 20
"""A lamp and its share of a pixel, which it makes a tenth brighter; something that is far brighter is near."""
UNLIT = np.ones((PICTURE, PICTURE, 3))
UNLIT[5, 9] = 80.0
TRUTH = UNLIT.copy()
TRUTH[8, 9] += BRIGHT * SHARE


def met(seed: int, samples: int) -> PixelStatistics:
    """Render a plain image with a lamp, by samples as even as can be: replicates meet it alike but for one."""
    rng = np.random.default_rng(seed)
    halves = UNLIT[..., 0] + 0.3 * rng.standard_normal((2, PICTURE, PICTURE)) / math.sqrt(samples / 2)
    halves[:, 8, 9] += BRIGHT * np.floor(samples / 2 * SHARE + rng.random(2)) / (samples / 2)
    both = np.repeat(halves[..., None], 3, axis=-1)
    counts = np.full((PICTURE, PICTURE), samples)
    return PixelStatistics(both.mean(axis=0), np.square(both[0] - both[1]) / 4.0, counts, 1.0)


def lamps_of(pixels: NDArray[np.intp], light: float, share: NDArray[np.float64]) -> Lamps:
    """Return lamps that all give their pixels the same light."""
    given = np.full((len(pixels), 3), light)
    return Lamps.small(pixels, given, share)


def the_lamp() -> Lamps:
    return lamps_of(np.array([8 * PICTURE + 9]), BRIGHT * SHARE, np.array([SHARE]))


def everywhere_dark(pixels: NDArray[np.uint32]) -> Floats:
    return np.zeros((len(pixels), 3))


def hits(samples: int, lamps: Callable[[], Lamps]) -> int:
    """Count the upper limits that hold after so many samples a pixel."""
    hidden = Unseen(everywhere_dark, lamps=lamps)
    return limits_that_hold(lambda seed: met(seed, samples), TRUTH, hidden)


@pytest.mark.parametrize(
    "samples", [100, 500, 1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 8000, 12000, 20000, 60000]
)
def test_the_upper_limit_holds_long_before_a_lamp_is_met_and_once_it_was(samples: int) -> None:
    """At 97.5 %, fewer than 187 of 200 happen once in 1500 times."""
    assert hits(samples, the_lamp) >= 187


@pytest.mark.parametrize("samples", [1500, 4000, 20000])
def test_without_it_the_upper_limit_would_be_seen_to_fail(samples: int) -> None:
    assert hits(samples, Lamps.none) < 187


def lacks(expected: float, *meetings: tuple[int, int], pixels: int = 1, beneath: float = 0.0) -> float:
    """Return error², over that of its light, that pixels hide with a lamp each that two replicates met so often.

    Beside them is what is far brighter, and beneath the lamps is other light.
    """
    samples, light, beside = 1000, 1e-3, 5.0 * pixels
    halves = np.full((2, pixels + 1), beside)
    halves[:, :-1] = np.resize(np.transpose(meetings), (2, pixels)) / expected * light + beneath
    both = np.repeat(halves[:, None, :, None], 3, axis=-1)
    lamps = lamps_of(np.arange(pixels), light, np.full(pixels, 2.0 * expected / samples))
    mean, variance = both.mean(axis=0), np.square(both[0] - both[1]) / 4.0
    added = lamps.missed(PixelStatistics(mean, variance, np.full((1, pixels + 1), samples), 1.0))
    return added * (pixels + 1) * (0.1 * mean.mean() / light) ** 2


@pytest.mark.parametrize("expected", [0.01, 0.1, 0.3, 0.5, 0.8, 1.4])
def test_a_dark_pixel_whose_replicates_missed_its_lamp_hides_that_it_lacks(expected: float) -> None:
    assert lacks(expected, (0, 0)) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(("expected", "met"), [(0.2, 1), (0.4, 1), (0.9, 2)])
def test_one_whose_replicates_met_it_too_soon_hides_that_it_is_too_bright(expected: float, met: int) -> None:
    assert lacks(expected, (met, met)) == pytest.approx((met / expected - 1.0) ** 2, rel=1e-3)


def test_what_happens_once_in_forty_times_or_less_is_left_aside() -> None:
    assert lacks(0.1, (1, 1)) < 2.0 < (1 / 0.1 - 1.0) ** 2


@pytest.mark.parametrize("expected", [0.3, 1.0, 2.6])
def test_of_many_pixels_those_whose_replicates_differ_show_what_the_others_hide(expected: float) -> None:
    """Meetings are as frequent as the module says, and bright pixels do not tell; what is left is the worst one's."""
    times, chances = (of[0] for of in lamps_module._meetings(np.array([expected]), 1.0))
    often = np.rint(5000 * np.outer(chances, chances)).astype(int)
    met = np.repeat(np.rint(times * expected)[np.indices(often.shape)].reshape(2, -1), often.ravel(), axis=1)
    found, without = (lacks(expected, *of.T, pixels=of.shape[1], beneath=0.1) for of in (met, met[:, met[0] == met[1]]))
    assert found < 0.01 * without


def test_a_lamp_met_much_too_soon_brightens_nothing_that_errors_are_divided_by() -> None:
    """Eight samples, of which one should meet it in two thousand: it does in one replicate, amid what is dark."""
    light, share, samples, side = 0.05, 5e-4, 8, 32
    truth = np.full((side, side, 3), 0.3)
    halves = truth * np.random.default_rng(3).normal(1.0, 0.3, (2, side, side, 1))
    truth[6, 6] += light
    halves[0, 6, 6] += light / share / (samples / 2)
    mean, variance = halves.mean(axis=0), np.square(halves[0] - halves[1]) / 4.0
    pixels = PixelStatistics(mean, variance, np.full((side, side), samples), 1.0)
    error = math.sqrt((np.square(mean - truth) / (np.square(truth) + (0.1 * truth.mean()) ** 2)).mean())
    lamps = lamps_of(np.array([6 * side + 6]), light, np.array([share]))
    value = image_error(pixels).value
    assert value < 0.9 * error, "which needs it"
    assert error < math.hypot(value, math.sqrt(lamps.outshone(pixels))) < 1.2 * error


def test_it_widens_the_upper_limit_while_replicates_may_have_missed_the_lamp_and_never_moves_the_estimate() -> None:
    added = []
    for samples in (3000, 8000, 20000, 400000):
        with_, without = (
            image_error(met(2, samples), hidden=Unseen(everywhere_dark, lamps=lamps))
            for lamps in (the_lamp, Lamps.none)
        )
        assert (with_.value, with_.low) == (without.value, without.low)
        added.append(with_.high / without.high)
    assert min(added[:-1]) > 1.2 > added[-1] == 1.0


def test_merged_renders_know_the_lamps_of_their_parts(tmp_path: Path) -> None:
    scene = et.load_dict(bulbs(floor={"type": "rectangle", "to_world": [{"scale": 9}, {"translate": [0, 0, 6]}]}))
    paths = [tmp_path / f"{seed}.exr" for seed in (1, 2)]
    parts = [et.render(scene, spp=16, seed=seed) for seed in (1, 2)]
    for part, path in zip(parts, paths, strict=True):
        part.save(path)
    merged = et.merge(paths)
    lamps = Lamps.from_channels(*(part.missed["lamps"] for part in parts))
    np.testing.assert_array_equal(merged.missed["lamps"], lamps.channels(SIDE, SIDE))
    assert merged.moments is not None
    pixels = statistics_of(merged.moments, merged.parts)
    assert merged.error.high > image_error(pixels, least=lamps.least(SIDE, SIDE)).high * 1.0001
