"""Measured runs of a strategy on a scene, and whether few of them make most of the error.

Where a few events make most of the error (`Runs.tail`), the mean over repeats is decided by the runs that met such
events. The spread over repeats does not tell the frequency of these events. `equaltime.statistics.curves` reads times
and errors off these runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from equaltime.statistics.intervals import FEWEST_REPEATS, Interval, join
from equaltime.words import percent

__all__ = ["MISSING", "TYPICAL", "Runs", "of_one_kind"]

Floats = NDArray[np.float64]

TYPICAL = "typical runs: the median of repeats"
"""Note of an interval of a time: the time is the median over repeats, not the time at which the mean error is
reached."""
MISSING = "all images differ from the reference alike: images or reference lack light, or the strategy is biased"
"""Note of an interval of an unbiased strategy whose images share an offset from the reference."""
_CLEAR = 4.0
"""Standard errors of the reference's part that a squared error must exceed to be read off the curve."""
_MOST_OF_ONE = 0.5
"""Largest share of one repeat in the squared errors of all for which it counts as a run like the others."""


def of_one_kind(numbers: Iterable[Interval]) -> bool:
    """Tell whether times or ratios are all of typical runs, or all of mean errors: others have no common mean."""
    return len({TYPICAL in number.note for number in numbers}) == 1


@dataclass(frozen=True, eq=False)
class Runs:
    """K repeats of one strategy on one scene: measurements that give error curves and times to an error.

    Each repeat is measured at the same C checkpoints (sample counts). The field ``relmse`` is the squared relative
    error.
    """

    seconds: Floats
    """(K, C): seconds since the first sample of the repeat; increasing along C."""
    relmse: Floats
    """(K, C): measured relMSE (mean squared relative error) of the image at each checkpoint, with the reference's noise
    subtracted; may be negative."""
    independent: bool = False
    """Whether samples are known to be independent, so that the error falls as time to the power -1/2."""
    biased: bool = False
    """Whether the strategy is biased, so that the error may stop falling; then nothing is extrapolated."""
    bias: float = 0.0
    """Lower end of the relative bias of a biased strategy, below which its error never falls; 0 if it is not known."""
    doubt: str = ""
    """Reason, in words, to think that a few rare bright paths make most of the error of the final images
    (`equaltime.film.tails`). Empty if there is none."""
    missing: str = ""
    """Reason, in words, why the true error may exceed the error of all repeats: light that no repeat met. The upper
    ends of intervals are then not valid. Empty if there is none."""
    unseen: float = 0.0
    """Largest addition to the squared error by light that no repeat met, as a fraction of relMSE; 0 if no such light is
    expected."""
    shared: float = 0.0
    """Standard error of relMSE due to the reference's noise, which all repeats share."""
    reference: float = 0.0
    """Relative error of the reference by its own noise. Beyond the runs, no time to a smaller error is given."""
    spp: Floats | None = None
    """(C,): samples per pixel at the checkpoints of a renderer that starts anew for each, so that every time contains
    its start. None if one image grows from checkpoint to checkpoint."""

    @property
    def repeats(self) -> int:
        """K, the number of repeats."""
        return len(self.seconds)

    @property
    def tail(self) -> str:
        """Reason, in words, why the mean error is not the error of typical runs; empty if the mean is typical.

        A reason is given if the field ``doubt`` has one, or if one repeat makes more than half of the squared error.
        """
        sums = self.relmse.sum(axis=0)
        clear = sums > max(_CLEAR * self.repeats * self.shared, 0.0)
        share = float((self.relmse.max(axis=0)[clear] / sums[clear]).max(initial=0.0))
        if self.doubt or self.repeats < FEWEST_REPEATS or share <= _MOST_OF_ONE:
            return self.doubt
        return f"one repeat of {self.repeats} makes {percent(share)} of their squared error"

    @property
    def exact(self) -> bool:
        """Whether every image equals an exact reference, so that no error is left to fall."""
        return self.shared == 0.0 and not self.relmse.any()

    @property
    def law(self) -> bool:
        """Whether the error is known to fall as 1 / sqrt(time), so that curves go on with that slope.

        It is True for independent, unbiased samples, unless a few rare bright paths make most of the error (``tail``).
        """
        return self.independent and not self.biased and not self.tail

    def typical(self, kept: Floats) -> tuple[Floats, Floats]:
        """Return the curve of typical repeats: log seconds and log error at each checkpoint, as medians over repeats.

        Logarithms are natural. ``kept`` (K,) is 1 for repeats that count, else 0. The curve ends before the first
        checkpoint at which the error is below the reference's noise, so both arrays may be shorter than C.
        """
        chosen = kept > 0.0
        seconds, square = (np.median(values[chosen], axis=0) for values in (self.seconds, self.relmse))
        return self._clear(seconds, square)

    def points(self, kept: Floats) -> tuple[Floats, Floats]:
        """Return the curve of the mean error: log seconds and log error at each checkpoint, from means over repeats.

        Logarithms are natural, and the error is the root of the mean relMSE. ``kept`` (K,) is the weight of each
        repeat. The curve ends before the first checkpoint at which the error is below the reference's noise, so both
        arrays may be shorter than C.
        """
        return self._clear(kept @ self.seconds / kept.sum(), kept @ self.relmse / kept.sum())

    def _clear(self, seconds: Floats, square: Floats) -> tuple[Floats, Floats]:
        sunk = np.flatnonzero(~(square > _CLEAR * self.shared))
        end = int(sunk[0]) if sunk.size else square.size
        return np.log(seconds[:end]), 0.5 * np.log(square[:end])

    def is_below(self, checkpoint: int = -1) -> bool:
        """Tell whether the error at a checkpoint, by default the last, is below the reference's noise."""
        return float(self.relmse[:, checkpoint].mean()) <= _CLEAR * self.shared

    def moved(self, errors: float) -> Runs:
        """Return a copy with every relMSE increased by ``errors`` times ``shared``.

        The copy shows the effect of the reference's noise: ``shared`` is the standard error of relMSE due to that
        noise. A negative number of ``errors`` lowers relMSE.
        """
        return replace(self, relmse=self.relmse + errors * self.shared)

    def judged(self, error: Interval) -> Interval:
        """Return ``error``, an interval of the error of these runs, corrected for rare bright paths.

        If a few such paths make most of the error (``tail``), or light may be missing (``missing``), only the lower end
        of the result stays valid. Otherwise the upper end is raised: light that no repeat met may add the fraction
        ``unseen`` to the squared error.
        """
        if reason := join((self.tail, self.missing)):
            return error.bounded("low", reason).telling()
        return error.widened(math.sqrt(1.0 + self.unseen) - 1.0)

    def judged_time(self, time: Interval) -> Interval:
        """Return ``time``, an interval of the seconds until an error, corrected for rare bright paths.

        If a few such paths make most of the error (``tail``), the field ``note`` says so. Otherwise the upper end is
        raised by the factor 1 + ``unseen``, by which light that no repeat met may raise the squared error. The factor
        is the same for the time, because errors fall at least as fast as 1 / sqrt(time). If light may be missing
        (``missing``), only the lower end stays valid. What says too little is left out (`Interval.telling`).
        """
        time = time.noted(f"{TYPICAL}; {tail}") if (tail := self.tail) else time.widened(self.unseen)
        return (time.bounded("low", self.missing) if self.missing else time).telling()
