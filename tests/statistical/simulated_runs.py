"""Runs of made-up renderers whose expected error is known: what intervals are tested against."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.analysis.strategy_runs import speed_up
from equaltime.images.metrics import tail_of
from equaltime.statistics.curves import (
    FARTHEST_REACH,
    error_at,
    error_curve,
    interval_of,
    log_time,
    log_times,
    slope,
    time_to_error,
)
from equaltime.statistics.intervals import UNKNOWN, Interval, exp
from equaltime.statistics.runs import TYPICAL, Runs

Array = NDArray[np.float64]

SPP = np.array([2, 4, 6, 8, 12, 16, 24, 32, 48, 64])
REPEATS = 8
POOLED = 24
"""Experiments of which typical runs are known."""
DRIFT, JITTER = 0.05, 0.01
"""How the machine's speed varies from repeat to repeat, and a time from checkpoint to checkpoint (relative)."""


@dataclass(frozen=True)
class Renderer:
    """Unit noise that falls as a power of the sample count, times a standard deviation that differs by pixel."""

    draw: Callable[[np.random.Generator, int, tuple[int, ...]], Array]
    """Sums of so many samples of mean 0 and variance 1."""
    power: float = -0.5
    """Of error in the sample count; below -0.5 as low-discrepancy points have it."""
    size: int = 32
    """Pixels along a side."""
    reference: float = 0.0
    """Noise of the reference, relative to the render's at the last checkpoint."""
    law: bool = False
    """Whether its samples are known to be independent."""

    @property
    def deviation(self) -> Array:
        """(size, size): the picture."""
        return np.asarray(np.exp(0.4 * np.random.default_rng(0).standard_normal((self.size, self.size))))

    def error(self, spp: float) -> float:
        """Return the expected relative error."""
        return float(np.sqrt(np.mean(self.deviation**2)) * spp**self.power)

    def runs(self, seed: int, speed: float = 1.0) -> Runs:
        """Render an image of value 1 everywhere, as often as there are repeats; a sample takes 1 / speed seconds.

        Means of samples are cumulative, so checkpoints of a run go together as they do in earnest; they are scaled to
        the power that is wanted. What is seen of tails in the last images is in the runs.
        """
        rng = np.random.default_rng(seed)
        shape = (REPEATS, self.size, self.size)
        sums = np.stack([self.draw(rng, int(count), shape) for count in np.diff(SPP, prepend=0)], axis=1)
        means = np.cumsum(sums, axis=1) / SPP[:, None, None]
        noise = means * self.deviation * (SPP ** (0.5 + self.power))[:, None, None]
        seconds = SPP / speed * np.exp(DRIFT * rng.standard_normal((REPEATS, 1)))
        seconds = seconds * (1.0 + JITTER * rng.standard_normal((REPEATS, len(SPP))))
        # one reference for all runs of an experiment: its seed is that of the pair
        sigma = self.reference * self.deviation * SPP[-1] ** self.power
        squares = np.square(noise - sigma * np.random.default_rng([1, seed // 2]).standard_normal(sigma.shape))
        shared = np.sqrt(2.0 * np.mean(sigma**4) / sigma.size)
        tail = tail_of(squares[:, -1].reshape(REPEATS, -1))
        relmse = squares.mean(axis=(2, 3)) - np.mean(sigma**2)
        return Runs(seconds, relmse, self.law, doubt=tail.doubt, unseen=tail.unseen, shared=float(shared))


@cache
def pooled(renderer: Renderer) -> Runs:
    """Return many runs, whose medians are those of typical runs to a few thousandths of a time's logarithm."""
    parts = [renderer.runs(1_000_000 + 2 * number) for number in range(POOLED)]
    seconds, relmse = (np.concatenate([getattr(part, name) for part in parts]) for name in ("seconds", "relmse"))
    return Runs(seconds, relmse, renderer.law)


@cache
def typical_time(renderer: Renderer, target: float) -> float:
    """Return the time at which half of all runs have this error."""
    return float(np.exp(np.median(log_times(pooled(renderer), target))))


def gaussian(rng: np.random.Generator, count: int, shape: tuple[int, ...]) -> Array:
    return np.asarray(np.sqrt(count) * rng.standard_normal(shape))


def pareto(index: float) -> Callable[[np.random.Generator, int, tuple[int, ...]], Array]:
    """Return samples with a power tail and finite variance (index above 2); squared errors have half the index."""
    mean = index / (index - 1.0)
    deviation = np.sqrt(index / (index - 2.0)) / (index - 1.0)

    def draw(rng: np.random.Generator, count: int, shape: tuple[int, ...]) -> Array:
        values: Array = (1.0 + rng.pareto(index, (count, *shape)) - mean) / deviation
        return np.asarray(values.sum(axis=0))

    return draw


def rare(probability: float) -> Callable[[np.random.Generator, int, tuple[int, ...]], Array]:
    """Return samples that are 0 but for a few, which are all alike: a light that is found by chance."""

    def draw(rng: np.random.Generator, count: int, shape: tuple[int, ...]) -> Array:
        found = rng.binomial(count, probability, shape)
        return np.asarray((found - count * probability) / np.sqrt(probability * (1.0 - probability)))

    return draw


def firefly(probability: float, size: float) -> Callable[[np.random.Generator, int, tuple[int, ...]], Array]:
    """Return normal samples, and with a tiny probability one that is larger by ``size`` standard deviations."""

    def draw(rng: np.random.Generator, count: int, shape: tuple[int, ...]) -> Array:
        met = rng.binomial(count, probability, shape)
        return gaussian(rng, count, shape) + size * (met - count * probability)

    return draw


@dataclass(frozen=True)
class Case:
    """An interval and what it should hold."""

    kind: str
    interval: Interval
    truth: float
    logarithmic: bool = True

    @property
    def wrong(self) -> bool:
        """Whether what is said of the truth is not so: by both ends if they are trusted, else by the one that holds."""
        low, high = self.interval.low, self.interval.high
        if self.interval.trusted:
            return not low <= self.truth <= high
        return {"low": low > self.truth, "high": high < self.truth}.get(self.interval.bound, False)

    def holds(self, narrow: float = 1.0) -> bool:
        """Tell whether the interval, made narrower about its value, holds the truth."""
        if narrow == 1.0:
            return self.interval.low <= self.truth <= self.interval.high
        ends = np.array([self.interval.low, self.interval.value, self.interval.high])
        if not np.isfinite(ends).all() or (self.logarithmic and not (ends > 0.0).all()):
            return bool(ends[0] <= self.truth <= ends[2])
        low, value, high = np.log(ends) if self.logarithmic else ends
        truth = np.log(self.truth) if self.logarithmic else self.truth
        return bool(value + narrow * (low - value) <= truth <= value + narrow * (high - value))


SPEED_UP = 3.0
_FAR = 2000.0
"""Samples of an error that is read off the law: 31 times the longest run; beyond 100 times no number is given."""


def _time(renderer: Renderer, runs: Runs, spp: float, kind: str = "time") -> Case:
    """Return the time to the error that is expected after ``spp`` samples; of typical runs where it says so."""
    target = renderer.error(spp)
    found = time_to_error(runs, target)
    return Case(kind, found, typical_time(renderer, target) if TYPICAL in found.note else spp)


def typical_error(renderer: Renderer, spp: float) -> float:
    """Return the error that typical runs have after so many samples, if it falls by the renderer's power."""
    end = float(np.median(pooled(renderer).relmse[:, -1])) ** 0.5
    return end * (spp / float(SPP[-1])) ** renderer.power


def cases_of_typical_runs(renderer: Renderer, seeds: Iterable[int]) -> tuple[list[Case], list[Case]]:
    """Return times of typical runs, within the runs and beyond, and speed-ups; the same by the mean over repeats."""
    found, by_mean = list[Case](), list[Case]()
    for seed in seeds:
        runs, slow = renderer.runs(2 * seed), renderer.runs(2 * seed + 1, 1.0 / SPEED_UP)
        for kind, spp in (("within", 40.0), ("beyond", 256.0)):
            target = typical_error(renderer, spp)
            truth = typical_time(renderer, target)
            found.append(Case(kind, time_to_error(runs, target), truth))
            by_mean.append(Case(kind, _time_by_mean(runs, target), truth))
            found.append(Case("speed-up", speed_up(slow, runs, target), SPEED_UP))
            by_mean.append(Case("speed-up", _speed_up_by_mean(slow, runs, target), SPEED_UP))
    return found, by_mean


def _time_by_mean(runs: Runs, target: float) -> Interval:
    """Return the time to an error by the mean over repeats, whatever they are: what one firefly moves.

    A time beyond a hundred times the longest run is at least that, by the estimate alone. Under heavy tails the lower
    end is all that is said.
    """
    value, end = log_time(runs, target, np.ones(runs.repeats)), float(np.log(runs.seconds[:, -1].mean()))
    if value > end + np.log(FARTHEST_REACH):
        found = Interval(np.inf, exp(end + (0.0 if np.isinf(value) else np.log(FARTHEST_REACH))), np.inf)
    else:
        found = interval_of(lambda kept, off: log_time(runs.moved(off), target, kept), runs.repeats).map(exp)
    return found.bounded("low", runs.tail) if runs.tail else found


def _speed_up_by_mean(slow: Runs, runs: Runs, target: float) -> Interval:
    """Return the ratio of such times; of two of which no more than lower ends hold nothing is said."""
    first, second = _time_by_mean(slow, target), _time_by_mean(runs, target)
    if np.isinf(first.value) and np.isinf(second.value):
        return UNKNOWN
    if np.isinf(first.value):
        found = Interval(np.inf, first.low / second.high, np.inf)
    elif np.isinf(second.value):
        found = Interval(0.0, 0.0, first.high / second.low)
    else:
        ratio = interval_of(lambda kept, _: log_time(slow, target, kept) - log_time(runs, target, kept), runs.repeats)
        found = ratio.map(exp)
    found = found.bounded("low", slow.tail) if slow.tail else found
    return found.bounded("high", runs.tail) if runs.tail else found


def cases(renderer: Renderer, seeds: Iterable[int]) -> list[Case]:
    """Return, for each seed, every kind of interval that experiments report."""
    found = []
    for seed in seeds:
        runs, slow = renderer.runs(2 * seed), renderer.runs(2 * seed + 1, 1.0 / SPEED_UP)
        for spp in (10.0, 40.0):
            target = renderer.error(spp)
            found.append(_time(renderer, runs, spp))
            found.append(Case("speed-up", speed_up(slow, runs, target), SPEED_UP))
            found.append(Case("error", error_at(runs, spp), target))
        found.append(_time(renderer, runs, 256.0, "extrapolated"))
        if renderer.law:
            far = renderer.error(_FAR)
            found += [Case("law", time_to_error(runs, far), _FAR), Case("law", speed_up(slow, runs, far), SPEED_UP)]
        found.append(Case("checkpoint", error_curve(runs)[6], renderer.error(float(SPP[6]))))
        found.append(Case("slope", slope(runs), renderer.power, logarithmic=False))
    return found
