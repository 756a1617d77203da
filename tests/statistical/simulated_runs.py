"""Runs of made-up renderers whose expected error is known: what intervals are tested against."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from equaltime.cost.curves import Runs, error_at, error_curve, slope, time_to_error
from equaltime.cost.ratios import speed_up
from equaltime.cost.statistics import Interval
from equaltime.cost.tails import tail_of

Array = NDArray[np.float64]

SPP = np.array([2, 4, 6, 8, 12, 16, 24, 32, 48, 64])
REPEATS = 8
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


@dataclass(frozen=True)
class Case:
    """An interval and what it should hold."""

    kind: str
    interval: Interval
    truth: float
    logarithmic: bool = True

    def holds(self, narrow: float = 1.0) -> bool:
        """Tell whether the interval, made narrower about its value, holds the truth."""
        if narrow == 1.0:
            return self.interval.low <= self.truth <= self.interval.high
        ends = np.array([self.interval.low, self.interval.value, self.interval.high])
        low, value, high = np.log(ends) if self.logarithmic else ends
        truth = np.log(self.truth) if self.logarithmic else self.truth
        return bool(value + narrow * (low - value) <= truth <= value + narrow * (high - value))


SPEED_UP = 3.0


def cases(renderer: Renderer, seeds: Iterable[int]) -> list[Case]:
    """Return, for each seed, every kind of interval that experiments report."""
    found = []
    for seed in seeds:
        runs, slow = renderer.runs(2 * seed), renderer.runs(2 * seed + 1, 1.0 / SPEED_UP)
        for spp in (10.0, 40.0):
            target = renderer.error(spp)
            found.append(Case("time", time_to_error(runs, target), spp))
            found.append(Case("speed-up", speed_up(slow, runs, target), SPEED_UP))
            found.append(Case("error", error_at(runs, spp), target))
        found.append(Case("extrapolated", time_to_error(runs, renderer.error(256.0)), 256.0))
        if renderer.law:
            far = renderer.error(1e5)
            found += [Case("law", time_to_error(runs, far), 1e5), Case("law", speed_up(slow, runs, far), SPEED_UP)]
        found.append(Case("checkpoint", error_curve(runs)[6], renderer.error(float(SPP[6]))))
        found.append(Case("slope", slope(runs), renderer.power, logarithmic=False))
    return found
