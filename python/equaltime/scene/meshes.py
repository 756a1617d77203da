"""Triangles in world space: the placement and orientation of meshes, cubes and rectangles.

Arrays are float64 (N, 3) for vertices and normals, uint32 (M, 3) for faces. A face is counter-clockwise when seen from
its front side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = [
    *("CUBE_FACES", "CUBE_UVS", "CUBE_VERTICES", "QUAD_FACES", "QUAD_VERTICES"),
    *("flip", "place", "place_normals", "smooth_normals"),
]

Vectors = NDArray[np.float64]
Faces = NDArray[np.uint32]

CHUNK = 1 << 15
IDENTITY: Vectors = np.eye(4)

QUAD_VERTICES: Vectors = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float64)
QUAD_FACES: Faces = np.array([[0, 1, 2], [2, 3, 0]], dtype=np.uint32)
CUBE_VERTICES: Vectors = np.array(
    [
        *([1, -1, -1], [1, -1, 1], [-1, -1, 1], [-1, -1, -1]),  # y = -1
        *([1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]),  # y = 1
        *([1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]),  # x = 1
        *([1, -1, 1], [1, 1, 1], [-1, 1, 1], [-1, -1, 1]),  # z = 1
        *([-1, -1, 1], [-1, 1, 1], [-1, 1, -1], [-1, -1, -1]),  # x = -1
        *([1, 1, -1], [1, -1, -1], [-1, -1, -1], [-1, 1, -1]),  # z = -1
    ],
    dtype=np.float64,
)  # four vertices for each face, counter-clockwise from outside
CUBE_UVS: Vectors = np.tile(np.array([[0, 1], [1, 1], [1, 0], [0, 0]], dtype=np.float64), (6, 1))
CUBE_FACES: Faces = np.array(
    [triangle for k in range(0, 24, 4) for triangle in ([k, k + 1, k + 2], [k + 3, k, k + 2])], dtype=np.uint32
)


def place(vertices: Vectors, to_world: Vectors) -> Vectors:
    """Return the vertices (N, 3), transformed to world space; raises ValueError if a coordinate overflows float64."""
    if (to_world == IDENTITY).all():
        return vertices
    with np.errstate(over="ignore", invalid="ignore"):
        placed = _times(vertices, to_world[:3, :3].T) + to_world[:3, 3]
    if not np.isfinite(placed).all():
        point = int(np.flatnonzero(~np.isfinite(placed).all(axis=1))[0])
        raise ValueError(f"to_world takes point {point} to infinity: {vertices[point].tolist()}")
    return placed


def place_normals(normals: Vectors, to_world: Vectors) -> Vectors:
    """Return the unit normals (N, 3), transformed to world space; a zero normal stays zero."""
    return _unit(_times(normals, np.asarray(np.linalg.inv(to_world[:3, :3]), dtype=np.float64)))


def _times(rows: Vectors, matrix: Vectors) -> Vectors:
    """Return rows (N, 3) times matrix (3, 3), without BLAS, whose bits and threads depend on the machine."""
    product: Vectors = rows[:, :1] * matrix[0] + rows[:, 1:2] * matrix[1] + rows[:, 2:] * matrix[2]
    return product


def smooth_normals(vertices: Vectors, faces: Faces) -> Vectors:
    """Return unit vertex normals (N, 3): means of the adjacent faces' normals, weighted by the angles at the vertex.

    Mitsuba 3 gives these normals to a mesh without normals (Thürmer and Wüthrich 1998, "Computing Vertex Normals from
    Polygonal Facets"). A vertex without any area around it gets the normal +x, as in Mitsuba.
    """
    sums = np.zeros(vertices.size)
    for start in range(0, len(faces), CHUNK):  # chunks that stay in the cache
        corners = faces[start : start + CHUNK].astype(np.intp)
        np.add.at(sums, 3 * corners[:, :, None] + np.arange(3), _weighted_normals(vertices[corners]))
    normals = _unit(sums.reshape(-1, 3))
    normals[~normals.any(axis=1)] = (1.0, 0.0, 0.0)
    return normals


def _weighted_normals(points: Vectors) -> Vectors:
    """Return the unit normal of each triangle (n, 3, 3) times its angle, for each of its corners."""
    edges = np.roll(points, -1, axis=1) - points
    largest = np.abs(edges).max(axis=(1, 2), keepdims=True)  # so that squares neither overflow nor vanish
    np.divide(edges, largest, out=edges, where=largest > 0.0)
    cross = np.cross(edges[:, 0], edges[:, 1])
    sine = np.sqrt(np.einsum("ni,ni->n", cross, cross))[:, None]  # both times the same two lengths
    cosine = -np.einsum("nci,nci->nc", edges, np.roll(edges, 1, axis=1))
    normal = np.divide(cross, sine, out=np.zeros_like(cross), where=sine > 0.0)
    weighted: Vectors = np.arctan2(sine, cosine)[:, :, None] * normal[:, None, :]
    return weighted


def _unit(vectors: Vectors) -> Vectors:
    """Return the vectors scaled to length 1; zero vectors stay zero."""
    largest = np.abs(vectors).max(axis=1, keepdims=True)  # so that squares neither overflow nor vanish
    scaled = np.divide(vectors, largest, out=np.zeros_like(vectors), where=largest > 0.0)
    lengths = np.sqrt(np.einsum("ij,ij->i", scaled, scaled))[:, None]
    unit: Vectors = np.divide(scaled, lengths, out=scaled, where=lengths > 0.0)
    return unit


def flip(faces: Faces) -> Faces:
    """Return the faces (M, 3) with the opposite orientation: the same vertices in the opposite order."""
    return np.ascontiguousarray(faces[:, [0, 2, 1]])
