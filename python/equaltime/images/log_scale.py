"""Logarithmic scales of maps, such as errors or variances of pixels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["LogScale"]


@dataclass(frozen=True)
class LogScale:
    """Logarithmic scale from ``low`` to ``high``, both above 0, for pictures of errors or variances."""

    low: float
    high: float

    @classmethod
    def of(cls, maps: Iterable[NDArray[Any]], decades: float, most: float = 0.0) -> LogScale:
        """Return a common scale of ``maps`` (arrays of any shape), so that equal colours mean equal values.

        The high end is the 99th percentile of all maps, rounded up to half a decade. Numbers that are not finite or not
        above 0 are left out. The scale spans ``decades`` factors of ten, or more if ``most`` allows it: at most
        ``most`` factors. It then reaches down to the 1st percentile of at least half of the maps, and to the 90th of
        every map. So one map far below all others does not take most of the scale from them.
        """
        flat = (np.ravel(values) for values in maps)
        positive = [kept for values in flat if (kept := values[np.isfinite(values) & (values > 0.0)]).size]
        if not positive:
            return cls(float(10.0 ** (-1.0 - decades)), 0.1)
        firsts, nineties = np.transpose([np.percentile(values, (1.0, 90.0)) for values in positive])
        least = 2.0 * np.log10(min(np.median(firsts), nineties.min()))
        largest = 2.0 * np.log10(np.percentile(np.concatenate(positive), 99.0))
        end, begin = np.ceil(largest) / 2.0, np.floor(least) / 2.0
        return cls(float(10.0 ** (end - np.clip(end - begin, decades, max(decades, most)))), float(10.0**end))

    @property
    def middle(self) -> float:
        """Value at the middle of the scale: the geometric mean of its ends."""
        return math.sqrt(self.low) * math.sqrt(self.high)

    @property
    def ticks(self) -> tuple[str, str, str]:
        """Labels, as text, of the low end, the middle and the high end, each with one digit."""
        low, middle, high = (f"{float(f'{value:.1g}'):g}" for value in (self.low, self.middle, self.high))
        return low, middle, high

    def position(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """Return the positions of ``values`` on the scale: 0 at the low end and 1 at the high end.

        Values below the low end, and NaN, are put at 0. Values above the high end, and infinite ones, are put at 1.
        """
        place = np.log(np.maximum(values, self.low) / self.low) / math.log(self.high / self.low)
        return np.asarray(np.clip(np.nan_to_num(place, nan=0.0), 0.0, 1.0), np.float64)
