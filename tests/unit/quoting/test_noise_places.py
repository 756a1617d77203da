"""Where the error is: made of noise whose place is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.cli import main
from equaltime.cli.quote_details import details
from equaltime.film.error import PixelStatistics, error_parts
from equaltime.quoting.noise_places import NoisePlaces, noise_places, share_within

Floats = NDArray[np.float64]
SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
SIZE = 48
EVEN = np.full((SIZE, SIZE), 0.02)
PATCH = EVEN.copy()
PATCH[6:18, 24:36] = 0.2
IN_PATCH = 144 * 0.2**2 / (144 * 0.2**2 + (SIZE**2 - 144) * 0.02**2)


def halves(deviation: Floats, seed: int) -> PixelStatistics:
    """Return a grey picture from two replicates with this noise."""
    first, second = 1.0 + deviation * np.random.default_rng(seed).standard_normal((2, *deviation.shape))
    mean, variance = 0.5 * (first + second), np.square(0.5 * (first - second))
    mean, variance = (np.repeat(values[..., None], 3, axis=-1) for values in (mean, variance))
    return PixelStatistics(mean, variance, np.full(deviation.shape, 8), 1.0)


def by_own_noise(pixels: PixelStatistics, fraction: float) -> float:
    """Return the share of the pixels that are themselves the noisiest: the twin, which chance makes large."""
    parts = np.sort(error_parts(pixels, float(pixels.mean.mean())).value, axis=None)
    return float(parts[-round(fraction * parts.size) :].sum() / parts.sum())


def test_even_noise_is_all_over_the_picture() -> None:
    runs = [halves(EVEN, seed) for seed in range(20)]
    found = [noise_places(run) for run in runs]
    for fraction, most in ((0.01, 0.002), (0.1, 0.005)):  # above 4 standard errors of the means
        mean = np.mean([places.noisiest[fraction].value for places in found])
        assert abs(mean - fraction) < most
        assert np.mean([by_own_noise(run, fraction) for run in runs]) - fraction > 10.0 * most
    assert np.mean([places.rectangle.share.value for places in found]) == pytest.approx(0.48, abs=0.03)
    assert min(places.rectangle.area for places in found) > 0.4
    assert sum(places.rectangle.stands_out for places in found) <= 3  # each by a chance of 2.5 %: more are 1 in 500
    assert max(places.single.value for places in found) < 0.02


def test_noise_of_one_patch_is_found_there() -> None:
    for seed in range(5):
        places = noise_places(halves(PATCH, seed), corner=(100, 50))
        held = places.rectangle
        assert 100 + 24 <= held.x[0] <= held.x[1] < 100 + 36
        assert 50 + 6 <= held.y[0] <= held.y[1] < 50 + 18
        assert held.area < 0.06
        assert held.stands_out
        assert places.noisiest[0.1].value > 0.9 * IN_PATCH


def test_intervals_hold_the_share_of_known_pixels() -> None:
    """95 % is asked for; less than 85 of 100, or none of them missed, has a chance below 1 in 100 each."""
    half = np.zeros(SIZE**2, np.bool_)
    half[: SIZE**2 // 64] = True
    intervals = [share_within(np.square(halves(PATCH, seed).mean[..., 0] - 1.0).ravel(), half) for seed in range(100)]
    true = float(np.square(PATCH).ravel()[half].sum() / np.square(PATCH).sum())
    assert sum(interval.low <= true <= interval.high for interval in intervals) >= 85
    assert sum(interval.low <= 2.0 * true <= interval.high for interval in intervals) < 50  # which is another share


def test_a_bright_pixel_is_told_apart_from_its_surroundings() -> None:
    pixels = halves(EVEN, 0)
    pixels.variance[30, 11] = 0.25
    places = noise_places(pixels)
    assert places.single_pixels[0] == (11, 30)
    share = 0.25 / (0.25 + 0.5 * SIZE**2 * 0.02**2)
    assert places.single.low < share < places.single.high
    assert places.single.value == pytest.approx(share, rel=0.1)
    assert places.noisiest[0.01].value < 0.05  # it is not its neighbours that are noisy
    quote = replace(et.quote(et.load(SCENE).with_(size=(8, 8)), error=0.5, why=False), places=places)
    said = [text for _, text in details(quote, None)]
    assert any("`equaltime replay SCENE --pixel 11,30` shows the brightest path there" in text for text in said)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (1, 40), (3, 5)])
def test_small_pictures_have_places_too(shape: tuple[int, int]) -> None:
    places = noise_places(halves(np.full(shape, 0.02), 3))
    for share in (*places.noisiest.values(), places.rectangle.share):
        assert 0.0 <= share.low <= share.value <= share.high <= 1.0


def test_pixels_without_any_error_leave_shares_unknown() -> None:
    assert not share_within(np.zeros(9), np.ones(9, np.bool_)).known
    assert share_within(np.ones(100), np.ones(100, np.bool_)).value == 1.0
    assert share_within(np.ones(100), np.zeros(100, np.bool_)).high == pytest.approx(0.03)


def lamp_behind_glass() -> dict[str, Any]:
    """A sky without noise, and at the left a ball that shines by a small lamp, met by chance only."""
    film = {"type": "hdrfilm", "width": 40, "height": 20, "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": 40.0, "fov_axis": "x", "film": film}
    ball = {"type": "sphere", "center": [1.0, 0.0, 5.0], "radius": 0.4, "bsdf": {"type": "diffuse"}}
    lamp = {"type": "sphere", "center": [1.0, 3.0, 5.0], "radius": 0.3}
    lamp |= {"emitter": {"type": "area", "radiance": {"type": "rgb", "value": [20.0, 20.0, 20.0]}}}
    sky = {"type": "constant", "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}}
    return {"type": "scene", "camera": camera, "ball": ball, "lamp": lamp, "sky": sky}


def quoted(crop: tuple[int, int, int, int] | None = None) -> NoisePlaces:
    scene = et.load_dict(lamp_behind_glass())
    cut = scene if crop is None else scene.with_(crop=crop)
    places = et.quote(cut, error=0.001, strategy="mis").places
    assert places is not None
    return places


def test_a_quote_tells_where_the_noise_of_a_scene_is() -> None:
    held = quoted().rectangle
    assert held.area < 0.1
    assert held.share.value > 0.3
    cropped = quoted((4, 2, 30, 16)).rectangle
    assert (abs(np.subtract(cropped.x, held.x)) <= 3).all()
    assert (abs(np.subtract(cropped.y, held.y)) <= 3).all()


def test_the_command_tells_where(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["quote", str(SCENE), "--error", "20%", "--size", "32x32"]
    assert main([*command, "-v"]) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert "the noisiest 1 % of the pixels make" in words
    assert "-v tells more" not in words
    assert "% of the picture, make" in words or "no rectangle of the picture stands out" in words
    assert main([*command, "--json"]) == 0
    places = json.loads(capsys.readouterr().out)["places"]
    assert [part["pixels"] for part in places["noisiest"]] == [0.01, 0.1]
    assert {"x", "y", "area", "share", "stands_out"} == set(places["rectangle"])
    assert set(places["single_pixels"]) == {"share", "at"}
