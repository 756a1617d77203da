"""Probes: some pixels rendered to the end say what the error of the whole image will be there."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime import probe as probes
from equaltime.budget import FIRST_LOOK, Limits
from equaltime.core_renderer import make_renderer
from equaltime.error_estimate import Estimate, PixelStatistics, image_error, pixel_statistics
from equaltime.law import Law, Probed
from equaltime.quote import Pilot
from equaltime.session import Session

SCENES = Path(__file__).parents[2] / "scenes"
SIDE, PILOT, SAMPLES, DRAWS, REPEATS = 64, 8, 64, 200, 24
BEST = et.Strategy.parse("best")
DENOMINATORS = 0.06
"""Of error², that the pilot's noise leaves to what squares are divided by."""


@cache
def scene() -> et.Scene:
    return et.load(SCENES / "cornell-box.toml").with_(size=(SIDE, SIDE), max_depth=4)


def statistics(samples: int) -> PixelStatistics:
    renderer = make_renderer(scene(), BEST, seed=0, threads=0)
    renderer.advance(samples)
    return pixel_statistics(renderer.moments)


def probe(pilot: PixelStatistics) -> probes.Probe:
    return probes.Probe(scene(), BEST, 0, 0, pilot, np.ones((SIDE, SIDE)), DRAWS)


def probed(pilot: PixelStatistics) -> float:
    """Return the error that a probe finds."""
    found = probe(pilot).advance(SAMPLES)
    assert found is not None
    return found.error


def distance(monkeypatch: pytest.MonkeyPatch) -> float:
    """Return by how many standard deviations probes of many draws miss error², as a mean."""
    pilot, whole = statistics(PILOT), image_error(statistics(SAMPLES)).value
    draw, squares = probes._draw, []
    for number in range(REPEATS):
        monkeypatch.setattr(
            probes, "_draw", lambda sizes, draws, _, number=number: draw(sizes, draws, np.random.default_rng(number))
        )
        squares.append((probed(pilot) / whole) ** 2)
    of_draws = float(np.std(squares, ddof=1)) / math.sqrt(REPEATS)
    return abs(float(np.mean(squares)) - 1.0) / math.hypot(of_draws, DENOMINATORS / 1.96)


def test_probes_say_the_error_of_the_whole_image(monkeypatch: pytest.MonkeyPatch) -> None:
    """False alarms: one in 370."""
    assert distance(monkeypatch) < 3.0


def test_pixels_that_are_drawn_evenly_but_counted_otherwise_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    evenly = np.random.default_rng(1)
    with monkeypatch.context() as patch:
        patch.setattr(probes, "_draw", lambda sizes, draws, _: evenly.integers(0, sizes.size, draws))
        pilot, whole = statistics(PILOT), image_error(statistics(SAMPLES)).value
        squares = [(probed(pilot) / whole) ** 2 for _ in range(REPEATS)]
    of_draws = float(np.std(squares, ddof=1)) / math.sqrt(REPEATS)
    assert abs(float(np.mean(squares)) - 1.0) / math.hypot(of_draws, DENOMINATORS / 1.96) > 3.0


def test_stated_doubts_are_as_probes_scatter() -> None:
    pilot, whole = statistics(PILOT), image_error(statistics(SAMPLES)).value
    found = []
    for seed in range(REPEATS):
        some = probes.Probe(scene(), BEST, 0, 0, pilot, np.ones((SIDE, SIDE)), DRAWS)
        some._drawn = some._drawn[np.random.default_rng(seed).integers(0, DRAWS, DRAWS)]  # as if drawn again
        each = some.advance(SAMPLES)
        assert each is not None
        found.append(each)
    scatter = float(np.std([math.log(each.error / whole) for each in found], ddof=1))
    assert 0.6 < scatter / found[0].doubt < 1.5  # chi² of 23 degrees: 1 in 1000 beyond


def test_its_samples_are_those_of_the_render() -> None:
    some = probe(statistics(PILOT))
    some.advance(SAMPLES)
    found, whole = pixel_statistics(some._renderer.moments), statistics(SAMPLES)
    there = found.samples > 0
    np.testing.assert_array_equal(found.mean[there], whole.mean[there])
    assert 0 < np.count_nonzero(there) <= DRAWS
    assert some.taken == SAMPLES * np.count_nonzero(there)


@pytest.mark.parametrize("error", [0.2, 0.05])
@pytest.mark.parametrize("strategy", ["best", "best,adaptive=error"])
def test_a_pilot_and_its_probe_take_what_a_quote_may(error: float, strategy: str) -> None:
    limits = Limits(error=error)
    session = Session(scene(), et.Strategy.parse(strategy), 0, 0, Limits(spp=FIRST_LOOK))
    pilot, found = Pilot(session, limits), None
    while found is None:
        for _ in session.passes:
            if (found := pilot.pass_ended()) is not None:
                break
        session.passes.limits = Limits(spp=max(pilot.due, session.passes.samples))
    pixels = session.passes.pixels
    probed = pilot.taken > session.passes.samples * pixels
    assert (
        probed or session.passes.samples == FIRST_LOOK
    )  # there is no room beside a pilot of 8 samples, if it needs them
    assert pilot.taken <= max(FIRST_LOOK, 0.05 * pilot._work) * pixels + DRAWS
    actual = et.render(scene(), error=error, strategy=strategy)
    assert 1.0 / 1.5 < found.spp.value / actual.spp < 1.5  # three standard deviations of 140 pixels


def test_pixels_without_noise_say_nothing() -> None:
    flat = PixelStatistics(np.ones((SIDE, SIDE, 3)), np.full((SIDE, SIDE, 3), 1e-9), np.full((SIDE, SIDE), 4), 1.0)
    film = {"type": "hdrfilm", "rfilter": {"type": "box"}}
    sky = {"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": {"type": "constant"}}
    even = et.load_dict(sky).with_(size=(SIDE, SIDE))
    assert probes.Probe(even, BEST, 0, 0, flat, np.ones((SIDE, SIDE)), DRAWS).advance(16) is None


def test_a_law_goes_through_what_was_probed() -> None:
    pilot = Law(8, 0.1, 0.1, 0.25, 0.6, 0.1, 1.0)
    law = pilot.through([Probed(32, 0.06, 0.001, 0.05), Probed(128, 0.03, 0.001, 0.04)], "sobol")
    assert law.error_at(8).value == pytest.approx(0.1)
    assert law.error_at(32).value == pytest.approx(0.06)
    assert law.error_at(128).value == pytest.approx(0.03, rel=0.01)
    assert 0.03 < law.error_at(64).value < 0.06
    assert law.exponent == pytest.approx(math.log(0.06 / 0.03) / math.log(4.0), rel=0.02)


def test_what_is_in_doubt_is_weighed_against_the_law() -> None:
    pilot = Law(8, 0.1, 0.1, 0.25, 0.6, 0.1, 1.0)
    foretold = pilot.error_at(128).value
    vague = pilot.through([Probed(128, 0.5 * foretold, 1.0, 0.04)], "sobol").error_at(128)
    sure = pilot.through([Probed(128, 0.5 * foretold, 0.01, 0.04)], "sobol").error_at(128)
    assert vague.value > 0.9 * foretold > 0.6 * foretold > sure.value
    assert vague.high / vague.low > sure.high / sure.low
    assert isinstance(sure, Estimate)
