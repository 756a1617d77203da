"""Runs whose error falls as a power of time, but for a little noise."""

from __future__ import annotations

import math

import numpy as np

from equaltime.statistics.intervals import Interval
from equaltime.statistics.runs import Runs

SPP = np.array([2.0, 4.0, 8.0, 16.0, 32.0, 64.0])


def power_law(repeats: int = 8, power: float = -0.5, speed: float = 1.0, scatter: float = 0.02, seed: int = 0) -> Runs:
    """Return runs with error = (seconds x speed)^power, but for noise that repeats differ by."""
    rng = np.random.default_rng(seed)
    seconds = SPP / speed * np.exp(scatter * rng.standard_normal((repeats, 1)))
    relmse = (SPP**power) ** 2 * np.exp(scatter * rng.standard_normal((repeats, len(SPP))))
    return Runs(seconds, relmse)


SIX = (0.210, 0.214, 0.207, 1.115, 0.207, 0.209)
"""Errors of six runs after 16 samples, one of which met a firefly last."""


def with_firefly(last: tuple[float, ...] = SIX, speed: float = 1.0, power: float = -0.5) -> Runs:
    """Return runs of 2 to 16 samples that end at these errors; all but the firefly is a power of time."""
    spp = SPP[:4]
    errors = np.median(last) * (spp / spp[-1]) ** power * np.ones((len(last), 1))
    errors[:, :-1] *= np.exp(0.01 * np.random.default_rng(4).standard_normal((len(last), len(spp) - 1)))
    errors[:, -1] = last
    return Runs(np.tile(spp / speed, (len(last), 1)), errors**2)


def close(interval: Interval, value: float, within: float = 0.05) -> bool:
    """Tell whether an interval holds the value, and is narrow."""
    width = math.log(interval.high / interval.low)
    return interval.low <= value <= interval.high and 0.0 < width < within and interval.low < interval.value
