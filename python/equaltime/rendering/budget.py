"""When a render stops: a number of samples, a time, an error, whichever comes first.

A render that is to reach an error looks at its error at counts that grow by a factor of 1.4, whatever the target. It
stops where two looks in a row agree. At each look the error to be believed is the upper limit of its interval, or 1.15
times its value if that is more: in a large image the interval is narrow, but what makes an estimate wrong, bright paths
that are not yet met, is not. The first of the two looks must find at most 1.2 times the target, the second the target.
One lucky look ends no render, and a bright path met at the second one prolongs it.

Counts follow from nothing but the rule, and stops from the film: never from a clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from equaltime.film.error import Estimate

__all__ = ["FIRST_LOOK", "Limits", "Look", "Looks", "next_look"]

FIRST_LOOK = 8
"""Samples per pixel before the error is looked at: less says too little."""
_GROWTH = 1.4
"""From look to look."""
_LEAST_DOUBT = 1.15
"""Times the estimate: the least that an error is believed to be, however narrow its interval."""
_BEFORE = 1.2
"""Times the target: the most that the look before the last may find."""


@dataclass(frozen=True)
class Limits:
    """When to stop, whichever comes first; None is no limit."""

    spp: int | None = None
    seconds: float | None = None
    error: float | None = None
    """Upper limit of the image's error: 0.02 is 2 %."""

    def __post_init__(self) -> None:
        """Make them Python's own numbers: what comes of NumPy's, or of fractions, no JSON could hold."""
        for name, kind in (("spp", int), ("seconds", float), ("error", float)):
            if (limit := getattr(self, name)) is not None:
                object.__setattr__(self, name, kind(limit))


class Look(NamedTuple):
    """What a render saw of its error."""

    samples: int
    """A pixel."""
    value: float
    high: float
    """The upper limit, at 95 %."""
    brightest: float = 0.0
    """How bright the brightest path was (`equaltime.film.tails.averaged_out`)."""

    @property
    def believed(self) -> float:
        """The error that the look finds for sure."""
        return max(self.high, _LEAST_DOUBT * self.value)


def next_look(samples: int) -> int:
    """Return the first count for a look beyond so many samples a pixel; even, so that both replicates are alike."""
    count = FIRST_LOOK
    while count <= samples:
        count = 2 * math.ceil(0.5 * _GROWTH * count)
    return count


class Looks:
    """The looks at the error of one render.

    Parameters
    ----------
    made
        By the render before, if it is taken up.
    """

    def __init__(self, made: tuple[Look, ...] = ()) -> None:
        self.made = made
        self.last: Estimate | None = None

    def due(self, samples: int) -> bool:
        """Tell whether the error is to be looked at after so many samples a pixel."""
        return next_look(samples - 1) == samples and (not self.made or self.made[-1].samples < samples)

    @property
    def brightest(self) -> float:
        """How bright the brightest path of all looks was."""
        return max((look.brightest for look in self.made), default=0.0)

    def look(self, error: Estimate, samples: int, brightest: float = 0.0) -> None:
        """Note the error at ``samples`` a pixel, and how bright its brightest path is."""
        self.last = error
        self.made = (*self.made, Look(samples, error.value, error.high, brightest))

    def met(self, target: float) -> bool:
        """Tell whether the last two looks agree that the error is at the target."""
        if len(self.made) < 2:
            return False
        before, last = (look.believed for look in self.made[-2:])
        return before <= _BEFORE * target and last <= target
