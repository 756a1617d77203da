"""Normals for meshes without normals that have both round parts and hard edges.

An edge is hard if its two faces meet at more than the crease angle: the angle between their normals, 0 where they lie
in one plane. Faces around a vertex share a normal as far as no hard edge is between them. An edge of one face, or of
more than two, is hard too, and so is one whose faces are wound in opposite directions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.core import SMOOTHING
from equaltime.scene.meshes import smooth_normals

__all__ = ["Creased", "creased", "has_creases"]

Vectors = NDArray[np.float64]
Indices = NDArray[np.intp]

_LOOKED_AT: Final = 100_000
"""Largest number of faces in which `has_creases` looks for edges, so that a large mesh loads as fast: they take about a
tenth of a second."""
_ROUNDING: Final = 1e-6
"""Cosine by which an angle may be too large because of rounding: a nonagon's 40 degrees are no more than 40."""


class Mesh(Protocol):
    """Vertices (N, 3), faces (M, 3), texture coordinates (N, 2), attributes and warnings of a mesh file."""

    @property
    def vertices(self) -> Vectors: ...
    @property
    def faces(self) -> NDArray[np.uint32]: ...
    @property
    def uvs(self) -> Vectors | None: ...
    @property
    def attributes(self) -> Mapping[str, Vectors]: ...
    @property
    def warnings(self) -> list[str]: ...


@dataclass(frozen=True, slots=True, eq=False)
class Creased:
    """A mesh with normals that are smooth except at hard edges, with the field names of `equaltime._core.MeshData`."""

    vertices: Vectors
    """Positions (K, 3), K >= N: a vertex at a hard edge is there once for each of its normals."""
    faces: NDArray[np.uint32]
    normals: Vectors
    """Unit normals (K, 3)."""
    uvs: Vectors | None
    attributes: Mapping[str, Vectors]
    warnings: list[str]


def creased(mesh: Mesh, angle: float) -> Creased:
    """Return `mesh` with normals by the crease angle `angle`, in degrees from 0 to 180.

    Vertices at one position count as one, whatever their texture coordinates. Without a hard edge, `smooth_normals`
    gives the same normals.
    """
    from scipy.sparse import coo_array  # late: slow to import
    from scipy.sparse.csgraph import connected_components

    places, corners = _places(mesh.vertices, mesh.faces)
    pairs = _edge_pairs(corners)
    soft = pairs[~_hard(mesh.vertices, mesh.faces, pairs, angle)].reshape(-1, 2)
    links = coo_array((np.ones(len(soft), np.int8), (soft[:, 0], soft[:, 1])), shape=(corners.size,) * 2)
    count, groups = connected_components(links, directed=False)
    first = np.empty(count, np.intp)
    first[groups] = corners.ravel()
    normals = smooth_normals(places[first], groups.astype(np.uint32).reshape(-1, 3))
    keys, faces = np.unique(mesh.faces.ravel().astype(np.int64) * count + groups, return_inverse=True)
    source = keys // count
    return Creased(
        mesh.vertices[source],
        faces.astype(np.uint32).reshape(-1, 3),
        normals[keys % count],
        None if mesh.uvs is None else mesh.uvs[source],
        {name: values[source] if name.startswith("vertex_") else values for name, values in mesh.attributes.items()},
        [
            text.split(SMOOTHING)[0] + f"edges of more than {angle:g} degrees are hard" if SMOOTHING in text else text
            for text in mesh.warnings
        ],
    )


def has_creases(mesh: Mesh, angle: float) -> bool:
    """Tell whether two faces of `mesh` meet at more than `angle`, in degrees; only 100,000 faces are looked at."""
    faces = mesh.faces[:_LOOKED_AT]
    _, corners = _places(mesh.vertices, faces)
    return bool(_hard(mesh.vertices, faces, _edge_pairs(corners), angle).any())


def _places(vertices: Vectors, faces: NDArray[np.uint32]) -> tuple[Vectors, Indices]:
    """Return the positions that faces use, each once, and the indices (M, 3) of the faces' corners among them."""
    used, corners = np.unique(faces, return_inverse=True)
    points = vertices[used].astype(np.float64)
    order = np.lexsort(points.T)
    new = np.ones(len(order), bool)
    new[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    number = np.empty(len(order), np.intp)
    number[order] = np.cumsum(new) - 1
    return points[order[new]], number[corners.reshape(faces.shape)]


def _edge_pairs(corners: Indices) -> Indices:
    """Return, for each edge of exactly two faces, the two corners at each of its ends: an array (E, 2, 2).

    The first corner of a pair is of one face, the second of the other; 3 f + k is corner k of face f. Faces with two
    corners at one position have no area and are left out, such as those at the pole of a sphere.
    """
    number = np.arange(corners.size).reshape(-1, 3)
    begin, end = corners, np.roll(corners, -1, axis=1)
    whole = (begin != end).all(axis=1)
    begin, end = begin[whole].ravel(), end[whole].ravel()
    at_begin, at_end = number[whole].ravel(), np.roll(number, -1, axis=1)[whole].ravel()
    turned = begin > end
    key = np.minimum(begin, end).astype(np.int64) * (corners.max() + 1) + np.maximum(begin, end)
    low, high = np.where(turned, at_end, at_begin), np.where(turned, at_begin, at_end)
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    two = starts[np.diff(starts, append=len(order)) == 2]
    one, other = order[two], order[two + 1]
    return np.stack([np.stack([low[one], low[other]], 1), np.stack([high[one], high[other]], 1)], 1)


def _hard(vertices: Vectors, faces: NDArray[np.uint32], pairs: Indices, angle: float) -> NDArray[np.bool_]:
    """Return for each pair of `_edge_pairs` whether its faces meet at more than `angle`, in degrees."""
    corners = vertices[faces].astype(np.float64)
    flat = smooth_normals(corners.reshape(-1, 3), np.arange(3 * len(faces), dtype=np.uint32).reshape(-1, 3))
    one, other = flat[pairs[:, 0, 0]], flat[pairs[:, 0, 1]]
    sharp: NDArray[np.bool_] = np.einsum("ij,ij->i", one, other) < math.cos(math.radians(angle)) - _ROUNDING
    return sharp
