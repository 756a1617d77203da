"""Second nets of some pixels, by which the error of pixels with one net each is known."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime.film.error import image_error, pixel_statistics
from equaltime.film.moments import DTYPE, stored
from equaltime.film.second_nets import FEWEST, SecondNets, statistics
from equaltime.film.sums import second_net_pixels
from equaltime.quoting.probe import Probe
from equaltime.rendering import core as core_renderer
from equaltime.rendering.budget import Limits
from equaltime.rendering.core import core_settings, nets
from equaltime.rendering.job import Job
from equaltime.rendering.render_file import read_film
from equaltime.rendering.session import Session

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
LATTICE = "best,sampler=lattice,adaptive=none"
Floats = NDArray[np.float64]


@pytest.fixture
def one_net(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let small pictures have one net a pixel too."""
    monkeypatch.setattr(core_renderer, "ONE_NET", 1)
    monkeypatch.setattr(core_renderer, "_SECOND_NETS", 64)


def scene(width: int = 24, height: int = 20, **changes: Any) -> et.Scene:
    return et.load(SCENE).with_(size=(width, height), max_depth=4, **changes)


def renderer(**options: Any) -> _core.Renderer:
    loaded = scene()
    settings = core_settings(loaded, et.Strategy.parse(LATTICE))
    made = _core.Renderer(loaded.core, settings, seed=3, **{"nets": 1, "second_net": 4, **options})
    made.advance(6)
    return made


@pytest.mark.parametrize("share", [1, 2, 4, 8, 16, 32])
@pytest.mark.parametrize("size", [(64, 32), (61, 35), (5, 3)])
def test_each_rectangle_of_pixels_has_one_within_it(share: int, size: tuple[int, int]) -> None:
    width, height = size
    wide, high = 1 << (share.bit_length() // 2), 1 << ((share.bit_length() - 1) // 2)
    found = second_net_pixels(7, width, height, share)
    assert wide * high == share
    assert found.shape == (-(-height // high), -(-width // wide))
    v, u = np.nonzero(found >= 0)
    y, x = np.divmod(found[v, u], width)
    np.testing.assert_array_equal((y // high, x // wide), (v, u))
    whole = found[: height // high, : width // wide]
    assert (whole >= 0).all(), "one is missing only where the film ends within a rectangle"


def test_seeds_draw_all_places_alike() -> None:
    counts = np.zeros((8, 16), int)
    for seed in range(4000):
        counts.reshape(-1)[second_net_pixels(seed, 16, 8, 32).ravel()] += 1
    expected = 4000 / 32
    chi_square = float((np.square(counts - expected) / expected).sum())
    assert 70.0 < chi_square < 190.0  # of 124 degrees of freedom: false alarms 1e-4


@pytest.mark.parametrize("share", [0, 3, 64])
def test_other_shares_are_refused(share: int) -> None:
    with pytest.raises(ValueError, match="a power of two up to 32"):
        second_net_pixels(0, 8, 8, share)


def test_a_second_net_is_not_in_the_image() -> None:
    with_second, without = renderer(), renderer(second_net=0)
    assert with_second.moments.tobytes() == without.moments.tobytes()
    assert without.second_moments.size == 0
    assert renderer(nets=2, second_net=0).moments.tobytes() != without.moments.tobytes(), "the twin: two nets"


def test_its_samples_are_those_that_follow_2_to_the_32nd() -> None:
    loaded, made = scene(), renderer()
    settings = core_settings(loaded, et.Strategy.parse(LATTICE))
    y, x = divmod(int(made.second_pixels[2, 3]), 24)
    replayed = [_core.replay(loaded.core, settings, 3, x, y, (1 << 32) + i, nets=1)["radiance"] for i in range(6)]
    own = [_core.replay(loaded.core, settings, 3, x, y, i, nets=1)["radiance"] for i in range(6)]
    for half, part in enumerate((slice(4), slice(4, 6))):
        found = made.second_moments[half, 2, 3]["mean"]
        np.testing.assert_allclose(found, np.mean(replayed[part], axis=0), rtol=1e-6)
        np.testing.assert_allclose(made.moments[half, y, x]["mean"], np.mean(own[part], axis=0), rtol=1e-6)
    assert not np.allclose(np.mean(own, axis=0), np.mean(replayed, axis=0)), "two nets are different ones"


def test_the_bits_depend_on_no_thread_and_no_block() -> None:
    first = renderer()
    for options in ({"threads": 1}, {"threads": 3}, {"tile": 5}):
        other = renderer(**options)
        assert other.second_moments.tobytes() == first.second_moments.tobytes()
        assert other.moments.tobytes() == first.moments.tobytes()


def test_a_crop_has_the_pixels_of_the_whole(one_net: None) -> None:
    whole = et.render(scene(), spp=4, strategy=LATTICE)
    crop = et.render(scene(crop=(5, 3, 8, 9)), spp=4, strategy=LATTICE)
    np.testing.assert_array_equal(crop.image, whole.image[3:12, 5:13])


def drawn(seed: int, shared: float, size: int = 96) -> tuple[NDArray[Any], SecondNets, Floats]:
    """Return moments of one net a pixel, second nets, and the truth: replicates differ by more than the net is wrong.

    Of the noise of each replicate, a part with the opposite sign is in the other, and a ``shared`` one in both.
    """
    rng = np.random.default_rng(seed)
    truth = 1.0 + 0.5 * np.sin(np.arange(size) / 9.0)[:, None, None] * np.ones((1, size, 3))

    def net(mean: Floats) -> NDArray[Any]:
        moments = np.zeros((2, *mean.shape[:2]), DTYPE)
        common, apart = shared * rng.standard_normal(mean.shape), rng.standard_normal(mean.shape)
        moments["mean"] = mean * (1.0 + 0.1 * np.stack([common + apart, common - apart]))
        moments["count"] = 8
        moments["deviation"] = stored(0.1 * math.sqrt(8.0) * np.broadcast_to(mean, (2, *mean.shape)))
        return moments

    image = net(truth)
    pixels = second_net_pixels(seed, size, size, 8)
    places = np.divmod(pixels, size)
    return image, SecondNets(net(truth[places]), pixels), truth


@pytest.mark.parametrize("shared", [0.5, 0.8, 1.0, 1.3])
def test_the_variance_is_that_of_the_net(shared: float) -> None:
    stated, believed, doubts = [], [], []
    for seed in range(40):
        moments, second, truth = drawn(seed, shared)
        pixels = statistics(moments, second)
        true = np.square(0.1 * shared * truth).mean()
        stated.append(float(pixels.variance.mean()) / true)
        believed.append(float(pixel_statistics(moments).variance.mean()) / true)
        doubts.append(pixels.common_doubt)
    scatter = float(np.std(stated, ddof=1))
    assert abs(np.mean(stated) - 1.0) < 4.0 * scatter / np.sqrt(40.0)  # false alarms: 1e-4
    assert 0.7 < scatter / np.mean(doubts) < 1.4, "the doubt is the scatter of the factor"
    if shared != 1.0:
        assert abs(np.mean(believed) - 1.0) > 20.0 * scatter / np.sqrt(40.0), "the twin: replicates alone"


def test_what_one_pixel_says_beyond_all_measured_ones_is_taken_as_it_is() -> None:
    moments, second, _ = drawn(0, 0.5)
    measured = set(second.pixels.ravel())
    rare = next(pixel for pixel in range(5000, 6000) if pixel not in measured)
    y, x = divmod(rare, 96)
    moments["mean"][0, y, x], moments["deviation"][0, y, x] = 1000.0, stored(np.full(3, 1000.0 * math.sqrt(7.0)))
    pixels = statistics(moments, second)
    plain = pixel_statistics(moments)
    assert pixels.variance[y, x, 0] > 0.99 * plain.variance[y, x, 0]
    assert pixels.variance[y, x - 5, 0] < 0.5 * plain.variance[y, x - 5, 0]


def test_the_largest_parts_that_make_a_fifth_are_reduced_less() -> None:
    """The share varies by 0.006 between seeds, as an eighth of the pixels tells the limit."""
    moments, second, truth = drawn(4, 0.5)
    pixels = statistics(moments, second)
    assert pixels.factors is not None
    parts = (pixels.spread / (np.square(truth) + np.square(0.1 * truth.mean()))).mean(axis=-1)
    large = pixels.factors > pixels.factors.min() * (1.0 + 1e-9)
    assert 0.17 < parts[large].sum() / parts.sum() < 0.23
    assert parts[large].min() > 0.7 * parts[~large].max(), "the largest, except that these weights are not quite theirs"


@pytest.mark.parametrize("later", [2, 4, 8])
def test_a_bright_sample_shows_its_own_size_however_small_the_second_half_is(later: int) -> None:
    """One sample of brightness x among N adds x² / N² to the variance of the mean if samples are independent."""
    moments, second, _ = drawn(0, 1.3)
    measured = set(second.pixels.ravel())
    y, x = divmod(next(pixel for pixel in range(5000, 6000) if pixel not in measured), 96)
    for film in (moments, second.moments):
        film["count"][1] = later
    bright = 1000.0 * later
    moments["mean"][:, y, x] = np.array([0.0, bright / later])[:, None]
    moments["deviation"][:, y, x] = stored(np.array([0.0, bright * math.sqrt(1 / later - 1 / later**2)])[:, None])
    pixels, count = statistics(moments, second), 8 + later
    share = np.square(bright / count)
    assert pixels.spread[y, x, 0] == pytest.approx(min(8 / later, 2.0) * share, rel=1e-5)
    plain = pixel_statistics(moments).variance[y, x, 0]
    assert plain == pytest.approx(8 / later * share), "the twin: the difference of the halves alone"


def test_it_widens_the_interval_of_the_error() -> None:
    moments, second, _ = drawn(1, 0.8)
    pixels = statistics(moments, second)
    doubted = image_error(replace(pixels, common_doubt=0.3))
    error = image_error(pixels)
    assert doubted.value == error.value
    assert doubted.high / doubted.low > 1.5 * error.high / error.low


def test_too_few_tell_nothing() -> None:
    moments, second, _ = drawn(2, 0.5, size=16)
    assert (second.pixels >= 0).sum() < FEWEST
    np.testing.assert_array_equal(statistics(moments, second).variance, pixel_statistics(moments).variance)


def test_at_scales_that_float64_cannot_square_nothing_is_told() -> None:
    moments, second, _ = drawn(3, 0.5)
    moments["mean"] *= 1e300
    second.moments["mean"] *= 1e300
    with np.errstate(over="ignore"):
        plain = pixel_statistics(moments)
    with np.errstate(over="ignore"):
        np.testing.assert_array_equal(statistics(moments, second).variance, plain.variance)


def test_a_render_with_one_net_is_saved_and_taken_up(one_net: None, tmp_path: Path) -> None:
    whole = et.render(scene(), spp=24, strategy=LATTICE, seed=5)
    et.render(scene(), spp=10, strategy=LATTICE, seed=5).save(tmp_path / "a.exr")
    taken_up = et.render(scene(), spp=24, strategy=LATTICE, seed=5, resume=tmp_path / "a.exr")
    assert whole.record["nets"] == 1
    assert whole.record["second_net"] == 4
    assert whole.record["common_doubt"] > 0.0
    np.testing.assert_array_equal(taken_up.image, whole.image)
    np.testing.assert_array_equal(taken_up.standard_error, whole.standard_error)
    assert taken_up.error == whole.error
    assert taken_up.second is not None
    assert whole.second is not None
    assert taken_up.second.moments.tobytes() == whole.second.moments.tobytes()
    taken_up.save(tmp_path / "b.exr")
    moments, _, second = read_film(tmp_path / "b.exr")
    assert moments is not None
    assert second is not None
    np.testing.assert_array_equal(
        statistics(moments, second).variance,
        statistics(whole.moments, whole.second).variance,
    )


def table(bsdf: dict[str, Any], radius: float, **more: Any) -> et.Scene:
    """Return a ball on a table, and a lamp beside the camera."""
    look = {"look_at": {"origin": [0, 2, 4], "target": [0, 0, 0], "up": [0, 1, 0]}}
    film = {"type": "hdrfilm", "width": 24, "height": 20}
    lamp = {"type": "sphere", "center": [2, 5, 4], "radius": radius, "emitter": {"type": "area", "radiance": 10.0}}
    return et.load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective", "fov": 40, "to_world": [look], "film": film},
            "table": {"type": "rectangle", "to_world": [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 4}]},
            "ball": {"type": "sphere", "center": [0, 0.5, 0], "radius": 0.5, "bsdf": bsdf},
            "lamp": lamp,
            **more,
        }
    )


GLASS, MATTE = {"type": "dielectric"}, {"type": "diffuse"}


@pytest.mark.parametrize(
    ("bsdf", "radius", "expected"),
    [(GLASS, 0.05, 2), (GLASS, 2.0, 1), (MATTE, 0.05, 1)],
    ids=["glass and a small lamp", "glass and a large lamp", "nothing specular"],
)
def test_rarely_met_light_takes_two_nets(one_net: None, bsdf: dict[str, Any], radius: float, expected: int) -> None:
    """At 256x256, one net of Veach's plates stated too low an error, and second nets in a few pixels did not see it."""
    strategy = et.Strategy.parse(LATTICE)
    assert nets(table(bsdf, radius), strategy) == expected


@pytest.mark.parametrize(("radius", "expected"), [(0.002, 2), (0.5, 1)], ids=["a bulb", "a lamp of many pixels"])
def test_lamps_smaller_than_a_pixel_take_two_nets(one_net: None, radius: float, expected: int) -> None:
    """Even a large lamp has pixels along its edge that few samples meet, but more that all do."""
    bulb = {"type": "sphere", "center": [0, 1.1, 0], "radius": radius, "emitter": {"type": "area", "radiance": 1e5}}
    assert nets(table(MATTE, 0.05, bulb=bulb), et.Strategy.parse(LATTICE)) == expected


def test_a_crop_has_as_many_nets_as_the_whole_film(one_net: None) -> None:
    whole, strategy = table(GLASS, 0.05), et.Strategy.parse(LATTICE)
    corner = whole.with_(crop=(0, 18, 2, 2))  # sees nothing of the ball
    assert nets(corner, strategy) == nets(whole, strategy) == 2
    a, b = (et.render(each, spp=4, strategy=LATTICE) for each in (whole, corner))
    np.testing.assert_array_equal(a.image[18:, :2], b.image)


def test_one_net_is_not_taken_up_as_two(one_net: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    et.render(scene(), spp=4, strategy=LATTICE).save(tmp_path / "a.exr")
    monkeypatch.setattr(core_renderer, "ONE_NET", 2**20)
    with pytest.raises(et.ImageError, match="point sets in a pixel: 1, not 2"):
        et.render(scene(), spp=8, strategy=LATTICE, resume=tmp_path / "a.exr")


def test_renders_with_one_net_are_merged(one_net: None, tmp_path: Path) -> None:
    paths = [tmp_path / f"{seed}.exr" for seed in range(3)]
    parts = [et.render(scene(32, 32), spp=16, strategy=LATTICE, seed=seed) for seed in range(3)]
    for part, path in zip(parts, paths, strict=True):
        part.save(path)
    merged = et.merge(paths)
    np.testing.assert_allclose(merged.image, np.mean([part.image for part in parts], axis=0), rtol=1e-5)
    assert merged.record["common_doubt"] == max(part.common_doubt for part in parts)
    assert 0.4 < merged.error.value / parts[0].error.value < 0.8
    merged.save(tmp_path / "merged.exr")
    assert json.loads(json.dumps(merged.record))["nets"] == 1
    assert et.merge([tmp_path / "merged.exr", _saved(tmp_path, 9)]).error.known


def test_a_probe_of_pixels_with_one_net_has_two_of_each(one_net: None) -> None:
    session = Session(Job(scene=scene(40, 40), strategy=et.Strategy.parse(LATTICE), limits=Limits(spp=8)))
    session.passes.run()
    probe = Probe.of(session, 16, 50)
    assert probe.advance(16) is not None
    first, second = (pixel_statistics(of) for of in (probe._renderer.moments, probe._renderer.second_moments))
    drawn = first.samples > 0
    assert 0 < drawn.sum() <= 50
    np.testing.assert_array_equal(first.samples, second.samples)
    found = probe._found()
    np.testing.assert_allclose(found.variance[drawn], 0.5 * np.square(first.mean - second.mean)[drawn])
    assert not np.allclose(found.variance[drawn], first.variance[drawn]), "the twin: halves of one net"
    assert probe.taken == pytest.approx(2.0 * first.samples.sum())


def _saved(folder: Path, seed: int) -> Path:
    path = folder / f"more{seed}.exr"
    et.render(scene(32, 32), spp=16, strategy=LATTICE, seed=seed).save(path)
    return path


@pytest.mark.parametrize(
    ("strategy", "size", "wanted"),
    [(LATTICE, (256, 256), (1, 32)), (LATTICE, (255, 256), (2, 0)), ("best,sampler=sobol", (512, 512), (2, 0))],
)
def test_large_pictures_by_a_lattice_have_one(strategy: str, size: tuple[int, int], wanted: tuple[int, int]) -> None:
    loaded, chosen = et.load(SCENE).with_(size=size), et.Strategy.parse(strategy)
    assert (core_renderer.nets(loaded, chosen), core_renderer.second_net(loaded, chosen)) == wanted


@pytest.mark.parametrize(("side", "share"), [(8, 1), (64, 2), (128, 8), (256, 32), (500, 32)])
def test_small_crops_of_large_pictures_have_more(side: int, share: int) -> None:
    loaded = et.load(SCENE).with_(size=(512, 512), crop=(0, 0, side, side))
    assert core_renderer.second_net(loaded, et.Strategy.parse(LATTICE)) == share
