"""Primary hits: the first surface that the ray through the middle of each pixel hits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equaltime.crosscheck.camera import Camera
from equaltime.crosscheck.refusal import camera_of
from equaltime.crosscheck.vectors import Array, Index
from equaltime.crosscheck.world import World
from equaltime.scene import Scene
from equaltime.scene.motion import still

__all__ = ["PrimaryHits", "primary_hits"]


@dataclass(frozen=True, slots=True, eq=False)
class PrimaryHits:
    """First surface hit by the ray through each pixel's middle, for the pixels of the crop window."""

    shape: Index
    """Index in the scene's shapes (H, W); -1 without a hit."""
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
