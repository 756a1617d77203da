"""Limits of a render: a number of samples, a time and an error; the first that is met ends the render.

A render with an error target estimates its error at fixed sample counts, called looks, and may stop there. The counts
are the powers of two and the counts halfway between two of them: 8, 12, 16, 24, 32 and so on, whatever the target. At
these counts low-discrepancy samples are even, and both groups whose difference shows the error have at least a third of
the samples. A small second group would make the estimate of the error noisy. The render stops when two looks in a row
agree. The error that counts at a look is the upper limit of the estimate, or 1.15 times the estimate if that is larger.
The factor matters in a large image, where the interval is narrow. There an estimate can still be wrong because bright
paths have not been met yet. The first of the two looks must find at most 1.2 times the target, the second at most the
target. So a single low estimate does not end a render, and a bright path met at the second look prolongs it.

The sample counts of looks follow from this rule alone, and the decision to stop follows from the samples alone. Neither
depends on a clock, so a rerun with an error target alone stops at the same count.

The rule for the error target (`Stop`) is stored with the result. A render that looks at its own error and stops when it
is small selects images. Images that have not met a rare bright path stop, and images that have met one go on. Each
sample is unbiased, but the mean over images that were stopped by their own error is biased. Images of small lights that
glass focuses or metal reflects come out too dark on average. A *fixed* count does not depend on the image: a pilot (a
short render that predicts, with separate samples) chooses the count, which is rendered whatever the image shows. Such
images are unbiased.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

from equaltime.statistics.intervals import Interval

__all__ = [
    "FIRST_LOOK",
    "LEAST_DOUBT",
    "Limits",
    "Look",
    "Looks",
    "Stop",
    "StopRule",
    "StoppedBy",
    "next_look",
    "noise_within",
]

StopRule = Literal["look", "fixed"]

StoppedBy = Literal["spp", "time", "error", "count", "interrupt", "nonfinite", "faulty", "unfinished", "merge"]
"""Reasons why a render ends: number of samples (``spp``), ``time``, ``error``, or the ``count`` that a short render
chose; Ctrl-C (``interrupt``); a sample that is NaN or infinite, or that raised a floating-point fault (``faulty``).
``unfinished`` is a render saved on the way, and ``merge`` one that was merged."""

_ALWAYS = ("rule", "selects", "error")

_OF_FIXED = ("spp", "pilot_seed", "pilot_spp", "pilot_seconds")
"""Fields of `Stop` that records hold beside `_ALWAYS` for the rule ``fixed``."""


@dataclass(frozen=True)
class Stop:
    """Rule by which a render with an error limit stops; it is stored with the result.

    The render stops by its own estimates of the error (``look``), or at a sample count that a pilot chose before
    (``fixed``). A pilot is a short render that predicts.
    """

    rule: StopRule
    """``look``: the render stops by estimates of its own error; ``fixed``: a pilot (short render) chose the sample
    count."""
    error: float
    """Relative error to reach, as a fraction, without the bias due to effects, such as media, that were left out."""
    spp: int | None = None
    """Samples per pixel that a pilot (short render that predicts) chose; None for ``look``."""
    pilot_seed: int | None = None
    """Seed of the samples of the pilot (short render that predicts); None for the rule ``look``."""
    pilot_spp: int | None = None
    """Samples per pixel of the pilot (short render that predicts), which are not part of the image; None for ``look``.
    """
    pilot_seconds: float = 0.0
    """Seconds that the pilot (short render that predicts) took; 0 for ``look``."""

    @property
    def selects(self) -> bool:
        """Whether the image decides its own sample count: True for the rule ``look``, False for ``fixed``.

        With ``look``, images that have met few rare bright paths stop early, so the mean over many renders is biased.
        """
        return self.rule == "look"

    def as_dict(self) -> dict[str, Any]:
        """Return the rule as JSON data, which is stored with a result: its fields by name.

        ``spp`` and the fields whose names begin with ``pilot`` are left out for the rule ``look``.
        """
        names = _ALWAYS if self.selects else (*_ALWAYS, *_OF_FIXED)
        return {name: getattr(self, name) for name in names}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Stop:
        """Return the rule from its fields as JSON data; missing optional fields get their defaults."""
        return cls(**{name: data[name] for name in ("rule", "error", *_OF_FIXED) if name in data})


FIRST_LOOK = 8
"""Samples per pixel at which a render with an error target first estimates its error; fewer say too little about the
error."""

LEAST_DOUBT: Final = 1.15
"""Least multiple of the estimate that is believed to be the error, however narrow its interval."""

_BEFORE = 1.2
"""Largest multiple of the target that the look before the last may find."""


@dataclass(frozen=True)
class Limits:
    """Limits of a render: samples per pixel, seconds and relative error. The first that is met ends the render.

    A field that is None is no limit.
    """

    spp: int | None = None
    seconds: float | None = None
    error: float | None = None
    """Relative error to reach: the render ends when the upper limit of its error is at most this fraction (0.02 is 2
    %)."""

    def __post_init__(self) -> None:
        """Convert the limits to Python's numbers: JSON cannot hold NumPy's numbers or fractions."""
        for name, kind in (("spp", int), ("seconds", float), ("error", float)):
            if (limit := getattr(self, name)) is not None:
                object.__setattr__(self, name, kind(limit))


class Look(NamedTuple):
    """Look: the estimate of a render's error at a sample count at which the render may stop.

    All errors are relative errors of the image, as fractions.
    """

    samples: int
    """Samples per pixel."""
    value: float
    """Estimated error."""
    high: float
    """Upper end of the 95 % interval of the error, as a fraction."""
    brightest: float = 0.0
    """Brightness of the brightest path met so far: its share of error², times error², times the square of ``samples``.
    A path keeps this brightness while samples are added (`equaltime.film.tails.averaged_out`)."""

    @property
    def believed(self) -> float:
        """Error by which this look decides whether the render stops, as a fraction.

        It is the upper limit, or 1.15 times the estimate if that is larger.
        """
        return max(self.high, LEAST_DOUBT * self.value)

    @property
    def widened(self) -> bool:
        """Whether one bright path makes a tenth of error², and the upper limit is more than twice the estimate."""
        return self.high > 2.0 * self.value and self.brightest > 0.1 * (self.samples * self.value) ** 2


def next_look(samples: int) -> int:
    """Return the sample count per pixel at which a render next estimates its error to decide whether it stops.

    The result is above ``samples``, the present count per pixel. It is 2^k or 3 · 2^(k-1), and at least 8.
    """
    power = 1 << samples.bit_length()  # the first power of two above
    return max(power if 4 * samples >= 3 * power else 3 * power // 4, FIRST_LOOK)


class Looks:
    """All looks of one render, to decide when it stops.

    A look is a moment at which the render estimates its error, and stops if the error limit is reached.

    Parameters
    ----------
    made
        Looks of the saved render, if the render resumes one; else empty.
    """

    def __init__(self, made: tuple[Look, ...] = ()) -> None:
        self.made = made
        self.last: Interval | None = None

    def due(self, samples: int) -> bool:
        """Tell whether the render should estimate its error (look) at ``samples`` per pixel."""
        return next_look(samples - 1) == samples and (not self.made or self.made[-1].samples < samples)

    @property
    def brightest(self) -> float:
        """Largest brightness of a path at any look (estimate of the error on the way); 0 without looks.

        A path's brightness is its share of error², times error², times the square of the samples per pixel. The largest
        brightness tells later whether a bright path has averaged out, which puts the error in doubt.
        """
        return max((look.brightest for look in self.made), default=0.0)

    def look(self, error: Interval, samples: int, brightest: float = 0.0) -> None:
        """Add a look: the estimated error at ``samples`` per pixel, and the brightness of the brightest path.

        The brightness of a path is its share of error², times error², times the square of ``samples``.
        """
        self.last = error
        self.made = (*self.made, Look(samples, error.value, error.high, brightest))

    def met(self, target: float) -> bool:
        """Tell whether the last two looks (estimates of the error) agree that the error is at most ``target``.

        ``target`` is a fraction. The first of the two looks may exceed it by a fifth.
        """
        if len(self.made) < 2:
            return False
        before, last = (look.believed for look in self.made[-2:])
        return before <= _BEFORE * target and last <= target

    def end(self, target: float, samples: int, exponent: float) -> int:
        """Return the samples per pixel of the look at which a render with ``samples`` is expected to stop.

        ``target`` is a fraction. From the last look on, the error falls as samples to the power of ``-exponent``.
        """
        last, before = self.made[-1], self.made[-1].believed
        end = next_look(max(samples - 1, last.samples))
        while (expected := last.believed * (last.samples / end) ** exponent) > target or before > _BEFORE * target:
            end, before = next_look(end), expected
        return end


def noise_within(error: float, bias: Interval | None) -> float | None:
    """Return the noise that makes the relative error ``error`` together with the upper limit of ``bias``.

    All are fractions; ``bias`` None stands for no bias. The result is None if the bias alone reaches ``error``.
    """
    if bias is None:
        return error
    return math.sqrt(error**2 - bias.high**2) if bias.high < error else None
