"""How many spellings are tried: 200 every day, 10,000 in the slow suite; the same ones each time."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import equaltime as et

EVERYDAY, SLOW = 200, 10_000
Test = TypeVar("Test", bound=Callable[..., None])
sizes: Callable[[Test], Test] = pytest.mark.parametrize(
    "examples", [EVERYDAY, pytest.param(SLOW, marks=pytest.mark.slow)]
)
"""Marks a test that calls `try_spellings` with the argument ``examples``."""


def try_spellings(check: Callable[[Random], object], examples: int) -> None:
    """Call `check` with so many sources of choices; of one that fails, Hypothesis shows the seed."""

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow],
    )
    @given(seed=st.integers(0, 2**32 - 1))
    def each(seed: int) -> None:
        check(Random(seed))

    each()


def assert_same_scenes(rewritten: Callable[[Random], et.Scene], original: et.Scene, examples: int) -> None:
    """Check that other spellings of `original` are the same scene, and that nothing is told of either."""

    def check(random: Random) -> None:
        scene = rewritten(random)
        assert (scene.digest, scene.warnings) == (original.digest, ())

    try_spellings(check, examples)


def assert_same_pictures(rewritten: Callable[[Random], et.Scene], original: et.Scene) -> None:
    """Check that pictures of three other spellings of `original` have its bits."""
    image = et.render(original, spp=4).image
    for seed in range(3):
        assert np.array_equal(et.render(rewritten(Random(seed)), spp=4).image, image)
