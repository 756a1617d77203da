"""Where paths are split, by what a pilot shows to be worth its rays, the image still depends on nothing but the scene,
the strategy, the samples and the seed: how often is decided by counts, and alike for every part of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.quoting.light_parts import KINDS_OF_PARTS
from equaltime.rendering.core import core_settings, make_renderer, split_light

from .shipped import FILES, same_bits, shipped

SPLITTING = et.Strategy.parse("best,roulette=efficiency,roulette_depth=3")
PLAIN = et.Strategy.parse("best,roulette_depth=3")


def film(file: str, samples: int = 6, threads: int = 1, tile: int = 16, passes: int = 1) -> _core.Renderer:
    scene = shipped(file)
    renderer = _core.Renderer(scene.core, core_settings(scene, SPLITTING), 5, threads, tile)
    for done in range(1, passes + 1):
        assert renderer.advance(samples * done // passes)
    return renderer


@pytest.mark.parametrize("file", FILES)
def test_paths_are_split_where_that_is_worth_it(file: str) -> None:
    scene, split = shipped(file), film(file)
    plain = make_renderer(scene, PLAIN, 5, threads=1)
    plain.advance(6)
    assert "splitting" in split.kernel
    assert "splitting" not in plain.kernel
    assert split.counters["paths"] == plain.counters["paths"]
    assert split.counters["rays"] > 1.05 * plain.counters["rays"]


@pytest.mark.parametrize("file", FILES[::3])
def test_threads_tiles_and_passes_change_no_bit(file: str) -> None:
    once = film(file)
    for other in (film(file, threads=3, tile=5), film(file, passes=3)):
        assert same_bits(once.moments, other.moments)
        assert once.counters == other.counters


def test_a_crop_has_the_bits_of_the_whole() -> None:
    window = (7, 3, 9, 8)
    part = make_renderer(shipped(FILES[0], crop=window), SPLITTING, 5, threads=1)
    part.advance(6)
    x, y, width, height = window
    assert same_bits(part.moments, film(FILES[0]).moments[:, y : y + height, x : x + width])


def test_a_render_that_is_taken_up_has_the_bits_of_one_that_was_not(tmp_path: Path) -> None:
    scene = shipped(FILES[0])
    saved = tmp_path / "half.exr"
    et.render(scene, spp=4, strategy=SPLITTING).save(saved)
    resumed = et.render(scene, spp=10, strategy=SPLITTING, resume=saved)
    whole = et.render(scene, spp=10, strategy=SPLITTING)
    assert resumed.moments is not None
    assert whole.moments is not None
    assert same_bits(resumed.moments, whole.moments)


def test_the_parts_of_an_image_add_up_to_it() -> None:
    scene = shipped(FILES[0])
    names, parts = split_light(scene, SPLITTING, seed=5, threads=1, samples=6)
    mean = film(FILES[0]).moments["mean"].mean(axis=0)
    for kind in KINDS_OF_PARTS:
        total = sum(parts[:, :, i] for i, (k, _) in enumerate(names) if k == kind)
        np.testing.assert_allclose(total, mean, rtol=1e-5, atol=1e-6 * mean.max())


def test_copies_of_a_path_leave_the_vertex_where_it_was_split() -> None:
    scene = shipped(FILES[0])
    for index in range(20):
        vertices = _core.replay(scene.core, core_settings(scene, SPLITTING), 5, 12, 8, index)["vertices"]
        left = [vertex["from"] for vertex in vertices]
        assert left[0] is None
        assert all(origin < own for own, origin in enumerate(left) if origin is not None)
        if len(set(left)) < len(left):
            return
    pytest.fail("no path was split")
