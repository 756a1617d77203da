"""Charts: maps from the unit square to directions, for `chi2`. Each knows how solid angle is stretched.

Directions of BSDFs are local (z along the normal); those of lights are seen from a receiver in world space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "ConeChart",
    "CylinderChart",
    "DiskChart",
    "HalfVectorChart",
    "LatLongChart",
    "RectangleChart",
    "SphereChart",
    "TriangleChart",
]

Array = NDArray[np.float64]
TAU = 2.0 * np.pi
GRAZING = 0.05


def unit(v: ArrayLike) -> Array:
    v = np.asarray(v, dtype=float)
    length: Array = v / np.linalg.norm(v, axis=-1, keepdims=True)
    return length


def frame(axis: ArrayLike) -> Array:
    """Return an orthonormal basis as rows, the last along `axis`."""
    z = unit(axis)
    x = unit(np.cross(z, np.eye(3)[np.argmin(np.abs(z))]))
    return np.stack([x, np.cross(z, x), z])


def turn(y: Array, x: Array) -> Array:
    """Return the azimuth in [0, 1)."""
    return np.asarray(np.arctan2(y, x) / TAU % 1.0)


def spherical(cosine: Array, one_minus_cosine: Array, azimuth: Array) -> Array:
    sine = np.sqrt(one_minus_cosine * (1.0 + cosine))
    return np.stack([sine * np.cos(TAU * azimuth), sine * np.sin(TAU * azimuth), cosine], axis=-1)


@dataclass(frozen=True, eq=False)
class SphereChart:
    """All directions, or the upper half: first coordinate down from a pole, second round it; equal areas."""

    half: bool = False
    pole: Array | None = None
    """z if None."""

    @property
    def basis(self) -> Array:
        return np.eye(3) if self.pole is None else frame(self.pole)

    @property
    def range(self) -> float:
        return 1.0 if self.half else 2.0

    def directions(self, square: Array) -> tuple[Array, Array]:
        one_minus = self.range * square[:, 0]
        local = spherical(1.0 - one_minus, one_minus, square[:, 1])
        return local @ self.basis, np.full(len(square), self.range * TAU)

    def places(self, directions: Array) -> Array:
        x, y, z = self.basis @ directions.T
        return np.stack([(1.0 - z) / self.range, turn(y, x)], axis=-1)


@dataclass(frozen=True, eq=False)
class ConeChart:
    """The cone that a sphere fills, seen from outside it; equal areas."""

    to_center: Array
    radius: float

    @property
    def range(self) -> float:
        """1 - cosine of the cone's half angle."""
        sine2 = self.radius**2 / float(self.to_center @ self.to_center)
        return float(sine2 / (1.0 + np.sqrt(1.0 - sine2)))

    def directions(self, square: Array) -> tuple[Array, Array]:
        one_minus = square[:, 0] * self.range
        local = spherical(1.0 - one_minus, one_minus, square[:, 1])
        return local @ frame(self.to_center), np.full(len(square), TAU * self.range)

    def places(self, directions: Array) -> Array:
        basis = frame(self.to_center)
        chord = directions - basis[2]
        one_minus = 0.5 * (chord * chord).sum(axis=-1)
        return np.stack([one_minus / self.range, turn(directions @ basis[1], directions @ basis[0])], axis=-1)


@dataclass(frozen=True, eq=False)
class LatLongChart:
    """Mitsuba's map of an environment: rows of equal polar angle from +y, columns from -z towards +x."""

    axes: Array
    """Of the map in world space, as columns."""

    def directions(self, square: Array) -> tuple[Array, Array]:
        theta, phi = np.pi * square[:, 0], TAU * square[:, 1]
        sine = np.sin(theta)
        local = np.stack([sine * np.sin(phi), np.cos(theta), -sine * np.cos(phi)], axis=-1)
        return local @ self.axes.T, np.pi * TAU * sine

    def places(self, directions: Array) -> Array:
        x, y, z = (directions @ self.axes).T
        return np.stack([np.arctan2(np.hypot(x, z), y) / np.pi, turn(x, -z)], axis=-1)


@dataclass(frozen=True, eq=False)
class HalfVectorChart:
    """Directions mirrored by microfacets: how steep the facet is, in units of roughness, and which way it leans.

    With r the stretched slope, 1 - P(r) = (1 - a)^2 for the P that makes D·cosθ uniform: the square stays smooth even
    for the visible normals at grazing incidence, which have twice the weight of the tail.
    """

    wo: Array
    distribution: str
    alpha_u: float
    alpha_v: float

    def directions(self, square: Array) -> tuple[Array, Array]:
        left = (1.0 - square[:, 0]) ** 2
        ggx = self.distribution == "ggx"
        r2 = (1.0 - left) / left if ggx else -np.log(left)
        derivative = 2.0 * (1.0 - square[:, 0]) / (left**2 if ggx else left)  # of r2 along the first coordinate
        r, phi = np.sqrt(r2), TAU * square[:, 1]
        m = unit(np.stack([self.alpha_u * r * np.cos(phi), self.alpha_v * r * np.sin(phi), np.ones_like(r)], axis=-1))
        facing = m @ self.wo
        wi = 2.0 * facing[:, None] * m - self.wo
        jacobian = 4.0 * facing * m[:, 2] ** 3 * self.alpha_u * self.alpha_v * 0.5 * derivative * TAU
        return wi, np.where((facing > 0) & (wi[:, 2] > 0), jacobian, 0.0)

    def places(self, directions: Array) -> Array:
        m = directions + self.wo
        if self.wo[2] < GRAZING:
            # Nearly opposite directions: their sum along the horizon follows from their lengths, which are equal.
            along = self.wo[:2] / np.hypot(*self.wo[:2])
            across = directions[:, 1] * along[0] - directions[:, 0] * along[1]
            away = directions[:, :2] @ along - self.wo[:2] @ along
            m_along = -((directions[:, 2] - self.wo[2]) * m[:, 2] + across**2) / away
            m[:, :2] = m_along[:, None] * along + across[:, None] * np.array([-along[1], along[0]])
        x, y = m[:, 0] / m[:, 2] / self.alpha_u, m[:, 1] / m[:, 2] / self.alpha_v
        r2 = x * x + y * y
        left = 1.0 / (1.0 + r2) if self.distribution == "ggx" else np.exp(-r2)
        return np.stack([1.0 - np.sqrt(left), turn(y, x)], axis=-1)


@dataclass(frozen=True, eq=False)
class _Plane:
    """What flat lights share: points origin + a·e1 + b·e2, seen from a receiver."""

    origin: Array
    e1: Array
    e2: Array
    receiver: Array

    def _seen(self, a: Array, b: Array, area: Array | float) -> tuple[Array, Array]:
        """Return directions to points, and the solid angle of `area` there."""
        normal = np.cross(self.e1, self.e2)
        to_point = (self.origin - self.receiver) + a[:, None] * self.e1 + b[:, None] * self.e2
        distance = np.linalg.norm(to_point, axis=-1)
        height = abs(float(unit(normal) @ (self.origin - self.receiver)))
        return to_point / distance[:, None], area * np.linalg.norm(normal) * height / distance**3

    def _met(self, directions: Array) -> tuple[Array, Array]:
        """Return a and b of the points where rays from the receiver meet the plane."""
        from_receiver = self.origin - self.receiver
        normal = np.cross(self.e1, self.e2)
        r = directions * ((normal @ from_receiver) / (directions @ normal))[:, None] - from_receiver
        square = normal @ normal
        return np.cross(r, self.e2) @ normal / square, np.cross(self.e1, r) @ normal / square


class RectangleChart(_Plane):
    def directions(self, square: Array) -> tuple[Array, Array]:
        return self._seen(square[:, 0], square[:, 1], 1.0)

    def places(self, directions: Array) -> Array:
        return np.stack(self._met(directions), axis=-1)


class TriangleChart(_Plane):
    """First coordinate: area share of the triangle cut off by a parallel to the far side."""

    def directions(self, square: Array) -> tuple[Array, Array]:
        s = np.sqrt(square[:, 0])
        return self._seen(s * (1.0 - square[:, 1]), s * square[:, 1], 0.5)

    def places(self, directions: Array) -> Array:
        a, b = self._met(directions)
        return np.stack([(a + b) ** 2, np.where(a + b > 0, b / (a + b), 0.0)], axis=-1)


class DiskChart(_Plane):
    """Points origin + r·cosφ·e1 + r·sinφ·e2: r² and φ."""

    def directions(self, square: Array) -> tuple[Array, Array]:
        r, phi = np.sqrt(square[:, 0]), TAU * square[:, 1]
        return self._seen(r * np.cos(phi), r * np.sin(phi), np.pi)

    def places(self, directions: Array) -> Array:
        a, b = self._met(directions)
        return np.stack([a * a + b * b, turn(b, a)], axis=-1)


@dataclass(frozen=True, eq=False)
class CylinderChart:
    """The part of a tube round the axis' unit vector, from -1 to 1 along it, whose front faces a receiver: height and
    azimuth. The front is the outside, or the inside.
    """

    axis: Array
    radius: float
    receiver: Array
    inward: bool

    @property
    def basis(self) -> Array:
        """Rows: towards the middle of what is seen, across that, and along the axis."""
        z = unit(self.axis)
        across = self.receiver - z * (self.receiver @ z)
        x = unit(across) * (-1.0 if self.inward and self._beyond else 1.0)
        return np.stack([x, np.cross(z, x), z])

    @property
    def _distance(self) -> float:
        z = unit(self.axis)
        return float(np.linalg.norm(self.receiver - z * (self.receiver @ z)))

    @property
    def _beyond(self) -> bool:
        return self._distance > self.radius

    @property
    def half(self) -> float:
        if not self._beyond:
            return np.pi
        outside = float(np.arccos(self.radius / self._distance))
        return np.pi - outside if self.inward else outside

    def directions(self, square: Array) -> tuple[Array, Array]:
        height, angle = 2.0 * square[:, 0] - 1.0, self.half * (2.0 * square[:, 1] - 1.0)
        normal = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1) @ self.basis
        to_point = self.radius * normal + height[:, None] * self.basis[2] - self.receiver
        distance = np.linalg.norm(to_point, axis=1)
        cosine = np.abs((normal * to_point).sum(axis=1)) / distance
        return to_point / distance[:, None], cosine / distance**2 * 4.0 * self.half * self.radius

    def places(self, directions: Array) -> Array:
        o, d = self.basis @ self.receiver, directions @ self.basis.T
        a, b = (d[:, :2] ** 2).sum(axis=1), d[:, :2] @ o[:2]
        root = np.sqrt(np.maximum(0.0, b**2 - a * (o[:2] @ o[:2] - self.radius**2)))
        t = (-b + (root if self.inward else -root)) / a
        at = o + t[:, None] * d
        return np.stack([0.5 * (at[:, 2] + 1.0), 0.5 * (np.arctan2(at[:, 1], at[:, 0]) / self.half + 1.0)], axis=-1)
