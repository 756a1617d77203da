"""Environment emitters: a constant sky, or a latitude-longitude image in Mitsuba's orientation."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from equaltime.crosscheck.vectors import Array
from equaltime.scene.assets import Assets
from equaltime.scene.model import Constant, EnvMap, as_array

__all__ = ["ConstantEnvironment", "Environment", "ImageEnvironment", "make_environment"]


class Environment(Protocol):
    """Interface of an environment emitter: radiance from every direction, with importance sampling of directions."""

    def radiance(self, directions: Array) -> Array:
        """Return the radiance (N, 3) that arrives from unit world directions (N, 3)."""

    def pdf(self, directions: Array) -> Array:
        """Return the density per solid angle (N,) with which `sample` draws unit world directions (N, 3)."""

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """Return random unit world directions (count, 3) towards the environment."""


def make_environment(emitter: Constant | EnvMap, assets: Assets) -> Environment | None:
    """Return the environment that an emitter of the scene describes, or None if the environment is black."""
    if isinstance(emitter, Constant):
        return ConstantEnvironment(np.array(emitter.radiance)) if any(emitter.radiance) else None
    image = ImageEnvironment(assets.image(emitter).astype(np.float64) * emitter.scale, as_array(emitter.to_world))
    return image if image.total > 0.0 else None


class ConstantEnvironment:
    """A constant environment, sampled uniformly over the sphere."""

    def __init__(self, radiance: Array) -> None:
        self._radiance = radiance

    def radiance(self, directions: Array) -> Array:
        """Return the constant radiance (N, 3) that arrives from each of `directions` (N, 3)."""
        return np.tile(self._radiance, (len(directions), 1))

    def pdf(self, directions: Array) -> Array:
        """Return the density per solid angle (N,) with which `sample` draws each of `directions` (N, 3): 1 / (4 pi)."""
        return np.full(len(directions), 0.25 / math.pi)

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """Return random unit world directions (count, 3), uniform over the sphere."""
        z, phi = rng.uniform(-1.0, 1.0, count), rng.uniform(0.0, 2.0 * math.pi, count)
        r = np.sqrt(1.0 - z**2)
        return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


class ImageEnvironment:
    """An image of H rows and W columns around the scene, interpolated bilinearly.

    Row i is centred at the polar angle pi i / (H - 1) from the local +y axis. Column j is centred at the angle
    2 pi (j + 1/2) / W from the local -z axis, turning towards +x; columns wrap around. The image thus has W (H - 1)
    cells, each between four texel centres. `sample` picks a cell, then a uniform point in the cell. The probability of
    a cell is proportional to its mean brightness times its solid angle.
    """

    def __init__(self, pixels: Array, to_world: Array) -> None:
        self._texels = np.concatenate([pixels, pixels[:, :1]], axis=1)
        self._rotation = to_world[:3, :3] / np.linalg.norm(to_world[:3, :3], axis=0)
        self._rows, self._columns = pixels.shape[0] - 1, pixels.shape[1]
        grey = self._texels.mean(axis=2)
        brightness = grey[1:, 1:] + grey[1:, :-1] + grey[:-1, 1:] + grey[:-1, :-1]
        middles = math.pi * (np.arange(self._rows) + 0.5) / self._rows
        self._running = np.cumsum(brightness * np.sin(middles)[:, None])
        self._pick = np.diff(self._running, prepend=0.0) / max(self.total, 1e-300)

    @property
    def total(self) -> float:
        """Sum of the sampling weights of all cells; 0 for a black image."""
        return float(self._running[-1])

    def radiance(self, directions: Array) -> Array:
        """Return the radiance (N, 3) from unit world directions (N, 3), interpolated between texels."""
        x, y = self._place(directions)
        column, row = x.astype(np.int64), y.astype(np.int64)
        right, down = (x - column)[:, None], (y - row)[:, None]
        upper = (1.0 - right) * self._texels[row, column] + right * self._texels[row, column + 1]
        lower = (1.0 - right) * self._texels[row + 1, column] + right * self._texels[row + 1, column + 1]
        interpolated: Array = (1.0 - down) * upper + down * lower
        return interpolated

    def pdf(self, directions: Array) -> Array:
        """Return the density per solid angle (N,) with which `sample` draws unit world directions (N, 3)."""
        x, y = self._place(directions)
        cell = y.astype(np.int64) * self._columns + x.astype(np.int64)
        sine = np.sin(math.pi * y / self._rows)
        # density over places in the image, then over angles, then over solid angle
        per_place = self._pick[cell] * self._rows * self._columns
        density: Array = per_place / (2.0 * math.pi**2 * np.maximum(sine, 1e-300))
        return density

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """Return random unit world directions (count, 3): a cell by its weight, then a uniform point in the cell."""
        cell = np.searchsorted(self._running, rng.uniform(0.0, self.total, count), side="right")
        row, column = np.divmod(np.minimum(cell, self._running.size - 1), self._columns)
        theta = math.pi * (row + rng.random(count)) / self._rows
        phi = 2.0 * math.pi * (column + 0.5 + rng.random(count)) / self._columns
        sine = np.sin(theta)
        local = np.stack([np.sin(phi) * sine, np.cos(theta), -np.cos(phi) * sine], axis=1)
        world: Array = local @ self._rotation.T
        return world

    def _place(self, directions: Array) -> tuple[Array, Array]:
        """Return the real-valued column and row at which directions meet the image, below the last ones."""
        x, y, z = (directions @ self._rotation).T
        column = np.mod(np.arctan2(x, -z) / (2.0 * math.pi) * self._columns - 0.5, self._columns)
        row = np.arccos(np.clip(y, -1.0, 1.0)) / math.pi * self._rows
        return np.minimum(column, self._columns * (1 - 1e-15)), np.minimum(row, self._rows * (1 - 1e-15))
