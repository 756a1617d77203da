"""What black pixels may hide: on images that the test makes up, and in rooms of which half is in the shade."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.film.error import PixelStatistics, image_error, pixel_statistics
from equaltime.film.lamps import Lamps
from equaltime.film.parts_of_merge import statistics_of
from equaltime.film.unseen import Unseen
from equaltime.rendering.core import core_settings
from equaltime.strategy import Strategy

from ..scene.limits import limits_that_hold

Floats = NDArray[np.float64]
OPENING = Path(__file__).parents[3] / "scenes" / "experiments" / "opening.toml"
SIDE, BRIGHT = 32, 200.0


def half_lit(seed: int, chance: float = 0.0, samples: int = 32) -> PixelStatistics:
    """Render an image whose left half is 1, little noise, and whose right half shows light of `BRIGHT` by chance."""
    rng = np.random.default_rng(seed)
    halves = 1.0 + 0.02 * rng.standard_normal((2, SIDE, SIDE))
    halves[:, :, SIDE // 2 :] = BRIGHT * rng.binomial(samples // 2, chance, (2, SIDE, SIDE // 2)) / (samples // 2)
    both = np.repeat(halves[..., None], 3, axis=-1)
    return PixelStatistics(both.mean(axis=0), np.square(both[0] - both[1]) / 4.0, np.full((SIDE, SIDE), samples), 1.0)


def everywhere(pixels: NDArray[np.uint32]) -> Floats:
    return np.full((len(pixels), 3), BRIGHT)


def test_it_widens_the_upper_limit_and_never_moves_the_estimate() -> None:
    pixels = half_lit(1)
    without, with_ = image_error(pixels), image_error(pixels, hidden=Unseen(everywhere))
    assert (with_.value, with_.low) == (without.value, without.low)
    assert with_.high > 3.0 * without.high


def test_the_rule_of_three_is_that_of_the_neighbourhood() -> None:
    pixels = half_lit(1)
    inside = math.log(2.0 / 0.1) * BRIGHT / (49 * 32)  # of the columns whose whole neighbourhood is black: 13 of 32
    square = inside**2 / (inside**2 + (0.1 * pixels.mean.mean()) ** 2)
    found = Unseen(everywhere)(pixels, 0.90)
    assert square * 13 / 32 < found < 2.0 * square * 13 / 32  # more at the border, where neighbours are fewer


def test_the_more_samples_saw_nothing_the_less_is_hidden() -> None:
    found = [Unseen(everywhere)(half_lit(1, samples=samples), 0.95) for samples in (1000, 4000, 16000)]
    assert found[0] > 2.0 * found[1] > 16.0 * found[2] > 0.0


def test_what_is_dark_for_certain_is_exempt_and_so_is_an_image_without_black() -> None:
    assert Unseen(lambda pixels: np.zeros((len(pixels), 3)))(half_lit(1), 0.95) == 0.0
    lit = half_lit(1)
    assert Unseen(everywhere)(replace(lit, mean=lit.mean + 1.0), 0.95) == 0.0


def test_a_black_image_has_no_error_if_nothing_can_be_hidden_and_any_otherwise() -> None:
    black = half_lit(1)
    black = replace(black, mean=0.0 * black.mean, variance=0.0 * black.variance)
    dark = Unseen(lambda pixels: np.zeros((len(pixels), 3)))
    assert image_error(black, hidden=dark).high == 0.0
    assert image_error(black, hidden=Unseen(everywhere)).high == image_error(black).high == math.inf


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_a_render_of_nothing_but_darkness_ends() -> None:
    scene = et.load_dict({"type": "scene", "ball": {"type": "sphere"}}).with_(size=(8, 8))
    found = et.render(scene, error=0.05, time=20.0)
    assert (found.stopped_by, found.error.high) == ("error", 0.0)


def test_black_pixels_beside_any_that_saw_light_are_left_to_their_variance() -> None:
    pixels = half_lit(1)
    pixels.mean[:, 20::7] += 0.1  # no neighbourhood is all black
    pixels.mean[:, -1] += 0.1
    assert Unseen(everywhere)(pixels, 0.95) == 0.0


def test_every_pixel_is_asked_once() -> None:
    asked: list[int] = []

    def possible(pixels: NDArray[np.uint32]) -> Floats:
        asked.extend(pixels.tolist())
        return everywhere(pixels)

    unseen = Unseen(possible)
    first, again = unseen(half_lit(1), 0.95), unseen(half_lit(1), 0.95)
    assert first == again
    assert len(asked) == len(set(asked)) <= SIDE * SIDE // 8


def hits(chance: float, hidden: Unseen | None) -> int:
    """Count the upper limits that hold where light is found with a chance."""
    truth = np.ones((SIDE, SIDE, 3))
    truth[:, SIDE // 2 :] = BRIGHT * chance
    return limits_that_hold(lambda seed: half_lit(seed, chance), truth, hidden)


@pytest.mark.parametrize("chance", [1e-5, 5e-5, 2e-4])
def test_the_upper_limit_holds_where_light_is_hardly_ever_found(chance: float) -> None:
    """At 97.5 %, fewer than 187 of 200 happen once in 1500 times."""
    assert hits(chance, Unseen(everywhere)) >= 187


def test_without_it_the_upper_limit_would_be_seen_to_fail() -> None:
    assert hits(5e-5, None) < 187


def test_a_chamber_in_the_shade_may_hide_light_and_empty_space_may_not() -> None:
    limits = [et.render(shade(), spp=spp).error for spp in (16, 256)]
    assert limits[0].high > 2.0 * limits[0].value > 0.0
    assert limits[1].high < 0.5 * limits[0].high
    ball = {"type": "sphere", "radius": 0.2, "emitter": {"type": "area", "radiance": 1.0}, "center": [0, 0, 4]}
    space = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "ball": ball}).with_(size=(24, 24))
    result = et.render(space, spp=16)
    assert (result.image == 0.0).mean() > 0.5
    assert result.moments is not None
    lamps = Lamps.of(space.core, core_settings(space, Strategy.parse("best")), 0, 1, mirrors=False)
    edge = image_error(
        pixel_statistics(result.moments),
        hidden=lambda pixels, _: lamps.missed(pixels) + lamps.outshone(pixels),
        least=lamps.least(*result.samples.shape),
    )
    assert result.error == edge, "the edge of the ball alone"


def shade() -> et.Scene:
    return et.load(OPENING).with_(size=(24, 24), max_depth=2)


def saved(folder: Path, scene: et.Scene, seed: int, spp: int) -> Path:
    path = folder / f"{seed}.exr"
    et.render(scene, spp=spp, seed=seed).save(path)
    return path


def test_merged_renders_state_the_upper_limit_of_a_render_of_the_scene_that_knows_as_much(tmp_path: Path) -> None:
    """What could have been seen is asked by each seed, at places of its own: limits may differ a little by that."""
    scene = shade()
    paths = [saved(tmp_path, scene, seed, spp) for seed, spp in ((0, 4), (1, 6), (2, 6))]
    merged = et.merge(paths)
    assert merged.moments is not None
    pixels = statistics_of(merged.moments, merged.parts)
    own = Unseen.of(scene.core, core_settings(scene, Strategy.parse("best")), 0, 1)
    one = image_error(pixels, hidden=own)
    assert (merged.error.value, merged.error.low) == (one.value, one.low)
    without = image_error(pixels).high
    added, expected = (math.sqrt(error.high**2 - without**2) for error in (merged.error, one))
    assert added == pytest.approx(expected, rel=0.1)
    assert added > 0.3 * merged.error.value, "the twin, a limit without what black pixels may hide, is far off"
    et.merge(paths[:2]).save(tmp_path / "pair.exr")
    assert et.merge([tmp_path / "pair.exr", paths[2]]).error.high == pytest.approx(merged.error.high, rel=1e-6)


def test_a_file_that_does_not_say_what_its_black_pixels_could_have_seen_may_hide_anything() -> None:
    pixels = half_lit(1)
    known = np.full((SIDE, SIDE, 3), np.nan, np.float32)
    anything = Unseen.together([{}, {}])(pixels, 0.95)
    assert anything == pytest.approx(13 / 32)
    assert Unseen.together([{}, {"unseen": known}])(pixels, 0.95) == anything
    known[:] = 0.0
    assert Unseen.together([{}, {"unseen": known}])(pixels, 0.95) == 0.0


def test_of_what_the_parts_could_have_seen_the_most_counts() -> None:
    parts = [{"unseen": np.full((SIDE, SIDE, 3), radiance, np.float32)} for radiance in (0.5, 2.0, 1.0)]
    together = Unseen.together([*parts, {}])
    assert together(half_lit(1), 0.95) == Unseen.together([parts[1]])(half_lit(1), 0.95)
    np.testing.assert_array_equal(together.parts(SIDE, SIDE)["unseen"], parts[1]["unseen"])
