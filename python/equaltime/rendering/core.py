"""Python's access to the core's renderer: its settings from a scene and a strategy, adaptive counts, and failures."""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import MOST_PIXELS_A_SECOND_NET, build_info
from equaltime.errors import FaultySample, NonFiniteSample, Problem, RenderError, SampleError, SceneError
from equaltime.film.adaptive import METRICS, PILOT, pilot_statistics
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
    "second_net",
    "split_light",
    "traced",
]

REPLICATES = 2
"""Number of replicates of a render; their differences give its error."""
ONE_NET = 2**16
"""Least number of pixels of the whole film for which all samples of a pixel are one net. Smaller pictures would need
too many second nets for their error to be known."""
_SECOND_NETS = 2048
"""Least number of pixels with a second net, unless the crop has fewer: they give the image's error to 2 to 3 %."""
MOMENTS_BYTES = 40
"""Bytes of one pixel's moments in a film of the core."""
_RESULT_BYTES = 100
"""Bytes of one pixel in a result, beside the film: image, standard error, counts, and copies on the way to a file."""


def make_renderer(scene: Scene, strategy: Strategy, seed: int, threads: int, **options: Any) -> _core.Renderer:
    """Return the core's renderer for a scene and a strategy; raises as `Session` does."""
    settings = core_settings(scene, strategy)
    check_memory(scene, REPLICATES * MOMENTS_BYTES + _RESULT_BYTES)
    make = _core.Renderer if strategy.adaptive == "none" else partial(AdaptiveRenderer, metric=strategy.adaptive)
    how = {"replicates": REPLICATES, "nets": nets(scene, strategy), "second_net": second_net(scene, strategy)}
    try:
        return make(scene.core, settings, seed=seed, threads=worker_threads(threads), **{**how, **options})
    except MemoryError as error:
        width, height = scene.size
        raise RenderError(f"not enough memory for the scene and a film of {width}x{height} pixels") from error


def nets(scene: Scene, strategy: Strategy) -> int:
    """Return the number of independent nets of a pixel's samples: one for a lattice on a large film, else two."""
    width, height = scene.model.sensor.film.size
    return 1 if strategy.sampler == "lattice" and width * height >= ONE_NET else REPLICATES


def second_net(scene: Scene, strategy: Strategy) -> int:
    """Return k, where one of k pixels has a second net (`equaltime.film.second_nets`); 0 if there are none."""
    if nets(scene, strategy) > 1:
        return 0
    _, _, width, height = scene.model.sensor.film.crop
    share = max(width * height // _SECOND_NETS, 1)
    return int(min(1 << (share.bit_length() - 1), MOST_PIXELS_A_SECOND_NET))


class AdaptiveRenderer(_core.Renderer):
    """A renderer with adaptive sample counts after the pilot; its decisions follow from the pilot alone."""

    def __init__(self, scene: _core.Scene, settings: _core.Settings, metric: str, **common: Any) -> None:
        options = {**common, "pixel_rays": True}
        super().__init__(scene, settings, **options)
        self._metric = METRICS[metric]
        self._pilot = partial(_core.Renderer, scene, settings, **options)
        self._rates: NDArray[np.float32] | None = None

    @property
    def counts(self) -> Counts | None:
        """Decision of the pilot; None before the pilot has ended."""
        return None if self._rates is None else "even" if (self._rates == 1.0).all() else "error"

    def rates(self, samples: int) -> NDArray[np.float64]:
        """Return each pixel's sample count over the mean count ``samples``, (H, W); the pilot must have ended."""
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
        """Bring the image to ``samples`` per pixel on average."""
        if samples <= PILOT or self._rates is not None:
            return super().advance(samples, seconds, poll, pause)
        begin = time.perf_counter()
        if not super().advance(PILOT, seconds, poll, pause) or self.nonfinite:  # a bad sample ends the render
            return False
        self._decide(self)
        took = time.perf_counter() - begin
        seconds, pause = (None if limit is None else max(0.0, limit - took) for limit in (seconds, pause))
        return super().advance(samples, seconds, poll, pause)

    def take_up(self, *, paths: int, rays: int, shadow_rays: int, position: tuple[int, int, int]) -> None:
        """Resume a render; its pilot is rendered again, since the film holds more samples by now."""
        pilot = self._pilot()
        pilot.advance(PILOT)
        self._decide(pilot)
        super().take_up(paths=paths, rays=rays, shadow_rays=shadow_rays, position=position)

    def _decide(self, pilot: _core.Renderer) -> None:
        rates = self._metric(pilot_statistics(pilot.moments), pilot.pixel_rays.astype(np.float64))
        self._rates = rates.astype(np.float32)
        if self.counts != "even":  # adapt() would rule out odd sample counts
            self.adapt(PILOT, self._rates)


def decision_of(renderer: _core.Renderer, strategy: Strategy) -> Decision:
    """Return the decisions of a renderer of this strategy so far."""
    counts = renderer.counts if isinstance(renderer, AdaptiveRenderer) and strategy.adaptive == "error" else None
    decided = renderer.decision
    if strategy.roulette != "automatic" or decided is None:
        return Decision(counts=counts)
    return Decision(decided["roulette"], decided["splitting"], counts)


def split_light(
    scene: Scene, strategy: Strategy, seed: int, threads: int, samples: int, only_lengths: bool = False
) -> tuple[list[tuple[str, str]], NDArray[np.float32]]:
    """Return the parts of the image that `make_renderer`'s renderer makes: names (kind, what), and (H, W, parts, 3).

    The parts are all kinds, or path lengths alone, which takes a third of the memory or less.
    """
    settings = core_settings(scene, strategy)
    return _core.split_light(
        scene.core, settings, seed, worker_threads(threads), samples, nets(scene, strategy), only_lengths
    )


def alpha(scene: Scene, strategy: Strategy, seed: int, threads: int, samples: int) -> NDArray[np.float32]:
    """Return the opacity of each pixel (H, W), in [0, 1], from the first camera rays of `make_renderer`'s renderer."""
    settings = core_settings(scene, strategy)
    return _core.alpha(scene.core, settings, seed, worker_threads(threads), samples, nets(scene, strategy))


def traced(scene: Scene, strategy: Strategy, pixel: tuple[int, int], index: int, seed: int) -> dict[str, Any]:
    """Return one sample of a pixel of the whole film in the core's form, with the same bits as in a render."""
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
    """Return the error for the first bad sample of a renderer, with the command that replays it."""
    x, y, index = renderer.nonfinite[0] if renderer.nonfinite else renderer.faulty[0][:3]
    left, top, _, _ = scene.model.sensor.film.crop
    pixel = (x + left, y + top)
    command: tuple[str, ...] = ()
    if scene.source is not None:
        sample = ("--pixel", f"{pixel[0]},{pixel[1]}", "--sample", str(index), "--seed", str(seed))
        problem = ("--size", f"{scene.size[0]}x{scene.size[1]}", "--max-depth", str(scene.max_depth))
        command = ("equaltime", "replay", str(scene.source), *sample, "--strategy", strategy.name, *problem)
        command += tuple(word for name in without for word in ("--without", name))
    if renderer.nonfinite:
        return NonFiniteSample(pixel, index, seed, result, command)
    return FaultySample(pixel, index, seed, result, command, f"floating-point fault ({renderer.faulty[0][3]})")


def core_settings(scene: Scene, strategy: Strategy) -> _core.Settings:
    """Return the core's settings for a strategy with the scene's depth."""
    words = strategy.model_dump(exclude={"truncate", "adaptive"})
    return _core.Settings(**words, truncate=strategy.truncate or 0, max_depth=scene.max_depth)


def check_memory(scene: Scene, bytes_per_pixel: float) -> None:
    """Raise `SceneError` for a film larger than the memory: the system would end the process without a message."""
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
    """Return the facts that identify the core, down to its bits."""
    content = Path(_core.__file__).read_bytes()
    python = ".".join(map(str, sys.version_info[:3]))
    return {**_core.build_info(), "core_sha256": hashlib.sha256(content).hexdigest(), "python": python}
