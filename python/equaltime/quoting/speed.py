"""What a sample costs in time, as short pilots show it, on machines that others use too."""

from __future__ import annotations

import glob
import itertools
import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from statistics import variance
from typing import NamedTuple

__all__ = ["Pace", "Processors", "from_start", "pace", "without_start"]

# Of the logarithm of the speed, from the pilot to the end. What is taken to be known before the pilot's passes have
# shown how their speed varies, and as how many passes it counts: machines that others use too vary by 0.1 (measured).
_DOUBT, _KNOWN_PASSES = 0.1, 2
# The first hundredths of a second are slower, until caches are filled and threads that woke are spread over the
# processors: what that takes in all, in seconds, with a machine of one's own, and what more for the share of it that
# others have; and how soon it is over (tests/bench/short_passes.py).
_LOSS, _LOSS_OF_TAKEN, _START = 0.004, 0.022, 0.05


class Processors(NamedTuple):
    """What the threads of this process had of the processors since they began.

    The time of processors that a sample takes hardly depends on what else runs; how much of them there is to be had
    varies from a tenth of a second to the next, and is better known the longer it was watched. Threads with nothing to
    do wait for none.
    """

    ran: float
    """Seconds, of all threads together."""
    waited: float
    """Seconds for which threads could have run, but others did."""

    @classmethod
    def now(cls) -> Processors:
        """Read the scheduler's own account (Linux; zero elsewhere)."""
        ran = waited = 0
        for task in glob.iglob("/proc/self/task/*/schedstat"):
            with suppress(OSError):  # the thread has ended
                times = Path(task).read_text().split()
                ran, waited = ran + int(times[0]), waited + int(times[1])
        return cls(1e-9 * ran, 1e-9 * waited)

    def had_since(self, before: Processors) -> float:
        """Return the share that they had of what they could have used; 1 where that is not known."""
        ran, waited = self.ran - before.ran, self.waited - before.waited
        return ran / (ran + waited) if ran > 0.0 and waited > 0.0 else 1.0


class Pace(NamedTuple):
    """How fast samples come, once they come evenly."""

    seconds_per_sample: float
    """A sample of every pixel."""
    doubt: float
    """Of the logarithm of the speed, until the end: a standard deviation."""
    lost: float
    """Seconds that the start takes longer."""


def pace(seconds: Mapping[int, float], had: float = 1.0) -> Pace:
    """Return the pace of the last two octaves of samples, or of all, by the seconds at some counts of samples.

    ``had`` is the share of the processors that there was to be had, meanwhile.
    """
    last, lost = max(seconds), _LOSS + _LOSS_OF_TAKEN * (1.0 - had)
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
