"""Integrals over [0, 1] whose values are known, as subjects of an experiment: every pixel estimates the same one.

The integrand is 3 x^2, whose integral is 1: the radiance of constant.toml, against which it is measured. A subject is
chosen by name in an experiment file: ``python = "integrands.py:uniform"``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from equaltime.rendering.core_subject import Point, RendererKind
from equaltime.scene import Scene

__all__ = ["linear", "matching", "opposite", "uniform"]

Array = NDArray[np.float64]


@dataclass
class Integral:
    """Estimates the integral by samples x with density pdf(x), made from uniform numbers by ``warp``."""

    label: str
    warp: Callable[[Array], Array]
    pdf: Callable[[Array], Array]
    renderer: RendererKind = "command"
    biased: bool = False

    @property
    def name(self) -> str:
        """What is estimated and how."""
        return f"integral of 3 x^2, {self.label}"

    def prepare(self, scene: Scene, threads: int) -> float:
        """Take the size of the image from the scene; there is nothing else to get ready."""
        width, height = scene.size
        self._shape = height, width, 3
        return 0.0

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None) -> Iterator[Point]:
        """Give the mean of f(x) / pdf(x) over independent samples."""
        rng = np.random.default_rng(seed)
        total, done, wall, cpu = np.zeros(self._shape), 0, 0.0, 0.0
        for spp in ladder:
            begin, cpu_begin = time.perf_counter(), time.process_time()  # what others do between does not count
            for _ in range(done, spp):
                x = self.warp(1.0 - rng.random(self._shape))  # in (0, 1]
                total += 3.0 * x**2 / self.pdf(x)
            done = spp
            wall += time.perf_counter() - begin
            cpu += time.process_time() - cpu_begin
            yield Point(spp, wall, cpu, (total / spp).astype(np.float32), paths=total.size * spp)
            if seconds is not None and wall >= seconds:
                return


def uniform(label: str) -> Integral:
    """Take all x alike: a variance of 4/5 a sample."""
    return Integral(label, lambda u: u, np.ones_like)


def linear(label: str) -> Integral:
    """Take more samples where f is large, pdf 2 x: a variance of 1/8."""
    return Integral(label, np.sqrt, lambda x: 2.0 * x)


def matching(label: str) -> Integral:
    """Take f itself for the pdf: every sample gives the answer."""
    return Integral(label, np.cbrt, lambda x: 3.0 * x**2)


def opposite(label: str) -> Integral:
    """Take more samples where f is small, pdf 2 (1 - x): unbiased, and the variance is infinite."""
    return Integral(label, lambda u: 1.0 - np.sqrt(u), lambda x: 2.0 * (1.0 - x))
