"""How many spellings are tried: 200 every day, 10,000 in the slow suite; the same ones each time."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

EVERYDAY, SLOW = 200, 10_000
Test = TypeVar("Test", bound=Callable[..., None])
sizes: Callable[[Test], Test] = pytest.mark.parametrize(
    "examples", [EVERYDAY, pytest.param(SLOW, marks=pytest.mark.slow)]
)
"""Marks a test that calls `try_spellings` with the argument ``examples``."""


def try_spellings(check: Callable[[Random], object], examples: int) -> None:
    """Call `check` with so many sources of choices; of one that fails, Hypothesis shows the seed."""

    @settings(max_examples=examples, deadline=None, database=None, derandomize=True)
    @given(seed=st.integers(0, 2**32 - 1))
    def each(seed: int) -> None:
        check(Random(seed))

    each()
