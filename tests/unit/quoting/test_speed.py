"""The pace of a render, by the seconds of its first passes."""

import threading
import time
from pathlib import Path

import pytest

from equaltime.quoting.law import Processors, from_start, pace, without_start


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
    own, shared = pace(seconds), pace(seconds, had=0.5)
    assert shared.lost > own.lost > 0.0
    assert shared.seconds_per_sample < own.seconds_per_sample < 0.01
    assert from_start(4 * own.seconds_per_sample, own.lost) == pytest.approx(0.04, rel=0.02)
    assert pace({0: 0.0, 2: 20.0, 4: 40.0}, had=0.5).seconds_per_sample == pytest.approx(10.0, rel=1e-3)


def test_what_was_to_be_had_is_what_ran_of_what_could_have() -> None:
    before = Processors(10.0, 5.0)
    assert Processors(10.3, 5.1).had_since(before) == pytest.approx(0.75)
    assert Processors(10.3, 5.0).had_since(before) == 1.0
    assert before.had_since(before) == 1.0
    assert Processors(0.0, 0.0).had_since(Processors(0.0, 0.0)) == 1.0


@pytest.mark.skipif(not Path("/proc/self/schedstat").exists(), reason="the system has no such account")
def test_threads_that_sleep_neither_run_nor_wait() -> None:
    done = threading.Event()
    sleepers = [threading.Thread(target=done.wait) for _ in range(40)]
    for thread in sleepers:
        thread.start()
    before = Processors.now()
    time.sleep(0.25)
    asleep = Processors.now()
    # 10 seconds of sleep; where others have the processors, to wake up takes its time as well
    assert asleep.ran - before.ran < 2.0
    assert asleep.waited - before.waited < 2.0
    end = time.process_time() + 0.02
    while time.process_time() < end:
        pass
    awake = Processors.now()
    done.set()
    assert awake.ran - asleep.ran > 0.01
