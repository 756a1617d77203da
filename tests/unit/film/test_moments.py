"""Moments: the variance of one sample, pooled over replicates, of a render and not of its mean."""

from __future__ import annotations

import numpy as np

import equaltime as et
from equaltime.film.moments import DTYPE, sample_variance, stored


def test_deviations_are_pooled_over_replicates() -> None:
    rng = np.random.default_rng(5)
    parts = rng.exponential(size=(10, 4, 5, 3)), 3.0 + rng.exponential(size=(7, 4, 5, 3))
    moments = np.zeros((2, 4, 5), DTYPE)
    for replicate, samples in zip(moments, parts, strict=True):
        replicate["mean"], replicate["count"] = samples.mean(axis=0), len(samples)
        replicate["deviation"] = stored(samples.std(axis=0))
    sums = sum(len(samples) * samples.var(axis=0) for samples in parts)
    np.testing.assert_allclose(sample_variance(moments), sums / 15.0, rtol=2.0**-19)


def test_a_sample_in_each_replicate_tells_no_variance() -> None:
    moments = np.zeros((2, 1, 2), DTYPE)
    moments["count"] = [[[1, 0]], [[1, 0]]]
    assert np.isinf(sample_variance(moments)).all()


def test_the_variance_of_a_render_is_that_of_its_samples() -> None:
    """The samples of two pixels are traced again, one by one; sample i belongs to replicate i mod 2."""
    scene = et.load("cornell-box").with_(size=(8, 8))
    strategy, spp = "best,sampler=independent,adaptive=none", 12
    found = et.render(scene, spp=spp, strategy=strategy, seed=3).variance
    assert found is not None
    for x, y in ((2, 5), (6, 3)):
        traced = [et.replay(scene, pixel=(x, y), sample=i, strategy=strategy, seed=3).radiance for i in range(spp)]
        parts = [np.array(traced[first::2]) for first in (0, 1)]
        pooled = sum(part.var(axis=0) * len(part) for part in parts) / (spp - 2)
        np.testing.assert_allclose(found[y, x], pooled, rtol=2.0**-18)
        assert not np.allclose(found[y, x], np.var(traced, axis=0), rtol=1e-3)
