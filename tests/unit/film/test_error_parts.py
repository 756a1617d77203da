"""What the core makes of the pixels of an image, against the same formulas written plainly for the whole image."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.film.sums import box_sum, error_contributions, neighbours, standard_errors

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

SIZES = [(1, 1), (3, 70), (31, 5), (33, 8), (100, 9)]
"""A band has 32 rows: images of one, of a bit more, and of several, whose neighbourhoods reach across."""
FLOOR = 0.01


def pixels(height: int, width: int, uneven: bool) -> tuple[Floats, Floats, Counts]:
    """Draw mean, variance and samples with edges, black pixels, and noise from none to all of the scatter."""
    rng = np.random.default_rng(height * width)
    mean = np.where(rng.random((height, width, 1)) < 0.3, 0.0, rng.gamma(2.0, size=(height, width, 3)))
    mean[:, width // 2 :] *= 20.0
    variance = mean * rng.gamma(0.5, 0.1, size=mean.shape)
    samples = 4 * rng.integers(1, 9, (height, width)) if uneven else np.full((height, width), 8)
    return mean, variance, samples.astype(np.int64)


def plain_errors(variance: Floats, samples: Counts) -> Floats:
    """Give the variance of one sample by the mean of the known ones around, over a pixel's own samples; its root."""
    counts, known = samples[..., None].astype(float), np.isfinite(variance[..., :1])
    around = np.maximum(box_sum(known.astype(float)), 1.0)
    one = box_sum(np.where(known, variance, 0.0) * counts) / around
    return np.where(known, np.sqrt(one / np.maximum(counts, 1.0)), np.inf)


def others(values: Floats) -> Floats:
    """Mean over the 7x7 neighbourhood without the pixel itself."""
    counts = np.maximum(neighbours(*values.shape[:2]) - 1.0, 1.0)
    return np.asarray((box_sum(values) - values) / counts)


def share(noise: Floats, scatter: Floats) -> Floats:
    """Weight of the local mean: the part of the scatter that is noise (Lee 1980)."""
    return np.where(scatter > 0.0, np.minimum(noise / np.where(scatter > 0.0, scatter, 1.0), 1.0), 1.0)


def plain_parts(
    mean: Floats, variance: Floats, samples: Counts, least: Floats | float = 0.0, lean: float = 0.5
) -> tuple[Floats, dict[str, float]]:
    around = neighbours(*samples.shape)
    local, deviation = box_sum(mean) / around, np.sqrt(variance)
    scatter = (mean - local) ** 2
    with_it, without = share(box_sum(variance), box_sum(scatter)), share(others(variance), others(scatter))
    noise = np.minimum(deviation / np.maximum(mean, np.finfo(float).tiny), 1.0)
    worst = np.minimum(deviation / np.maximum(mean - deviation, np.finfo(float).tiny), 1.0)
    lenient = np.maximum(local + (np.maximum(mean - lean * noise * deviation, 0.0) - local) * (1.0 - with_it), least)
    outside, cautious = (
        np.maximum(others(mean) + (np.maximum(mean - part * deviation, 0.0) - others(mean)) * (1.0 - without), least)
        for part in (noise, worst)
    )
    above, below = lenient**2 + FLOOR, outside**2 + FLOOR
    weight = 0.2 + 0.5 * np.maximum(without, noise)
    parts = variance / (above ** (1.0 - weight) * below**weight)
    errors = plain_errors(variance, samples)
    slope = parts * ((1.0 - weight) / above + weight / below)
    moved = 2.0 * parts * ((1.0 - weight) * with_it * lenient / above + weight * without * outside / below)
    by_local, by_mean = (box_sum(moved / around) * errors).mean(axis=-1), errors.mean(axis=-1)
    sums = {
        "slopes": slope.sum(),
        "locals_squared": (by_local**2).sum(),
        "crossed": (by_local * by_mean).sum(),
        "means_squared": (by_mean**2).sum(),
    }
    found = np.stack([part.mean(axis=-1) for part in (parts, variance / above, variance / (cautious**2 + FLOOR))])
    return found, {name: float(value) for name, value in sums.items()}


def differ(found: tuple[Floats, dict[str, float]], expected: tuple[Floats, dict[str, float]]) -> list[str]:
    """Name what differs by more than rounding does."""
    wrong = [name for name, value in expected[1].items() if not np.isclose(found[1][name], value, rtol=1e-9)]
    kinds = zip(("value", "lenient", "cautious"), found[0], expected[0], strict=True)
    return wrong + [name for name, one, other in kinds if not np.allclose(one, other, rtol=1e-9, atol=1e-12)]


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_parts_are_those_of_the_plain_formulas(height: int, width: int, uneven: bool) -> None:
    image = pixels(height, width, uneven)
    assert differ(error_contributions(*image, FLOOR), plain_parts(*image)) == []


def test_no_reference_is_below_the_light_of_known_lamps() -> None:
    image = pixels(33, 8, uneven=False)
    least = np.where(np.random.default_rng(1).random(image[0].shape) < 0.1, 30.0, 0.0)
    found = error_contributions(*image, FLOOR, least)
    assert differ(found, plain_parts(*image, least=least)) == []
    assert differ(found, plain_parts(*image)) != [], "the twin: without lamps"


def test_a_reference_that_leans_a_little_less_would_be_seen() -> None:
    image = pixels(33, 8, uneven=False)
    assert {"value", "lenient"} <= {*differ(error_contributions(*image, FLOOR), plain_parts(*image, lean=0.499))}


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_standard_errors_are_those_of_the_plain_formula(height: int, width: int, uneven: bool) -> None:
    _, variance, samples = image = pixels(height, width, uneven)
    np.testing.assert_allclose(standard_errors(*image), plain_errors(variance, samples), rtol=1e-6)


def test_standard_errors_leave_out_what_is_unknown() -> None:
    mean, variance, samples = pixels(40, 6, uneven=True)
    variance[30:33, 2] = np.nan
    found, expected = standard_errors(mean, variance, samples), plain_errors(variance, samples)
    assert np.isinf(found[30:33, 2]).all()
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize(
    "call", [lambda m, v, n: error_contributions(m, v, n, FLOOR), standard_errors], ids=["parts", "standard errors"]
)
def test_arrays_of_other_shapes_are_refused(call: Callable[[Floats, Floats, Counts], object]) -> None:
    mean, variance, samples = pixels(3, 4, uneven=False)
    with pytest.raises(ValueError, match=r"samples are \(H, W\), mean and variance \(H, W, 3\)"):
        call(mean[:2], variance, samples)
