"""When renders stop at an error: the looks at it, on errors that the test decides."""

import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np
import pytest

from equaltime.budget import FIRST_LOOK, Looks
from equaltime.error_estimate import Estimate


def falling(exponent: float, spread: float = 1.0) -> Callable[[int], Estimate]:
    """An error of 1 at one sample that falls as a power of the samples."""
    return lambda samples: Estimate(samples**-exponent, 0.0, samples**-exponent * spread)


def looked(error: Callable[[int], Estimate], target: float) -> Looks:
    """Look until the target is reached."""
    looks = Looks()
    while not looks.look(lambda _: error(looks.next), looks.next, target):
        assert len(looks.made) < 100
    return looks


@pytest.mark.parametrize("exponent", [0.5, 0.6, 0.75, 1.0])
@pytest.mark.parametrize("target", [0.1, 0.02, 0.005])
def test_a_render_stops_soon_after_its_upper_limit_is_at_the_target(exponent: float, target: float) -> None:
    """An error that falls faster than was to be expected is passed by at most half."""
    looks = looked(falling(exponent), target)
    needed = max(target ** (-1.0 / exponent), FIRST_LOOK)
    assert needed <= looks.made[-1].samples <= (1.5 if exponent > 0.75 else 1.25) * needed + 2


def test_looks_are_few() -> None:
    assert len(looked(falling(0.5), 0.005).made) <= 12


def test_it_is_the_upper_limit_that_counts() -> None:
    assert looked(falling(0.5, spread=2.0), 0.1).made[-1].samples >= 400


def test_an_unknown_error_is_looked_at_again_and_not_taken_for_none() -> None:
    looks = Looks()
    assert not looks.look(lambda _: Estimate(math.nan, 0.0, math.inf), looks.next, 0.1)
    assert FIRST_LOOK < looks.next <= 2 * FIRST_LOOK


def test_an_error_beyond_all_bounds_is_looked_at_again() -> None:
    looks = Looks()
    assert not looks.look(lambda _: Estimate(1e300, 1e299, 1e301), looks.next, 1e-3)
    assert looks.next == 8 * FIRST_LOOK


def test_a_limit_far_above_the_estimate_is_looked_at_again_soon() -> None:
    """It is not extended by a law, at which the target would be eight times as far."""
    looks = Looks()
    looks.look(lambda _: Estimate(0.06, 0.01, 0.6), looks.next, 0.05)
    assert 1.15 * FIRST_LOOK < looks.next < 4 * FIRST_LOOK


def levels_of(error: Callable[[int], Estimate], looks: Looks, target: float, count: int) -> list[float]:
    """Return the levels at which the next looks ask for the error."""
    levels: list[float] = []

    def noted(level: float) -> Estimate:
        levels.append(level)
        return error(looks.next)

    for _ in range(count):
        if looks.look(noted, looks.next, target):
            break
    return levels


def test_six_looks_have_the_95_percent_limit_and_later_ones_are_stricter() -> None:
    levels = levels_of(lambda _: Estimate(0.1, 0.09, 0.11), Looks(), 0.1, 60)
    assert levels[:6] == [pytest.approx(0.95, abs=1e-5)] * 6
    assert levels[6:20] == sorted(set(levels[6:20]))
    assert levels[6] > 0.96
    assert levels[-1] < 1.0


def test_looks_that_cannot_end_a_render_spend_nothing() -> None:
    far = levels_of(lambda _: Estimate(1.0, 0.9, 1.1), Looks(), 0.1, 30)
    assert far == [pytest.approx(0.95, abs=1e-5)] * 30


def test_the_chances_to_stop_wrongly_are_5_percent_in_all() -> None:
    levels = levels_of(lambda _: Estimate(0.1, 0.09, 0.11), Looks(), 0.1, 60)
    normal = NormalDist()
    chances = [normal.cdf(-normal.inv_cdf(0.5 + 0.5 * level) / math.sqrt(2.0)) ** 2 for level in levels]
    assert 0.049 < sum(chances) < 0.050001


def test_a_render_that_is_taken_up_goes_on_with_its_looks() -> None:
    whole = looked(falling(0.55), 0.01)
    taken_up = Looks(whole.made[:3], 0.01)
    assert taken_up.next == whole.made[3].samples
    while not taken_up.look(lambda _: falling(0.55)(taken_up.next), taken_up.next, 0.01):
        pass
    assert taken_up.made == whole.made
    assert Looks(whole.made, 0.01).met


def test_another_target_goes_on_as_if_all_looks_had_been_made_for_it() -> None:
    looks, alone = looked(falling(0.5), 0.05), looked(falling(0.5), 0.02)
    assert not looks.look(lambda _: falling(0.5)(looks.next), looks.next, 0.02)
    assert not looks.met
    looks.aim(0.08)
    assert looks.met
    assert len(alone.made) <= len(looks.made) + 3


def wrong_stops(
    stands: float, limit: Callable[[float], float] = lambda z: z, trials: int = 2000, spread: float = 0.05
) -> float:
    """Share of renders that stop above the target, where the error to be expected stays so many deviations above it.

    The estimate and the image vary independently and by the same, also from look to look, the worst case: most chances
    to be lucky.
    """
    rng = np.random.default_rng(7)
    wrong = 0
    for _ in range(trials):
        looks = Looks()
        for _ in range(40):
            low, bad = spread * (stands + rng.standard_normal(2) / math.sqrt(2.0))

            def noisy(level: float, low: float = low) -> Estimate:
                z = limit(NormalDist().inv_cdf(0.5 + 0.5 * level))
                seen = 0.1 * math.exp(low)
                return Estimate(seen, seen * math.exp(-spread * z), seen * math.exp(spread * z))

            if looks.look(noisy, looks.next, 0.1):
                wrong += bad > 0.0
                break
    return wrong / trials


PLACES = (-1.5, -1.0, -0.5, 0.0)
"""Of the expected error, in standard deviations of the interval above the target."""


@pytest.mark.parametrize("stands", PLACES)
def test_looking_often_stops_wrongly_in_less_than_5_percent_of_renders(stands: float) -> None:
    """5 % + 3.3 standard errors of 2000 trials (false alarms: 5e-4)."""
    assert wrong_stops(stands) < 0.05 + 3.3 * math.sqrt(0.05 * 0.95 / 2000)


def test_looks_that_spent_nothing_would_stop_wrongly_too_often() -> None:
    assert wrong_stops(-0.5, lambda _: 1.96) > 0.08


def test_a_limit_of_one_standard_deviation_would_stop_wrongly_too_often() -> None:
    assert wrong_stops(-0.5, lambda z: 0.5 * z) > 0.1


def wrong_stops_of_falling_errors(exponent: float, spread: float, limit: float = 1.0, trials: int = 2000) -> float:
    """Share of renders that stop above the target, of an error that falls as a power of the samples.

    What chance made of both halves wears off as new samples come in: of the log errors after n and N samples, n / N
    is the correlation.
    """
    rng = np.random.default_rng(11)
    wrong = 0
    for _ in range(trials):
        looks, samples, chance = Looks(), 0, rng.standard_normal(2)
        while True:
            kept = samples / looks.next
            chance = kept * chance + math.sqrt(1.0 - kept**2) * rng.standard_normal(2)
            samples = looks.next
            low, bad = samples**-exponent * np.exp(spread * chance / math.sqrt(2.0))

            def seen(level: float, value: float = float(low)) -> Estimate:
                factor = math.exp(limit * spread * NormalDist().inv_cdf(0.5 + 0.5 * level))
                return Estimate(value, value / factor, value * factor)

            if looks.look(seen, samples, 0.03):
                wrong += bad > 0.03
                break
    return wrong / trials


@pytest.mark.parametrize("exponent", [0.5, 0.7])
@pytest.mark.parametrize("spread", [0.02, 0.2])
def test_renders_whose_error_falls_stop_wrongly_in_less_than_5_percent(exponent: float, spread: float) -> None:
    assert wrong_stops_of_falling_errors(exponent, spread) < 0.05


def test_a_limit_at_the_estimate_itself_would_stop_too_early() -> None:
    assert wrong_stops_of_falling_errors(0.5, 0.2, limit=0.0) > 0.2
