"""Subjects of experiments: renderers that render to given sample counts and measure their time; the core is one."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from equaltime.film.moments import sample_variance
from equaltime.film.second_nets import statistics_so_far
from equaltime.film.unseen import Unseen, stated_error
from equaltime.images.float32 import as_float32, beyond_float32
from equaltime.images.variance_picture import of_colours
from equaltime.rendering.core import bad_sample, core_settings, decision_of, make_renderer
from equaltime.rendering.decision import Decision
from equaltime.scene import Scene
from equaltime.scene.effects.focusing import focusing_surfaces
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["CoreSubject", "Point", "RendererKind", "Subject"]

RendererKind = Literal["core", "mitsuba", "command"]


@dataclass(frozen=True, eq=False)
class Point:
    """State of a render at a checkpoint of an experiment: image, time and cost at one sample count.

    At the checkpoint, pixels have ``spp`` samples (on average, if uneven).
    """

    spp: int
    wall_s: float
    """Wall-clock seconds of rendering since the first sample, without other work."""
    cpu_s: float
    """CPU seconds of rendering since the first sample, summed over all threads."""
    image: NDArray[np.float32]
    """(H, W, 3): linear RGB radiance."""
    estimate: Interval | None = None
    """Relative error that the renderer itself states, without a reference; None if it states none."""
    paths: int | None = None
    """Number of camera paths so far; None if the renderer does not count them."""
    rays: int | None = None
    """Number of rays so far, without shadow rays; None if the renderer does not count them."""
    shadow_rays: int | None = None
    """Number of shadow rays so far; None if the renderer does not count them."""
    samples: NDArray[np.int64] | None = None
    """(H, W): number of samples of each pixel; None if all pixels have ``spp``."""
    variance: NDArray[np.float32] | None = None
    """(H, W): variance of one sample of each pixel, mean of R, G and B; None if the renderer does not report it."""
    decision: Decision = field(default_factory=Decision)
    """Decisions that the strategy leaves to the render."""


class Subject(Protocol):
    """Interface of a renderer with a strategy that takes part in an experiment; write one to add your own renderer.

    A subject may have a method ``close``, which is called when the subject is no longer needed.
    """

    @property
    def label(self) -> str:
        """Short name that the experiment gives the strategy."""

    @property
    def name(self) -> str:
        """Full name of the strategy, on one line."""

    @property
    def renderer(self) -> RendererKind:
        """Kind of the renderer: ``core``, ``mitsuba`` or ``command``."""

    @property
    def biased(self) -> bool:
        """Whether the strategy is known to converge to an image other than the scene's."""

    def prepare(self, scene: Scene, threads: int) -> float:
        """Get ready to render a scene, and return the seconds that this took.

        ``threads`` is the number of threads; 0 is one per processor. Work that a renderer does once per process or
        scene belongs here: loading, compiling, a first sample to warm up.
        """

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None) -> Iterator[Point]:
        """Render with random numbers of ``seed`` (31 bits), and yield a checkpoint at each sample count in ``ladder``.

        The counts are total samples per pixel, in ascending order. Each count is taken from ``ladder`` only after the
        previous checkpoint was yielded, so it may depend on the measured times. With ``seconds``, the run ends at the
        first checkpoint after that time.
        """


@dataclass
class CoreSubject:
    """Subject of experiments (object that renders) with equaltime's core, one renderer for each run.

    The clocks run only while samples are taken. Making the film does not count, nor do the image and the error estimate
    at a sample count.
    """

    label: str
    strategy: Strategy
    renderer: RendererKind = "core"
    _scene: Scene | None = field(default=None, init=False, repr=False)
    _threads: int = field(default=0, init=False, repr=False)
    _warm: set[str] = field(default_factory=set, init=False, repr=False)

    @property
    def name(self) -> str:
        """The strategy's full name, on one line."""
        return self.strategy.name

    @property
    def biased(self) -> bool:
        """Whether the strategy converges to an image other than the scene's."""
        return self.strategy.biased

    def prepare(self, scene: Scene, threads: int) -> float:
        """Build ``scene`` if needed, render one sample to warm up, and return the seconds of loading and building.

        ``threads`` is the number of threads of later runs; 0 is one for each processor.
        """
        self._scene, self._threads = scene, threads
        if scene.digest not in self._warm:
            make_renderer(scene, self.strategy, 0, threads).advance(1)
            self._warm.add(scene.digest)
        return sum(scene.timings.values())

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Point]:
        """Yield a checkpoint of one growing image at each sample count per pixel in ``ladder``, in ascending order.

        ``seed`` has 31 bits. With ``seconds``, the run ends at the first checkpoint after that time.

        Raises
        ------
        NonFiniteSample
            If a sample is NaN or infinite.
        BrightImage
            If float32 cannot hold the image.
        """
        assert self._scene is not None, "prepare comes first"
        scene, threads = self._scene, self._threads
        renderer = make_renderer(scene, self.strategy, seed, threads)
        unseen = Unseen.of(
            scene.core, core_settings(scene, self.strategy), seed, threads, partial(focusing_surfaces, scene)
        )
        wall = cpu = 0.0
        for spp in ladder:
            wall_before, cpu_before = time.perf_counter(), time.process_time()
            renderer.advance(spp)
            cpu += time.process_time() - cpu_before
            wall += time.perf_counter() - wall_before
            if renderer.nonfinite:
                raise bad_sample(scene, self.strategy, seed, renderer)
            pixels = statistics_so_far(renderer)
            where = ": ".join(filter(None, (str(scene.source or ""), self.label)))
            if (beyond := beyond_float32(pixels.mean, scene.model.sensor.film.crop[:2], where)) is not None:
                raise beyond
            counters = renderer.counters
            yield Point(
                spp=spp,
                wall_s=wall,
                cpu_s=cpu,
                image=as_float32(pixels.mean),
                estimate=stated_error(pixels, unseen),
                paths=counters["paths"],
                rays=counters["rays"],
                shadow_rays=counters["shadow_rays"],
                samples=None if (pixels.samples == spp).all() else pixels.samples,
                variance=as_float32(of_colours(sample_variance(renderer.moments))),
                decision=decision_of(renderer, self.strategy),
            )
            if seconds is not None and wall >= seconds:
                return
