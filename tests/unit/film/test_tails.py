"""Whether one render can tell how far its error spreads: simulated images whose truth is 1."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.cli import main
from equaltime.film.error import PixelStatistics, error_and_brightest, error_parts, expected_half_width
from equaltime.film.tails import averaged_out
from equaltime.film.unseen import stated_error
from equaltime.rendering.budget import Look, Looks
from equaltime.statistics.intervals import Interval

Floats = NDArray[np.float64]
Draw = Callable[[np.random.Generator, tuple[int, ...]], Floats]
SAMPLES = 8
"""Of each half of the image."""
SIDE = 48
RENDERS = 40
CAUSTIC = Path(__file__).parents[3] / "scenes" / "experiments" / "caustic.toml"


def gaussian(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    return np.asarray(0.1 * rng.standard_normal(shape))


def rare(chance: float) -> Draw:
    return lambda rng, shape: 5.0 * (rng.binomial(SAMPLES, chance, shape) / SAMPLES - chance)


def pareto(index: float) -> Draw:
    """Samples with a power tail: below 2 they have no variance."""
    mean = index / (index - 1.0)
    return lambda rng, shape: 0.3 * (1.0 + rng.pareto(index, (SAMPLES, *shape)) - mean).mean(axis=0)


def images(draw: Draw) -> list[tuple[PixelStatistics, float]]:
    """Return renders, and the true error of each; noise differs from place to place."""
    rng = np.random.default_rng(3)
    x = np.arange(SIDE)
    place = np.exp(0.6 * np.sin(x / 3.0)[:, None] + 0.6 * np.cos(x / 4.0))
    found = []
    for _ in range(RENDERS):
        halves = np.repeat((1.0 + place * draw(rng, (2, SIDE, SIDE)))[..., None], 3, axis=-1)
        variance = np.square(halves[0] - halves[1]) / 4.0
        pixels = PixelStatistics(halves.mean(axis=0), variance, np.full((SIDE, SIDE), 2 * SAMPLES), 1.0)
        found.append((pixels, math.sqrt(np.square(pixels.mean - 1.0).mean() / 1.01)))
    return found


def renders(draw: Draw) -> list[tuple[Interval, float, float]]:
    """Return what each render states of its error, its true one, and how much its brightest path makes."""
    return [(error, true, bright) for pixels, true in images(draw) for error, bright in [error_and_brightest(pixels)]]


@pytest.mark.parametrize("draw", [gaussian, rare(0.02)], ids=["gaussian", "light that 2 % of samples find"])
def test_noise_that_differs_and_many_rare_samples_are_no_bright_path(draw: Draw) -> None:
    assert max(bright for _, _, bright in renders(draw)) < 0.1


@pytest.mark.parametrize("index", [1.3, 1.6])
def test_upper_limits_hold_under_heavy_tails(index: float) -> None:
    """Of 40 intervals of 97.5 %, more than 4 miss by chance once in 300 times."""
    assert sum(error.high < true for error, true, _ in renders(pareto(index))) <= 4


def test_limits_by_a_reference_with_the_pixel_would_miss() -> None:
    assert sum(lenient_limit(pixels) < true for pixels, true in images(pareto(1.3))) > 4


def lenient_limit(pixels: PixelStatistics) -> float:
    """Return the upper limit by the reference that a bright pixel makes too bright."""
    lenient = error_parts(pixels, float(pixels.mean.mean())).lenient
    squares = float(np.square(lenient).mean() / lenient.mean() ** 2)
    return math.sqrt(lenient.mean()) * math.exp(expected_half_width(squares, lenient.size, pixels.degrees))


def test_a_handful_of_rare_samples_is_a_bright_path_each() -> None:
    assert renders(rare(6.0 / (2 * SAMPLES * SIDE**2)))[0][2] > 0.1


def test_a_bright_path_that_an_error_still_shows_is_no_reason_for_doubt() -> None:
    # at 8 samples it made all of error² = 1; at 16 it makes a quarter, which is all that is left
    assert averaged_out(past=64.0, samples=16.0, square=0.25, share=1.0) == ""


def test_a_bright_path_that_an_error_no_longer_shows_is_one() -> None:
    assert averaged_out(past=64.0, samples=16.0, square=0.25, share=0.0).startswith("a rare bright path")
    # more samples make of it what is negligible
    assert averaged_out(past=64.0, samples=64.0, square=0.25, share=0.0) == ""


def test_a_render_remembers_the_bright_path_of_a_look() -> None:
    looks = (Look(8, 1.0, 1.2, brightest=64.0),)
    pixels, _ = images(gaussian)[0]
    assert not stated_error(pixels).doubt
    brightest = Looks(looks).brightest * stated_error(pixels).value ** 2 * (2 * SAMPLES / 8.0) ** 2
    assert "averaged out" in stated_error(pixels, brightest=brightest).doubt


def test_a_render_that_stops_at_an_error_it_cannot_know_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A caustic at few samples."""
    command = ["render", str(CAUSTIC), "-o", str(tmp_path / "a.exr"), "--size", "48x48", "--error", "99%"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "Reached 99 %: error " in said
    assert "favours images that have not met rare light" in said
    assert "unbiased" not in said
    assert "small bright emitters" in said, "with the forecast, if there was one, or with the result"
    assert "the error's upper limit cannot be trusted" in said
    assert main([*command, "--json"]) == 0
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["doubt"].startswith("small bright emitters")
