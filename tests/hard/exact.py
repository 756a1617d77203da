"""Where a ray meets a plane or a sphere, in exact rational arithmetic, and what float32 may leave of that."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import isqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "cross",
    "dot",
    "fractions",
    "meet_plane",
    "meet_sphere",
    "roundings",
    "textbook_sphere",
    "traced",
    "unit_normal",
]

Array = NDArray[np.float64]
Vector = Sequence[Fraction]

BITS = 200
"""Of a square root, behind the point."""


def fractions(vector: Iterable[float]) -> Vector:
    return [Fraction(float(x)) for x in vector]


def dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def minus(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def along(o: Vector, d: Vector, t: Fraction) -> Vector:
    return [x + t * y for x, y in zip(o, d, strict=True)]


def root(x: Fraction) -> Fraction:
    return Fraction(isqrt((x.numerator << 2 * BITS) // x.denominator), 1 << BITS)


def unit_normal(corners: ArrayLike) -> Array:
    """Return the unit normal (3,) of a triangle (3, 3), right to float64 for any shape."""
    a, b, c = (fractions(v) for v in np.asarray(corners, dtype=np.float64))
    n = cross(minus(b, a), minus(c, a))
    length = root(dot(n, n))
    return np.array([float(x / length) for x in n])


def meet_plane(origin: ArrayLike, direction: ArrayLike, corners: ArrayLike) -> Array:
    """Return the point (3,) where a ray meets the plane of a triangle (3, 3)."""
    a, b, c = (fractions(v) for v in np.asarray(corners, dtype=np.float64))
    o, d = fractions(np.asarray(origin)), fractions(np.asarray(direction))
    n = cross(minus(b, a), minus(c, a))
    return np.array([float(x) for x in along(o, d, dot(n, minus(a, o)) / dot(n, d))])


def meet_sphere(origin: ArrayLike, direction: ArrayLike, center: ArrayLike, radius: float) -> Array | None:
    """Return the first point (3,) where a ray meets a sphere, if any."""
    o, d, c = (fractions(np.asarray(v)) for v in (origin, direction, center))
    r = minus(o, c)
    a, half_b = dot(d, d), dot(r, d)
    discriminant = half_b**2 - a * (dot(r, r) - Fraction(radius) ** 2)
    if discriminant <= 0:
        return None
    times = [t for t in ((-half_b - root(discriminant)) / a, (-half_b + root(discriminant)) / a) if t > 0]
    return np.array([float(x) for x in along(o, d, times[0])]) if times else None


def textbook_sphere(directions: Array, center: Array, radius: float) -> Array:
    """Return where unit rays (N, 3) from the origin first meet a sphere by the textbook's quadratic in float32.

    NaN where that finds no point.
    """
    d, c = directions.astype(np.float32), center.astype(np.float32)
    b = (d * c).sum(axis=1)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - ((c * c).sum() - np.float32(radius) ** 2))
    t = np.where(b > root, b - root, b + root)
    points: Array = (t[:, None] * d).astype(np.float64)
    return points


def traced(directions: Array) -> Array:
    """Return directions (N, 3) as the core traces them: of unit length, in float32."""
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    rounded: Array = unit.astype(np.float32).astype(np.float64)
    return rounded


def roundings(points: Array, reference: Array, slope: ArrayLike, extent: float) -> Array:
    """Return by how much points (N, 3) are off, as a share of what rounding them to float32 excuses.

    That is half a unit in the last place of each coordinate (both in a space whose origin is the camera's place), and
    what float64 leaves of a point: 2^-46 of the scene's extent, more for a ray with a small `slope` (the cosine
    between ray and normal, (N,)).
    """
    half = 0.5 * np.spacing(np.abs(reference).astype(np.float32)).astype(np.float64)
    excused = half + 2.0**-46 * extent / np.abs(np.asarray(slope))[:, None]
    share: Array = (np.abs(points - reference) / excused).max(axis=1)
    return share
