"""The soak, for as long as an everyday test may take; and that it would see what it is there for."""

from __future__ import annotations

import numpy as np
import pytest

from .soak import LEVEL, MOST_GROWTH, SCENES, Soaked, drift, growth, shipped, soak


@pytest.mark.parametrize("name", ["hard/glass.toml", "hard/furnace-box.toml", "cornell-box.toml"])
def test_scenes_soak_without_a_fault(name: str) -> None:
    assert SCENES / name in set(shipped())
    found = soak(SCENES / name, 150_000, threads=2)
    assert found.passes(LEVEL / 100), found
    assert found.samples >= 130_000


def test_a_drift_is_seen() -> None:
    """The twin: the second half brighter by two standard errors of one render, over 256 renders."""
    rng = np.random.default_rng(1)
    means = rng.normal(1.0, 0.01, 256)
    assert drift(means.tolist()) > LEVEL
    means[128:] += 0.008
    assert drift(means.tolist()) < LEVEL / 100


def test_a_leak_and_a_bad_sample_are_seen() -> None:
    """The twin: 200 kB a render."""
    assert growth([100 << 20] * 100) == 0
    assert growth([(100 << 20) + 200_000 * i for i in range(100)]) > MOST_GROWTH
    assert not Soaked(100, 1, 0, 0.5, 1.0).passes(LEVEL)
    assert not Soaked(100, 0, 0, LEVEL / 2, 1.0).passes(LEVEL)
