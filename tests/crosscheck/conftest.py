"""How the tests here tell whether two renderers agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime import crosscheck

Array = NDArray[np.float64]
BLOCK = 4
SEEDS = 16
ROUNDING = 2e-6
"""What float32 may do to a mean that has no noise, relative."""


@pytest.fixture
def scalar_mitsuba() -> Iterator[None]:
    """Choose Mitsuba's variant that starts at once, and give back the one that other tests chose."""
    mi = pytest.importorskip("mitsuba")
    chosen = mi.variant()
    mi.set_variant("scalar_rgb")
    yield
    if chosen:
        mi.set_variant(chosen)


@pytest.fixture
def agreement() -> Callable[..., float]:
    return _agreement


def _agreement(scene: et.Scene, spp: int, core: et.Scene | None = None, strategy: str = "best") -> float:
    """Return the p-value of the hypothesis that core and cross-check have the same expected image.

    The core renders `core` (else the same scene) with 16 seeds, the cross-check the scene once. Blocks of 4x4 pixels
    are compared by Welch's test. Three looks at the results share the false alarms: the worst of all blocks and
    channels (Bonferroni), the mean over the blocks, which sees a small bias everywhere, and how they are distributed
    (Kolmogorov-Smirnov), which sees wrong standard errors too.
    """
    mean, variance = crosscheck.render(scene, spp, seed=1)
    images = [
        et.render(core or scene, spp=spp // 4, seed=s, strategy=strategy).image.astype(np.float64) for s in range(SEEDS)
    ]
    z = _block_z(mean, variance, images)
    if z is None:
        return 0.0
    brightest = z[:, int(np.argmax(mean.sum(axis=(0, 1))))]
    worst = z.size * 2.0 * stats.norm.sf(np.abs(z).max())
    everywhere = 2.0 * stats.norm.sf(abs(brightest.mean()) * math.sqrt(brightest.size))
    p = np.array([worst, everywhere, stats.kstest(brightest, stats.norm.cdf).pvalue])
    assert np.isfinite(p).all()
    return min(1.0, 3.0 * float(p.min()))


def _block_z(mean: Array, variance: Array, images: list[Array]) -> Array | None:
    """Return the blocks' differences as normal deviates, (blocks, channels).

    Blocks without any noise (background) must be equal and are left out; None if they are not.
    """
    ours, error = _blocks(mean), _blocks(variance) / BLOCK**2
    theirs = np.stack([_blocks(image) for image in images])
    theirs_error = theirs.var(axis=0, ddof=1) / len(images)
    difference, rounding = ours - theirs.mean(axis=0), ROUNDING * ours
    noisy = (np.sqrt(error + theirs_error) > rounding).all(axis=1)
    if (np.abs(difference) > rounding)[~noisy].any():
        return None
    error, theirs_error, difference = error[noisy], theirs_error[noisy], difference[noisy]
    total = error + theirs_error
    degrees = total**2 / np.maximum(theirs_error**2 / (len(images) - 1), 1e-9 * total**2)
    tail = stats.t.sf(np.abs(difference) / np.sqrt(total), degrees)
    return np.asarray(-np.sign(difference) * stats.norm.ppf(np.maximum(tail, 1e-300)))


def _blocks(image: Array) -> Array:
    """Return the means of blocks of pixels, (blocks, channels); what is left over at the right and below is dropped."""
    rows, columns = image.shape[0] // BLOCK, image.shape[1] // BLOCK
    cut = image[: rows * BLOCK, : columns * BLOCK]
    return np.asarray(cut.reshape(rows, BLOCK, columns, BLOCK, -1).mean(axis=(1, 3)).reshape(rows * columns, -1))
