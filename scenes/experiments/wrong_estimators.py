"""Estimators that are wrong on purpose, and right ones made the same way, for experiments that look for bias.

An experiment reaches them by name (``python = "wrong_estimators.py:choice_forgotten"``); no strategy of equaltime leads
here. All trace with the NumPy cross-check, whose lights are exchanged for ones that lie about their densities.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from equaltime.crosscheck.lights import Lights, LightSamples
from equaltime.crosscheck.tracer import Tracer
from equaltime.crosscheck.world import Hits
from equaltime.rendering.core_subject import Point, RendererKind
from equaltime.scene import Scene
from equaltime.scene.model import Sphere

__all__ = ["choice_forgotten", "fixed_cone", "light_sampling", "mis", "weights_above_one"]

Array = NDArray[np.float64]
FIXED_RADIUS = 1.5


@dataclass
class ChangedLights:
    """Lights whose samples, and whose word on what BSDF sampling finds, are changed."""

    inner: Lights
    change: Callable[[LightSamples, Array, Scene], None]
    scene: Scene
    lights_only: bool
    """Whether what the BSDF's ray meets counts for nothing."""

    def __getattr__(self, name: str) -> object:
        return getattr(self.inner, name)

    def surface_pdf(self, hits: Hits, directions: Array) -> Array:
        density = self.inner.surface_pdf(hits, directions)
        return np.where(density > 0.0, 1e300, 0.0) if self.lights_only else density

    def sample(self, points: Array, rng: np.random.Generator) -> LightSamples:
        samples = self.inner.sample(points, rng)
        self.change(samples, points, self.scene)
        return samples


@dataclass
class NumpySubject:
    """The cross-check as the subject of an experiment, with changed lights."""

    label: str
    change: Callable[[LightSamples, Array, Scene], None]
    lights_only: bool = True
    renderer: RendererKind = "command"
    biased: bool = False  # they do not say so themselves: that is for the experiment to find

    @property
    def name(self) -> str:
        return f"wrong_estimators.py:{self.label}"

    def prepare(self, scene: Scene, threads: int) -> float:
        begin = time.perf_counter()
        self._tracer = Tracer(scene)
        lights = ChangedLights(self._tracer._lights, self.change, scene, self.lights_only)
        self._tracer._lights = lights  # type: ignore[assignment]
        return time.perf_counter() - begin

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None) -> Iterator[Point]:
        rng = np.random.Generator(np.random.Philox(seed))
        pixels = self._tracer.camera.pixels()
        total, done, wall, cpu = np.zeros((len(pixels), 3)), 0, 0.0, 0.0
        for spp in ladder:
            wall_before, cpu_before = time.perf_counter(), time.process_time()
            while done < spp:
                total += self._tracer.sample(pixels, rng)
                done += 1
            wall += time.perf_counter() - wall_before
            cpu += time.process_time() - cpu_before
            image = (total / done).reshape(*self._tracer.film_shape, 3).astype(np.float32)
            yield Point(spp, wall, cpu, image, paths=done * len(pixels))
            if seconds is not None and wall >= seconds:
                return


def mis(label: str) -> NumpySubject:
    """Return light and BSDF sampling with the balance heuristic, which is right."""
    return NumpySubject(label, lambda samples, points, scene: None, lights_only=False)


def light_sampling(label: str) -> NumpySubject:
    """Return light sampling alone, which is right."""
    return NumpySubject(label, _alone)


def choice_forgotten(label: str) -> NumpySubject:
    """Return an estimator whose densities lack the probability with which one of several lights was chosen."""

    def change(samples: LightSamples, points: Array, scene: Scene) -> None:
        _alone(samples, points, scene)
        samples.pdf *= sum(shape.emitter is not None for shape in scene.model.shapes)

    return NumpySubject(label, change)


def weights_above_one(label: str) -> NumpySubject:
    """Return an estimator with weights that sum to more than 1: light samples count in full, BSDF samples by MIS."""
    return NumpySubject(label, _alone, lights_only=False)


def fixed_cone(label: str) -> NumpySubject:
    """Return an estimator that weights light samples by the cone of a sphere of radius 1.5, as montelight does."""

    def change(samples: LightSamples, points: Array, scene: Scene) -> None:
        _alone(samples, points, scene)
        places = points + samples.wi * samples.distance[:, None]
        for lamp in (s for s in scene.model.shapes if s.emitter is not None and isinstance(s, Sphere)):
            on = np.linalg.norm(places - np.asarray(lamp.center), axis=1) < 1.01 * lamp.radius
            squared = np.square(points[on] - np.asarray(lamp.center)).sum(axis=1)
            samples.pdf[on] *= _cap(lamp.radius, squared) / _cap(FIXED_RADIUS, squared)

    return NumpySubject(label, change)


def _alone(samples: LightSamples, points: Array, scene: Scene) -> None:
    """Say that nothing but light sampling finds these."""
    samples.single[:] = 1.0


def _cap(radius: float, squared_distance: Array) -> Array:
    """Return the solid angle of a sphere over 2 pi; of a hemisphere from within."""
    sine_squared = np.minimum(radius**2 / squared_distance, 1.0)
    cap: Array = sine_squared / (1.0 + np.sqrt(1.0 - sine_squared))
    return cap
