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
# The first hundredths of a second are slower, until caches are filled and threads that woke are spread over the
# processors: what that takes in all, in seconds, with a machine of one's own, and what more for the share of it that
# others have; and how soon it is over (tests/bench/short_passes.py).
_LOSS, _LOSS_OF_TAKEN, _START = 0.004, 0.022, 0.05


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

    def taken(self, threads: int) -> float:
        """Return the share of so many processors that others had."""
        return max(0.0, 1.0 - self.processing / (self.seconds * threads)) if self.seconds else 0.0

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
    lost: float
    """Seconds that the start takes longer."""


def pace(seconds: Mapping[int, float], taken: float = 0.0) -> Pace:
    """Return the pace of the last two octaves of samples, or of all, by the seconds at some counts of samples.

    ``taken`` is the share of the processors that others had.
    """
    last, lost = max(seconds), _LOSS + _LOSS_OF_TAKEN * taken
    first = max((n for n in seconds if 4 * n <= last), default=min(seconds))
    even = without_start(seconds[last], lost) - without_start(seconds[first], lost)
    steps = itertools.pairwise(sorted(seconds.items()))
    speeds = [math.log((after - before) / (n - m)) for (m, before), (n, after) in steps if after > before]
    apart = (len(speeds) - 1) * variance(speeds) if len(speeds) > 1 else 0.0
    doubt = math.sqrt((_KNOWN_PASSES * _DOUBT**2 + apart) / (_KNOWN_PASSES + max(len(speeds) - 1, 0)))
    return Pace(even / (last - first), doubt, lost)


def from_start(even: float, lost: float) -> float:
    """Return how many seconds it takes from the first sample on, what at an even pace takes ``even``."""
    return even + lost * (1.0 - math.exp(-even / _START))


def without_start(seconds: float, lost: float) -> float:
    """Return about the seconds at an even pace of what takes so many from the first sample on."""
    return seconds - lost * (1.0 - math.exp(-seconds / _START))
