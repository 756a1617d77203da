"""Light sampling without importance: each light is equally probable, and points are uniform over a light's area."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equaltime.crosscheck.environment import Environment, make_environment
from equaltime.crosscheck.patches import DiskPatch, SpherePatch
from equaltime.crosscheck.vectors import Array, Index, dot
from equaltime.crosscheck.world import Hits, World
from equaltime.scene.assets import Assets
from equaltime.scene.geometry import Surface
from equaltime.scene.model import Constant, EnvMap, Point, SceneModel

__all__ = ["LightSamples", "Lights"]


@dataclass(slots=True, eq=False)
class LightSamples:
    """One light sample for each shaded point, a row per point: direction, distance, radiance and density."""

    wi: Array
    """Unit directions towards the light (N, 3)."""
    distance: Array
    """Distances to the light (N,); infinite for the environment."""
    radiance: Array
    """Unoccluded radiance (N, 3); for point lights intensity over squared distance."""
    pdf: Array
    """Density per solid angle (N,), including the choice of the light."""
    single: Array
    """Flags (N,): 1 if only light sampling can find the light (point lights), else 0."""


class Lights:
    """All lights of a scene, for light sampling: each is chosen with equal probability."""

    def __init__(self, model: SceneModel, surfaces: tuple[Surface, ...], world: World, assets: Assets) -> None:
        self._world = world
        self._emission = np.array([surface.sides.radiance or (0.0, 0.0, 0.0) for surface in surfaces]).reshape(-1, 3)
        self._surfaces = [_AreaLight(world, int(shape)) for shape in np.flatnonzero(self._emission.any(axis=1))]
        self._areas = np.full(len(surfaces), np.inf)
        for light in self._surfaces:
            self._areas[light.shape] = light.area
        self._points = [emitter for emitter in model.emitters if isinstance(emitter, Point)]
        around = [make_environment(e, assets) for e in model.emitters if isinstance(e, Constant | EnvMap)]
        self.environment: Environment | None = around[0] if around else None

    @property
    def count(self) -> int:
        """Number of lights to choose from: emitting shapes, point lights, and the environment."""
        return len(self._surfaces) + len(self._points) + (self.environment is not None)

    def emitted(self, hits: Hits, directions: Array) -> Array:
        """Return the radiance (N, 3) that the hit surfaces emit towards the rays' origins; only front sides emit.

        `directions` (N, 3) are the unit directions of the rays.
        """
        front = dot(hits.normal, directions) < 0.0
        emission: Array = np.where(front[:, None], self._emission[self._world.shape[hits.patch]], 0.0)
        return emission

    def surface_pdf(self, hits: Hits, directions: Array) -> Array:
        """Return the density per solid angle (N,) with which `sample` chooses the surface points in `hits`.

        `directions` (N, 3) are the unit directions of the rays that hit these points.
        """
        cosine = np.abs(dot(hits.normal, directions))
        area = self._areas[self._world.shape[hits.patch]]
        density: Array = hits.t**2 / (np.maximum(cosine, 1e-300) * area * max(self.count, 1))
        return density

    def environment_pdf(self, directions: Array) -> Array:
        """Return the density per solid angle (N,) with which `sample` chooses directions to the environment.

        `directions` (N, 3) are unit vectors.
        """
        if self.environment is None:
            return np.zeros(len(directions))
        return self.environment.pdf(directions) / self.count

    def sample(self, points: Array, rng: np.random.Generator) -> LightSamples:
        """Return a light sample for each of `points` (N, 3): a random light and a random point on the light.

        Whether the light is visible from the point is not tested.
        """
        n = len(points)
        samples = LightSamples(np.zeros((n, 3)), np.full(n, np.inf), np.zeros((n, 3)), np.ones(n), np.zeros(n))
        samples.wi[:, 2] = 1.0
        chosen = rng.integers(max(self.count, 1), size=n)
        for number, light in enumerate(self._surfaces):
            rows = np.flatnonzero(chosen == number)
            place, normal = light.sample(len(rows), rng)
            self._aim(samples, rows, points, place)
            cosine = -dot(normal, samples.wi[rows])
            samples.radiance[rows] = self._emission[light.shape] * (cosine > 0.0)[:, None]
            samples.pdf[rows] = samples.distance[rows] ** 2 / (np.maximum(cosine, 1e-300) * light.area * self.count)
        for number, point in enumerate(self._points, len(self._surfaces)):
            rows = np.flatnonzero(chosen == number)
            self._aim(samples, rows, points, np.array(point.world_position))
            samples.radiance[rows] = np.array(point.intensity) / samples.distance[rows, None] ** 2
            samples.pdf[rows], samples.single[rows] = 1.0 / self.count, 1.0
        if self.environment is not None:
            rows = np.flatnonzero(chosen == self.count - 1)
            samples.wi[rows] = self.environment.sample(len(rows), rng)
            samples.radiance[rows] = self.environment.radiance(samples.wi[rows])
            samples.pdf[rows] = self.environment_pdf(samples.wi[rows])
        return samples

    def _aim(self, samples: LightSamples, rows: Index, points: Array, places: Array) -> None:
        towards = places - points[rows]
        samples.distance[rows] = np.sqrt(dot(towards, towards))
        samples.wi[rows] = towards / samples.distance[rows, None]


class _AreaLight:
    """An emitting shape: triangles, a sphere or a disk."""

    def __init__(self, world: World, shape: int) -> None:
        self.shape = shape
        self._triangles = world.triangles
        self._rows = np.flatnonzero(world.triangles.shapes == shape)
        analytic: list[SpherePatch | DiskPatch] = [*world.spheres, *world.disks]
        self._patch = next((patch for patch in analytic if patch.shape == shape), None)
        self._running = np.cumsum(world.triangles.areas[self._rows])

    @property
    def area(self) -> float:
        """Area of the whole shape."""
        if isinstance(self._patch, SpherePatch):
            return 4.0 * math.pi * self._patch.radius**2
        if isinstance(self._patch, DiskPatch):
            axes = self._patch.to_world[:3, :2]
            return math.pi * float(np.linalg.norm(np.cross(axes[:, 0], axes[:, 1])))
        return float(self._running[-1]) if self._running.size else 0.0

    def sample(self, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return points uniform over the area, and the front side's normals there, (count, 3) each."""
        if isinstance(self._patch, SpherePatch):
            z, phi = rng.uniform(-1.0, 1.0, count), rng.uniform(0.0, 2.0 * math.pi, count)
            r = np.sqrt(1.0 - z**2)
            outward = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
            return self._patch.center + self._patch.radius * outward, self._patch.front * outward
        if isinstance(self._patch, DiskPatch):
            r, phi = np.sqrt(rng.random(count)), rng.uniform(0.0, 2.0 * math.pi, count)
            local = np.stack([r * np.cos(phi), r * np.sin(phi), np.zeros(count), np.ones(count)], axis=1)
            return (local @ self._patch.to_world.T)[:, :3], np.tile(self._patch.normal, (count, 1))
        picked = np.searchsorted(self._running, rng.uniform(0.0, self.area, count), side="right")
        row = self._rows[np.minimum(picked, len(self._rows) - 1)]
        a, b = np.sort(rng.random((2, count)), axis=0)  # the gaps between two random numbers are uniform weights
        weights = np.stack([a, b - a, 1.0 - b], axis=1)
        return np.einsum("nk,nki->ni", weights, self._triangles.corners[row]), self._triangles.normals[row]
