"""C7: paths that lose nothing come to an end, without a bias; and nobody who stops a render waits for one."""

from __future__ import annotations

import subprocess
import sys
import time
from functools import cache
from typing import Any, Final

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.examples import scenes_folder

HARD: Final = scenes_folder() / "hard"
ENDLESS: Final = 1024
"""Segments, from which on a path without a limit of depth is ended at random."""
TRAP = """
import equaltime as et
from equaltime.examples import scenes_folder
scene = et.load(scenes_folder() / "hard" / "glass.toml", ior=1.5, eye=[-0.3, 0.5, 0.7]).with_(max_depth={})
et.render(scene.with_(size=(4, 4)), spp=4)
"""


def traced(max_depth: int, seconds: float) -> None:
    """Render in a process of its own from within a cube of glass, which holds much by total reflection."""
    subprocess.run([sys.executable, "-c", TRAP.format(max_depth)], check=True, timeout=seconds)


def test_C07_paths_that_glass_traps_come_to_an_end() -> None:  # noqa: N802
    traced(-1, 60.0)


def test_C07_without_the_roulette_of_endless_paths_they_would_not() -> None:  # noqa: N802
    """The twin: a limit of depth that nobody reaches, in place of none."""
    with pytest.raises(subprocess.TimeoutExpired):
        traced(2**31 - 2, 4.0)


@cache
def trap(max_depth: int) -> et.Scene:
    scene = et.load(HARD / "glass.toml", ior=1.5, eye=[-0.3, 0.5, 0.7])
    return scene.with_(size=(8, 8), max_depth=max_depth)


def renderer(max_depth: int, **options: Any) -> _core.Renderer:
    depth = max_depth if max_depth > 0 else -1
    settings = _core.Settings(roulette="none", sampler="independent", max_depth=depth)
    return _core.Renderer(trap(max_depth).core, settings, **{"seed": 3, "threads": 2, "tile": 4} | options)


def test_C07_endless_paths_are_as_long_as_their_roulette_says() -> None:  # noqa: N802
    """Of trapped paths half are longer than sqrt(2) 1024 segments, a quarter than 2048, and the mean is 2048."""
    subject = renderer(-1, tile=1, pixel_rays=True)
    lengths = []
    before = np.zeros((8, 8))
    for samples in range(1, 41):
        subject.advance(samples)
        rays = subject.pixel_rays.astype(np.float64)
        lengths.append(rays - before)
        before = rays
    trapped = np.concatenate([n[n >= ENDLESS] for n in lengths])
    assert trapped.size > 400
    for share, beyond in ((0.5, np.sqrt(2) * ENDLESS), (0.25, 2 * ENDLESS), (1 / 16, 4 * ENDLESS)):
        found = float((trapped > beyond).mean())
        limit = 4 * np.sqrt(share * (1 - share) / trapped.size)
        assert abs(found - share) < limit, (share, found)
        assert abs(0.8 * share - found) > limit or share < 0.25, "the twin: a fifth fewer"


def furnace(max_depth: int, seed: int) -> float:
    """Return the mean of mirrors that lose a 1024th of the light that they reflect, and shine with it."""
    scene = et.load(HARD / "furnace-mirrors.toml", max_depth=max_depth)
    return float(et.render(scene.with_(size=(4, 4)), spp=4, strategy="best,roulette=none", seed=seed).image.mean())


def test_C07_the_end_of_endless_paths_is_no_bias() -> None:  # noqa: N802
    """Mirrors send 1 - 2^-10 of the light on: 1 in all, of which paths of 1024 segments see 0.63."""
    means = np.array([furnace(-1, seed) for seed in range(20)])
    error = means.std(ddof=1) / np.sqrt(means.size)
    z = (means.mean() - 1.0) / error
    print(f"{means.mean():.4f} ± {error:.4f}")
    assert abs(z) < 4
    assert error < 0.05
    assert furnace(ENDLESS, 0) < 1.0 - 4 * error, "the twin: where they were simply cut"


def test_C07_a_limit_of_depth_is_kept_to_the_bit() -> None:  # noqa: N802
    """Nothing is ended at random where the scene itself has an end."""
    assert furnace(3000, 0) == pytest.approx(1.0 - (1.0 - 2.0**-10) ** 3000, rel=2e-6)


@pytest.mark.parametrize("threads", [1, 3])
def test_C07_a_long_path_does_not_hold_up_who_stops_the_render(threads: int) -> None:  # noqa: N802
    """Paths of this scene take minutes; the film holds finished blocks only, and nothing is counted twice."""
    subject = renderer(10**9, threads=threads)
    begin = time.perf_counter()
    assert not subject.advance(4, poll=lambda: False)
    assert time.perf_counter() - begin < 10.0
    assert subject.counters["paths"] == subject.moments["count"].sum()
    assert not subject.advance(4, seconds=0.05)
    assert subject.counters["paths"] == subject.moments["count"].sum()


def test_C07_what_was_given_up_is_made_anew_with_the_same_bits() -> None:  # noqa: N802
    whole = renderer(6000, threads=1, pixel_rays=True)
    assert whole.advance(4)
    subject = renderer(6000, threads=3, pixel_rays=True)
    limit = 1e-3
    while not subject.advance(4, seconds=limit):
        limit *= 1.5
    assert subject.moments.tobytes() == whole.moments.tobytes()
    assert (subject.pixel_rays == whole.pixel_rays).all()
    assert subject.counters == whole.counters


def test_C07_a_checkpoint_of_blocks_that_were_given_up_is_taken_up() -> None:  # noqa: N802
    whole = renderer(6000, threads=1)
    assert whole.advance(4)
    stopped = renderer(6000, threads=3)
    stopped.advance(4, seconds=0.01)
    subject = renderer(6000, threads=2)
    subject.moments[...] = stopped.moments
    rays = {name: stopped.counters[name] for name in ("paths", "rays", "shadow_rays")}
    subject.resume(**rays, position=stopped.position)
    assert subject.advance(4)
    assert subject.moments.tobytes() == whole.moments.tobytes()
    assert subject.counters == whole.counters


def test_C07_a_pause_waits_for_long_paths_and_so_comes_to_the_end_with_the_same_bits() -> None:  # noqa: N802
    whole = renderer(6000, threads=1)
    assert whole.advance(4)
    subject = renderer(6000, threads=3)
    pauses = 0
    while not subject.advance(4, pause=0.0):
        pauses += 1
    assert pauses > 0
    assert subject.moments.tobytes() == whole.moments.tobytes()
    assert subject.counters == whole.counters


def test_C07_a_pause_that_waits_for_a_long_path_does_not_hold_up_who_stops_the_render() -> None:  # noqa: N802
    """The calling thread sleeps when it is asked, until the other has come to a block of paths that take minutes."""
    scene = trap(10**9).with_(size=(512, 512), crop=(0, 0, 384, 32))
    settings = _core.Settings(roulette="none", sampler="independent", max_depth=10**9)
    subject = _core.Renderer(scene.core, settings, seed=3, threads=2, tile=32)
    asked: list[float] = []
    begin = time.perf_counter()

    def poll() -> bool:
        asked.append(time.perf_counter() - begin)
        time.sleep(max(0.0, 1.2 - asked[-1]))
        return len(asked) < 2

    assert not subject.advance(16, poll=poll, pause=1.0)
    assert time.perf_counter() - begin < 10.0
    assert len(asked) == 2
    assert subject.counters["paths"] == subject.moments["count"].sum()
