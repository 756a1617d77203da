"""The variance of one sample: pooled over replicates, and of the render, not of its mean."""

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


def test_the_variance_of_a_sample_does_not_fall_with_their_number() -> None:
    scene = et.load("cornell-box").with_(size=(24, 24))
    few, many = (et.render(scene, spp=spp, strategy="best,sampler=independent,adaptive=none") for spp in (32, 512))
    assert few.variance is not None
    assert many.variance is not None
    ratio = float(many.variance.sum() / few.variance.sum())
    assert 1.0 / 3.0 < ratio < 3.0, "the variances of means would be 16 times apart"
