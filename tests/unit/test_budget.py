"""When renders stop at an error: the looks at it, on errors that the test decides."""

import math
from collections.abc import Callable

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
    assert needed <= looks.made[-1] <= (1.5 if exponent > 0.75 else 1.25) * needed + 2


def test_looks_are_few() -> None:
    assert len(looked(falling(0.5), 0.005).made) <= 12


def test_it_is_the_upper_limit_that_counts() -> None:
    assert looked(falling(0.5, spread=2.0), 0.1).made[-1] >= 400


def test_an_unknown_error_is_looked_at_again_and_not_taken_for_none() -> None:
    looks = Looks()
    assert not looks.look(lambda _: Estimate(math.inf, 0.0, math.inf), looks.next, 0.1)
    assert FIRST_LOOK < looks.next <= 2 * FIRST_LOOK


def test_an_error_beyond_all_bounds_is_looked_at_again() -> None:
    looks = Looks()
    assert not looks.look(lambda _: Estimate(1e300, 1e299, 1e301), looks.next, 1e-3)
    assert looks.next == 8 * FIRST_LOOK


def test_a_render_that_is_taken_up_goes_on_with_its_looks() -> None:
    whole = looked(falling(0.55), 0.01)
    taken_up = Looks(whole.made[:3])
    assert taken_up.next > whole.made[2]
    levels: list[float] = []

    def noted(level: float) -> Estimate:
        levels.append(level)
        return falling(0.55)(taken_up.next)

    taken_up.look(noted, taken_up.next, 0.01)
    assert levels == [pytest.approx(1.0 - 2.0 * 0.05 / 2.0**4)]


def test_looks_that_cannot_end_a_render_spend_no_level() -> None:
    looks, levels = Looks(), list[float]()

    def noted(level: float) -> Estimate:
        levels.append(level)
        return falling(0.5)(looks.next)

    while not looks.look(noted, looks.next, 0.01):
        pass
    idle = sum(n**-0.5 >= 0.02 for n in looks.made)
    assert idle >= 2
    assert levels[: idle + 1] == [pytest.approx(0.95)] * (idle + 1)
    assert levels[idle + 1 :] == sorted(set(levels[idle + 1 :]))


def wrong_stops(level_of: Callable[[float], float], trials: int = 4000) -> float:
    """Share of renders that stop above the target, where the error stays a little above it and each look is noisy.

    The look's noise is independent from look to look, the worst case: most chances to be lucky.
    """
    rng = np.random.default_rng(7)
    wrong = 0
    for _ in range(trials):
        looks = Looks()
        for _ in range(40):

            def noisy(level: float) -> Estimate:
                from scipy.special import ndtri

                factor = math.exp(0.05 * ndtri(0.5 + 0.5 * level_of(level)))
                seen = 0.1001 * math.exp(0.05 * rng.standard_normal())
                return Estimate(seen, seen / factor, seen * factor)

            if looks.look(noisy, looks.next, 0.1):
                wrong += 1
                break
    return wrong / trials


def test_looking_often_stops_too_early_in_less_than_5_percent_of_renders() -> None:
    """5 % + 3.3 standard errors of 4000 trials (false alarms: 5e-4)."""
    assert wrong_stops(lambda level: level) < 0.05 + 3.3 * math.sqrt(0.05 * 0.95 / 4000)


def test_looks_that_spent_no_level_would_stop_too_early() -> None:
    assert wrong_stops(lambda _: 0.90) > 0.3
