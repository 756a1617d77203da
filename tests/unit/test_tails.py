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
from equaltime.error_estimate import Estimate, PixelStatistics, image_error

Floats = NDArray[np.float64]
Draw = Callable[[np.random.Generator, tuple[int, ...]], Floats]
SAMPLES = 8
"""Of each half of the image."""
SIDE = 48
RENDERS = 40
CAUSTIC = Path(__file__).parents[2] / "scenes" / "experiments" / "caustic.toml"


def gaussian(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    return np.asarray(0.1 * rng.standard_normal(shape))


def rare(chance: float) -> Draw:
    return lambda rng, shape: 5.0 * (rng.binomial(SAMPLES, chance, shape) / SAMPLES - chance)


def pareto(index: float) -> Draw:
    """Samples with a power tail: below 2 they have no variance."""
    mean = index / (index - 1.0)
    return lambda rng, shape: 0.3 * (1.0 + rng.pareto(index, (SAMPLES, *shape)) - mean).mean(axis=0)


def renders(draw: Draw) -> list[tuple[Estimate, float]]:
    """Return what each states of its error, and its true one; noise differs from place to place."""
    rng = np.random.default_rng(3)
    x = np.arange(SIDE)
    place = np.exp(0.6 * np.sin(x / 3.0)[:, None] + 0.6 * np.cos(x / 4.0))
    found = []
    for _ in range(RENDERS):
        halves = np.repeat((1.0 + place * draw(rng, (2, SIDE, SIDE)))[..., None], 3, axis=-1)
        variance = np.square(halves[0] - halves[1]) / 4.0
        pixels = PixelStatistics(halves.mean(axis=0), variance, np.full((SIDE, SIDE), 2 * SAMPLES), 1.0)
        found.append((image_error(pixels), math.sqrt(np.square(pixels.mean - 1.0).mean() / 1.01)))
    return found


def holds(error: Estimate, true: float) -> bool:
    return error.low <= true <= error.high


@pytest.mark.parametrize("draw", [gaussian, rare(0.02)], ids=["gaussian", "light that 2 % of samples find"])
def test_noise_that_differs_and_many_rare_samples_are_trusted(draw: Draw) -> None:
    assert sum(error.trusted for error, _ in renders(draw)) >= 0.9 * RENDERS


@pytest.mark.parametrize("index", [1.3, 1.6])
def test_under_heavy_tails_what_misses_is_marked(index: float) -> None:
    found = renders(pareto(index))
    assert sum(error.trusted and not holds(error, true) for error, true in found) <= 0.05 * RENDERS
    assert sum(error.trusted for error, _ in found) <= 0.2 * RENDERS


def test_unmarked_they_would_fail() -> None:
    assert sum(not holds(error, true) for error, true in renders(pareto(1.3))) > 0.15 * RENDERS


def test_a_handful_of_rare_samples_is_said_to_be_one() -> None:
    error = renders(rare(6.0 / (2 * SAMPLES * SIDE**2)))[0][0]
    assert error.doubt.startswith("heavy tail: one pixel of one render makes ")
    assert error.as_dict()["doubt"] == error.doubt


def test_a_render_that_stops_at_an_error_it_cannot_know_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A caustic at few samples."""
    command = ["render", str(CAUSTIC), "-o", str(tmp_path / "a.exr"), "--size", "48x48", "--error", "99%"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "stopped by error" in said
    assert "the error's upper limit cannot be trusted: heavy tail" in said
    assert main([*command, "--json"]) == 0
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["doubt"].startswith("heavy tail")
