"""What is doubted about runs, and how far intervals of errors, times and ratios say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from equaltime.cost.curves import error_at, error_curve, slope, time_to_error
from equaltime.cost.ratios import efficiency, speed_up

from .made_up_runs import SPP, power_law


def test_a_doubt_about_the_runs_is_carried_by_every_number() -> None:
    runs = replace(power_law(), doubt="heavy tail")
    numbers = (time_to_error(runs, 0.2), time_to_error(runs, 1e-9), error_at(runs, 20.0), slope(runs))
    for number in (*numbers, *error_curve(runs), speed_up(power_law(), runs, 0.2), speed_up(runs, power_law(), 0.2)):
        assert not number.trusted
        assert "heavy tail" in number.note


def test_of_errors_and_times_with_heavy_tails_the_lower_end_holds() -> None:
    runs = replace(power_law(), doubt="heavy tail")
    for number in (time_to_error(runs, 0.2), error_at(runs, 20.0), *error_curve(runs)):
        assert number.bound == "low"
    assert speed_up(runs, power_law(), 0.2).bound == "low"
    assert speed_up(power_law(), runs, 0.2).bound == "high"
    assert speed_up(runs, runs, 0.2).bound == slope(runs).bound == ""
    assert time_to_error(replace(runs, relmse=runs.relmse[:2], seconds=runs.seconds[:2]), 0.2).bound == ""


def test_what_was_not_seen_moves_one_end_out() -> None:
    plain = replace(power_law(), independent=True)
    runs = replace(plain, unseen=0.21)
    for found, before, power in (
        (time_to_error(runs, 0.2), time_to_error(plain, 0.2), 1.0),
        (error_at(runs, 20.0), error_at(plain, 20.0), 0.5),
        (speed_up(runs, plain, 0.2), speed_up(plain, plain, 0.2), 1.0),
    ):
        assert (found.value, found.low) == (before.value, before.low)
        assert found.high == pytest.approx(before.high * 1.21**power)
    assert speed_up(plain, runs, 0.2).low == pytest.approx(1.0 / 1.21)


def test_what_the_reference_leaves_open_widens_every_interval() -> None:
    plain = power_law()
    runs = replace(plain, shared=0.1 * plain.relmse[0, -1])
    for function in (
        lambda r: time_to_error(r, 0.13),
        lambda r: error_at(r, 60.0),
        lambda r: error_curve(r)[-1],
        slope,
    ):
        before, after = function(plain), function(runs)
        assert after.trusted
        assert after.high - after.low > 1.2 * (before.high - before.low)


def test_two_strategies_share_what_the_reference_leaves_open() -> None:
    plain = power_law()
    runs = replace(plain, shared=0.1 * plain.relmse[0, -1])
    same = speed_up(runs, runs, 0.13)
    assert (same.low, same.high) == pytest.approx((1.0, 1.0))
    slower = replace(runs, relmse=4.0 * runs.relmse)
    both = speed_up(slower, runs, 0.13)
    assert both.high / both.low > 1.05


def test_errors_that_the_reference_cannot_show_are_left_out() -> None:
    plain = power_law(scatter=0.0)
    runs = replace(plain, shared=0.3 * plain.relmse[0, -1])
    assert len(runs.points(np.ones(8))[0]) == len(SPP) - 1
    assert "extrapolated" in time_to_error(runs, 60.0**-0.5).note


def test_efficiency_is_the_median_of_what_pairs_of_repeats_say() -> None:
    fast, slow = power_law(speed=4.0, scatter=0.0), power_law(scatter=0.0)
    found = efficiency(slow, fast)
    assert (found.value, found.low, found.high) == pytest.approx((4.0, 4.0, 4.0))
    slow.relmse[3] *= 1e6
    assert efficiency(slow, fast).value == pytest.approx(4.0), "a firefly moves no median"
    assert not efficiency(slow, replace(fast, biased=True)).known
    assert not efficiency(slow, replace(fast, relmse=-fast.relmse)).known
