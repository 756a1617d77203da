"""Whether samples follow the density that their sampler states: a χ² test on a chart of the directions.

A chart maps the unit square to directions. It is cut into 24 by 24 cells; each cell's expected count comes from the
stated density, integrated over the cell at jittered points, four times; how far the four differ widens the cell's
variance. (A regular grid would go wrong where the edge of the domain runs along it, as it does at grazing incidence.)
Four looks at one histogram share the false alarms:

- *fine*: all cells, which sees a mistake in one place, such as a ring near the horizon;
- *coarse*: 3 by 3 cells joined, which sees a mistake of some width;
- *lean*: the samples' mean place in the square, which sees a density that is tilted by 2 %;
- *total*: how many samples there are at all against the density's integral, which sees a density scaled by 1.02.

A sampler may reject some of its samples; the rest must then be as many as the density integrates to.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from equaltime.statistics.agreement import share, sidak

__all__ = ["LEVEL", "SAMPLES", "Chart", "Histogram", "Masses", "chi_square", "share", "sidak", "uniforms"]

Array = NDArray[np.float64]
Density = Callable[[Array], Array]
"""Of directions (N, 3), per solid angle."""

LEVEL = 0.001
"""The false-alarm rate of all the χ² tests of one file together."""
SAMPLES = 1 << 20
"""Enough to see a density tilted by 2 %: it moves the mean place by 12 standard errors."""
CELLS, JOINED, POINTS, REPEATS = 24, 3, 9, 4
LEAST_EXPECTED = 10.0
ROUNDING = 1e-6
"""What float32 may do to the integral of a density."""


class Chart(Protocol):
    def directions(self, square: Array) -> tuple[Array, Array]:
        """Return the directions of places (N, 2) and their solid angle per unit of area; 0 outside the domain."""
        ...

    def places(self, directions: Array) -> Array:
        """Return where directions (N, 3) lie in the unit square."""
        ...


def uniforms(count: int, columns: int, seed: int) -> Array:
    """Return numbers as the samplers make them: multiples of 2^-24 in [0, 1)."""
    return np.random.default_rng(seed).integers(0, 1 << 24, (count, columns)) * 2.0**-24


@dataclass(frozen=True, eq=False)
class Masses:
    """The integrals of a density over the cells of a chart."""

    chart: Chart
    density: Density
    points: int = POINTS
    """Along each side of a cell."""

    @cached_property
    def _repeats(self) -> Array:
        rng, side = np.random.default_rng(0), CELLS * self.points
        corners = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
        return np.stack([self._once((corners + rng.random(corners.shape)) / side) for _ in range(REPEATS)])

    def _once(self, square: Array) -> Array:
        directions, jacobian = self.chart.directions(square)
        values = np.zeros(len(square))
        inside = jacobian > 0
        values[inside] = self.density(directions[inside]) * jacobian[inside]
        cells: Array = values.reshape(CELLS, self.points, CELLS, self.points).mean(axis=(1, 3)) / CELLS**2
        return cells

    @property
    def cells(self) -> Array:
        cells: Array = self._repeats.mean(axis=0)
        return cells

    @property
    def doubt(self) -> Array:
        """The standard error of each cell's integral."""
        error: Array = self._repeats.std(axis=0, ddof=1) / math.sqrt(REPEATS)
        return error

    @property
    def total(self) -> float:
        return float(self.cells.sum())

    def changed(self, change: Callable[[Array, Array], Array], keep_total: bool = False) -> Masses:
        """Return the masses of a wrong density, for power twins: `change` gets densities and directions."""
        wrong = Masses(self.chart, lambda wi: change(self.density(wi), wi), self.points)
        if not keep_total:
            return wrong
        factor = self.total / wrong.total
        return Masses(self.chart, lambda wi: factor * change(self.density(wi), wi), self.points)


@dataclass(frozen=True, eq=False)
class Histogram:
    """Where the samples of a sampler fell; `drawn` counts the rejected ones too."""

    counts: Array
    drawn: int
    looks: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, chart: Chart, directions: Array, drawn: int) -> Histogram:
        index = np.clip((chart.places(directions) * CELLS).astype(int), 0, CELLS - 1)
        counts = np.bincount(index[:, 0] * CELLS + index[:, 1], minlength=CELLS**2)
        return cls(counts.reshape(CELLS, CELLS).astype(float), drawn)

    def p(self, masses: Masses) -> float:
        """Return the p-value of the hypothesis that the samples have these masses."""
        expected, doubt = self.drawn * masses.cells, self.drawn * masses.doubt
        self.looks.update(
            fine=chi_square(self.counts, expected, doubt),
            coarse=chi_square(_join(self.counts), _join(expected), np.sqrt(_join(doubt**2))),
            lean=min(1.0, 2.0 * min(self._lean(masses, axis) for axis in (0, 1))),
            total=self._total(masses),
        )
        return sidak(min(self.looks.values()), len(self.looks))

    def _lean(self, masses: Masses, axis: int) -> float:
        """Return the two-sided p-value of the mean place along an axis."""
        place = (np.arange(CELLS) + 0.5) / CELLS
        counts, mass = self.counts.sum(axis=1 - axis), masses.cells.sum(axis=1 - axis)
        mean = float(mass @ place / mass.sum())
        from_mean = place - mean
        doubt = float((masses.doubt**2).sum(axis=1 - axis) @ from_mean**2) / masses.total**2
        variance = float(mass @ from_mean**2 / mass.sum()) / counts.sum() + doubt + ROUNDING**2
        return 2.0 * float(stats.norm.sf(abs(float(counts @ from_mean)) / counts.sum() / math.sqrt(variance)))

    def _total(self, masses: Masses) -> float:
        """Return the two-sided p-value of the number of samples that were not rejected."""
        rate, doubt = masses.total, float((masses.doubt**2).sum()) + ROUNDING**2
        variance = self.drawn * max(rate * (1.0 - rate), 0.0) + self.drawn**2 * doubt
        return 2.0 * float(stats.norm.sf(abs(self.counts.sum() - self.drawn * rate) / math.sqrt(variance)))


def _join(cells: Array) -> Array:
    joined: Array = cells.reshape(CELLS // JOINED, JOINED, CELLS // JOINED, JOINED).sum(axis=(1, 3))
    return joined


def chi_square(counts: Array, expected: Array, doubt: Array | float = 0.0) -> float:
    """Return the p-value of Pearson's statistic; cells that expect fewer than ten are put together.

    `doubt` is the standard error of the expected counts. Cells are taken as independent, with a degree of freedom each:
    the number of samples that were rejected is free. Where none can be, that is one degree too many, and safe.
    """
    counts, expected, doubt = (np.broadcast_to(x, expected.shape).ravel() for x in (counts, expected, doubt))
    order = np.argsort(expected)
    running = np.cumsum(expected[order])
    few = int((expected < LEAST_EXPECTED).sum())
    groups = int(running[few - 1] // LEAST_EXPECTED) if few else 0  # of cells that expect few samples
    label = np.empty(order.size, dtype=int)
    label[order[:few]] = np.minimum(running[:few] // LEAST_EXPECTED, max(groups - 1, 0))
    label[order[few:]] = groups + np.arange(order.size - few)
    counts, expected, doubt = (np.bincount(label, weights=x) for x in (counts, expected, doubt))
    statistic = ((counts - expected) ** 2 / (expected + doubt**2)).sum()
    return float(stats.chi2.sf(statistic, expected.size))
