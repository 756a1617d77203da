"""Adaptive sampling: the construction that makes it unbiased, and that a render with it is like any other."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.errors import ImageError, StrategyError
from equaltime.film.adaptive import METRICS, PILOT, Gain, pilot_statistics
from equaltime.film.error import PixelStatistics
from equaltime.film.moments import DTYPE, stored

Floats = NDArray[np.float64]
SHAPE = (48, 64)
EVEN = np.full(SHAPE, 100.0)
"""Rays of the pilot."""


def pilot_of(halves: Floats) -> PixelStatistics:
    """Make a pilot from the means of its two replicates, (2, H, W)."""
    both = np.repeat(halves[..., None], 3, axis=-1)
    variance = np.square(both[0] - both[1]) / 4.0
    return PixelStatistics(both.mean(axis=0), variance, np.full(halves.shape[1:], PILOT), 1.0)


def a_pilot(seed: int = 1) -> PixelStatistics:
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((2, *SHAPE)) * np.linspace(0.05, 1.0, SHAPE[1])
    return pilot_of(np.exp(noise))


@pytest.mark.parametrize("place", [(0, 0), (20, 30), (15, 16), (47, 63), (3, 47)])
def test_the_rate_of_a_pixel_does_not_depend_on_its_own_pilot_by_a_bit(place: tuple[int, int]) -> None:
    before = a_pilot()
    changed = PixelStatistics(before.mean.copy(), before.variance.copy(), before.samples, before.degrees)
    rays = EVEN.copy()
    changed.mean[place], changed.variance[place], rays[place] = 1e9, 1e20, 1e6
    assert METRICS["error"](changed, rays)[place] == METRICS["error"](before, EVEN)[place]
    assert METRICS["history"](changed, rays)[place] != METRICS["history"](before, EVEN)[place], "the twin"


@pytest.mark.parametrize("metric", METRICS)
def test_rates_keep_the_total_and_follow_the_noise(metric: str) -> None:
    rates = METRICS[metric](a_pilot(), EVEN)
    assert abs(rates.mean() - 1.0) < 0.06  # a noisy tile knows a whole without it; of twelve, that is felt
    assert rates[:, -16:].mean() > 2.0 * rates[:, :16].mean()


def test_deviations_are_those_of_all_samples_of_a_pixel() -> None:
    samples = np.random.default_rng(6).lognormal(size=(PILOT, 3, 5, 3))
    moments = np.zeros((2, 3, 5), DTYPE)
    for half, own in enumerate((samples[::2], samples[1::2])):
        moments["count"][half], moments["mean"][half] = len(own), own.mean(axis=0)
        moments["deviation"][half] = stored(own.std(axis=0))
    deviation = pilot_statistics(moments).deviation
    assert deviation is not None
    np.testing.assert_allclose(deviation, samples.std(axis=0, ddof=1), rtol=1e-6)


def test_samples_that_take_more_rays_are_fewer() -> None:
    rays = EVEN.copy()
    rays[:, :32] *= 4.0
    even, uneven = METRICS["error"](a_pilot(), EVEN), METRICS["error"](a_pilot(), rays)
    least = 0.3
    assert (uneven[:, :24] - least < 0.8 * (even[:, :24] - least)).mean() > 0.5
    assert (uneven[:, 40:] > even[:, 40:]).all()


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("value", [0.0, 1.0])
def test_a_pilot_without_noise_says_nothing(metric: str, value: float) -> None:
    rates = METRICS[metric](pilot_of(np.full((2, *SHAPE), value)), EVEN)
    assert np.isfinite(rates).all()
    assert np.ptp(rates) == 0.0


def test_where_there_is_no_noise_three_tenths_of_the_samples_are_spent() -> None:
    """Not none: a pilot that saw nothing does not know that there is nothing."""
    halves = np.where(np.arange(SHAPE[1]) % 8 < 4, 1.0, 3.0) * np.ones((2, *SHAPE))
    halves[:, :, 40:] *= np.exp(0.3 * np.random.default_rng(6).standard_normal((2, SHAPE[0], 24)))
    assert (METRICS["error"](pilot_of(halves), EVEN)[:, :37] == 0.3).all()
    assert (METRICS["neighbours"](pilot_of(halves), EVEN)[:, :37] > 0.5).any(), "the twin takes edges for noise"


def test_one_tile_with_all_the_noise_gets_no_more_than_half_of_all_samples_besides() -> None:
    halves = np.ones((2, *SHAPE))
    halves += np.random.default_rng(3).standard_normal(halves.shape) * np.where(np.arange(SHAPE[1]) < 32, 1e-10, 1e-9)
    halves[:, 16:32, 16:32] += np.random.default_rng(4).standard_normal((2, 16, 16))
    rates = METRICS["error"](pilot_of(halves), EVEN)
    assert rates.max() == 0.5 * rates.size / 16**2
    assert rates.mean() < 2.0


def test_where_noise_is_even_samples_are_alike() -> None:
    noise = 0.3 * np.random.default_rng(8).standard_normal((2, *SHAPE))
    assert (METRICS["error"](pilot_of(np.exp(noise)), EVEN) == 1.0).all()
    noise[:, :, 32:] *= 2.5
    assert np.ptp(METRICS["error"](pilot_of(np.exp(noise)), EVEN)) > 0.5, "the twin"


def test_counts_that_single_samples_ask_for_are_refused_where_even_points_leave_no_such_noise() -> None:
    """Deviations of samples choose the counts; the difference of replicates, which is even here, judges them."""
    even = pilot_of(np.exp(0.3 * np.random.default_rng(8).standard_normal((2, *SHAPE))))
    deviation = np.full_like(even.mean, 0.3)
    deviation[:, 32:] *= 2.5
    assert (METRICS["error"](replace(even, deviation=deviation), EVEN) == 1.0).all()


def test_the_gain_of_the_best_counts_is_that_of_the_closed_form() -> None:
    """A quarter of the pixels has 16 times the noise and 4 times the rays: counts as its root, (1/4 + 3/4) ratios.

    Even: error² is (16 + 3) / 4 and rays (4 + 3) / 4; with counts in proportion to sqrt(noise / rays), 2 to 1, both
    products are the square of (sqrt(16 * 4) + 3) / 4.
    """
    loud = np.arange(4000) < 1000
    noise, rays = np.where(loud, 16.0, 1.0), np.where(loud, 4.0, 1.0)
    gain = Gain.of(noise, rays, np.where(loud, 2.0, 1.0), samples=10**9)
    assert gain.value == pytest.approx(math.log((19 / 4) * (7 / 4) / (11 / 4) ** 2), rel=1e-6)
    assert gain.sure
    assert not Gain.of(noise, rays, np.where(loud, 1.0, 3.0), samples=10**9).sure, "the twin: the other way round"


def test_a_gain_counts_the_samples_of_the_pilot_which_are_even() -> None:
    loud = np.arange(4000) < 2000
    noise, rates = np.where(loud, 9.0, 1.0), np.where(loud, 1.5, 0.5)
    short, long = (Gain.of(noise, np.ones(4000), rates, samples).value for samples in (2 * PILOT, 64 * PILOT))
    half = np.array([1.25, 0.75])
    assert short == pytest.approx(math.log(5.0 / (np.array([9.0, 1.0]) / half).mean()))
    assert long > 1.3 * short


def test_the_standard_error_of_a_gain_is_how_far_gains_scatter() -> None:
    """300 pictures of 900 pixels with noise of one degree of freedom; the scatter is known within 4 sigma, 16 %."""
    random = np.random.default_rng(11)
    rates, rays = np.repeat([0.5, 1.5], 450), np.ones(900)
    gains = [Gain.of(np.repeat([1.0, 4.0], 450) * random.chisquare(1, 900), rays, rates) for _ in range(300)]
    scatter = float(np.std([gain.value for gain in gains], ddof=1))
    assert np.mean([gain.error for gain in gains]) == pytest.approx(scatter, rel=0.16)


def test_a_gain_of_nothing_is_not_sure() -> None:
    assert not Gain.of(np.zeros(9), np.ones(9), np.ones(9)).sure


def test_an_image_too_small_for_a_chessboard_is_sampled_evenly() -> None:
    rates = METRICS["error"](pilot_of(np.random.default_rng(2).random((2, 15, 40))), np.ones((15, 40)))
    assert (rates == 1.0).all()


def mean_of_rare_light(metric: str, seeds: int, parts: int = 1) -> tuple[float, float, float]:
    """Return the mean over pixels and seeds of images whose truth is 1, its standard error, and how often counts adapt.

    An image is merged from parts: their mean by counts.

    One sample in fifty is 50 on the left, 17 in 20 are 20/17 on the right, and the others are 0. Three times
    the pilot's samples follow by its rates. Half of the pilots decide for even counts, since the picture is so small.
    """
    rng = np.random.default_rng(5)
    share = np.where(np.arange(48) < 24, 0.02, 0.85) * np.ones((48, 1))
    means, adapts = [], 0
    for _ in range(seeds):
        sums, counts = np.zeros((48, 48)), np.zeros((48, 48))
        for _ in range(parts):
            halves = rng.binomial(PILOT // 2, share, (2, 48, 48)) / share / (PILOT // 2)
            rates = METRICS[metric](pilot_of(halves), np.ones((48, 48)))
            adapts += bool((rates != 1.0).any())
            later = 2 * np.rint(1.5 * PILOT * rates).astype(np.int64)
            sums += PILOT * halves.mean(axis=0) + rng.binomial(later, share) / share
            counts += PILOT + later
        means.append(float((sums / counts).mean()))
    return float(np.mean(means)), float(np.std(means, ddof=1) / math.sqrt(seeds)), adapts / (seeds * parts)


def test_images_are_right_on_average_where_looking_at_oneself_is_not() -> None:
    """False alarms: 1 in 15,787 (4 sigma, two-sided)."""
    mean, error, adapts = mean_of_rare_light("error", 300)
    assert abs(mean - 1.0) < 4.0 * error
    assert 0.1 < adapts < 0.95, "both decisions are met"
    for metric in ("history", "cutoff"):
        mean, error, _ = mean_of_rare_light(metric, 300)
        assert mean < 1.0 - 10.0 * error, f"the twin: {metric}"


def test_merged_images_are_right_on_average_where_looking_at_oneself_is_not() -> None:
    """False alarms: 1 in 15,787 (4 sigma, two-sided)."""
    mean, error, _ = mean_of_rare_light("error", 150, parts=2)
    assert abs(mean - 1.0) < 4.0 * error
    mean, error, _ = mean_of_rare_light("history", 150, parts=2)
    assert mean < 1.0 - 10.0 * error, "the twin"


def box(size: tuple[int, int] = (48, 48)) -> et.Scene:
    return et.load(Path(__file__).parents[3] / "scenes/cornell-box.toml").with_(size=size)


def test_bits_do_not_depend_on_threads_or_on_being_taken_up(tmp_path: Path) -> None:
    scene, strategy = box(), "best,adaptive=error"
    whole = et.render(scene, spp=64, strategy=strategy, threads=2)
    assert whole.samples.min() < 64 < whole.samples.max()
    assert abs(whole.spp - 64) < 4
    assert (et.render(scene, spp=64, strategy=strategy, threads=1).image == whole.image).all()
    assert (et.render(scene, spp=64, strategy=strategy, seed=1).samples != whole.samples).any(), "the twin"
    for first in (8, PILOT, 40):
        et.render(scene, spp=first, strategy=strategy).save(tmp_path / "part.exr")
        again = et.render(scene, spp=64, strategy=strategy, resume=tmp_path / "part.exr")
        assert (again.image == whole.image).all()
        assert (again.samples == whole.samples).all()


def test_a_time_limit_leaves_what_can_be_taken_up(tmp_path: Path) -> None:
    scene, strategy = box(), "best,adaptive=error"
    whole = et.render(scene, spp=800, strategy=strategy)
    for seconds in (0.01, 0.1):
        cut = et.render(scene, time=seconds, strategy=strategy)
        assert cut.spp < 400
        cut.save(tmp_path / "cut.exr")
        again = et.render(scene, spp=800, strategy=strategy, resume=tmp_path / "cut.exr")
        assert (again.image == whole.image).all()


def test_adaptive_renders_are_merged_unless_pixels_look_at_themselves(tmp_path: Path) -> None:
    scene, files = box((32, 32)), [tmp_path / "1.exr", tmp_path / "2.exr"]
    for metric in ("error", "history"):
        parts = [et.render(scene, spp=24, strategy=f"best,adaptive={metric}", seed=seed) for seed in (1, 2)]
        for part, file in zip(parts, files, strict=True):
            part.save(file)
        if metric == "history":
            with pytest.raises(ImageError, match="its own samples"):
                et.merge(files)
            continue
        merged, counts = et.merge(files), [part.samples[..., None] for part in parts]
        assert (merged.samples == parts[0].samples + parts[1].samples).all()
        together = (counts[0] * parts[0].image + counts[1] * parts[1].image) / (counts[0] + counts[1])
        np.testing.assert_allclose(merged.image, together, rtol=1e-5)


def test_biased_metrics_say_so() -> None:
    assert not et.Strategy.parse("best,adaptive=error").biased
    assert all(et.Strategy.parse(f"best,adaptive={metric}").biased for metric in METRICS if metric != "error")
    with pytest.raises(StrategyError, match="error"):
        et.Strategy.parse("best,adaptive=errors")


def test_the_learn_page_tells_how_dark_neighbours_are(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its example is run as it stands; 95 % intervals of the two ratios are 0.0025 and 0.003 to each side."""
    root = Path(__file__).parents[3]
    monkeypatch.chdir(root)
    page = (root / "scenes" / "learn" / "README.md").read_text("utf-8")
    programs = (part.partition("```")[0] for part in page.split("```python")[1:])
    (code,) = (program for program in programs if "adaptive={rule}" in program)
    exec(code, {})
    neighbours, error = map(float, capsys.readouterr().out.split())
    assert neighbours == pytest.approx(0.992, abs=0.003)
    assert error == pytest.approx(1.0, abs=0.003)
