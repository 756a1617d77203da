"""Metrics of images against references: definitions, noise that is subtracted, and bias apart from variance."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.images.bias_variance import relmse_of_parts
from equaltime.images.flip import flip
from equaltime.images.metrics import METRICS, Metric, Reference, contributions, measure
from equaltime.statistics.intervals import signed_root

Array = NDArray[np.float64]
SHAPE = (16, 24, 3)
TRUTH = np.random.default_rng(7).uniform(0.2, 2.0, SHAPE)
M = float(TRUTH.mean())


def exact(truth: Array = TRUTH) -> Reference:
    return Reference(truth, np.zeros_like(truth))


def noise(seed: int, sigma: float) -> Array:
    return sigma * np.random.default_rng(seed).standard_normal(SHAPE)


def noisy(seed: int, sigma: float) -> Reference:
    """Return a reference whose mean has noise of standard deviation sigma, in two halves."""
    halves = tuple(TRUTH + noise(2 * seed + i, sigma * math.sqrt(2.0)) for i in range(2))
    return Reference(0.5 * (halves[0] + halves[1]), np.full(SHAPE, sigma**2), (halves[0], halves[1]))


def value(image: Array, reference: Reference, metric: Metric) -> float:
    return measure(image, reference, [metric])[metric].value


def test_an_exact_image_has_no_error_in_any_metric() -> None:
    assert {name: measured.value for name, measured in measure(TRUTH, exact()).items()} == dict.fromkeys(METRICS, 0.0)


def test_the_definitions_are_the_design_s() -> None:
    image = TRUTH + noise(1, 0.1)
    square = (image - TRUTH) ** 2
    expected = np.mean(square / (TRUTH**2 + (0.1 * M) ** 2))
    assert value(image, exact(), "relmse") == pytest.approx(expected, rel=1e-12)
    assert value(image, exact(), "error") == pytest.approx(math.sqrt(expected), rel=1e-12)
    assert value(image, exact(), "mse") == pytest.approx(np.mean(square), rel=1e-12)
    assert value(image, exact(), "mare") == pytest.approx(np.mean(np.abs(image - TRUTH) / (TRUTH + 0.1 * M)), rel=1e-12)


@pytest.mark.parametrize("metric", ["error", "relmse", "mare", "flip"])
def test_relative_metrics_do_not_depend_on_exposure(metric: Metric) -> None:
    image = TRUTH + noise(1, 0.1)
    bright = value(64.0 * image, exact(64.0 * TRUTH), metric)
    assert bright == pytest.approx(value(image, exact(), metric), rel=1e-3 if metric == "flip" else 1e-12)


def test_contributions_average_to_relmse() -> None:
    image, reference = TRUTH + noise(1, 0.1), noisy(5, 0.03)
    parts = contributions(image, reference)
    assert parts.shape == SHAPE[:2]
    assert parts.mean() == pytest.approx(value(image, reference, "relmse"), rel=1e-12)


def mean_over_references(sigma: float, subtract: bool, image: Array) -> tuple[float, float]:
    """Return the mean relMSE over 200 noisy references and its standard error."""
    found = []
    for seed in range(200):
        reference = noisy(seed, sigma)
        if not subtract:
            reference = exact(reference.mean)
        found.append(value(image, reference, "relmse"))
    return float(np.mean(found)), float(np.std(found, ddof=1) / math.sqrt(len(found)))


def test_the_reference_s_noise_is_subtracted_without_bias() -> None:
    image = TRUTH + noise(10**6, 0.05)
    mean, error = mean_over_references(0.02, True, image)
    assert abs(mean - value(image, exact(), "relmse")) < 4.0 * error + 2e-3 * mean


def test_left_in_it_would_be_seen() -> None:
    image = TRUTH + noise(10**6, 0.05)
    mean, error = mean_over_references(0.02, False, image)
    assert mean - value(image, exact(), "relmse") > 10.0 * error


def test_a_converged_image_falls_on_both_sides_of_zero() -> None:
    found = [value(TRUTH, noisy(seed, 0.05), "relmse") for seed in range(100)]
    assert min(found) < 0.0 < max(found)
    assert value(TRUTH, noisy(int(np.argmin(found)), 0.05), "error") < 0.0
    assert signed_root(-0.04) == -0.2


def test_halves_alone_stand_for_the_variance() -> None:
    image, reference = TRUTH + noise(1, 0.1), noisy(3, 0.03)
    halves_only = Reference(reference.mean, np.zeros(SHAPE), reference.halves)
    difference = 0.5 * (reference.halves[0] - reference.halves[1])  # type: ignore[index]
    square = np.mean((image - reference.mean) ** 2 - difference**2)
    assert value(image, halves_only, "mse") == pytest.approx(square, rel=1e-12)


def sampled(spp: int, firefly: float) -> Reference:
    """Return a reference from samples with normal noise, one of which is a firefly in one pixel."""
    samples = TRUTH + 0.3 * np.random.default_rng(3).standard_normal((spp, *SHAPE))
    samples[0, 5, 7] += firefly
    halves = (samples[: spp // 2].mean(axis=0), samples[spp // 2 :].mean(axis=0))
    return Reference(samples.mean(axis=0), samples.var(axis=0, ddof=1) / spp, halves)


def test_a_reference_whose_error_one_pixel_makes_has_a_heavy_tail() -> None:
    plain, with_firefly = sampled(64, 0.0), sampled(64, 50.0)
    assert not plain.has_heavy_tail
    assert with_firefly.has_heavy_tail
    assert not exact().has_heavy_tail
    halves_only = [Reference(one.mean, np.zeros(SHAPE), one.halves) for one in (plain, with_firefly)]
    assert [one.has_heavy_tail for one in halves_only] == [False, True]


def covered(metric: Metric, images: Array, seeds: range, sigma: float, narrow: float = 1.0) -> float:
    """Return how often the interval of a metric holds the value against the truth."""
    hits = 0
    for seed in seeds:
        image = TRUTH + images[seed % len(images)]
        truth = value(image, exact(), metric)
        found = measure(image, noisy(seed, sigma), [metric])[metric]
        middle, half = 0.5 * (found.low + found.high), 0.5 * narrow * (found.high - found.low)
        hits += abs(truth - middle) <= half
    return hits / len(seeds)


IMAGES = np.stack([noise(1000 + i, 0.1) for i in range(5)])


@pytest.mark.parametrize("metric", ["relmse", "mse", "error"])
def test_the_interval_holds_what_the_reference_s_noise_leaves_open(metric: Metric) -> None:
    assert 0.93 < covered(metric, IMAGES, range(1000), 0.02) < 0.97


def test_a_narrower_interval_would_not() -> None:
    assert covered("relmse", IMAGES, range(1000), 0.02, narrow=0.85) < 0.93


def test_absolute_error_is_bounded() -> None:
    assert covered("mare", IMAGES, range(200), 0.02) == 1.0


def test_flip_is_bounded_by_what_it_sees_between_halves() -> None:
    image, reference = TRUTH + noise(1, 0.1), noisy(2, 0.02)
    found = measure(image, reference, ["flip"])["flip"]
    assert found.low <= value(image, exact(), "flip") <= found.high


def test_without_knowledge_of_the_noise_there_is_no_interval() -> None:
    for measured in measure(TRUTH + 0.1, exact()).values():
        assert (measured.low, measured.high) == (-math.inf, math.inf)
        assert not measured.trusted


def test_what_is_not_finite_has_no_error() -> None:
    image = TRUTH.copy()
    image[3, 4, 1] = np.inf
    assert all(math.isnan(measured.value) for measured in measure(image, exact()).values())


def test_a_black_reference_forgives_only_black() -> None:
    black = exact(np.zeros(SHAPE))
    assert value(np.zeros(SHAPE), black, "relmse") == 0.0
    assert value(TRUTH, black, "relmse") == math.inf


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_flip_survives_a_reference_of_one_luminance(level: float) -> None:
    """The package would end the process."""
    reference = np.full(SHAPE, level)
    assert flip(reference, reference) == 0.0
    assert 0.0 < flip(reference + TRUTH, reference) <= 1.0


SWEEP = """
import numpy as np
from equaltime.images.flip import flip

truth = np.random.default_rng(1).gamma(0.5, 1.0, (8, 12, 3))
print(len({flip(np.ldexp(1.1 * truth, k), np.ldexp(truth, k)) for k in range(-140, 121, 52)}))
print(0.0 < flip(np.ldexp(truth, 300), np.where(truth > 1.0, truth, 0.0)) <= 1.0)
"""


def test_flip_does_not_depend_on_scale_and_does_not_end_the_process() -> None:
    """The package ends the process, with no exception, where a reference is dim: so it is tried in a process."""
    done = subprocess.run([sys.executable, "-c", SWEEP], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stdout.splitlines()) == (0, ["1", "True"]), done.stderr


def test_flip_has_the_exposures_of_the_package() -> None:
    package = pytest.importorskip("flip_evaluator")
    pair = [np.ascontiguousarray(a, np.float32) for a in (TRUTH, TRUTH + noise(1, 0.1))]
    assert flip(pair[1], pair[0]) == pytest.approx(package.evaluate(*pair, "HDR", applyMagma=False)[1], rel=1e-4)


def test_flip_takes_negative_values_for_black_and_ranks_noise() -> None:
    assert flip(-TRUTH, TRUTH) == flip(np.zeros(SHAPE), TRUTH)
    assert flip(TRUTH + noise(1, 0.02), TRUTH) < flip(TRUTH + noise(1, 0.2), TRUTH)


def test_different_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match="cannot be measured"):
        measure(TRUTH[:-1], exact())
    with pytest.raises(ValueError, match="cannot be measured"):
        measure(TRUTH[..., :1], exact(TRUTH[..., :1]))


def test_a_reference_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="not finite"):
        measure(TRUTH, exact(np.full(SHAPE, np.nan)))


def renders(seed: int, bias: float, count: int = 8) -> Array:
    rng = np.random.default_rng(seed)
    return TRUTH * (1.0 + bias) + 0.1 * rng.standard_normal((count, *SHAPE))


def test_bias_and_variance_are_told_apart() -> None:
    parts = relmse_of_parts(renders(1, 0.05), exact())
    denominator = exact().denominator
    assert parts.bias2.low < 0.05**2 * np.mean(TRUTH**2 / denominator) < parts.bias2.high
    assert parts.bias2.low > 0.0
    assert parts.variance.low < np.mean(0.01 / denominator) < parts.variance.high


def test_together_they_are_the_mean_relmse() -> None:
    images, reference = renders(1, 0.05), noisy(4, 0.02)
    parts = relmse_of_parts(images, reference)
    direct = np.mean([value(image, reference, "relmse") for image in images])
    # the jackknife's value of the variance is freed of a bias of its own
    assert parts.bias2.value + parts.variance.value == pytest.approx(direct, rel=1e-3)


def test_without_bias_its_interval_holds_zero() -> None:
    held = [relmse_of_parts(renders(seed, 0.0), exact()).bias2 for seed in range(100)]
    assert sum(one.low <= 0.0 <= one.high for one in held) >= 90
    assert any(one.value < 0.0 for one in held)


def test_one_render_tells_nothing_apart() -> None:
    parts = relmse_of_parts(renders(1, 0.0, count=1), exact())
    assert not parts.bias2.trusted
    assert "one render" in parts.bias2.note


def test_two_renders_are_not_trusted() -> None:
    parts = relmse_of_parts(renders(1, 0.0, count=2), exact())
    assert not parts.bias2.trusted
    assert parts.bias2.high == math.inf


def test_renders_without_noise_have_no_variance() -> None:
    parts = relmse_of_parts(np.stack([TRUTH + 0.1] * 4), exact())
    assert parts.variance.value == 0.0
    assert parts.bias2.value == pytest.approx(np.mean(0.01 / exact().denominator))


def test_a_reference_of_images_knows_its_noise() -> None:
    reference = Reference.of_images(renders(3, 0.0, count=64))
    assert reference.relmse == pytest.approx(np.mean(0.01 / 64 / exact().denominator), rel=0.1)
    assert reference.halves is not None
    np.testing.assert_allclose(0.5 * (reference.halves[0] + reference.halves[1]), reference.mean)
