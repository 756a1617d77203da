"""Access to the core's renderer: its settings from a scene and a strategy, adaptive sample counts, and its errors."""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import MOST_PIXELS_A_SECOND_NET, build_info
from equaltime.errors import FaultySample, NonFiniteSample, Problem, RenderError, SampleError, SceneError
from equaltime.film.adaptive import METRICS, PILOT, pilot_statistics
from equaltime.film.focus import Focus
from equaltime.film.lamps import Lamps
from equaltime.machine import memory_bytes, worker_threads
from equaltime.rendering.decision import Counts, Decision
from equaltime.rendering.result import Result
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = [
    "MOMENTS_BYTES",
    "ONE_NET",
    "REPLICATES",
    "AdaptiveRenderer",
    "alpha",
    "bad_sample",
    "build_facts",
    "build_info",
    "check_memory",
    "core_settings",
    "decision_of",
    "make_renderer",
    "nets",
    "numbers_version",
    "second_net",
    "split_light",
    "traced",
]

REPLICATES = 2
"""Number of replicates of a render: equal parts of each pixel's samples, whose differences give the image's error."""
ONE_NET = 2**16
"""Least number of pixels of the whole film for which all samples of a pixel are one net (low-discrepancy point set).
The error of one net needs a second, independent net in some pixels, and these would be too large a part of a smaller
film."""
_SECOND_NETS = 2048
"""Least number of pixels with a second net, unless the crop has fewer: they give the image's error to 2 to 3 %."""
_RARE_LIGHT: WeakKeyDictionary[Scene, bool] = WeakKeyDictionary()
"""Whether a scene has light that few pixels meet: found once for each scene."""
MOMENTS_BYTES = 40
"""Bytes that a film of the core needs for a pixel's moments: count, means and deviations of its samples."""
_RESULT_BYTES = 100
"""Bytes of one pixel in a result, beside the film: image, standard error, counts, and copies on the way to a file."""


def make_renderer(
    scene: Scene,
    strategy: Strategy,
    seed: int,
    threads: int,
    kinds: tuple[type[_core.Renderer], type[AdaptiveRenderer]] | None = None,
    **options: Any,
) -> _core.Renderer:
    """Return the core's renderer for a scene and a strategy, with two replicates (halves of each pixel's samples).

    ``seed`` is the seed of all samples. ``threads`` is the number of worker threads; 0 is one for each processor.
    ``options`` are further keyword arguments of `_core.Renderer`, and override those that follow from scene and
    strategy. ``kinds`` are the classes for even and for adaptive sample counts; None for `_core.Renderer` and
    `AdaptiveRenderer`. Raises `SceneError` or `RenderError` if there is not enough memory.
    """
    settings = core_settings(scene, strategy)
    check_memory(scene, REPLICATES * MOMENTS_BYTES + _RESULT_BYTES)
    even, adaptive = kinds or (_core.Renderer, AdaptiveRenderer)
    make = even if strategy.adaptive == "none" else partial(adaptive, metric=strategy.adaptive)
    how = {"replicates": REPLICATES, "nets": nets(scene, strategy), "second_net": second_net(scene, strategy)}
    try:
        return make(scene.core, settings, seed=seed, threads=worker_threads(threads), **{**how, **options})
    except MemoryError as error:
        width, height = scene.size
        raise RenderError(f"not enough memory for the scene and a film of {width}x{height} pixels") from error


def nets(scene: Scene, strategy: Strategy) -> int:
    """Return the number of nets (low-discrepancy point sets) that the samples of a pixel form: 1 or 2.

    Two nets of a pixel are independent, so their difference shows the noise. A single net has less noise, but its
    halves do not show how much. Some pixels then need further samples, a second net. The number is 1 for the lattice
    sampler on a film of at least 2^16 pixels, else 2. It is also 2 if specular surfaces focus the light of very small
    emitters, or if the lamps in sight are smaller than a pixel. Few pixels meet such light, and second nets in a 32nd
    of the pixels would not show its noise. The choice does not depend on the crop or the seed.
    """
    width, height = scene.model.sensor.film.size
    if strategy.sampler != "lattice" or width * height < ONE_NET:
        return REPLICATES
    if scene not in _RARE_LIGHT:
        anyhow = core_settings(scene, Strategy())  # such light is the scene's, whatever samples it
        focus = Focus.of(scene.core, anyhow, seed=0, threads=0, whole_film=True)
        _RARE_LIGHT[scene] = focus.rarely_met or Lamps.in_plain_sight(scene.core, anyhow).mostly_small
    return REPLICATES if _RARE_LIGHT[scene] else 1


def numbers_version(strategy: Strategy) -> int:
    """Return the version of the numbers that the strategy's sampler gives: 2 for ``sobol``, else 1.

    Version 1 of ``sobol`` had two dimensions for each decision of a path, instead of one sequence for all.
    """
    return 2 if strategy.sampler == "sobol" else 1


def second_net(scene: Scene, strategy: Strategy) -> int:
    """Return k if one of every k pixels has a second net; 0 if no pixel has one.

    A net is a low-discrepancy point set. A second net is a set of further samples of a pixel, which is not in the
    image. Its difference from the first net gives the variance (`equaltime.film.second_nets`).
    """
    if nets(scene, strategy) > 1:
        return 0
    _, _, width, height = scene.model.sensor.film.crop
    share = max(width * height // _SECOND_NETS, 1)
    return int(min(1 << (share.bit_length() - 1), MOST_PIXELS_A_SECOND_NET))


class AdaptiveRenderer(_core.Renderer):
    """Renderer with adaptive sample counts, which follow from a pilot: the first samples of every pixel.

    Parameters
    ----------
    scene, settings
        Scene and settings of the core.
    metric
        Rule by which counts follow from the pilot: a key of `equaltime.film.adaptive.METRICS`.
    common
        Further keyword arguments of `_core.Renderer`.
    """

    def __init__(self, scene: _core.Scene, settings: _core.Settings, metric: str, **common: Any) -> None:
        options = {**common, "pixel_rays": True}
        super().__init__(scene, settings, **options)
        self._metric = METRICS[metric]
        self._pilot = partial(_core.Renderer, scene, settings, **options)
        self._rates: NDArray[np.float32] | None = None

    @property
    def counts(self) -> Counts | None:
        """Sample counts of pixels: ``even`` or ``error`` (uneven); None before the pilot has ended, which chooses.

        The pilot is the first samples of every pixel.
        """
        return None if self._rates is None else "even" if (self._rates == 1.0).all() else "error"

    def rates(self, samples: float) -> NDArray[np.float64]:
        """Return how samples are distributed over pixels: each pixel's count divided by the mean count, (H, W).

        ``samples`` is the mean count. The pilot must have ended, because the ratios follow from its samples.
        """
        if self._rates is None:
            self._decide(self)
        assert self._rates is not None
        return np.asarray(PILOT / samples + self._rates.astype(np.float64) * (1.0 - PILOT / samples))

    def advance(
        self,
        samples: int,
        seconds: float | None = None,
        poll: Callable[[], bool] | None = None,
        pause: float | None = None,
    ) -> bool:
        """Render until pixels have ``samples`` samples on average; return whether that count is reached.

        The call ends early after ``seconds``, or when ``poll``, called about every 0.05 s, returns False. After
        ``pause`` seconds the call ends too, with all begun blocks of pixels finished. The call also ends if one of the
        first samples, from which counts follow, is NaN or infinite.
        """
        if samples <= PILOT or self._rates is not None:
            return super().advance(samples, seconds, poll, pause)
        begin = time.perf_counter()
        if not super().advance(PILOT, seconds, poll, pause) or self.nonfinite:  # a bad sample ends the render
            return False
        self._decide(self)
        took = time.perf_counter() - begin
        seconds, pause = (None if limit is None else max(0.0, limit - took) for limit in (seconds, pause))
        return super().advance(samples, seconds, poll, pause)

    def resume(self, *, paths: int, rays: int, shadow_rays: int, position: tuple[int, int, int]) -> None:
        """Resume a saved render at its position in the passes, with its counts of paths, rays and shadow rays.

        ``position`` holds the completed samples per pixel, the samples of the running pass, and its next block. The
        first samples, from which sample counts follow, are rendered again, since the saved film holds more samples.
        """
        pilot = self._pilot()
        pilot.advance(PILOT)
        self._decide(pilot)
        super().resume(paths=paths, rays=rays, shadow_rays=shadow_rays, position=position)

    def _decide(self, pilot: _core.Renderer) -> None:
        rates = self._metric(pilot_statistics(pilot.moments), pilot.pixel_rays.astype(np.float64))
        self._rates = rates.astype(np.float32)
        if self.counts != "even":  # adapt() would rule out odd sample counts
            self.set_sample_rates(PILOT, self._rates)


def decision_of(renderer: _core.Renderer, strategy: Strategy) -> Decision:
    """Return the decisions that the renderer has made so far: whether paths are split, and whether counts are uneven.

    The renderer must have been made for ``strategy``.
    """
    counts = renderer.counts if isinstance(renderer, AdaptiveRenderer) and strategy.adaptive == "error" else None
    decided = renderer.decision
    if strategy.roulette != "automatic" or decided is None:
        return Decision(counts=counts)
    return Decision(decided["roulette"], decided["splitting"], counts)


def split_light(
    scene: Scene,
    strategy: Strategy,
    seed: int,
    threads: int,
    samples: int,
    only_lengths: bool = False,
    surface_groups: Sequence[int] = (),
) -> tuple[list[tuple[str, str]], NDArray[np.float32]]:
    """Return the image of a render of ``scene`` with this strategy and seed, split into parts by the light's origin.

    ``samples`` is the number of samples per pixel, and ``threads`` the number of threads. The list names the parts, as
    pairs (kind, name), such as a path length or a light source. The array holds their images, (H, W, parts, 3). The
    parts of each kind sum to the image. With ``only_lengths`` path length is the only kind, which takes a third of the
    memory or less. ``surface_groups`` has the group of each shape in the core's order, from 0; the names of the parts
    of the kind ``surface`` are these numbers. If it is empty, all shapes are one group.
    """
    settings, groups = core_settings(scene, strategy), np.array(surface_groups, np.uint32)
    return _core.split_light(
        scene.core, settings, seed, worker_threads(threads), samples, nets(scene, strategy), only_lengths, groups
    )


def alpha(scene: Scene, strategy: Strategy, seed: int, threads: int, samples: int) -> NDArray[np.float32]:
    """Return the opacity of each pixel, (H, W), in [0, 1], from the camera rays of a render.

    The render is of ``scene`` by ``strategy`` with ``seed``. ``samples`` is the number of rays in each pixel, and
    ``threads`` the number of threads.
    """
    settings = core_settings(scene, strategy)
    return _core.alpha(scene.core, settings, seed, worker_threads(threads), samples, nets(scene, strategy))


def traced(scene: Scene, strategy: Strategy, pixel: tuple[int, int], index: int, seed: int) -> dict[str, Any]:
    """Return the path of one sample, traced again with the same bits as in a render: the data of a `Replay`.

    The render is of ``scene`` by ``strategy`` with ``seed``. ``pixel`` is (x, y) in the whole film. ``index`` is the
    number of the sample in the pixel, from 0.
    """
    x, y, _, _ = scene.model.sensor.film.crop
    return _core.replay(
        scene.core, core_settings(scene, strategy), seed, pixel[0] - x, pixel[1] - y, index, nets=nets(scene, strategy)
    )


def bad_sample(
    scene: Scene,
    strategy: Strategy,
    seed: int,
    renderer: _core.Renderer,
    result: Result | None = None,
    without: tuple[str, ...] = (),
) -> SampleError:
    """Return an error for the first bad sample of a renderer; the error holds the command that replays the sample.

    A sample is bad if it is NaN or infinite, or raised a floating-point fault. ``result`` is the result so far, which
    the error holds too. ``without`` names the effects (features of the scene, such as media) that were left out.
    """
    x, y, index = renderer.nonfinite[0] if renderer.nonfinite else renderer.faulty[0][:3]
    left, top, _, _ = scene.model.sensor.film.crop
    pixel = (x + left, y + top)
    command: tuple[str, ...] = ()
    if scene.source is not None:
        sample = ("--pixel", f"{pixel[0]},{pixel[1]}", "--sample", str(index), "--seed", str(seed))
        problem = ("--size", f"{scene.size[0]}x{scene.size[1]}", "--max-depth", str(scene.max_depth))
        command = ("equaltime", "replay", str(scene.source), *sample, "--strategy", strategy.name, *problem)
        command += tuple(word for name in without for word in ("--without", name))
        command += ("--transparent",) * scene.transparent
    if renderer.nonfinite:
        return NonFiniteSample(pixel, index, seed, result, command)
    return FaultySample(pixel, index, seed, result, command, f"floating-point fault ({renderer.faulty[0][3]})")


def core_settings(scene: Scene, strategy: Strategy) -> _core.Settings:
    """Return the core's settings for a strategy and the scene's ``max_depth``."""
    words = strategy.model_dump(exclude={"truncate", "adaptive"})
    return _core.Settings(**words, truncate=strategy.truncate or 0, max_depth=scene.max_depth)


def check_memory(scene: Scene, bytes_per_pixel: float) -> None:
    """Raise `SceneError` if a film (image in memory) needs more memory than this machine or its container has.

    ``bytes_per_pixel`` is the film's need. Without the check, the system would end the process without a message.
    """
    _, _, width, height = scene.model.sensor.film.crop
    needed = width * height * bytes_per_pixel
    present = memory_bytes()
    if needed > present:
        message = (
            f"an image of {width}x{height} pixels: {needed / 1e9:.3g} GB of memory needed, {present / 1e9:.3g} GB "
            "allowed by the machine or its container; choose a smaller size or crop"
        )
        raise SceneError((Problem("", message),))


def build_facts() -> dict[str, Any]:
    """Return facts that identify the core: how it was built, the SHA-256 of its file, and Python's version."""
    content = Path(_core.__file__).read_bytes()
    python = ".".join(map(str, sys.version_info[:3]))
    return {**_core.build_info(), "core_sha256": hashlib.sha256(content).hexdigest(), "python": python}
