"""Small scenes that the statistical, analytic, invariance and hard-case tests share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime import _core

__all__ = ["affine", "build", "direction", "octahedron", "turned"]

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


def build(*add: Add, eye: ArrayLike = (0.0, 0.0, 0.0)) -> _core.Scene:
    """Return the scene of what the given functions add, with a camera of one pixel."""
    builder = _core.SceneBuilder()
    for function in add:
        function(builder)
    builder.set_perspective(affine([1, 0, 0], [0, 1, 0], [0, 0, 1], eye), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    return builder.build()


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
