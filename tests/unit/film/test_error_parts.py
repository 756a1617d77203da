"""What the core makes of the pixels of an image, against the same formulas written plainly for the whole image."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from equaltime.film.sums import error_contributions, standard_errors

from .plain_parts import Counts, Floats, plain_errors, plain_parts, whole_means

SIZES = [(1, 1), (3, 70), (63, 5), (65, 8), (150, 9)]
"""A band has 64 rows: images of one, of a bit more, and of several, whose neighbourhoods reach across."""
FLOOR = 0.01


def pixels(height: int, width: int, uneven: bool) -> tuple[Floats, Floats, Counts]:
    """Draw mean, variance and samples with edges, black pixels, and noise from none to all of the scatter."""
    rng = np.random.default_rng(height * width)
    mean = np.where(rng.random((height, width, 1)) < 0.3, 0.0, rng.gamma(2.0, size=(height, width, 3)))
    mean[:, width // 2 :] *= 20.0
    variance = mean * rng.gamma(0.5, 0.1, size=mean.shape)
    samples = 4 * rng.integers(1, 9, (height, width)) if uneven else np.full((height, width), 8)
    return mean, variance, samples.astype(np.int64)


def differ(found: tuple[Floats, dict[str, float]], expected: tuple[Floats, dict[str, float]]) -> list[str]:
    """Name what differs by more than rounding does."""
    wrong = [name for name, value in expected[1].items() if not np.isclose(found[1][name], value, rtol=1e-9)]
    kinds = zip(("value", "lenient", "cautious"), found[0], expected[0], strict=True)
    return wrong + [name for name, one, other in kinds if not np.allclose(one, other, rtol=1e-9, atol=1e-12)]


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_parts_are_those_of_the_plain_formulas(height: int, width: int, uneven: bool) -> None:
    image = pixels(height, width, uneven)
    assert differ(error_contributions(*image, FLOOR), plain_parts(*image, FLOOR)) == []


def test_no_reference_is_below_the_light_of_known_lamps() -> None:
    image = pixels(33, 8, uneven=False)
    least = np.where(np.random.default_rng(1).random(image[0].shape) < 0.1, 30.0, 0.0)
    found = error_contributions(*image, FLOOR, least)
    assert differ(found, plain_parts(*image, FLOOR, least=least)) == []
    assert differ(found, plain_parts(*image, FLOOR)) != [], "the twin: without lamps"


def test_a_reference_that_leans_a_little_less_would_be_seen() -> None:
    image = pixels(33, 8, uneven=False)
    assert {"value", "lenient"} <= {*differ(error_contributions(*image, FLOOR), plain_parts(*image, FLOOR, lean=0.499))}


def test_local_means_that_reach_across_edges_would_be_seen() -> None:
    image = pixels(33, 8, uneven=False)
    found, expected = error_contributions(*image, FLOOR), plain_parts(*image, FLOOR, means=whole_means)
    assert {"value", "lenient", "cautious"} <= {*differ(found, expected)}


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
