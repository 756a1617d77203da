"""Maps of one scene: error and standard error of each pixel, and the blocks of pixels that cause most of the error.

All errors are relative as in `metrics.contributions`: the mean of a map's squared values is the image's squared error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.images.metrics import Reference, contributions

__all__ = ["LEVEL", "Losses", "error_map", "losses", "spread_map", "squares"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEVEL = 0.001
"""Significance level at which a block is called worse or better."""
_BLOCKS = 28
_FEWEST = 3


def squares(runs: NDArray[Any], reference: Reference) -> Floats:
    """Return the relative squared error of each pixel (K, H, W) of the K images in ``runs`` (K, H, W, 3).

    The reference's own noise is subtracted, so that a value may be negative by chance.
    """
    return np.stack([contributions(run, reference) for run in runs])


def error_map(pixels: Floats) -> Floats:
    """Return the relative error of each pixel (H, W): the root of its mean squared error over K runs.

    ``pixels`` are the squared errors (K, H, W) from `squares`.
    """
    return np.asarray(np.sqrt(np.maximum(pixels.mean(axis=0), 0.0)))


def spread_map(runs: NDArray[Any], reference: Reference) -> Floats | None:
    """Return the relative standard error of each pixel of one run (H, W).

    The estimate comes from the spread over the K images in ``runs`` (K, H, W, 3).

    Returns None for fewer than two runs.
    """
    if len(runs) < 2:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = runs.var(axis=0, ddof=1, dtype=np.float64) / reference.denominator
    return np.asarray(np.sqrt(np.nan_to_num(relative, posinf=0.0).mean(axis=2)))


@dataclass(frozen=True, eq=False)
class Losses:
    """Distribution of a strategy's error over square blocks of pixels.

    Each array has one value per block: (rows of blocks, columns of blocks).
    """

    block: int
    """Side of a block in pixels; the last block of a row or column may be smaller."""
    half: Flags
    """The fewest blocks that make up half of the squared error."""
    half_area: float
    """Share of the image that the blocks of ``half`` cover, in [0, 1]."""
    ratio: Floats | None
    """Error over the baseline's at equal time; None for the baseline itself."""
    worse: Flags | None
    better: Flags | None
    """Blocks that are significantly worse or better than the baseline's; None with fewer than three repeats."""

    def spread(self, flags: NDArray[np.generic], shape: tuple[int, ...]) -> NDArray[np.generic]:
        """Return an image in which each pixel has its block's value in ``flags``; ``shape`` is (height, width)."""
        return flags.repeat(self.block, axis=0).repeat(self.block, axis=1)[: shape[0], : shape[1]]


def losses(own: Floats, baseline: Floats | None) -> Losses:
    """Return the blocks of pixels that make half of a strategy's squared error, and a comparison with the baseline.

    Parameters
    ----------
    own
        Squared errors of the strategy's pixels in K repeats, (K, H, W), scaled to equal render time.
    baseline
        Squared errors of the baseline's pixels, likewise; None if the strategy is the baseline.
    """
    block = max(1, math.ceil(max(own.shape[1:]) / _BLOCKS))
    mine = _block_sums(own, block)
    total = np.maximum(mine.mean(axis=0), 0.0)
    half = _fewest_that_make_half(total)
    area = _block_sums(np.ones((1, *own.shape[1:])), block)[0]
    half_area = float(area[half].sum() / area.sum())
    if baseline is None:
        return Losses(block, half, half_area, None, None, None)
    theirs = _block_sums(baseline, block)
    reference = np.maximum(theirs.mean(axis=0), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(total / reference)
    worse, better = _significant(mine, theirs) or (None, None)
    return Losses(block, half, half_area, ratio, worse, better)


def _block_sums(pixels: Floats, block: int) -> Floats:
    rows = np.add.reduceat(pixels, np.arange(0, pixels.shape[1], block), axis=1)
    return np.asarray(np.add.reduceat(rows, np.arange(0, pixels.shape[2], block), axis=2))


def _fewest_that_make_half(total: Floats) -> Flags:
    order = np.argsort(total, axis=None)[::-1]
    running = np.cumsum(total.ravel()[order])
    chosen = np.zeros(total.size, np.bool_)
    chosen[order[: int(np.searchsorted(running, 0.5 * running[-1])) + 1]] = running[-1] > 0.0
    return chosen.reshape(total.shape)


def _significant(mine: Floats, theirs: Floats) -> tuple[Flags, Flags] | None:
    """Compare blocks by Welch's t-test over repeats; return the blocks where the first is worse, and better."""
    if min(len(mine), len(theirs)) < _FEWEST:
        return None
    difference = mine.mean(axis=0) - theirs.mean(axis=0)
    own, other = mine.var(axis=0, ddof=1) / len(mine), theirs.var(axis=0, ddof=1) / len(theirs)
    from scipy import stats  # late: slow to import

    spread = own + other
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = spread**2 / (own**2 / (len(mine) - 1) + other**2 / (len(theirs) - 1))
        chance = 2.0 * stats.t.sf(np.abs(difference) / np.sqrt(spread), freedom)
    sure = np.nan_to_num(chance, nan=1.0) < LEVEL
    return sure & (difference > 0.0), sure & (difference < 0.0)
