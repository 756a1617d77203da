"""Whether quotes of samples hold: imagined renders whose errors fall by a known law, stopped by the real looks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from statistics import NormalDist, geometric_mean

import numpy as np
import pytest

from equaltime.quoting.law import Law, fit
from equaltime.rendering.budget import FIRST_LOOK, Looks, next_look
from equaltime.statistics.intervals import Interval

TRIALS, MOST = 80, 40_000


class Imagined:
    """A render whose error falls nearly as a power of the samples, with chance that wears off as samples come in.

    From octave to octave the exponent rises or falls a little. Of what chance makes of the logarithm after n and N
    samples, n / N is the correlation.
    """

    def __init__(self, seed: int, exponent: float, spread: float) -> None:
        rng = np.random.default_rng(seed)
        self._exponent, self._bend = exponent + 0.05 * rng.uniform(-1.0, 1.0), 0.03 * rng.uniform(-1.0, 1.0)
        self._spread = spread
        counts = np.arange(1, MOST + 1)
        self._chance = np.cumsum(np.sqrt(2.0 * counts - 1.0) * rng.standard_normal(MOST)) / counts

    def error(self, samples: int, level: float = 0.95) -> Interval:
        """Return what it states after so many samples."""
        chance = self._chance[min(samples, MOST) - 1] / math.sqrt(2.0)
        growth = math.log(samples / 8)
        fallen = (self._exponent + 0.5 * self._bend * min(growth, 6.0)) * growth
        value = 0.3 * math.exp(self._spread * float(chance) - fallen)
        factor = math.exp(self._spread * NormalDist().inv_cdf(0.5 + 0.5 * level))
        return Interval(value, value / factor, value * factor)


def noted(upto: int) -> Iterator[int]:
    """Give 2, 3, 4, 6, 8, 12, … doubled, as far as wanted."""
    count = 2
    while count < upto:
        yield count
        count = count * 3 // 2 if count.bit_count() == 1 and count > 2 else 2 ** count.bit_length()
    yield upto


def quoted(seed: int, target: float, exponent: float, spread: float) -> tuple[Law, Interval]:
    """Return the law of a pilot of a twentieth of the work, and the samples that it quotes."""
    due, render = FIRST_LOOK, Imagined(seed, exponent, spread)
    while True:
        errors = {n: render.error(n) for n in noted(due)}
        law = fit(errors, {n: 0.1 * n for n in errors}, "sobol")
        samples = law.samples_until(target)
        if samples.value / 20 <= due:
            return law, samples
        due = 2 * math.ceil(samples.value / 40)


def stop(seed: int, target: float, exponent: float, spread: float) -> int:
    """Return where the same render stops."""
    render, looks, samples = Imagined(seed, exponent, spread), Looks(), 0
    while not looks.met(target):
        samples = next_look(samples)
        looks.look(render.error(samples), samples)
    return samples


CASES = [(0.03, 0.54, 0.03), (0.01, 0.6, 0.02), (0.05, 0.54, 0.15)]


@pytest.mark.parametrize(("target", "exponent", "spread"), CASES)
def test_quoted_intervals_hold_where_renders_stop(target: float, exponent: float, spread: float) -> None:
    """At 95 %, fewer than 68 of 80 happen once in 3000 times."""
    held = 0
    for seed in range(TRIALS):
        samples = quoted(seed, target, exponent, spread)[1]
        held += samples.low <= stop(seed, target, exponent, spread) <= samples.high
    assert held >= 68


def test_intervals_of_an_exponent_that_is_off_would_be_seen_to_fail() -> None:
    held, (target, exponent, spread) = 0, CASES[0]
    for seed in range(TRIALS):
        law, _ = quoted(seed, target, exponent, spread)
        samples = replace(law, exponent=law.exponent + 0.12, exponent_doubt=0.0).samples_until(target)
        held += samples.low <= stop(seed, target, exponent, spread) <= samples.high
    assert held < 68


def test_half_of_the_renders_stop_before_the_quote() -> None:
    target, exponent, spread = CASES[0]
    ratios = [stop(s, target, exponent, spread) / quoted(s, target, exponent, spread)[1].value for s in range(TRIALS)]
    assert 0.9 < float(np.median(ratios)) < 1.1


def test_a_quote_foretells_the_upper_limit_and_not_the_error() -> None:
    """A wide interval needs samples until the limit is there; a narrow one is believed to be 1.15 times the error."""
    narrow = Law(8, 0.1, 0.02, 0.0, 0.5, 0.001, 1.0, 0.1)
    wide = replace(narrow, width=0.4)
    errors = np.geomspace(0.005, 0.02, 16)  # over several steps from look to look
    ratios = [wide.samples_until(error).value / narrow.samples_until(error).value for error in errors]
    assert geometric_mean(ratios) == pytest.approx((math.exp(0.4) / 1.15) ** 2, rel=0.3)
    assert geometric_mean(ratios) > 1.5


def test_an_interval_that_narrows_asks_for_fewer() -> None:
    wide = Law(8, 0.1, 0.4, 0.0, 0.5, 0.001, 1.0, 0.1)
    assert replace(wide, narrowing=0.3).samples_until(0.02).value < 0.8 * wide.samples_until(0.02).value


def test_speeds_that_varied_leave_the_time_in_doubt() -> None:
    counts = list(noted(64))
    errors = {n: Interval(0.3 * n**-0.5, 0.29 * n**-0.5, 0.31 * n**-0.5) for n in counts}
    spent = np.cumsum(np.diff([0, *counts]) * np.where(np.arange(len(counts)) % 2, 0.13, 0.1))
    even = fit(errors, {n: 0.1 * n for n in counts}, "independent")
    uneven = fit(errors, dict(zip(counts, map(float, spent), strict=True)), "independent")
    assert even.speed_doubt < 0.06 < 0.1 < uneven.speed_doubt < 0.16
    samples = Interval(1000.0, 1000.0, 1000.0)
    assert uneven.seconds_for(samples).high / uneven.seconds_for(samples).value > 1.2
    assert even.seconds_for(samples).high / even.seconds_for(samples).value < 1.13
