"""The pinhole camera, the pixel filters and the primary hits, in Mitsuba's conventions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equaltime.crosscheck.vectors import Array, Index, normalize
from equaltime.crosscheck.world import World
from equaltime.errors import RenderError
from equaltime.scene import Scene
from equaltime.scene.model import Box, Filter, Gaussian, Perspective, SceneModel, Tent, as_array, poses
from equaltime.scene.motion import still

__all__ = ["Camera", "PrimaryHits", "camera_of", "filter_offsets", "primary_hits"]

GAUSSIAN_CUT = 4.0
"""Radius of the Gaussian filter, in standard deviations; the filter is shifted down to be zero there."""


class Camera:
    """A pinhole camera that makes rays through points on the film.

    Camera space looks along +z, with +x to the left of the image and +y up. Points on the film are in pixels of the
    whole film, from its upper left corner: the middle of the first pixel is (0.5, 0.5).
    """

    def __init__(self, sensor: Perspective) -> None:
        self._film = sensor.film
        self._to_world = as_array(poses(sensor.to_world)[0])
        self._half_width = math.tan(math.radians(sensor.x_fov) / 2.0)
        self._principal_point = np.array([sensor.principal_point_offset_x, sensor.principal_point_offset_y])
        self._near = sensor.near_clip or 0.0
        self._far = sensor.far_clip or math.inf

    @property
    def origin(self) -> Array:
        """Position of the pinhole (3,) in the world."""
        return self._to_world[:3, 3]

    def pixels(self) -> Array:
        """Return the upper left corner (x, y) of each pixel of the crop window, as rows (height * width, 2).

        Corners are in pixels of the whole film.
        """
        x, y, width, height = self._film.crop
        columns, rows = np.meshgrid(np.arange(x, x + width), np.arange(y, y + height))
        return np.stack([columns, rows], axis=-1).reshape(-1, 2).astype(np.float64)

    def rays(self, places: Array) -> tuple[Array, Array, Array]:
        """Return rays through points of the film: unit directions, and distances to the near and to the far plane.

        `places` (N, 2) are the points, in pixels of the whole film. Directions (N, 3) start at `origin`. Both distances
        (N,) are along each ray, from the pinhole.
        """
        width, height = self._film.size
        x, y = (1.0 - 2.0 * (places / (width, height) + self._principal_point)).T
        local = np.stack([self._half_width * x, self._half_width * height / width * y, np.ones_like(x)], axis=1)
        length = np.sqrt((local**2).sum(axis=1))
        directions = normalize(local @ self._to_world[:3, :3].T)
        return directions, self._near * length, self._far * length


def camera_of(model: SceneModel) -> Perspective:
    """Return the scene's pinhole camera; raises RenderError for any other sensor."""
    if not isinstance(model.sensor, Perspective):
        raise RenderError(f"the cross-check cannot trace '{model.sensor.type}'")
    return model.sensor


def filter_offsets(rfilter: Filter, count: int, rng: np.random.Generator) -> Array:
    """Return random offsets (count, 2) from the middle of a pixel, with the pixel filter as density.

    The pixel value is then the unweighted mean of its samples. Both coordinates are drawn independently, since each
    filter is a product of a function of x and a function of y.
    """
    if isinstance(rfilter, Box):
        return rng.uniform(-0.5, 0.5, (count, 2))
    if isinstance(rfilter, Tent):  # the sum of two uniform numbers has this density
        return rfilter.radius * (rng.random((count, 2)) - rng.random((count, 2)))
    if not isinstance(rfilter, Gaussian):
        raise RenderError(f"the cross-check cannot sample the filter '{rfilter.type}'")
    return rfilter.stddev * _cut_gaussian(2 * count, rng).reshape(count, 2)


def _cut_gaussian(count: int, rng: np.random.Generator) -> Array:
    """Return numbers with density proportional to exp(-x^2/2) - exp(-cut^2/2), by rejection from normal numbers."""
    x, pending = np.empty(count), np.arange(count)
    while pending.size:
        proposed = rng.standard_normal(pending.size)
        accepted = rng.random(pending.size) < 1.0 - np.exp(0.5 * (proposed**2 - GAUSSIAN_CUT**2))
        x[pending[accepted]] = proposed[accepted]
        pending = pending[~accepted]
    return x


@dataclass(frozen=True, slots=True, eq=False)
class PrimaryHits:
    """First surface hit by the ray through the middle of each pixel of the crop window, to compare geometry."""

    shape: Index
    """Index of the hit shape among the scene's shapes (H, W); -1 without a hit."""
    primitive: Index
    """Index of a mesh's triangle, 0 for other shapes (H, W); -1 without a hit."""
    t: Array
    """Distance from the pinhole (H, W); infinite without a hit."""
    point: Array
    """Hit point (H, W, 3); NaN without a hit."""


def primary_hits(scene: Scene) -> PrimaryHits:
    """Return the first surface that the ray through each pixel's middle hits, in arrays (H, W) of the crop window.

    Surfaces outside the clip planes are ignored. A moving scene is taken at the middle of the shutter time.
    """
    model = still(scene.model)
    camera, world = Camera(camera_of(model)), World(model, scene.assets)
    directions, near, far = camera.rays(camera.pixels() + 0.5)
    origins = camera.origin + near[:, None] * directions
    t, patch = world.intersect(origins, directions, np.full(len(directions), -1))
    patch = np.where(t <= far - near, patch, -1)
    there = patch >= 0
    hits = world.hits(origins, directions, t, patch)
    height, width = scene.model.sensor.film.crop[3], scene.model.sensor.film.crop[2]
    return PrimaryHits(
        np.where(there, world.shape[patch] if world.shape.size else -1, -1).reshape(height, width),
        np.where(there, world.primitive[patch] if world.shape.size else -1, -1).reshape(height, width),
        np.where(there, t + near, np.inf).reshape(height, width),
        np.where(there[:, None], hits.point, np.nan).reshape(height, width, 3),
    )
