"""One build, one image: no bit of a shipped scene depends on threads, tiles, passes, time limits or the crop.

The renders compared are of the same scene, strategy, sample range and seed; they are compared byte by byte.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise, product
from typing import Any, Final

import pytest

from .shipped import FILES, SIZE, Moments, renderer, same_bits, shipped

SAMPLES: Final = 11
"""Odd: the two replicates have different counts."""
SPLITS: Final = [(SAMPLES,), (1, 2, 3, 10, SAMPLES), (7, SAMPLES)]
SCHEDULES: Final = list(product([1, 2, 3, 7], [1, 5, 16, 64]))
STRATEGIES: Final[dict[str, dict[str, Any]]] = {
    "best": {},
    "independent": {"sampler": "independent"},
    "bsdf": {"technique": "bsdf"},
    "light": {"technique": "light", "lights": "uniform", "roulette": "none"},
    "naive": {"technique": "uniform", "roulette": "albedo", "sampler": "independent"},
    "mixture": {"technique": "mixture", "roulette": "constant"},
    "lights by the tree": {"lights": "tree", "sampler": "stratified"},
    "lattice": {"sampler": "lattice"},
}


@cache
def reference(file: str, strategy: str) -> Moments:
    """Return what one thread makes of the whole film at once, in one tile."""
    return rendered(file, strategy, threads=1, tile=1000)


def rendered(file: str, strategy: str = "best", split: tuple[int, ...] = (SAMPLES,), **schedule: int) -> Moments:
    subject = renderer(shipped(file).core, **schedule, **STRATEGIES[strategy])
    for samples in split:
        assert subject.advance(samples)
    assert not subject.nonfinite
    return subject.moments.copy()


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("file", FILES)
def test_threads_tiles_and_passes_leave_every_bit_where_it_is(file: str, strategy: str) -> None:
    core = shipped(file).core
    assert reference(file, strategy)["mean"].mean() > 0.01
    for (threads, tile), split in product(SCHEDULES, SPLITS):
        subject = renderer(core, threads=threads, tile=tile, **STRATEGIES[strategy])
        for samples in split:
            assert subject.advance(samples)
        assert same_bits(subject.moments, reference(file, strategy)), (threads, tile, split)


@pytest.mark.parametrize("file", FILES)
def test_another_seed_or_a_sample_less_does_change_bits(file: str) -> None:
    """The twin."""
    assert not same_bits(rendered(file, seed=6), reference(file, "best"))
    assert not same_bits(rendered(file, split=(SAMPLES - 1,)), reference(file, "best"))


@pytest.mark.parametrize("crop", [(0, 0, 9, 7), (7, 3, 11, 9), (23, 15, 1, 1), (0, 8, 24, 8)])
@pytest.mark.parametrize("file", FILES)
def test_a_crop_has_the_bits_of_the_whole(file: str, crop: tuple[int, int, int, int]) -> None:
    x, y, width, height = crop
    subject = renderer(shipped(file, crop).core, threads=3, tile=5)
    assert subject.advance(SAMPLES)
    assert subject.moments.shape == (2, height, width)
    assert same_bits(subject.moments, reference(file, "best")[:, y : y + height, x : x + width])


@pytest.mark.parametrize("file", FILES)
def test_a_crop_is_not_an_image_of_its_size(file: str) -> None:
    """The twin: pixels are keyed by their place in the whole film."""
    crop = renderer(shipped(file, (1, 0, SIZE[0] - 1, SIZE[1])).core)
    assert crop.advance(SAMPLES)
    assert not same_bits(crop.moments, reference(file, "best")[:, :, : SIZE[0] - 1])


@pytest.mark.parametrize("threads", [1, 2, 7])
@pytest.mark.parametrize("file", FILES)
def test_passes_that_a_clock_cuts_go_on_where_they_stopped(file: str, threads: int) -> None:
    subject = renderer(shipped(file).core, threads=threads, tile=5)
    cuts, limit = 0, 1e-4
    while not subject.advance(SAMPLES, seconds=limit):
        cuts += 1
        limit *= 1.02  # on a machine that is busy elsewhere nothing may be done in time, again and again
    assert cuts > 0, "the limit was too long to test anything"
    assert same_bits(subject.moments, reference(file, "best"))


@pytest.mark.parametrize("threads", [1, 2, 7])
@pytest.mark.parametrize("file", FILES)
def test_passes_that_pause_go_on_and_come_to_the_end_however_short_their_runs(file: str, threads: int) -> None:
    subject = renderer(shipped(file).core, threads=threads, tile=5)
    begun = [0]
    while not subject.advance(SAMPLES, pause=0.0):
        begun.append(int(subject.moments["count"].sum()))
    assert len(begun) > 1, "it never paused"
    assert all(a < b for a, b in pairwise(begun)), "a pause that nothing was done before"
    assert same_bits(subject.moments, reference(file, "best"))


@pytest.mark.parametrize("file", FILES)
def test_passes_that_a_caller_ends_go_on_where_they_stopped(file: str) -> None:
    samples = 2001
    subject, whole = renderer(shipped(file).core), renderer(shipped(file).core, threads=1)
    assert not subject.advance(samples, poll=lambda: False), "ended before it was asked"
    assert subject.moments["count"].sum() < samples * SIZE[0] * SIZE[1]
    assert subject.advance(samples)
    assert whole.advance(samples)
    assert same_bits(subject.moments, whole.moments)
