"""The sample counts at which a run is looked at: they rise, and use up what the run may take."""

from itertools import islice, pairwise

import pytest

from equaltime.experiments.run.single_run import BudgetLadder, counts


def test_counts_double_with_one_between() -> None:
    assert list(islice(counts(), 12)) == [2, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128]


@pytest.mark.parametrize("rate", [0.1, 1.0, 7.0, 33.3, 100.0, 12345.6])
def test_a_budget_is_used_up_and_not_passed(rate: float) -> None:
    ladder, taken = BudgetLadder(10.0), []
    for spp in ladder:
        taken.append(spp)
        ladder.taken(spp, spp / rate)
    assert all(b > a for a, b in pairwise(taken))
    assert taken[-1] / rate <= 10.0 or taken == [2]
    assert taken[-1] * 1.1 + 2 > 10.0 * rate


def test_a_count_that_was_rounded_up_is_not_asked_for_again() -> None:
    ladder = BudgetLadder(10.0)
    assert next(ladder) == 2
    ladder.taken(16, 0.01)
    assert next(ladder) == 24


def test_a_renderer_that_takes_the_same_time_for_any_count_ends() -> None:
    ladder, spp = BudgetLadder(10.0), 0
    for spp in ladder:
        ladder.taken(spp, 0.4)
    assert 2**30 <= spp <= 2**31
