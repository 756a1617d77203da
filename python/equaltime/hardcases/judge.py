"""Criteria of passing a hard case: a t-test for noisy images, units in the last place for images without noise.

A renderer makes one image for each of several seeds. The means of these images are nearly normally distributed. The
t-test uses the spread of the means, not the renderer's error bars. All t-tests share one family-wise level, `LEVEL`.
Without noise, every pixel is compared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.statistics.agreement import ROUNDING, share
from equaltime.strict_json import fields_to_json, to_json

__all__ = ["LEVEL", "MOST_ULP", "Outcome", "broken", "judge_bits", "judge_same", "judge_value", "limit_of"]

Images = Sequence[NDArray[np.float32]]
LEVEL: Final = 0.001
"""False-alarm rate of the self-test: probability that a correct renderer fails at least one of all cases."""
MOST_ULP: Final = ROUNDING * 2.0**24
"""Largest deviation of an image without noise that passes, in units in the last place: float32 rounding along a
path."""


@dataclass(frozen=True)
class Outcome:
    """Result of one renderer in one hard case: it passes if its score does not exceed the limit."""

    expected: float | None
    """Known mean of all pixels; None if two sets of images are compared."""
    got: float | None
    """Mean of all pixels and seeds; None if rendering failed."""
    error: float
    """Standard error of ``got`` (of the difference if two sets of images are compared); 0 without noise."""
    kind: Literal["z", "ulp", "failure"]
    score: float
    """Deviation from the expected value: in standard errors, or for the worst pixel in units in the last place."""
    limit: float
    """Largest score with which the case passes."""
    seconds: float = 0.0
    note: str = ""
    """Reason why rendering failed; else empty."""

    @property
    def passed(self) -> bool:
        """Whether the case was rendered and its score is within the limit."""
        return self.kind != "failure" and self.score <= self.limit

    @property
    def resolution(self) -> float | None:
        """Relative bias that the case can find: the bias at which half of the renders would fail.

        None for images without noise, and for an expected mean of 0.
        """
        if not self.expected or self.kind != "z":
            return None
        return self.limit * self.error / abs(self.expected) + ROUNDING

    def as_dict(self) -> dict[str, Any]:
        """Return the outcome's fields by name as JSON data; numbers that are not finite become None."""
        return {**fields_to_json(self), "pass": self.passed, "resolution": to_json(self.resolution)}


def limit_of(cases: int) -> float:
    """Return the largest score that passes one of ``cases`` t-tests, which share the false-alarm rate `LEVEL`.

    The score is the absolute deviation from the expected mean in standard errors, converted to a normal deviate.
    """
    from scipy import stats  # late: slow to import

    return float(stats.norm.isf(share(LEVEL, cases) / 2.0))


def judge_value(images: Images, expected: float, limit: float) -> Outcome:
    """Compare the mean of images of independent seeds with the known mean ``expected``, by a t-test.

    Returns score and limit as an outcome. ``limit`` is the largest score that passes, in standard errors. If the images
    have no noise, there is only one image, or ``expected`` is 0, every pixel is compared with ``expected`` instead.
    """
    stack = np.array(images, dtype=np.float64)
    got, unit = float(stack.mean()), float(np.spacing(np.float32(abs(expected))))
    if not expected or len(stack) == 1 or np.ptp(stack, axis=0).max() <= MOST_ULP * unit:
        return Outcome(expected, got, 0.0, "ulp", float(np.abs(stack - expected).max()) / unit, MOST_ULP)
    means = stack.mean(axis=(1, 2, 3))
    error = _standard_error(means)
    z = _deviate(got - expected, error, len(means) - 1, ROUNDING * abs(expected))
    return Outcome(expected, got, error, "z", z, limit)


def judge_same(first: Images, second: Images, limit: float) -> Outcome:
    """Compare the means of two sets of images by Welch's t-test; the outcome passes unless they differ significantly.

    ``limit`` is the largest score that passes: the difference in standard errors.
    """
    a, b = (np.array([np.asarray(image, dtype=np.float64).mean() for image in side]) for side in (first, second))
    expected, got = float(a.mean()), float(b.mean())
    errors = _standard_error(a), _standard_error(b)
    total = math.hypot(*errors)
    degrees = total**4 / max(sum(e**4 / (len(s) - 1) for e, s in zip(errors, (a, b), strict=True)), 1e-300)
    z = _deviate(got - expected, total, max(degrees, 1.0), ROUNDING * abs(expected))
    return Outcome(expected, got, total, "z", z, limit)


def judge_bits(first: NDArray[np.float32], second: NDArray[np.float32]) -> Outcome:
    """Compare two images bit by bit; the outcome passes only if all bits are equal."""
    a, b = first.astype(np.float64), second.astype(np.float64)
    apart = np.abs(a - b) / np.spacing(np.maximum(np.abs(first), np.abs(second)))
    ulp = float(apart.max())
    if ulp == 0.0 and first.tobytes() != second.tobytes():
        ulp = 0.5  # signs of zeros
    return Outcome(float(a.mean()), float(b.mean()), 0.0, "ulp", ulp, 0.0)


def broken(expected: float | None, reason: str) -> Outcome:
    """Return the failed outcome of a case that could not be rendered; ``reason`` says why."""
    return Outcome(expected, None, 0.0, "failure", math.inf, 0.0, note=reason)


def _standard_error(means: NDArray[np.float64]) -> float:
    return float(means.std(ddof=1)) / math.sqrt(len(means)) if len(means) > 1 else 0.0


def _deviate(off: float, error: float, degrees: float, rounding: float) -> float:
    """Return the normal deviate with the t-statistic's tail probability, after subtracting the rounding."""
    from scipy import stats  # late: slow to import

    excess = max(abs(off) - rounding, 0.0)
    if error == 0.0:
        return math.inf if excess else 0.0
    t = excess / error
    z = float(-stats.norm.ppf(stats.t.sf(t, degrees)))
    return max(0.0, z) if math.isfinite(z) else t
