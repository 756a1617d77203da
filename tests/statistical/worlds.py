"""Small scenes that the statistical, analytic, invariance and hard-case tests share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from equaltime import _core
from equaltime.film.moments import squared_deviations
from equaltime.statistics.agreement import sidak

__all__ = ["Estimate", "affine", "build", "direction", "estimate", "looking", "octahedron", "render", "turned"]

Array = NDArray[np.float64]
Add = Callable[[_core.SceneBuilder], object]


def direction(theta: float, phi: float = 0.0) -> Array:
    """Return the local direction at `theta` degrees from the normal, `phi` degrees round it, as float32 has it."""
    t, p = np.radians(theta), np.radians(phi)
    wi = np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    return wi.astype(np.float32).astype(np.float64)


def affine(x: ArrayLike, y: ArrayLike, z: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the transform whose axes are x, y and z."""
    matrix = np.eye(4)
    matrix[:3, :] = np.stack([np.asarray(v, dtype=float) for v in (x, y, z, origin)], axis=1)
    return matrix


def turned(axis: ArrayLike, degrees: float) -> Array:
    """Return the rotation (3, 3) about an axis."""
    u, t = np.asarray(axis, dtype=float), np.radians(degrees)
    u = u / np.linalg.norm(u)
    cross = np.cross(np.eye(3), u)
    rotation: Array = np.cos(t) * np.eye(3) + np.sin(t) * cross + (1.0 - np.cos(t)) * np.outer(u, u)
    return rotation


def looking(origin: ArrayLike, towards: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Array:
    """Return the transform of a camera."""
    z = np.asarray(towards, dtype=float) - np.asarray(origin, dtype=float)
    z = z / np.linalg.norm(z)
    x = np.cross(np.asarray(up, dtype=float), z)
    x = x / np.linalg.norm(x)
    return affine(x, np.cross(z, x), z, origin)


def build(
    *add: Add,
    eye: ArrayLike = (0.0, 0.0, 0.0),
    camera: Array | None = None,
    fov: float = 40.0,
    size: tuple[int, int] = (1, 1),
) -> _core.Scene:
    """Return the scene of what the given functions add. The camera looks from `eye` along z, if it is not given."""
    builder = _core.SceneBuilder()
    for function in add:
        function(builder)
    builder.set_perspective(np.array(affine(*np.eye(3), eye) if camera is None else camera), fov)
    builder.set_film(*size, (0, 0, *size), "box", 0.5)
    return builder.build()


@dataclass(frozen=True, eq=False)
class Estimate:
    """The mean over all samples of a film whose pixels all have the same expectation."""

    mean: Array
    error: Array
    """Standard error of each channel."""
    least: Array
    most: Array
    """Of the pixels' means."""

    def p(self, exact: ArrayLike) -> float:
        """Return the p-value of the hypothesis that the expectation is `exact`, by a z-test of each channel."""
        off = np.abs(self.mean - exact) / (self.error + ROUNDING * np.abs(exact))
        return sidak(2.0 * float(stats.norm.sf(off.max())), 3)


ROUNDING = 1e-6
"""What float32 may do to a mean, relative."""


def estimate(scene: _core.Scene, spp: int, seed: int = 1, **settings: object) -> Estimate:
    """Render with independent numbers, whose samples are all independent."""
    film = render(scene, spp, seed, sampler="independent", **settings)[0]
    count, mean = film["count"].sum(), film["mean"]
    squares = squared_deviations(film).sum(axis=(0, 1))
    total = mean.mean(axis=(0, 1))
    between = ((mean - total) ** 2).sum(axis=(0, 1)) * spp
    error = np.sqrt((squares + between) / count / count)
    return Estimate(total, error, mean.min(axis=(0, 1)), mean.max(axis=(0, 1)))


def render(
    scene: _core.Scene,
    spp: int,
    seed: int = 1,
    *,
    replicates: int = 1,
    threads: int = 2,
    tile: int = 16,
    **settings: Any,
) -> NDArray[Any]:
    """Return the moments (replicates, height, width) of a render that must be finite everywhere."""
    renderer = _core.Renderer(scene, _core.Settings(**settings), seed, threads, tile, replicates)
    assert renderer.advance(spp)
    assert not renderer.nonfinite
    moments: NDArray[Any] = renderer.moments.copy()
    return moments


def octahedron(levels: int, radius: float = 1.0, center: ArrayLike = (0, 0, 0)) -> tuple[Array, NDArray[np.uint32]]:
    """Return vertices and faces of an octahedron, subdivided and blown up to a sphere; normals point outwards."""
    vertices = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], dtype=float)
    faces = [(x, y, z) if (x + y + z) % 2 else (x, z, y) for x in (0, 3) for y in (1, 4) for z in (2, 5)]
    for _ in range(levels):
        corners = vertices[np.array(faces)]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        ab, bc, ca = a + b, b + c, c + a
        parts = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        vertices, index = np.unique(np.round(parts.reshape(-1, 3), 12), axis=0, return_inverse=True)
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
        faces = [tuple(f) for f in index.reshape(-1, 3).tolist()]
    return radius * vertices + np.asarray(center), np.array(faces, dtype=np.uint32)
