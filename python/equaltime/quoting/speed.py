"""Time of a sample, as short pilots show it, on machines with other users too."""

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

# Standard deviation of the logarithm of the speed, from the pilot to the end, before the pilot's passes have shown how
# their speed varies; and the number of passes that this prior counts as. Machines with other users vary by 0.1
# (measured).
_DOUBT, _KNOWN_PASSES = 0.1, 2
# The first hundredths of a second are slower, until caches are filled and woken threads are spread over the processors.
# In seconds: the loss on a machine without other users, the additional loss times the share of it that others have, and
# the time in which the loss decays (tests/bench/short_passes.py).
_LOSS, _LOSS_OF_TAKEN, _START = 0.004, 0.022, 0.05


class Processors(NamedTuple):
    """Processor time that the threads of this process had since they began.

    The processor time of a sample hardly depends on other processes. The available share of the processors varies from
    a tenth of a second to the next, and is better known the longer it was watched. Idle threads wait for no processor.
    """

    ran: float
    """Seconds that threads ran, all together."""
    waited: float
    """Seconds in which threads could have run, but others did."""

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
        """Return the share of the usable processor time that the threads had; 1 if it is not known."""
        ran, waited = self.ran - before.ran, self.waited - before.waited
        return ran / (ran + waited) if ran > 0.0 and waited > 0.0 else 1.0


class Pace(NamedTuple):
    """Speed of sampling, once samples come evenly."""

    seconds_per_sample: float
    """Seconds for one sample of every pixel."""
    doubt: float
    """Standard deviation of the logarithm of the speed, until the end."""
    lost: float
    """Additional seconds of the start."""


def pace(seconds: Mapping[int, float], had: float = 1.0) -> Pace:
    """Return the pace of the last two octaves of samples, or of all, from the seconds at some counts of samples.

    ``had`` is the share of the processors that was available meanwhile.
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
    """Return the seconds from the first sample on for work that takes ``even`` seconds at an even pace."""
    return even + lost * (1.0 - math.exp(-even / _START))


def without_start(seconds: float, lost: float) -> float:
    """Return approximately the seconds at an even pace for work that takes ``seconds`` from the first sample on."""
    return seconds - lost * (1.0 - math.exp(-seconds / _START))
