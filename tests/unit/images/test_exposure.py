"""Exposure of previews: chosen in whole stops where a picture would be too dark or too bright, kept, and told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from equaltime.images import preview
from equaltime.images.exposure import automatic_stops, checked_exposure, exposure_in_words


def pixels(brightness: float) -> Any:
    return np.full((8, 9, 3), brightness, np.float32)


@pytest.mark.parametrize(
    ("brightness", "stops"),
    [(0.7, 0), (0.2, 0), (2.5, 0), (0.1, 3), (10.0, -4), (2.0**-30, 30), (1e30, -100), (1e-45, 148)],
)
def test_a_picture_keeps_its_exposure_unless_it_would_be_black_or_white(brightness: float, stops: float) -> None:
    found = automatic_stops(pixels(brightness))
    assert found == stops
    assert isinstance(found, float)


def test_a_picture_without_light_or_pixels_keeps_its_exposure() -> None:
    assert automatic_stops(pixels(0.0)) == automatic_stops(np.zeros((0, 3))) == 0.0
    assert automatic_stops(pixels(np.nan), 3.0) == automatic_stops(pixels(np.inf), 3.0) == 3.0


def test_the_exposure_before_stays_while_it_suits() -> None:
    """Twice as bright: 3 stops become 2, which nobody asked for while 3 are still right."""
    assert automatic_stops(pixels(0.1)) == 3.0
    assert automatic_stops(pixels(0.17)) == 2.0
    assert automatic_stops(pixels(0.17), shown=3.0) == 3.0
    assert automatic_stops(pixels(10.0), shown=3.0) == -4.0


@pytest.mark.parametrize("wrong", ["", "bright", None, True, 151, -1e9, float("nan"), float("inf")])
def test_what_is_no_exposure_is_refused(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"exposure is 'auto' or a number of stops|at most 150 stops"):
        checked_exposure(wrong)


def test_an_exposure_is_told_unless_it_is_zero() -> None:
    assert [exposure_in_words(stops) for stops in (0.0, 2.0, -1.0, 1.5)] == [
        "",
        "2 stops brighter",
        "1 stop darker",
        "1.5 stops brighter",
    ]


def description(path: Path) -> str:
    return str(oiio.ImageBuf(str(path)).spec().getattribute("ImageDescription"))


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.JPEG"])
def test_a_preview_is_exposed_and_says_so(name: str, tmp_path: Path) -> None:
    preview.write(tmp_path / name, pixels(0.05), "box", "/box.toml", stops=2.0)
    seen = oiio.ImageBuf(str(tmp_path / name))
    assert np.abs(seen.get_pixels(oiio.UINT8).astype(int) - 124).max() <= 1  # 0.2 by the curve of sRGB
    assert description(tmp_path / name) == "box; shown 2 stops brighter"
    assert seen.spec().getattribute("equaltime:scene") == "/box.toml"
    assert str(seen.spec().getattribute("Software")).startswith("equaltime ")
    preview.write(tmp_path / name, pixels(0.05), "box")
    assert description(tmp_path / name) == "box"


def test_a_jpeg_has_no_alpha_and_keeps_colours_apart(tmp_path: Path) -> None:
    image = np.zeros((8, 8, 3))
    image[:, ::2, 0] = image[:, 1::2, 2] = 1.0
    preview.write(tmp_path / "a.jpg", image, alpha=np.full((8, 8), 0.5))
    seen = oiio.ImageBuf(str(tmp_path / "a.jpg")).get_pixels(oiio.UINT8)
    assert seen.shape == (8, 8, 3)
    assert np.abs(seen.astype(int) - preview.srgb_bytes(image)).max() < 40, "not so where two columns share a colour"
