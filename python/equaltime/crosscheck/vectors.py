"""Vectors as rows of (N, 3) float64 arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Array", "Frames", "Index", "Mask", "dot", "normalize", "perpendicular"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


def dot(a: Array, b: Array) -> Array:
    """Return the scalar products (N,) of the rows of two arrays (N, 3)."""
    product: Array = np.einsum("...i,...i->...", a, b)
    return product


def normalize(a: Array) -> Array:
    """Return the rows (N, 3) of `a`, each scaled to length 1."""
    unit: Array = a / np.sqrt(dot(a, a))[..., None]
    return unit


def perpendicular(n: Array) -> Array:
    """Return a unit vector perpendicular to each unit vector in `n`, as an array (N, 3).

    Mitsuba chooses the same vector for a surface without a tangent.

    See Duff et al. 2017, "Building an orthonormal basis, revisited".
    """
    sign = np.copysign(1.0, n[:, 2])
    a = -1.0 / (sign + n[:, 2])
    return np.stack([1.0 + sign * n[:, 0] ** 2 * a, sign * n[:, 0] * n[:, 1] * a, -sign * n[:, 0]], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Orthonormal frames, one per row, to turn directions to local coordinates: axes s, t and normal n, each (N, 3).

    A local direction has z equal to the cosine of its angle with n.
    """

    s: Array
    t: Array
    n: Array

    @classmethod
    def from_normals(cls, n: Array, tangents: Array) -> Frames:
        """Return frames with unit normals ``n`` (N, 3).

        The axis s is along ``tangents`` (N, 3), projected onto the surface; tangents may have any length.
        """
        s = tangents - n * dot(n, tangents)[:, None]
        useless = ~(dot(s, s) > 1e-24 * dot(tangents, tangents))
        s[useless] = perpendicular(n[useless])
        s = normalize(s)
        return cls(s, np.cross(n, s), n)

    def to_local(self, v: Array) -> Array:
        """Return the world directions ``v`` (N, 3) in local coordinates, row by row."""
        return np.stack([dot(v, self.s), dot(v, self.t), dot(v, self.n)], axis=1)

    def to_world(self, v: Array) -> Array:
        """Return the local directions ``v`` (N, 3) in world coordinates, row by row."""
        world: Array = v[:, :1] * self.s + v[:, 1:2] * self.t + v[:, 2:] * self.n
        return world
