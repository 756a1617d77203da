"""When a render stops: a number of samples, a time, an error, whichever comes first.

An error target is met when the *upper* limit of the error's interval is. A render that looked at its interval after
every pass would sooner or later stop at a lucky one, so the looks are few, at counts that grow geometrically, and a
total level of 5 % is spent over them: the k-th may be wrong with probability ``0.05 / 2^k`` (the sum over all k is
0.05). A look that finds more than twice the target cannot end the render, and spends nothing. Counts and levels follow
from the film alone, never from a clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from equaltime.error_estimate import Estimate

__all__ = ["FIRST_LOOK", "Limits", "Looks"]

FIRST_LOOK = 8
"""Samples per pixel before the error is looked at: less says too little."""

_LEVEL = 0.05
_SMALLEST = 30
"""Power of two beyond which levels fall no more: no number tells a smaller one from nothing."""
_IDLE = 2.0
"""Times the target: a look that finds more cannot end a render, and spends nothing."""
_GROWTH = 1.15
_LONGEST_JUMP = 8.0
# Errors fall as n^-0.5 for independent samples and up to about n^-0.75 for low-discrepancy ones where the picture has
# edges. From afar the target is not expected before the faster law says so; near by a likely one saves looks.
_FASTEST_LAW = 0.75
_LIKELY_LAW = 0.6
_NEAR = 2.0


@dataclass(frozen=True)
class Limits:
    """When to stop, whichever comes first; None is no limit."""

    spp: int | None = None
    seconds: float | None = None
    error: float | None = None
    """Upper limit of the image's error: 0.02 is 2 %."""


class Looks:
    """The looks at the error of one render.

    Parameters
    ----------
    made
        Sample counts at which it was looked before, by a render that is taken up.
    """

    def __init__(self, made: tuple[int, ...] = ()) -> None:
        self.made = made
        self.last: Estimate | None = None
        self._spent = len(made)
        self.next = _even(made[-1] * _GROWTH) if made else FIRST_LOOK

    def look(self, error: Callable[[float], Estimate], samples: int, target: float) -> bool:
        """Look at the error at ``samples`` a pixel, given by its level; return whether it is surely at the target."""
        self.made = (*self.made, samples)
        self.last = error(1.0 - 2.0 * _LEVEL / 2.0 ** min(self._spent + 1, _SMALLEST))
        if self.last.value < _IDLE * target:
            self._spent += 1
        excess = self.last.high / target
        law = _LIKELY_LAW if excess < _NEAR else _FASTEST_LAW
        growth = min(excess, _LONGEST_JUMP) ** (1.0 / law) if math.isfinite(excess) else _GROWTH
        self.next = _even(samples * min(max(growth, _GROWTH), _LONGEST_JUMP))
        return self.last.high <= target


def _even(samples: float) -> int:
    """Round up to an even count, at which both replicates are alike."""
    return 2 * math.ceil(samples / 2.0)
