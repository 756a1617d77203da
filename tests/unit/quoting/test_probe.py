"""Probes: some pixels rendered to the end say what the error of the whole image will be there."""

import math
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

import equaltime as et
from equaltime.film.error import PixelStatistics, error_parts, expected_half_width, image_error, pixel_statistics
from equaltime.film.lamps import Lamps
from equaltime.quoting import probe as probes
from equaltime.quoting.law import Law, Probed
from equaltime.quoting.pilot import Pilot
from equaltime.rendering.budget import FIRST_LOOK, Limits
from equaltime.rendering.core import make_renderer
from equaltime.rendering.job import Job
from equaltime.rendering.session import Session
from equaltime.statistics.intervals import Interval

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Draw = Callable[[Floats, int, np.random.Generator], Indices]

SCENES = Path(__file__).parents[3] / "scenes"
SIDE, PILOT, SAMPLES, DRAWS, REPEATS = 64, 8, 64, 200, 24
BEST = et.Strategy.parse("best,adaptive=none")
NO_LAMPS = Lamps.none()
DENOMINATORS = 0.06
"""Of error², that the pilot's noise leaves to what squares are divided by."""


@cache
def scene() -> et.Scene:
    return et.load(SCENES / "cornell-box.toml").with_(size=(SIDE, SIDE), max_depth=4)


def statistics(samples: int) -> PixelStatistics:
    renderer = make_renderer(scene(), BEST, seed=0, threads=0)
    renderer.advance(samples)
    return pixel_statistics(renderer.moments)


def probe(pilot: PixelStatistics, lamps: Lamps = NO_LAMPS) -> probes.Probe:
    return probes.Probe(scene(), BEST, 0, 0, pilot, np.ones((SIDE, SIDE)), DRAWS, lamps)


@cache
def drawn(evenly: bool = False) -> tuple[Probed, ...]:
    """Return what probes of many draws find; wrongly, if pixels are drawn unevenly but counted as if evenly."""
    pilot, draw, found = statistics(PILOT), probes._draw, []
    with pytest.MonkeyPatch.context() as patch:
        for number in range(REPEATS):
            random = np.random.default_rng(number)
            patch.setattr(probes, "_draw", partial(_drawn, draw, random))
            some = probe(pilot)
            if evenly:
                some._sizes = np.full_like(some._sizes, some._sizes.mean())
            each = some.advance(SAMPLES)
            assert each is not None
            found.append(each)
    return tuple(found)


def _drawn(draw: Draw, random: np.random.Generator, sizes: Floats, draws: int, _: object) -> Indices:
    return draw(sizes, draws, random)


def distance(found: tuple[Probed, ...]) -> float:
    """Return by how many standard deviations probes miss error², as a mean."""
    squares = np.square([each.error / whole().value for each in found])
    of_draws = float(squares.std(ddof=1)) / math.sqrt(REPEATS)
    return abs(float(squares.mean()) - 1.0) / math.hypot(of_draws, DENOMINATORS / 1.96)


@cache
def whole() -> Interval:
    return image_error(statistics(SAMPLES))


def test_probes_say_the_error_of_the_whole_image() -> None:
    """False alarms: one in 370."""
    assert distance(drawn()) < 3.0


def test_pixels_that_are_drawn_unevenly_but_counted_evenly_would_be_seen() -> None:
    assert distance(drawn(evenly=True)) > 3.0


@pytest.mark.parametrize(("share", "holds"), [(1.0, True), (1.0 / 3.0, False)])
def test_probes_scatter_by_no_more_than_they_state(share: float, holds: bool) -> None:
    """One in 2000, of variances with 23 degrees of freedom; by less, since draws are stratified."""
    stated = np.mean([each.doubt**2 - probes._LEAST_DOUBT**2 for each in drawn()])
    scatter = np.var([math.log(each.error) for each in drawn()], ddof=1)
    assert (scatter / (share**2 * stated) < chi2.ppf(0.9995, REPEATS - 1) / (REPEATS - 1)) == holds


def test_the_upper_limit_follows_from_what_is_known_of_few_pixels() -> None:
    """To a fifth: what the noise of denominators adds is left out."""
    cautious = error_parts(statistics(SAMPLES), float(statistics(SAMPLES).mean.mean())).cautious
    squares = float(np.square(cautious).mean() / cautious.mean() ** 2)
    stated = math.log(whole().high / math.sqrt(cautious.mean()))
    assert abs(expected_half_width(squares, SIDE**2, 1.0) / stated - 1.0) < 0.2
    assert abs(expected_half_width(squares, 4 * SIDE**2, 1.0) / stated - 1.0) > 0.3, (
        "the twin: of four times the pixels"
    )


def test_its_samples_are_those_of_the_render() -> None:
    some = probe(statistics(PILOT))
    some.advance(SAMPLES)
    found, whole = pixel_statistics(some._renderer.moments), statistics(SAMPLES)
    there = found.samples > 0
    np.testing.assert_array_equal(found.mean[there], whole.mean[there])
    assert 0 < np.count_nonzero(there) <= DRAWS
    assert some.taken == SAMPLES * np.count_nonzero(there)


@pytest.mark.parametrize("error", [0.2, 0.05])
@pytest.mark.parametrize("strategy", ["best,adaptive=none", "best,adaptive=error"])
def test_a_pilot_and_its_probe_take_what_a_quote_may(error: float, strategy: str) -> None:
    limits = Limits(error=error)
    session = Session(Job(scene=scene(), strategy=et.Strategy.parse(strategy), limits=Limits(spp=FIRST_LOOK)))
    pilot, found = Pilot(session, limits), None
    while found is None:
        for _ in session.passes:
            if (found := pilot.pass_ended()) is not None:
                break
        session.passes.limits = Limits(spp=max(pilot.due, session.passes.samples))
    pixels = session.passes.pixels
    probed = pilot.taken > session.passes.samples * pixels
    # else a pilot of 8 samples, which it needs, leaves no room
    assert probed == (strategy == "best,adaptive=none" or error == 0.05)
    assert pilot.taken <= max(FIRST_LOOK, 0.05 * pilot._work) * pixels + DRAWS
    actual = et.render(scene(), error=error, strategy=strategy)
    assert 1.0 / 1.5 < found.spp.value / actual.spp < 1.5  # three standard deviations of 140 pixels


def test_pixels_without_noise_say_nothing() -> None:
    flat = PixelStatistics(np.ones((SIDE, SIDE, 3)), np.full((SIDE, SIDE, 3), 1e-9), np.full((SIDE, SIDE), 4), 1.0)
    film = {"type": "hdrfilm", "rfilter": {"type": "box"}}
    sky = {"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": {"type": "constant"}}
    even = et.load_dict(sky).with_(size=(SIDE, SIDE))
    assert probes.Probe(even, BEST, 0, 0, flat, np.ones((SIDE, SIDE)), DRAWS, NO_LAMPS).advance(16) is None


def test_a_small_lamp_in_sight_widens_the_limit_that_is_foretold_as_it_will_the_limit_that_is_stated() -> None:
    pixels = np.arange(20, 28)[:, None] * SIDE + np.arange(12, 52)
    light = np.full((pixels.size, 3), 1.5)
    lamp = Lamps.small(pixels.ravel(), light, np.full(pixels.size, 0.5 / SAMPLES))
    pilot, whole = statistics(PILOT), statistics(SAMPLES)
    found = [each for lamps in (NO_LAMPS, lamp) if (each := probe(pilot, lamps).advance(SAMPLES))]
    without, by = ((each.error * math.exp(each.width)) ** 2 for each in found)
    stated = lamp.missed(whole)
    assert by - without == pytest.approx(stated, rel=0.3)
    assert stated > 0.1 * image_error(whole).value ** 2, "the twin, a probe without lamps, foretells nothing of it"


def test_a_law_goes_through_what_was_probed() -> None:
    pilot = Law(8, 0.1, 0.1, 0.25, 0.6, 0.1, 1.0, 0.1)
    law = pilot.through([Probed(32, 0.06, 0.001, 0.05), Probed(128, 0.03, 0.001, 0.04)], "sobol")
    assert law.error_at(8).value == pytest.approx(0.1)
    assert law.error_at(32).value == pytest.approx(0.06)
    assert law.error_at(128).value == pytest.approx(0.03, rel=0.01)
    assert 0.03 < law.error_at(64).value < 0.06
    assert law.exponent == pytest.approx(math.log(0.06 / 0.03) / math.log(4.0), rel=0.02)


@pytest.mark.parametrize(("sampler", "slope"), [("independent", 0.5), ("sobol", 0.45), ("lattice", 0.45)])
def test_beyond_a_probe_no_error_falls_slower_than_independent_samples_for_long(sampler: str, slope: float) -> None:
    """Estimates fall slowly while light is still being met: by BSDF sampling of veach-mis as n^-0.34 over a probe.

    A quote that went on at this rate told 80 times the time that 10 % takes.
    """
    pilot = Law(8, 8.0, 0.6, 0.1, 0.4, 0.005, 1.0, 0.1)
    law = pilot.through([Probed(64, 5.0, 0.01, 0.4), Probed(646, 2.73, 0.01, 0.3)], sampler)
    assert law.error_at(64).value / law.error_at(646).value < 2.0
    assert law.error_at(646).value / law.error_at(646 * 4**5).value == pytest.approx(4.0 ** (5 * slope))


def test_what_a_probe_finds_just_beyond_a_pilot_says_nothing_of_what_lies_before_it() -> None:
    pilot = Law(58, 0.0884, 0.061, 0.16, 0.545, 0.064, 0.01, 0.1)
    law = pilot.through([Probed(64, 0.098, 0.001, 0.06), Probed(512, 0.024, 0.001, 0.043)], "sobol")
    assert law.error_at(8).value > 0.1  # the slope between the two would make it 1 %
    assert law.samples_until(0.01).low > 512.0


def test_what_is_in_doubt_is_weighed_against_the_law() -> None:
    pilot = Law(8, 0.1, 0.1, 0.25, 0.6, 0.1, 1.0, 0.1)
    foretold = pilot.error_at(128).value
    vague = pilot.through([Probed(128, 0.5 * foretold, 1.0, 0.04)], "sobol").error_at(128)
    sure = pilot.through([Probed(128, 0.5 * foretold, 0.01, 0.04)], "sobol").error_at(128)
    assert vague.value > 0.9 * foretold > 0.6 * foretold > sure.value
    assert vague.high / vague.low > sure.high / sure.low
    assert isinstance(sure, Interval)
