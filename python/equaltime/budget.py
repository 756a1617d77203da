"""When a render stops: a number of samples, a time, an error, whichever comes first.

An error target is met when the *upper* limit of the error's interval is. A render that looked at its interval after
every pass would sooner or later stop at a lucky one, so the looks are few, at counts that grow geometrically, and a
total chance of 5 % to stop wrongly is spent over them.

To stop wrongly takes two things at once: an estimate that is low by chance, and an image that is worse by chance than
was to be expected. The one is made of the difference of two halves of the samples, the other of their sum. These are
independent where noise is normal and of like variance, so that a limit ``z`` standard deviations of both together above
the estimate lets a look stop wrongly with a chance of at most ``Φ(-z/√2)²``, wherever the error stands (the product of
``Φ(√2 x)`` and ``Φ(-√2 (z + x))`` is largest at ``x = -z/2``). Where rare bright paths make the noise both are low
together, and the chance is less. For the 95 % limit itself it is 0.7 %. A look may take half of what is left of the
5 %: six have the 95 % limit, and after these limits move outwards. A look that finds more than twice the target cannot
end the render, and spends nothing. Counts and limits follow from the film alone, never from a clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

from equaltime.error_estimate import Estimate

__all__ = ["FIRST_LOOK", "Limits", "Look", "Looks"]

FIRST_LOOK = 8
"""Samples per pixel before the error is looked at: less says too little."""

_CHANCE = 0.05
"""To stop wrongly, over all looks."""
_LEAST_Z, _MOST_Z = 1.960, 6.0
"""Of the limits at looks: that of 95 %, and one beyond which no number tells a chance from nothing."""
_IDLE = 2.0
"""Times the target: a look that finds more cannot end a render, and spends nothing."""
_WIDE = 2.0
"""Times the estimate: an upper limit beyond is of so few paths that it closes faster than errors fall."""
_GROWTH = 1.15
_LONGEST_JUMP = 8.0
# Errors fall as n^-0.5 for independent samples and up to about n^-0.75 for low-discrepancy ones where the picture has
# edges: the target is not expected before the faster law says so, since looks cost less than samples beyond it.
_FASTEST_LAW = 0.75
_NORMAL = NormalDist()


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
    """The upper limit, at the level of this look."""


class Looks:
    """The looks at the error of one render.

    Parameters
    ----------
    made
        By the render before, if it is taken up.
    target
        For which error they go on; may be told later (`aim`).
    """

    def __init__(self, made: tuple[Look, ...] = (), target: float | None = None) -> None:
        self.made = made
        self.last: Estimate | None = None
        self._target: float | None = None
        self._begin()
        if target is not None:
            self.aim(target)

    def _begin(self) -> None:
        self._left, self.next = _CHANCE, FIRST_LOOK
        self.met = False
        """Whether the last look found the target met."""

    def aim(self, target: float) -> None:
        """Go on for this target: as if all looks had been made for it."""
        if target == self._target:
            return
        self._target = target
        self._begin()
        for look in self.made:
            self._note(look, target)

    def look(self, error: Callable[[float], Estimate], samples: int, target: float) -> bool:
        """Look at the error at ``samples`` a pixel, given by its level; return whether it is surely at the target."""
        self.aim(target)
        self.last = error(2.0 * _NORMAL.cdf(_z(self._left)) - 1.0)
        look = Look(samples, self.last.value, self.last.high)
        self.made = (*self.made, look)
        self._note(look, target)
        return self.met

    def _note(self, look: Look, target: float) -> None:
        """Spend, and plan the next look."""
        if look.value < _IDLE * target:
            self._left -= _chance(_z(self._left))
        excess = min(look.high, _WIDE * look.value) / target
        growth = min(excess, _LONGEST_JUMP) ** (1.0 / _FASTEST_LAW) if math.isfinite(look.high) else _GROWTH
        self.next = _even(look.samples * min(max(growth, _GROWTH), _LONGEST_JUMP))
        self.met = look.high <= target


def _z(left: float) -> float:
    """Return the limit at which a look takes half of what is left, or that of 95 %."""
    root = math.sqrt(max(0.5 * left, _chance(_MOST_Z)))
    return max(_LEAST_Z, -math.sqrt(2.0) * _NORMAL.inv_cdf(root))


def _chance(z: float) -> float:
    """Return the chance to stop wrongly of a look whose limit is ``z``."""
    return _NORMAL.cdf(-z / math.sqrt(2.0)) ** 2


def _even(samples: float) -> int:
    """Round up to an even count, at which both replicates are alike."""
    return 2 * math.ceil(samples / 2.0)
