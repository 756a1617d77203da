"""The pace of a render, by the seconds of its first passes."""

import time

import pytest

from equaltime.speed import Meter, from_start, pace, without_start


def test_the_pace_is_that_of_the_last_two_octaves() -> None:
    seconds = {0: 5.0, 2: 9.0, 4: 10.0, 8: 11.0, 16: 13.0}
    assert pace(seconds).seconds_per_sample == pytest.approx(0.25)


def test_two_octaves_that_are_not_there_yet_are_all_there_is() -> None:
    assert pace({0: 10.0, 2: 12.0, 4: 13.0}).seconds_per_sample == pytest.approx(0.75)
    assert pace({100: 10.0, 102: 12.0, 104: 13.0}).seconds_per_sample == pytest.approx(0.75)


def test_a_pace_that_varies_is_in_doubt() -> None:
    even, uneven = pace({2: 1.0, 4: 2.0, 6: 3.0, 8: 4.0}), pace({2: 1.0, 4: 3.0, 6: 4.0, 8: 7.0})
    assert even.doubt < 0.1 < uneven.doubt


@pytest.mark.parametrize("even", [0.005, 0.05, 0.5, 5.0])
def test_the_start_is_slower_than_the_rest(even: float) -> None:
    seconds = from_start(even, 0.004)
    assert even < seconds < even + 0.00401
    assert without_start(seconds, 0.004) == pytest.approx(even, rel=0.02)


def test_the_start_is_slowest_where_others_have_the_processors() -> None:
    seconds = {0: 0.0, 2: 0.02, 4: 0.04}
    own, shared = pace(seconds), pace(seconds, taken=0.5)
    assert shared.lost > own.lost > 0.0
    assert shared.seconds_per_sample < own.seconds_per_sample < 0.01
    assert from_start(4 * own.seconds_per_sample, own.lost) == pytest.approx(0.04, rel=0.02)
    assert pace({0: 0.0, 2: 20.0, 4: 40.0}, taken=0.5).seconds_per_sample == pytest.approx(10.0, rel=1e-3)


def metered(seconds: float, processing: float) -> Meter:
    meter = Meter()
    meter.seconds, meter.processing = seconds, processing
    return meter


def test_what_had_less_of_the_processors_than_on_average_will_be_faster() -> None:
    pilot, probe = metered(0.1, 0.1), metered(0.3, 0.5)
    assert pilot.slower(probe) == pytest.approx(1.0 / 1.5)
    assert probe.slower(pilot) == pytest.approx((0.5 / 0.3) / 1.5)
    assert pilot.slower(metered(0.3, 0.3)) == pytest.approx(1.0)
    assert pilot.slower(Meter()) == 1.0


def test_what_others_have_is_the_rest_of_the_processors() -> None:
    assert metered(0.1, 0.1).taken(2) == pytest.approx(0.5)
    assert metered(0.1, 0.21).taken(2) == 0.0
    assert Meter().taken(2) == 0.0


def test_a_meter_counts_work_and_no_sleep() -> None:
    meter = Meter()
    with meter:
        time.sleep(0.05)
    assert meter.seconds >= 0.05 > 0.04 > meter.processing
    with meter:
        end = time.process_time() + 0.02
        while time.process_time() < end:
            pass
    assert meter.processing >= 0.02
    assert meter.seconds >= 0.07
