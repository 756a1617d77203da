"""Logarithmic scales, and the grey picture of variances that is drawn on one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from equaltime.images.log_scale import LogScale
from equaltime.images.variance_picture import is_known, scale_in_words, scale_of, write_variance


def powers(*exponents: float) -> Any:
    return np.array([[10.0**exponent for exponent in exponents]])


def test_a_scale_ends_at_half_a_decade_and_leaves_out_what_has_no_logarithm() -> None:
    odd = np.array([[0.0, -1.0, np.nan, np.inf]])
    scale = LogScale.of([powers(*[-0.2] * 300), odd], 2.0)
    assert (scale.low, scale.high) == pytest.approx((0.01, 1.0))
    assert LogScale.of([powers(*[-0.7] * 300)], 2.0).high == pytest.approx(10.0**-0.5)
    assert LogScale.of([odd], 2.0) == LogScale(1e-3, 0.1)


@pytest.mark.parametrize(("least", "low"), [(-1.0, 1e-3), (-4.2, 10.0**-4.5), (-9.0, 1e-6)])
def test_a_scale_is_as_long_as_its_numbers_within_limits(least: float, low: float) -> None:
    numbers = powers(*[least] * 200, *[0.0] * 200)
    assert LogScale.of([numbers], 3.0, 6.0).low == pytest.approx(low)
    assert LogScale.of([numbers], 3.0).low == pytest.approx(1e-3)


def test_positions_are_between_the_ends() -> None:
    scale = LogScale(0.01, 1.0)
    found = scale.position(np.array([0.0, 0.01, 0.1, 1.0, 7.0, np.inf, np.nan]))
    assert found == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.0])
    assert scale.middle == pytest.approx(0.1)


def test_ticks_are_short_and_mostly_without_exponents() -> None:
    assert LogScale(10.0**-3.5, 10.0**2.5).ticks == ("0.0003", "0.3", "300")
    assert LogScale(1e-5, 10.0).ticks == ("1e-05", "0.01", "10")


def test_a_picture_is_darker_where_the_variance_is_higher_and_tells_its_scale(tmp_path: Path) -> None:
    variance = np.repeat(np.logspace(-3.0, 0.0, 30).reshape(5, 6)[..., None], 3, axis=2)
    variance[0, 0], variance[4, 5, 1] = 0.0, np.inf
    write_variance(tmp_path / "a.png", variance, "box", "/box.toml")
    seen = oiio.ImageBuf(str(tmp_path / "a.png"))
    grey = seen.get_pixels(oiio.UINT8)
    assert grey.shape == (5, 6, 1)
    assert (grey[0, 0, 0], grey[4, 5, 0]) == (255, 0), "no variance, and an unknown one"
    assert (np.diff(grey.ravel().astype(int)[1:]) <= 0).all()
    scale = "variance of one sample, from 0.001 (white) to 1 (black) on a log scale"
    assert scale_in_words(variance) == scale
    assert seen.spec().getattribute("ImageDescription") == f"{scale}; box"
    assert seen.spec().getattribute("equaltime:scene") == "/box.toml"


def test_pictures_have_one_scale() -> None:
    assert scale_of([powers(*[0.0] * 200), powers(*[-4.0] * 200)]) == LogScale(1e-4, 1.0)


def test_a_map_far_below_the_others_leaves_them_most_of_the_scale() -> None:
    """As a strategy that cuts paths has, without most of the light: its 10 % of highest variances are still seen."""
    low = np.logspace(-6.0, -2.0, 400)[None]
    maps = [low, *[np.logspace(-2.0, -1.0, 400)[None]] * 3]
    scale = scale_of(maps)
    assert scale.position(maps[1]).min() > 0.4
    assert np.ptp(scale.position(maps[1])) > 0.3
    assert np.ptp(scale.position(low)) > 0.2
    assert scale.low < np.percentile(low, 90.0)


def test_a_variance_that_no_pixel_has_is_not_known() -> None:
    assert not is_known(np.full((2, 2, 3), np.inf))
    assert is_known(np.array([[[np.inf, np.inf, 0.0]]]))
