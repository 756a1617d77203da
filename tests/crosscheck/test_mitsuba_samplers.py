"""Some of Mitsuba's samplers have a mean of their own on the shipped Cornell box: `UNFIT_SAMPLERS` has their names.

The bias grows with the length of paths. All comparisons that expect agreement have together a false-alarm rate of
0.1 %; the unfit samplers are the power twins.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime.experiments.peers.common import with_box_filter
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.images.mitsuba_reference import UNFIT_SAMPLERS, fit_sampler
from equaltime.statistics.agreement import LEVEL, share

pytest.importorskip("mitsuba")

FILE = Path(__file__).parents[2] / "scenes" / "mitsuba" / "cornell-box" / "scene.xml"
SEEDS = 64
FIT = {"independent": 16, "multijitter": 16, "orthogonal": 16}
"""Samplers and samples a pixel."""
EACH = share(LEVEL, len(FIT) + 1)


def box(side: int) -> et.Scene:
    return with_box_filter(et.load(FILE, integrator="path", resx=side, resy=side))


@cache
def ours(side: int) -> NDArray[np.float64]:
    """Return the mean of each of our images."""
    scene = box(side)
    return np.array([et.render(scene, spp=64, seed=seed).image.mean(dtype=np.float64) for seed in range(SEEDS)])


def p_of(sampler: str, side: int, spp: int) -> float:
    """Return the p-value of equal means of Mitsuba's images with a sampler and of ours."""
    peer = MitsubaPeer(sampler, "scalar_rgb", sampler=sampler)
    try:
        peer.prepare(box(side), 0)
        checkpoints = [next(peer.run(seed, (spp,))) for seed in range(SEEDS)]
    finally:
        peer.close()
    means = np.array([checkpoint.image.mean(dtype=np.float64) for checkpoint in checkpoints])
    found = stats.ttest_ind(means, ours(side), equal_var=False)
    ratio, error = means.mean() / ours(side).mean(), np.hypot(means.std(), ours(side).std()) / ours(side).mean() / 8
    print(f"{sampler} {spp}: {ratio - 1:+.5f} +- {error:.5f}, t {found.statistic:+.1f}")
    return float(found.pvalue)


@pytest.mark.parametrize("sampler", FIT)
def test_a_sampler_that_makes_references_has_our_mean(sampler: str) -> None:
    assert fit_sampler(sampler) == sampler
    assert p_of(sampler, 32, FIT[sampler]) > EACH


def test_stratified_numbers_have_another_mean_at_four_samples() -> None:
    assert "stratified" in UNFIT_SAMPLERS
    assert p_of("stratified", 32, 4) < EACH


@pytest.mark.slow
def test_ldsampler_has_another_mean_and_multijitter_has_not() -> None:
    assert "ldsampler" in UNFIT_SAMPLERS
    assert p_of("ldsampler", 64, 64) < EACH
    assert p_of("multijitter", 64, 64) > EACH
