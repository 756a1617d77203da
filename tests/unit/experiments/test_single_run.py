"""The sample counts at which a run is looked at: they rise, and use up what the run may take."""

from itertools import islice, pairwise

import pytest

from equaltime.experiments.run.single_run import BudgetLadder, counts


def test_counts_double_with_one_between() -> None:
    assert list(islice(counts(), 12)) == [2, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128]


@pytest.mark.parametrize("rate", [0.1, 1.0, 7.0, 33.3, 100.0, 12345.6])
def test_a_budget_is_used_up_and_hardly_passed(rate: float) -> None:
    ladder, taken = BudgetLadder(10.0), []
    for spp in ladder:
        taken.append(spp)
        ladder.taken(spp, spp / rate)
    assert all(b > a for a, b in pairwise(taken))
    assert taken[-1] / rate <= 10.5 or taken == [2]
    assert taken[-1] > 10.0 * rate or (taken[-1] + 2) / rate > 10.5
    assert all(b >= 1.1 * a for a, b in pairwise(taken))


@pytest.mark.parametrize("rate", [20.0, 33.3, 100.0, 12345.6])
@pytest.mark.parametrize("faster", [1.0, 1.04])
def test_errors_at_the_budget_are_not_extrapolated_where_later_repeats_are_faster(rate: float, faster: float) -> None:
    """From 5 % beyond the runs' mean time on, a number counts as extrapolated."""
    ladder, spp = BudgetLadder(10.0), 0
    for spp in ladder:
        ladder.taken(spp, spp / rate)
    first = spp / rate
    assert (first + 5 * first / faster) / 6 * 1.05 > 10.0


def test_a_rest_that_numbers_would_be_extrapolated_over_is_spent() -> None:
    """A renderer that gets faster than it was predicted: 7 % of the budget are left."""
    ladder = BudgetLadder(10.0)
    taken = [next(ladder)]
    for wall in (1.0, 2.0, 9.3, 10.0):
        ladder.taken(taken[-1], wall)
        taken += [*islice(ladder, 1)]
    assert taken[-1] > taken[-2]


@pytest.mark.parametrize("start", [0.0, 0.1, 1.0, 6.0])
def test_counts_double_where_every_count_is_a_render_of_its_own(start: float) -> None:
    """Also where most of a time is the start, the last render takes nearly all of the budget."""
    ladder, taken = BudgetLadder(10.0, anew=True), []
    for spp in ladder:
        taken.append(spp)
        ladder.taken(spp, start + spp / 100.0)
    assert all(b >= 2 * a for a, b in pairwise(taken[:-1]))
    assert 8.5 < start + taken[-1] / 100.0 <= 10.5
    assert len(taken) <= 10
    assert sum(taken[:-1]) < 2.0 * taken[-1]


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
