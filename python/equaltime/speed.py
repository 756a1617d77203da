"""What a sample costs in time, as short pilots show it, on machines that others use too."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Mapping
from statistics import variance
from typing import NamedTuple

__all__ = ["Meter", "Pace", "from_start", "pace", "without_start"]

# Of the logarithm of the speed, from the pilot to the end. What is taken to be known before the pilot's passes have
# shown how their speed varies, and as how many passes it counts: machines that others use too vary by 0.1 (measured).
_DOUBT, _KNOWN_PASSES = 0.1, 2
# The first tenth of a second is slower, until threads are spread over the processors, and caches are filled: what that
# takes in all, and within which time, in seconds (measured, on an idle machine and with processors taken).
_LOSS, _START = 0.009, 0.1


class Meter:
    """Measures what runs while it is entered: how long, and how much of the processors it had.

    The time of processors that a sample takes hardly depends on what else runs; how many of them there are to be had
    varies from a tenth of a second to the next, and is better known the longer it was watched.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.processing = 0.0
        """Seconds of processors, of all threads together."""

    def __enter__(self) -> None:
        self._begin = time.perf_counter(), time.process_time()

    def __exit__(self, *_: object) -> None:
        self.seconds += time.perf_counter() - self._begin[0]
        self.processing += time.process_time() - self._begin[1]

    def slower(self, other: Meter) -> float:
        """Return by what to multiply the time of what this measured: as if it had had what both had, on average."""
        seconds, processing = self.seconds + other.seconds, self.processing + other.processing
        return self.processing * seconds / (self.seconds * processing) if self.processing and other.processing else 1.0


class Pace(NamedTuple):
    """How fast samples come, once they come evenly."""

    seconds_per_sample: float
    """A sample of every pixel."""
    doubt: float
    """Of the logarithm of the speed, until the end: a standard deviation."""


def pace(seconds: Mapping[int, float]) -> Pace:
    """Return the pace of the last two octaves of samples, or of all, by the seconds at some counts of samples."""
    last = max(seconds)
    first = max((n for n in seconds if 4 * n <= last), default=min(seconds))
    taken = without_start(seconds[last]) - without_start(seconds[first])
    steps = itertools.pairwise(sorted(seconds.items()))
    speeds = [math.log((after - before) / (n - m)) for (m, before), (n, after) in steps if after > before]
    apart = (len(speeds) - 1) * variance(speeds) if len(speeds) > 1 else 0.0
    doubt = math.sqrt((_KNOWN_PASSES * _DOUBT**2 + apart) / (_KNOWN_PASSES + max(len(speeds) - 1, 0)))
    return Pace(taken / (last - first), doubt)


def from_start(even: float) -> float:
    """Return how many seconds it takes from the first sample on, what at an even pace takes ``even``."""
    return even + _LOSS * (1.0 - math.exp(-even / _START))


def without_start(seconds: float) -> float:
    """Return about the seconds at an even pace of what takes so many from the first sample on."""
    return seconds - _LOSS * (1.0 - math.exp(-seconds / _START))
