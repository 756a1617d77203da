"""A strategy of equaltime's own core as the subject of an experiment."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from equaltime.film.second_nets import statistics_so_far
from equaltime.film.unseen import Unseen, stated_error
from equaltime.images.float32 import as_float32, beyond_float32
from equaltime.rendering.core import bad_sample, core_settings, make_renderer
from equaltime.rendering.subject import Checkpoint, RendererKind
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["CoreSubject"]


@dataclass
class CoreSubject:
    """Renders with one long-lived renderer per run.

    The clocks run only during `advance`: they exclude making the film, and the image and the error estimate at a
    checkpoint.
    """

    label: str
    strategy: Strategy
    renderer: RendererKind = "core"
    _scene: Scene | None = field(default=None, init=False, repr=False)
    _threads: int = field(default=0, init=False, repr=False)
    _warm: set[str] = field(default_factory=set, init=False, repr=False)

    @property
    def name(self) -> str:
        """The strategy's name."""
        return self.strategy.name

    @property
    def biased(self) -> bool:
        """Whether the strategy is biased."""
        return self.strategy.biased

    def prepare(self, scene: Scene, threads: int) -> float:
        """Build the scene if needed, take one sample to warm up, and return the seconds of loading and building."""
        self._scene, self._threads = scene, threads
        if scene.digest not in self._warm:
            make_renderer(scene, self.strategy, 0, threads).advance(1)
            self._warm.add(scene.digest)
        return sum(scene.timings.values())

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Checkpoint]:
        """Bring one image to each count of ``ladder``.

        Raises
        ------
        NonFiniteSample
            If a sample was not a number.
        BrightImage
            If float32 cannot hold the image.
        """
        assert self._scene is not None, "prepare comes first"
        scene, threads = self._scene, self._threads
        renderer = make_renderer(scene, self.strategy, seed, threads)
        unseen = Unseen.of(scene.core, core_settings(scene, self.strategy), seed, threads)
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
            yield Checkpoint(
                spp=spp,
                wall_s=wall,
                cpu_s=cpu,
                image=as_float32(pixels.mean),
                estimate=stated_error(pixels, unseen),
                paths=counters["paths"],
                rays=counters["rays"],
                shadow_rays=counters["shadow_rays"],
                samples=None if (pixels.samples == spp).all() else pixels.samples,
            )
            if seconds is not None and wall >= seconds:
                return
