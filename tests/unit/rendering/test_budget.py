"""When renders stop at an error: the looks at it, on errors that the test decides."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

from equaltime.film.error import UNKNOWN_ERROR
from equaltime.rendering.budget import FIRST_LOOK, Look, Looks, next_look
from equaltime.statistics.intervals import Interval


def falling(exponent: float, spread: float = 1.0) -> Callable[[int], Interval]:
    """An error of 1 at one sample that falls as a power of the samples."""
    return lambda samples: Interval(samples**-exponent, 0.0, samples**-exponent * spread)


def looked(error: Callable[[int], Interval], target: float) -> Looks:
    """Look until the target is reached."""
    looks, samples = Looks(), 0
    while not looks.met(target):
        samples = next_look(samples)
        looks.look(error(samples), samples)
        assert len(looks.made) < 100
    return looks


def test_looks_are_where_both_halves_of_a_net_are_large() -> None:
    """The first half holds the largest power of two of samples below the count; the second, those after it."""
    counts = [look.samples for look in looked(falling(0.5), 0.01).made]
    assert counts[:9] == [8, 12, 16, 24, 32, 48, 64, 96, 128]
    assert all(4 * after in (6 * before, 16 * before / 3) for before, after in itertools.pairwise(counts))
    assert [next_look(n) for n in (1, 9, 16, 17, 23, 24, 25, 31)] == [8, 12, 24, 24, 24, 32, 32, 32]


@pytest.mark.parametrize("exponent", [0.5, 0.6, 0.75, 1.0])
@pytest.mark.parametrize("target", [0.1, 0.02, 0.005])
def test_a_render_stops_soon_after_its_error_is_surely_at_the_target(exponent: float, target: float) -> None:
    """An error that is known exactly is believed to be 1.15 times as large; two looks take twice as many samples."""
    stopped = looked(falling(exponent), target).made[-1].samples
    needed = max((1.15 / target) ** (1.0 / exponent), FIRST_LOOK)
    assert needed <= stopped <= 2 * needed + 4


def test_it_is_the_upper_limit_that_counts() -> None:
    assert looked(falling(0.5, spread=2.0), 0.1).made[-1].samples >= 400


def test_a_narrow_interval_is_believed_no_more_than_a_wide_one() -> None:
    assert Look(8, 0.1, 0.1001).believed == pytest.approx(0.115)
    assert Look(8, 0.1, 0.3).believed == 0.3


def test_two_looks_in_a_row_must_agree() -> None:
    errors = {8: 0.2, 12: 0.01, 16: 0.2, 24: 0.115, 32: 0.099}
    looks = looked(lambda n: Interval(errors[n] / 1.2, 0.0, errors[n]), 0.1)
    assert [look.samples for look in looks.made] == [*errors], "the lucky look after 12 samples ends nothing"


def test_the_look_before_may_be_a_fifth_above_and_no_more() -> None:
    for before, met in ((0.1199, True), (0.1201, False)):
        looks = Looks((Look(8, 0.1 * before, before), Look(12, 0.01, 0.1)))
        assert looks.met(0.1) == met


def test_an_unknown_error_is_not_taken_for_none() -> None:
    looks = Looks()
    for samples in (8, 12, 16):
        looks.look(UNKNOWN_ERROR, samples)
        assert not looks.met(0.1)


def test_looks_are_due_at_their_counts_alone_and_once() -> None:
    looks = Looks()
    assert [n for n in range(40) if looks.due(n)] == [8, 12, 16, 24, 32]
    looks.look(Interval(0.1, 0.09, 0.11), 8)
    assert not looks.due(8)
    assert looks.due(12)


def test_a_render_that_is_taken_up_goes_on_with_its_looks() -> None:
    whole = looked(falling(0.55), 0.01)
    taken_up, samples = Looks(whole.made[:3]), whole.made[2].samples
    while not taken_up.met(0.01):
        samples = next_look(samples)
        taken_up.look(falling(0.55)(samples), samples)
    assert taken_up.made == whole.made


def wrong_stops(stands: float, alone: bool = False, spread: float = 0.1, trials: int = 2000) -> float:
    """Share of renders that stop above the target, where the error to be expected stays so far above it.

    The estimate and the image vary independently and by the same, also from look to look, the worst case: most chances
    to be lucky. ``stands`` counts in standard deviations of both.
    """
    rng = np.random.default_rng(7)
    wrong = 0
    for _ in range(trials):
        looks, samples = Looks(), 0
        for _ in range(20):
            samples = next_look(samples)
            low, bad = spread * (stands + rng.standard_normal(2) / math.sqrt(2.0))
            seen = 0.1 * math.exp(low)
            looks.look(Interval(seen, 0.0, seen * math.exp(1.96 * spread)), samples)
            if looks.met(0.1) or (alone and looks.made[-1].believed <= 0.1):
                wrong += bad > 0.0
                break
    return wrong / trials


@pytest.mark.parametrize("stands", [-1.5, -1.0, -0.5, 0.0])
def test_looking_often_stops_wrongly_in_less_than_5_percent_of_renders(stands: float) -> None:
    """5 % + 3.3 standard errors of 2000 trials (false alarms: 5e-4)."""
    assert wrong_stops(stands) < 0.05 + 3.3 * math.sqrt(0.05 * 0.95 / 2000)


def test_single_looks_would_stop_wrongly_too_often() -> None:
    assert wrong_stops(-0.5, alone=True) > 0.065
