"""Units of a render: windows of the film with the samples between two counts, for a process that renders them alone.

A unit holds the moments that its pixels have before these samples. The process adds the samples in ascending order and
returns the moments. So a pixel has the same bits wherever its units were rendered.
"""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime.film.adaptive import PILOT
from equaltime.machine import worker_threads
from equaltime.rendering.core import REPLICATES, core_settings
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["BLOCK", "Recipe", "Rendered", "Unit", "Window", "add_samples", "place", "release", "second_place"]

Window = tuple[int, int, int, int]
"""Rectangle of the crop in pixels, as (x0, y0, x1, y1), without column x1 and row y1."""
BLOCK = 16
"""Side, in pixels, of the square blocks in which the core renders a film."""
_LEAST_SECONDS = 1e-9
_CACHED: list[tuple[Scene, Recipe, int, _core.Renderer]] = []
"""The renderer of the last unit, since the next one mostly belongs to the same render."""
_ONE = threading.Lock()
"""Held while a unit is rendered: a process has all its threads at work on one unit."""


@dataclass(frozen=True)
class Recipe:
    """Settings that decide the bits of a render's samples, beside the scene, for each process that takes samples."""

    strategy: str
    """Name of the strategy, with the render's decisions (on splitting and sample counts) in place of automatic values.
    """
    seed: int
    nets: int
    """Number of independent nets (low-discrepancy point sets) that a pixel's samples form: 1 or 2."""
    second_net: int
    """k, if one of k pixels has a second net: further samples, not in the image, that show its noise. 0 if there are
    none."""
    pixel_rays: bool
    """Whether to count the rays of each pixel."""
    traps: str
    """Treatment of floating-point faults: ``ignore`` them, or name the sample (``check``)."""
    build: str
    """Facts of the build and the processor that decide bits, as JSON text; a process with other facts must not take
    part."""


@dataclass(frozen=True, eq=False)
class Unit:
    """Work for one process: samples to add to the pixels of a window, and the samples that these pixels have already.

    The window begins and ends at borders of blocks of 16 x 16 pixels.
    """

    recipe: Recipe
    window: Window
    begin: int
    """Samples per pixel, on average, before the work."""
    end: int
    """Samples per pixel, on average, after the work."""
    moments: NDArray[Any]
    """(R, h, w): count, mean and deviation of the samples of each of the window's pixels, in each of R replicates
    (parts of the samples)."""
    second: NDArray[Any]
    """(R, h', w'): moments of the second nets in the window, which are further samples of some pixels to show the
    noise; empty if there are none."""
    rates: NDArray[np.float32] | None
    """(h, w): number of samples that each pixel gets for one sample of the average, after the pilot; None for even
    counts."""

    @property
    def pixels(self) -> int:
        """Number of pixels in the window."""
        x0, y0, x1, y1 = self.window
        return (x1 - x0) * (y1 - y0)


@dataclass(frozen=True, eq=False)
class Rendered:
    """Result of rendering a unit: the pixels of its window with old and new samples, and the cost of the new ones.

    A unit is a window of the film with the samples between two counts per pixel.
    """

    moments: NDArray[Any]
    """(R, h, w): count, mean and deviation of the samples of each of the window's pixels, in each of R replicates
    (parts of the samples)."""
    second: NDArray[Any]
    """(R, h', w'): moments of the second nets in the window, which are further samples of some pixels to show the
    noise; empty if there are none."""
    pixel_rays: NDArray[np.uint64] | None
    """(h, w): number of rays of each pixel's added samples, second nets left out; None if not counted."""
    counters: Mapping[str, int]
    """Numbers of paths, rays and shadow rays of the added samples."""
    nonfinite: tuple[tuple[int, int, int], ...]
    """Samples that were NaN or infinite, as (x, y, sample index), with x and y in the crop."""
    faulty: tuple[tuple[int, int, int, str], ...]
    """Samples that raised floating-point faults, as (x, y, sample index, fault)."""
    seconds: float
    """Wall-clock seconds."""
    core_seconds: float
    """Processor seconds of all threads."""
    threads: int
    process: str
    """Name of the process that rendered the window: host and process number."""


def add_samples(scene: Scene, unit: Unit, threads: int = 0) -> Rendered:
    """Render the new samples of a unit in this process; return the pixels with the old and the new samples.

    A unit is a window of the film of ``scene`` with the samples that its pixels already have, ``unit.begin`` per pixel
    on average. The function renders further samples until there are ``unit.end`` per pixel on average. ``threads`` is
    the number of threads; 0 is one for each processor. Raises RenderError for lack of memory, and ValueError if the
    sample counts in ``unit.moments`` are not those after ``unit.begin`` samples per pixel.
    """
    with _ONE:
        return _with_samples(scene, unit, threads)


def release() -> None:
    """Free the renderer that this process keeps for further units of the same render."""
    with _ONE:
        _CACHED.clear()


def _with_samples(scene: Scene, unit: Unit, threads: int) -> Rendered:
    begin, spent = time.perf_counter(), time.process_time()
    renderer = _renderer(scene, unit.recipe, worker_threads(threads))
    renderer.limit_to(unit.window)
    there, second = place(unit.window), second_place(unit.window, unit.recipe.second_net)
    renderer.moments[there] = unit.moments
    if unit.second.size:
        renderer.second_moments[second] = unit.second
    if unit.rates is not None:
        rates = np.zeros(renderer.moments.shape[1:], np.float32)
        rates[there[1:]] = unit.rates
        renderer.set_sample_rates(PILOT, rates)
    renderer.resume(paths=0, rays=0, shadow_rays=0, position=(unit.begin, unit.begin, 0))
    renderer.advance(unit.end)
    return Rendered(
        renderer.moments[there].copy(),
        renderer.second_moments[second].copy() if unit.second.size else unit.second,
        renderer.pixel_rays[there[1:]].copy() if unit.recipe.pixel_rays else None,
        {name: renderer.counters[name] for name in ("paths", "rays", "shadow_rays")},
        tuple(renderer.nonfinite),
        tuple(renderer.faulty),
        max(time.perf_counter() - begin, _LEAST_SECONDS),
        time.process_time() - spent,
        renderer.threads,
        f"{socket.gethostname()}:{os.getpid()}",
    )


def place(window: Window) -> tuple[slice, slice, slice]:
    """Return the index of a window's pixels in an array (R, H, W) of the crop's pixels, as three slices."""
    x0, y0, x1, y1 = window
    return slice(None), slice(y0, y1), slice(x0, x1)


def second_place(window: Window, pixels: int) -> tuple[slice, slice, slice]:
    """Return the index of a window's second nets in the array of all second nets, (R, h, w), as three slices.

    A second net is a set of further samples of a pixel. One of ``pixels`` pixels (a power of two) has one: one in each
    rectangle of that many pixels, as high as it is wide or half as high.
    """
    if not pixels:
        return slice(None), slice(0, 0), slice(0, 0)
    wide, high = pixels.bit_length() // 2, (pixels.bit_length() - 1) // 2
    x0, y0, x1, y1 = window
    return slice(None), slice(y0 >> high, -(-y1 >> high)), slice(x0 >> wide, -(-x1 >> wide))


def _renderer(scene: Scene, recipe: Recipe, threads: int) -> _core.Renderer:
    for cached_scene, cached_recipe, cached_threads, renderer in _CACHED:
        if cached_scene is scene and (cached_recipe, cached_threads) == (recipe, threads):
            return renderer
    _CACHED.clear()  # a film may take much of the memory
    made = _core.Renderer(
        scene.core,
        core_settings(scene, Strategy.parse(recipe.strategy)),
        seed=recipe.seed,
        threads=threads,
        replicates=REPLICATES,
        nets=recipe.nets,
        second_net=recipe.second_net,
        pixel_rays=recipe.pixel_rays,
        traps=recipe.traps,  # type: ignore[arg-type]  # a word of `Traps`
    )
    _CACHED.append((scene, recipe, threads, made))
    return made
