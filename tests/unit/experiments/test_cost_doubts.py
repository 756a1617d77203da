"""What is doubted about runs, and how far intervals of errors, times and ratios say so."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from equaltime.experiments.analysis.strategy_runs import efficiency, speed_up
from equaltime.statistics.curves import error_at, error_curve, slope, time_to_error
from equaltime.statistics.intervals import TOO_WIDE, Interval
from equaltime.statistics.runs import TYPICAL, Runs

from .made_up_runs import SPP, power_law, with_firefly


def test_a_doubt_about_the_runs_is_carried_by_every_number() -> None:
    runs = replace(power_law(), doubt="heavy tail")
    numbers = (time_to_error(runs, 0.2), time_to_error(runs, 1e-9), error_at(runs, 20.0), slope(runs))
    for number in (*numbers, *error_curve(runs), speed_up(power_law(), runs, 0.2), speed_up(runs, power_law(), 0.2)):
        assert "heavy tail" in number.note


def test_of_errors_with_heavy_tails_the_lower_end_holds_and_times_are_those_of_typical_runs() -> None:
    runs = replace(power_law(), doubt="heavy tail")
    assert all(number.bound == "low" for number in (error_at(runs, 20.0), *error_curve(runs)))
    assert (slope(runs).trusted, slope(runs).bound) == (False, "")
    for number in (
        time_to_error(runs, 0.2),
        speed_up(runs, power_law(speed=3.0), 0.2),
        speed_up(power_law(), runs, 0.2),
    ):
        assert number.trusted
        assert TYPICAL in number.note
    assert TYPICAL not in time_to_error(power_law(), 0.2).note
    few = replace(runs, relmse=runs.relmse[:5], seconds=runs.seconds[:5])
    assert "6 are the least for a median" in time_to_error(few, 0.2).note
    assert not time_to_error(few, 0.2).trusted


def test_of_runs_that_have_not_found_all_light_the_lower_end_holds() -> None:
    runs = replace(power_law(), missing="they have not found all light yet")
    for number in (time_to_error(runs, 0.2), error_at(runs, 20.0), *error_curve(runs)):
        assert (number.trusted, number.bound) == (False, "low")
    assert speed_up(runs, power_law(speed=3.0), 0.2).bound == "low"
    assert speed_up(power_law(speed=3.0), runs, 0.2).bound == "high"
    assert speed_up(runs, runs, 0.2).bound == slope(runs).bound == ""
    assert time_to_error(replace(runs, relmse=runs.relmse[:2], seconds=runs.seconds[:2]), 0.2).bound == ""


def test_a_bound_that_leaves_open_which_is_faster_is_none() -> None:
    runs = replace(power_law(), missing="they have not found all light yet")
    assert speed_up(runs, power_law(speed=0.3), 0.2).bound == "", "at least 0.3 times as fast"
    assert speed_up(power_law(speed=0.3), runs, 0.2).bound == "", "at most 3 times as fast"
    stuck = replace(power_law(), relmse=power_law().relmse + 0.1, biased=True)
    assert math.isinf(speed_up(stuck, power_law(), 0.2).value)
    slower = speed_up(stuck, power_law(speed=0.2), 0.2)
    assert math.isnan(slower.value), "the baseline has not reached it in half of the time that this one takes"
    assert "baseline: not reached" in slower.note


def test_an_end_that_is_far_off_the_estimate_is_none() -> None:
    assert Interval(5.0, 0.6, 9.0).bounded("low", "why").telling().bound == "low"
    assert Interval(5.0, 0.4, 9.0).bounded("low", "why").telling().bound == ""
    assert Interval(math.inf, 3.0, math.inf).bounded("low", "why").telling().bound == "low"
    assert Interval(math.inf, 0.0, math.inf).bounded("low", "why").telling().bound == ""


def test_an_interval_of_more_than_a_factor_of_ten_either_way_tells_no_number() -> None:
    endless, beginningless = Interval(5.0, 4.0, math.inf).telling(), Interval(5.0, 0.0, 6.0).telling()
    assert (endless.trusted, endless.bound) == (False, "low")
    assert (beginningless.trusted, beginningless.bound) == (False, "high"), "a ratio of times is never 0"
    wide = Interval(5.0, 1e-11, 1e12, reach=3.0).telling()
    assert (math.isnan(wide.value), wide.trusted, wide.bound, wide.note) == (True, False, "", TOO_WIDE)
    assert "within a factor of 10" in wide.as_dict()["doubt"]
    upper, lower = Interval(5.0, 4.0, 60.0).telling(), Interval(5.0, 0.1, 6.0).telling()
    assert upper.trusted
    assert lower.trusted
    assert Interval(5.0, 0.5, 50.0).telling() == Interval(5.0, 0.5, 50.0)
    assert Interval(5.0, 4.0, math.inf).bounded("high", "why").telling().bound == ""
    for without_width in (
        Interval(0.0, 0.0, 3.0),
        Interval(math.inf, 0.0, math.inf),
        Interval(math.inf, 2.0, math.inf),
    ):
        assert without_width.telling() == without_width


def test_runs_that_scatter_by_powers_of_ten_tell_neither_time_nor_ratio() -> None:
    steady = power_law()
    wild = replace(steady, seconds=steady.seconds * np.logspace(-4.0, 4.0, 8)[:, np.newaxis], doubt="heavy tail")
    for number in (time_to_error(wild, 0.2), speed_up(steady, wild, 0.2), efficiency(steady, wild)):
        assert (number.known, number.trusted, number.bound) == (False, False, "")
        assert TOO_WIDE in number.note


def test_one_firefly_in_six_runs_changes_no_time() -> None:
    """Errors of 21.0, 21.4, 20.7, 111.5, 20.7 and 20.9 % after 16 s: to 10 % a typical run takes 4.4 times as long."""
    runs, typical = with_firefly(), 16.0 * (0.2095 / 0.10) ** 2
    found = time_to_error(runs, 0.10)
    assert found.trusted
    assert found.low < typical < found.high
    assert found.value == pytest.approx(typical, rel=0.02)
    assert found.reach == pytest.approx(4.4, rel=0.02)
    assert "one repeat of 6 makes 85 % of their squared error" in found.note
    end = error_curve(runs)[-1]
    assert (end.trusted, end.bound) == (False, "low")
    assert end.low == pytest.approx(0.207, rel=0.01), "the least that the mean can be is what typical runs have"


def test_a_law_of_the_mean_error_says_nothing_of_typical_runs_that_lack_light() -> None:
    """One run of six has met the lamp; the others are as dark after 16 samples as after two."""
    errors = np.full((6, 4), 0.95) * np.exp(0.002 * np.random.default_rng(1).standard_normal((6, 4)))
    errors[2, -1] = 80.0
    runs = Runs(np.tile(SPP[:4], (6, 1)), errors**2, independent=True)
    assert math.isinf(time_to_error(runs, 0.1).value), "not in 16 s x (95 % / 10 %)²"


def test_one_firefly_makes_no_bound_that_contradicts_what_typical_runs_gain() -> None:
    """The baseline is thirty times as far off in every run."""
    runs, baseline = with_firefly(), with_firefly(tuple(30.0 * error for error in (0.21, 0.19, 0.23, 0.8, 0.2, 0.22)))
    gain = efficiency(baseline, runs)
    assert gain.trusted
    for target in (0.3, 0.21, 0.1, 0.05):
        found = speed_up(baseline, runs, target)
        assert found.bound == ""
        if math.isinf(found.value):
            assert 1.0 < found.low < gain.low, "the baseline is not reached"
        else:
            assert not found.known or max(found.low, gain.low) < min(found.high, gain.high)
    near = with_firefly(tuple(3.0 * error for error in (0.21, 0.19, 0.23, 0.8, 0.2, 0.22)))
    for target in (0.3, 0.21):
        found, gain = speed_up(near, runs, target), efficiency(near, runs)
        assert found.trusted
        assert found.low < 9.0 < found.high
        assert max(found.low, gain.low) < min(found.high, gain.high)


def test_not_reached_is_no_bound_unless_the_error_is_surely_above() -> None:
    """A slope that is fitted to noise reaches beyond all bounds, but the error at the end may be the one asked for."""
    rng = np.random.default_rng(2)
    seconds = np.tile(SPP, (8, 1))
    level = 0.04 * np.exp(0.3 * rng.standard_normal((8, len(SPP))))
    runs = Runs(seconds, level)
    flat = time_to_error(runs, 0.8 * math.sqrt(0.04))
    near = time_to_error(runs, 0.98 * math.sqrt(float(level.mean(axis=0).min())))
    assert (flat.value, near.value) == (math.inf, math.inf)
    assert flat.low == pytest.approx(SPP[-1])
    assert near.low == 0.0


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
    assert efficiency(replace(slow, missing="light"), fast).doubt == "light"
    assert not efficiency(slow, replace(fast, relmse=-fast.relmse)).known


def test_an_error_that_the_reference_hides_makes_efficiency_a_bound() -> None:
    """The truth is 400 times less; measured errors scatter around 0, and their median may be anything."""
    rng = np.random.default_rng(3)
    seen = power_law(repeats=6)
    shared = 0.1 * float(seen.relmse[0, -1])
    hidden = replace(seen, relmse=seen.relmse / 400.0 + shared * rng.standard_normal((6, 1)), shared=shared)
    seen = replace(seen, shared=shared)
    more, less = efficiency(seen, hidden), efficiency(hidden, seen)
    assert (more.trusted, more.bound, less.trusted, less.bound) == (False, "low", False, "high")
    assert 1.0 < more.low < 10.0
    assert less.high == pytest.approx(1.0 / more.low, rel=0.3)
    assert "this: the error is below what the reference can show" in more.note
    assert not efficiency(hidden, hidden).trusted
    assert efficiency(hidden, hidden).bound == ""


def test_the_reference_widens_efficiency() -> None:
    first, second = power_law(seed=1), power_law(seed=2)
    shared = 0.1 * float(first.relmse[0, -1])
    plain, widened = efficiency(first, second), efficiency(*(replace(one, shared=shared) for one in (first, second)))
    far = replace(second, relmse=9.0 * second.relmse)
    assert widened.trusted
    assert widened.low <= plain.low
    moved = efficiency(*(replace(one, shared=shared) for one in (first, far)))
    assert moved.high > 1.1 * efficiency(first, far).high


def test_efficiency_of_heavy_tails_says_that_it_is_of_typical_runs() -> None:
    assert "typical runs" in efficiency(with_firefly(), power_law(repeats=6)).note
    assert "typical runs" not in efficiency(power_law(), power_law()).note


@pytest.mark.parametrize("scatter", [0.0, 0.2])
def test_the_interval_of_a_gain_contains_the_scatter_of_times(scatter: float) -> None:
    """The gain is 1, and runs have one measurement each. Errors scatter by 1 %, times by nothing or by a fifth."""
    experiments = 400
    found = []
    for seed in range(experiments):
        rng = np.random.default_rng(seed)
        first, second = (
            Runs(np.exp(scatter * rng.standard_normal((8, 1))), np.exp(0.02 * rng.standard_normal((8, 1))))
            for _ in range(2)
        )
        found.append(efficiency(first, second))
    held = sum(gain.low <= 1.0 <= gain.high for gain in found)
    assert abs(held - 0.95 * experiments) <= 3.0 * math.sqrt(0.95 * 0.05 * experiments)
    width = float(np.mean([math.log(gain.high / gain.low) for gain in found]))
    assert width == pytest.approx(0.05 if scatter == 0.0 else 0.5, rel=0.1)
