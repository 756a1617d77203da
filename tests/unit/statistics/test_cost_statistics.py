"""Intervals and curves: what they say in cases that can be worked out by hand, and when they doubt themselves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import binomtest

from equaltime.experiments.analysis.strategy_runs import speed_up
from equaltime.experiments.report.words import factor_cell
from equaltime.statistics.curves import (
    AGAINST_SAMPLES,
    RISES,
    error_at,
    error_curve,
    falling,
    least_error_at,
    second_curve,
    slope,
    time_to_error,
)
from equaltime.statistics.intervals import (
    Interval,
    exp,
    jackknife,
    join,
    mean_interval,
    median_interval,
    ratio_interval,
    student,
)
from equaltime.statistics.runs import Runs

from ..experiments.made_up_runs import SPP, close, power_law, with_firefly

Array = NDArray[np.float64]


def test_a_mean_has_student_s_interval() -> None:
    found = mean_interval([1.0, 2.0, 3.0, 4.0])
    half = 3.182446 * math.sqrt(5.0 / 3.0) / 2.0
    assert found.value == 2.5
    assert (found.low, found.high) == pytest.approx((2.5 - half, 2.5 + half), rel=1e-6)
    assert found.trusted


def test_student_s_quantile_tends_to_the_normal_one() -> None:
    assert student(1) == pytest.approx(12.7062, rel=1e-5)
    assert student(1e9) == pytest.approx(1.959964, rel=1e-5)


@pytest.mark.parametrize("count", [1, 2])
def test_fewer_than_three_repeats_are_not_trusted(count: int) -> None:
    found = mean_interval([1.0, 2.0][:count])
    assert not found.trusted
    assert "repeat" in found.note
    assert not time_to_error(power_law(repeats=count), 0.2).trusted


def test_three_are() -> None:
    assert mean_interval([1.0, 2.0, 4.0]).trusted
    assert time_to_error(power_law(repeats=3), 0.2).trusted


def test_no_interval_comes_of_what_is_not_there() -> None:
    for found in (mean_interval([]), mean_interval([1.0, math.nan, 2.0])):
        assert not found.known
        assert not found.trusted
        assert found.note


def test_the_jackknife_of_a_mean_is_student_s_interval() -> None:
    values = np.array([1.0, 2.0, 5.0, 9.0])
    found = jackknife(lambda kept: float(kept @ values / kept.sum()), 4)
    expected = mean_interval(values)
    assert (found.value, found.low, found.high) == pytest.approx((expected.value, expected.low, expected.high))


def test_a_ratio_is_paired() -> None:
    below = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    paired = ratio_interval(3.0 * below * [1.01, 0.99, 1.0, 1.02, 0.98], below)
    mixed = ratio_interval(3.0 * below[::-1], below)
    assert close(paired, 3.0, 0.1)
    assert mixed.high / mixed.low > 5.0 * paired.high / paired.low


def test_a_ratio_and_its_inverse_say_the_same() -> None:
    above, below = np.array([3.0, 4.0, 5.0]), np.array([1.0, 1.5, 1.2])
    one, other = ratio_interval(above, below), ratio_interval(below, above)
    assert (one.low, one.value, one.high) == pytest.approx((1 / other.high, 1 / other.value, 1 / other.low))


def test_intervals_keep_their_order_and_their_doubts_when_mapped() -> None:
    found = Interval(2.0, 1.0, 4.0).doubted("first").noted("second").map(lambda x: 1.0 / x)
    assert found == Interval(0.5, 0.25, 1.0, False, "first; second")
    assert join(["a", "", "b", "a"]) == "a; b"


def test_the_falling_curve_is_left_alone() -> None:
    x, y = np.array([0.0, 1.0, 2.0]), np.array([3.0, 2.0, 1.0])
    np.testing.assert_array_equal(falling(x, y), (x, y))


def test_points_that_rise_are_pooled() -> None:
    x, y = falling(np.array([0.0, 1.0, 2.0, 3.0]), np.array([3.0, 1.0, 2.0, 0.0]))
    np.testing.assert_allclose(x, [0.0, 1.5, 3.0])
    np.testing.assert_allclose(y, [3.0, 1.5, 0.0])


@pytest.mark.parametrize("power", [-0.5, -0.75])
@pytest.mark.parametrize("seconds", [3.0, 20.0, 50.0])
def test_the_time_to_an_error_within_the_runs(power: float, seconds: float) -> None:
    found = time_to_error(power_law(power=power), seconds**power)
    assert close(found, seconds, 0.1)
    assert found.trusted
    assert found.note == ""


def test_reference_noise_below_zero_averages_away() -> None:
    """Single repeats may fall below zero; only their mean must not."""
    runs = power_law(scatter=0.0)
    wobble = 0.3 * runs.relmse[:, -1:] * np.array([1, -1, 6, -6, 1, -1, 5, -5])[:, None]
    found = time_to_error(replace(runs, relmse=runs.relmse + wobble), 0.2)
    assert (runs.relmse + wobble).min() < 0.0
    assert found.value == pytest.approx(25.0, rel=0.05)


def test_beyond_the_runs_the_time_is_extrapolated_and_says_so() -> None:
    found = time_to_error(power_law(power=-0.75), 320.0**-0.75)
    assert close(found, 320.0, 0.5)
    assert found.trusted
    assert "times beyond the longest run by the fitted slope" in found.note
    assert found.reach == pytest.approx(5.0, rel=0.1)
    assert time_to_error(power_law(power=-0.75), 32.0**-0.75).reach == 1.0


def starting_anew(start: float, power: float = -0.5, rate: float = 0.01) -> Runs:
    """Return runs of a renderer that begins anew for each checkpoint, ``start`` seconds before its samples."""
    plain = power_law(power=power)
    scatter = plain.seconds / SPP
    return replace(plain, seconds=start + rate * SPP * scatter, spp=SPP)


@pytest.mark.parametrize("start", [0.02, 0.2, 1.0])
def test_a_start_is_not_taken_for_a_steep_slope(start: float) -> None:
    """A start of 0.2 s makes slopes of -1.4 against time: errors beyond the runs would come far too soon."""
    runs, truth = starting_anew(start), start + 0.01 * 4 * 64.0
    found = time_to_error(runs, (4 * 64.0) ** -0.5)
    assert found.trusted
    assert found.low < truth < found.high
    assert found.value == pytest.approx(truth, rel=0.05)
    assert "beside its samples" in found.note
    against_time = time_to_error(replace(runs, spp=None), (4 * 64.0) ** -0.5)
    if start > 0.1:
        assert "by slope -0.8" in against_time.note, "held, if the start were not known"
        assert against_time.low < truth < against_time.high
    told = slope(runs)
    assert told.value == pytest.approx(-0.5, abs=0.03)
    assert told.note.startswith(AGAINST_SAMPLES)


def test_a_start_does_not_count_as_time_that_samples_took() -> None:
    """Twice the time is 200 times the samples where the start takes all but a hundredth of the time."""
    runs = starting_anew(100.0)
    far = time_to_error(runs, (64.0 * 50.0) ** -0.5)
    assert far.value == pytest.approx(100.0 + 0.01 * 64.0 * 50.0, rel=0.05)
    assert far.reach < 2.0
    assert "a fitted slope may not hold so far" in far.doubt
    assert not error_at(runs, 190.0).known
    assert time_to_error(runs, 100.0).value == pytest.approx(100.0, rel=0.01), "no time is shorter than the start"


def test_an_error_at_a_time_beyond_a_render_that_starts_anew() -> None:
    runs = starting_anew(0.2)
    assert close(error_at(runs, 0.2 + 0.01 * 100.0), 100.0**-0.5, 0.2)
    assert not error_at(runs, 0.1).known, "before any first sample"


def test_no_curve_goes_on_steeper_than_low_discrepancy_points_can() -> None:
    """A steeper fit is held at -0.8, and the interval holds the times by the fit and by one as much flatter."""
    runs = power_law(power=-0.9)
    end, fall = 64.0, 3.0
    found = time_to_error(runs, end**-0.9 / fall)
    assert found.value == pytest.approx(end * fall ** (1.0 / 0.8), rel=0.03)
    assert found.low < end * fall ** (1.0 / 0.9)
    assert found.high > end * fall ** (1.0 / 0.7)
    assert "beyond the longest run by slope -0.8; the fitted slope is steeper than -0.8" in found.note
    flatter = time_to_error(power_law(power=-1.43), end**-1.43 / fall)
    assert end * fall**2 < flatter.high < 1.3 * end * fall**2, "not flatter than -1/2"
    ratio = speed_up(power_law(power=-0.5), runs, end**-0.9 / fall)
    assert ratio.high / ratio.low > found.high / found.low
    within = time_to_error(runs, 30.0**-0.9)
    assert close(within, 30.0, 0.1)


def test_a_fitted_slope_is_doubted_far_out_and_refused_farther_out() -> None:
    runs = power_law()
    assert not time_to_error(runs, (64.0 * 30.0) ** -0.5).trusted
    far = time_to_error(runs, (64.0 * 300.0) ** -0.5)
    assert far.value == math.inf
    assert far.low == pytest.approx(6400.0, rel=0.1)
    assert "not reached in 100 times the longest run" in far.note


def test_independent_samples_have_a_law_that_is_trusted_up_to_100_times_the_longest_run() -> None:
    runs = replace(power_law(), independent=True)
    found = time_to_error(runs, (64.0 * 80.0) ** -0.5)
    assert close(found, 64.0 * 80.0, 0.1)
    assert found.trusted
    assert "by slope -1/2" in found.note
    far = time_to_error(runs, (64.0 * 515.0) ** -0.5)
    assert (far.value, far.trusted) == (math.inf, True)
    assert far.low == pytest.approx(6400.0, rel=0.1)
    assert far.note == "not reached in 100 times the longest run"
    noisy = replace(power_law(scatter=0.3), independent=True)
    edges = [time_to_error(noisy, (64.0 * factor) ** -0.5) for factor in np.geomspace(50.0, 250.0, 20)]
    assert [math.isnan(one.value) for one in edges].count(True) > 1, "if the interval reaches into the limit"
    assert edges[0].known
    assert edges[-1].value == math.inf
    ratio = speed_up(runs, power_law(), (64.0 * 515.0) ** -0.5)
    assert not ratio.known
    fast = replace(power_law(seed=2), relmse=power_law(seed=2).relmse / 600.0)
    ratio = speed_up(runs, fast, (64.0 * 515.0) ** -0.5)
    assert ratio.value == math.inf
    assert ratio.low == pytest.approx(6400.0 / (64.0 * 515.0 / 600.0), rel=0.2)


def test_an_error_below_the_noise_of_the_reference_is_the_least_there_is() -> None:
    """The strategy with the least error is what others are held against."""
    runs = power_law(scatter=0.0)
    end = float(runs.seconds[:, -1].mean())
    assert least_error_at(runs, end) == error_at(runs, end).value > 0.0
    below = replace(runs, relmse=runs.relmse - 2.0 * runs.relmse[:, -1:].max())
    nothing = replace(below, relmse=np.minimum(below.relmse, -1e-9))
    assert least_error_at(nothing, end) == 0.0
    assert error_at(nothing, end).doubt.startswith("the error is below what the reference can show; reference.error")


def below_the_noise(rng: np.random.Generator, square: float, shared: float) -> Runs:
    """Return runs whose expected squared error at the end is ``square``, measured by a reference with noise."""
    falls = square * np.array([256.0, 16.0, 1.0])
    noise = shared * rng.standard_normal()
    relmse = falls * rng.gamma(50.0, 1.0 / 50.0, (6, 3)) + noise
    return Runs(seconds=np.tile([1.0, 16.0, 256.0], (6, 1)), relmse=relmse, shared=shared)


def test_an_error_that_the_noise_of_the_reference_hides_has_an_upper_limit_that_holds() -> None:
    """The limit is at 97.5 %: of 1,000 references at most 42 may give a smaller one than the error (p > 0.001).

    A limit that left the reference's noise out would fail far more often.
    """
    rng, square, shared = np.random.default_rng(3), 1e-4, 1e-4
    found = [(runs, error_at(runs, 256.0)) for runs in (below_the_noise(rng, square, shared) for _ in range(1000))]
    limits = np.array([error.high if error.bound == "high" else math.inf for runs, error in found if runs.is_below()])
    assert limits.size > 990
    assert np.count_nonzero(limits < square**0.5) <= 42
    assert np.median(limits) < (square + 3.0 * shared) ** 0.5
    without = [mean_interval(runs.relmse[:, -1]).high for runs, _ in found]
    assert np.count_nonzero(np.array(without) < square) > 300


def test_the_upper_limit_of_a_hidden_error_is_none_where_light_may_be_missing() -> None:
    runs = below_the_noise(np.random.default_rng(5), 1e-4, 1e-4)
    assert error_at(runs, 280.0).bound == "high", "runs may end a little early"
    assert not error_at(runs, 512.0).bound
    assert not error_at(replace(runs, missing="light"), 256.0).bound
    assert not error_at(replace(runs, doubt="heavy tail"), 256.0).bound


def test_no_number_stays_none() -> None:
    assert math.isnan(exp(math.nan))
    assert exp(1e4) == math.inf


def test_a_bias_is_not_extrapolated() -> None:
    runs = power_law()
    floor = replace(runs, relmse=runs.relmse + 0.1, biased=True)
    found = time_to_error(floor, 0.2)
    assert found.value == math.inf
    assert found.low == pytest.approx(64.0, rel=0.1)
    assert "biased" in found.note


def test_biased_typical_runs_that_do_not_reach_an_error_were_only_seen_for_the_longest_run() -> None:
    """No repeat of a heavy tail reaches 20 %, so the median of their times is infinite: longer runs may."""
    runs = power_law()
    floor = replace(runs, relmse=runs.relmse + 0.1, biased=True, doubt="heavy tail")
    found, fast = time_to_error(floor, 0.2), replace(power_law(speed=4.0), doubt="heavy tail")
    assert (found.value, found.low) == (math.inf, pytest.approx(64.0, rel=0.1))
    ratio = speed_up(fast, floor, 0.2)
    assert (ratio.value, ratio.high) == (0.0, pytest.approx(25.0 / 4.0 / 64.0, rel=0.2)), "not a hundredth of it"
    assert not speed_up(power_law(speed=0.2), floor, 0.2).known, "the baseline takes longer than the runs of this one"


def test_a_bias_above_an_error_is_never_below_it() -> None:
    runs = power_law()
    floor = replace(runs, relmse=runs.relmse + 0.1, biased=True, bias=0.3)
    found = time_to_error(floor, 0.2)
    assert (found.value, found.low, found.note) == (math.inf, math.inf, "never reached: its bias is larger")
    assert Interval.from_dict(found.as_dict()) == found
    assert "biased, not extrapolated" in time_to_error(replace(floor, relmse=runs.relmse + 0.2), 0.31).note
    ratio = speed_up(runs, floor, 0.2)
    assert (ratio.value, ratio.high) == (0.0, 0.0)
    assert factor_cell(ratio).text == "never"
    assert speed_up(floor, runs, 0.2).low == pytest.approx(64.0 / 25.0, rel=0.1), "a limit that can be printed"


def test_the_error_at_the_end_of_runs_is_told_though_it_rose_there() -> None:
    seconds = np.tile([1.0, 2.0, 4.0, 8.0, 16.0], (4, 1))
    runs = Runs(seconds, np.tile([1.0, 0.5, 0.6, 0.7, 0.8], (4, 1)) * np.array([[0.9], [1.0], [1.1], [1.0]]))
    level = error_at(runs, 16.0).value
    assert level == pytest.approx(error_curve(runs)[-1].value)
    assert level == pytest.approx(math.sqrt(0.8))
    assert error_at(runs, 20.0).known
    independent = replace(runs, independent=True)
    assert error_at(independent, 16.0).value == pytest.approx(level)
    assert error_at(independent, 25.0).value == pytest.approx(0.8 * level)
    assert error_at(runs, 40.0).doubt == "no run is near that time"
    few = Runs(seconds[:, :2], runs.relmse[:, :2])
    assert error_at(few, 2.2).known
    assert not error_at(few, 2.6).known


def test_a_time_to_an_error_that_the_last_measurement_exceeds_says_so() -> None:
    """Errors of Sobol points at 16, 32, 64 and 70 samples: the last count is no power of two."""
    seconds = np.tile([1.0, 2.0, 4.0, 4.4], (6, 1))
    runs = Runs(seconds, np.square(np.tile([4.0, 2.0, 0.95, 1.15], (6, 1)) * np.linspace(0.98, 1.02, 6)[:, None]))
    found = time_to_error(runs, 1.03)
    assert 2.0 < found.value <= 4.4
    assert RISES in found.note
    assert RISES not in time_to_error(runs, 1.5).note
    assert RISES not in time_to_error(replace(runs, relmse=runs.relmse[:, :3], seconds=seconds[:, :3]), 1.03).note


def test_a_slope_against_samples_has_one_reason_whether_or_not_times_show_a_start() -> None:
    """One table then has one footnote for all programs of a kind."""
    note = f"{AGAINST_SAMPLES}: times of other programs than equaltime may contain a start"
    runs = replace(power_law(), spp=SPP)
    without = replace(runs, seconds=np.broadcast_to(SPP, runs.seconds.shape))
    for each in (runs, without, starting_anew(0.5)):
        assert slope(each).note.startswith(note)


def test_the_error_at_a_checkpoint_is_that_of_the_curve_also_where_errors_rise_or_a_few_events_make_them() -> None:
    for runs in (power_law(scatter=0.5), with_firefly()):
        measured = np.sqrt(runs.relmse.mean(axis=0))
        for time, error, root in zip(second_curve(runs), error_curve(runs), measured, strict=True):
            assert error_at(runs, time.value).value == pytest.approx(root)
            assert error.value == pytest.approx(root)
            assert error.low <= root <= error.high


def test_an_error_that_does_not_fall_tells_no_time_unless_it_is_a_bias() -> None:
    level = replace(power_law(), relmse=np.linspace(0.1, 0.11, len(SPP)) * np.ones((8, 1)))
    found = time_to_error(level, 0.01)
    assert (found.value, found.trusted, found.bound) == (math.inf, False, "low")
    assert found.low == pytest.approx(level.seconds[:, -1].mean())
    assert "does not fall over the last three doublings" in found.note
    biased = time_to_error(replace(level, biased=True), 0.01)
    assert biased.value == math.inf
    assert biased.trusted
    assert "biased" in biased.note


def test_a_time_is_beyond_the_limits_only_if_the_slope_s_interval_says_so() -> None:
    """An error that halves in a thousand times the longest run: with noise the slope may be steeper."""
    runs = power_law()
    slow = np.array(SPP) ** -0.1 * np.ones((8, 1))
    error = math.sqrt(slow[0, -1])
    assert time_to_error(replace(runs, relmse=slow), 0.7 * error).note.startswith("not reached in 100 times")
    noise = np.exp(np.random.default_rng(3).normal(0.0, 0.5, (8, 8, len(SPP))))
    found = [time_to_error(replace(runs, relmse=slow * each), 0.7 * error) for each in noise]
    assert not any(one.value == math.inf and one.trusted for one in found)


def test_a_heavy_tail_hides_how_fast_an_error_falls_in_the_end() -> None:
    """Medians that hardly fall say nothing beyond the runs, unless even the slope -1/2 does not reach the target."""
    runs = replace(power_law(), relmse=np.array(SPP) ** -0.1 * np.ones((8, 1)), doubt="rare bright paths")
    error = math.sqrt(runs.relmse[0, -1])
    near, far = (time_to_error(runs, share * error) for share in (0.7, 0.05))
    assert math.isnan(near.value)
    assert "varies too much" in near.note
    assert far.note.startswith("not reached in 100 times")


def test_a_law_from_few_checkpoints_is_not_trusted_far_beyond_the_runs() -> None:
    runs = replace(power_law(power=-0.5), independent=True)
    last = float(runs.seconds.mean(axis=0)[-1])
    single = replace(runs, seconds=runs.seconds[:, -1:], relmse=runs.relmse[:, -1:])
    error = math.sqrt(float(single.relmse.mean()))
    near, far = (time_to_error(single, error / factor**0.5) for factor in (5.0, 51.0))
    assert near.trusted
    assert not far.trusted
    assert far.note.endswith("too few checkpoints to extrapolate so far")
    assert far.value == pytest.approx(51.0 * last, rel=0.1)
    assert time_to_error(runs, error / 51.0**0.5).trusted, "with checkpoints that show the law"


def test_what_was_reached_before_the_first_checkpoint_is_said_to_be() -> None:
    near, far = (time_to_error(power_law(), seconds**-0.5) for seconds in (1.5, 0.1))
    assert near.value == pytest.approx(1.5, rel=0.05)
    assert near.trusted
    assert not far.trusted
    assert "before the first measurement" in far.note


def test_two_checkpoints_are_too_few_to_extrapolate() -> None:
    runs = power_law()
    found = time_to_error(Runs(runs.seconds[:, :2], runs.relmse[:, :2]), 0.01)
    assert not found.known
    assert "too few checkpoints" in found.note


def test_beyond_the_runs_no_time_is_given_to_an_error_below_the_reference_s_own() -> None:
    """Within the runs such an error was measured, and a larger one may be extrapolated."""
    plain = power_law()
    error = math.sqrt(float(plain.relmse[0, -1]))
    noisy = replace(plain, reference=2.0 * error)
    for target, known in ((0.5 * error, False), (1.5 * error, True), (2.5 * error, True)):
        assert time_to_error(noisy, target).known is known
    doubt = time_to_error(noisy, 0.5 * error).doubt
    assert doubt.startswith("the reference has an error of 24.9 %, too much")
    assert "ask for a better one" in doubt
    assert time_to_error(replace(noisy, reference=0.4 * error), 0.5 * error).known
    assert "not extrapolated" in time_to_error(replace(noisy, biased=True), 0.5 * error).note
    ratio = speed_up(noisy, replace(noisy, seconds=0.1 * noisy.seconds), 0.5 * error)
    assert not ratio.known
    assert not ratio.bound
    assert "baseline: the reference has an error" in ratio.note


def test_below_the_reference_s_noise_there_is_nothing_to_read() -> None:
    runs = power_law()
    drowned = replace(runs, relmse=-runs.relmse)
    assert not time_to_error(drowned, 0.1).known
    assert not error_at(drowned, 10.0).known
    assert not slope(drowned).known
    assert not any(point.trusted for point in error_curve(drowned))


def test_a_speed_up_is_paired_over_repeats() -> None:
    """A machine that drifts does so for both."""
    fast, slow = power_law(speed=4.0, seed=1), power_law(speed=1.0)
    drift = np.exp(0.5 * np.random.default_rng(3).standard_normal((8, 1)))
    drifting = [replace(runs, seconds=runs.seconds * drift) for runs in (slow, fast)]
    assert close(speed_up(*drifting, 0.2), 4.0, 0.1)
    time = time_to_error(drifting[1], 0.2)
    assert time.high / time.low > 1.5


def test_a_speed_up_over_itself_is_one() -> None:
    found = speed_up(power_law(), power_law(), 0.2)
    assert (found.value, found.low, found.high) == pytest.approx((1.0, 1.0, 1.0))


def test_a_speed_up_over_what_never_arrives_is_at_least_what_is_known() -> None:
    fast = power_law()
    stuck = replace(fast, relmse=fast.relmse + 0.1, biased=True)
    found = speed_up(stuck, fast, 0.2)
    assert found.value == math.inf
    assert found.low == pytest.approx(64.0 / 25.0, rel=0.1)
    other = speed_up(fast, stuck, 0.2)
    assert other.value == 0.0
    assert other.high == pytest.approx(25.0 / 64.0, rel=0.1)
    neither = speed_up(stuck, stuck, 0.2)
    assert not neither.known


def test_repeats_that_only_one_has_are_left_out() -> None:
    assert close(speed_up(power_law(repeats=8), power_law(repeats=5, speed=2.0), 0.2), 2.0, 0.2)


def test_the_error_at_a_time() -> None:
    runs = power_law()
    assert close(error_at(runs, 20.0), 20.0**-0.5)
    assert close(error_at(runs, 80.0), 80.0**-0.5, 0.1)
    assert not error_at(runs, 1000.0).known


def test_an_error_at_a_time_outside_the_runs_says_so() -> None:
    runs = power_law()
    last = float(runs.seconds[:, -1].mean())
    late, early = error_at(runs, 1.25 * last), error_at(runs, 1.5)
    assert (late.reach, late.note) == (pytest.approx(1.25), "extrapolated 1.25 times beyond the longest run")
    assert "times before the first measurement" in early.note
    for within in (error_at(runs, 20.0), error_at(runs, 1.04 * last)):
        assert (within.reach, within.note) == (1.0, "")


@pytest.mark.parametrize("power", [-0.5, -0.75])
def test_the_slope(power: float) -> None:
    found = slope(power_law(power=power))
    assert found.low < power < found.high
    assert found.high - found.low < 0.02
    assert AGAINST_SAMPLES not in found.note


def test_curves_have_an_interval_at_every_checkpoint() -> None:
    runs = power_law()
    assert all(close(point, spp**-0.5) for point, spp in zip(error_curve(runs), SPP, strict=True))
    assert all(close(point, spp, 0.1) for point, spp in zip(second_curve(runs), SPP, strict=True))


def test_a_median_has_the_interval_of_the_sign_test() -> None:
    values = np.arange(9.0)
    found = median_interval(values)
    assert (found.value, found.low + found.high) == (4.0, pytest.approx(8.0))
    assert 1.0 < found.low < 2.0, "96.1 % from the second to the eighth, 82 % from the third to the seventh"
    assert not median_interval(values[:5]).trusted
    assert not median_interval([]).known


def test_the_interval_holds_the_median_as_often_as_it_says_and_a_shifted_one_seldom() -> None:
    found = [median_interval(row) for row in np.random.default_rng(1).exponential(size=(2000, 9))]

    def covering(median: float) -> int:
        return sum(one.low <= median <= one.high for one in found)

    assert binomtest(covering(np.log(2.0)), 2000, 0.95).pvalue > 1e-3
    assert binomtest(covering(1.3 * np.log(2.0)), 2000, 0.95).pvalue < 1e-9


def test_exact_images_have_no_error_and_need_at_most_the_first_image() -> None:
    runs = Runs(np.tile([1.0, 2.0, 4.0], (4, 1)), np.zeros((4, 3)))
    error, time = error_at(runs, 2.0), time_to_error(runs, 0.01)
    assert (error.trusted, error.value, error.low, error.high) == (True, 0.0, 0.0, 0.0)
    assert (time.bound, time.high, time.note) == ("high", 1.0, "the first image is exact already")
    assert slope(runs).note == "an exact image has no error that falls"


@pytest.mark.parametrize(("power", "noted"), [(-0.3, True), (-0.5, False), (-0.8, False)])
def test_a_shallow_slope_is_explained(power: float, noted: bool) -> None:
    assert ("shallower than -0.5" in slope(power_law(power=power)).note) is noted
