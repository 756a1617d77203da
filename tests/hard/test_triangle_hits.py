"""Hit points on triangles, against exact arithmetic, over sizes of the scene from 2^-20 to 2^20 (G3, G5, G7).

Embree only says which triangle is met; the point is the core's. The vertices and origins here are numbers that float32
holds at every size, so that all that may be lost is the rounding of the point itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from ..statistical.worlds import build
from .exact import meet_plane, roundings, traced, unit_normal

Array = NDArray[np.float64]
TRIANGLES, RAYS = 200, 2000
EXTENT = 8.0
SIZES = [2.0**k for k in (-20, -13, -3, 0, 6, 20)]


def grid(x: Array) -> Array:
    """Round to numbers that float32 holds, with bits to spare."""
    return np.round(x * 2.0**18) / 2.0**18


def triangles(rng: np.random.Generator) -> Array:
    """Return triangles (N, 3, 3) about a unit large, some of them thin, within the extent; the last two span it."""
    place = rng.uniform(-3, 3, (TRIANGLES, 1, 3))
    corners = place + rng.uniform(-1, 1, (TRIANGLES, 3, 3))
    thin = corners[: TRIANGLES // 4]
    thin[:, 2] = 0.4 * thin[:, 0] + 0.6 * thin[:, 1] + 1e-3 * rng.uniform(-1, 1, (len(thin), 3))
    corners[-1], corners[-2] = -4 + np.eye(3) / 8, 4 - np.eye(3) / 8
    corners[-1, 0], corners[-2, 0] = -4, 4
    return grid(corners)


def rays(rng: np.random.Generator, corners: Array) -> tuple[Array, Array]:
    """Return origins and directions, not unit, towards points of the triangles."""
    weights = rng.dirichlet((1, 1, 1), RAYS)
    targets = np.einsum("nk,nkc->nc", weights, corners[rng.integers(0, len(corners), RAYS)])
    origins = grid(rng.uniform(-4, 4, (RAYS, 3)))
    return origins, targets - origins


def mesh(corners: Array, scale: float) -> _core.Scene:
    faces = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    return build(
        lambda b: b.add_mesh(scale * corners.reshape(-1, 3), faces, front=None, back=None, radiance=None), size=(8, 8)
    )


def nearest(origins: Array, directions: Array, corners: Array) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return which triangle each ray meets first, by float64, and for which rays float32 could not doubt it.

    Those keep 20 units in the last place of the extent from the lines of all edges and from other triangles met.
    """
    e = np.roll(corners, -1, axis=1) - corners
    r, d = origins[:, None, None] - corners, directions[:, None, None]
    across = np.cross(d, e)
    passing = (r * across).sum(axis=3)
    inside = (passing > 0).all(axis=2) | (passing < 0).all(axis=2)
    doubtful = (np.abs(passing) < 1e-5 * np.linalg.norm(across, axis=3)).any(axis=(1, 2))
    n = normals(corners)
    slope = directions @ n.T
    t = -(r[:, :, 0] * n).sum(axis=2) / slope
    first = np.where(inside & (t > 0), t, np.inf)
    best = first.argmin(axis=1)
    two = np.partition(first, 1, axis=1)
    flat = np.abs(slope[np.arange(len(slope)), best]) < 1e-3
    return best, np.isfinite(two[:, 0]) & (two[:, 0] > 1e-2) & (two[:, 1] > 1.01 * two[:, 0]) & ~doubtful & ~flat


def normals(corners: Array) -> Array:
    n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit: Array = n / np.linalg.norm(n, axis=1, keepdims=True)
    return unit


@dataclass(frozen=True, eq=False)
class Case:
    """Rays that clearly meet one triangle first, which one, and where exactly."""

    corners: Array
    origins: Array
    directions: Array
    """as given to the core"""
    traced: Array
    """as the core traces them"""
    which: NDArray[np.int64]
    points: Array
    slope: Array
    """cosines between rays and normals"""


@cache
def case(seed: int = 3) -> Case:
    rng = np.random.default_rng(seed)
    corners = triangles(rng)
    origins, directions = rays(rng, corners)
    which, clear = nearest(origins, traced(directions), corners)
    origins, directions, which = origins[clear], directions[clear], which[clear]
    unit = traced(directions)
    points = np.array([meet_plane(o, d, corners[k]) for o, d, k in zip(origins, unit, which, strict=True)])
    return Case(corners, origins, directions, unit, which, points, (unit * normals(corners)[which]).sum(axis=1))


@pytest.mark.parametrize("scale", SIZES)
def test_hit_points_are_the_exact_ones_rounded_once(scale: float) -> None:
    c = case()
    assert len(c.points) > RAYS // 2
    hits = mesh(c.corners, scale).intersect(scale * c.origins, c.directions)
    np.testing.assert_array_equal(hits["primitive"], c.which)
    off = roundings(hits["p"] / scale, c.points, c.slope, EXTENT)
    print(f"size {scale:g}: {len(off)} rays, at most {off.max():.4f} of the rounding of the point")
    assert off.max() <= 1.0
    t = np.linalg.norm(c.points - c.origins, axis=1)
    np.testing.assert_allclose(hits["t"] / scale, t, rtol=0, atol=2.0**-24 * EXTENT)


def test_every_size_gives_the_same_bits() -> None:
    c = case()
    reference = mesh(c.corners, 1.0).intersect(c.origins, c.directions)
    for scale in SIZES:
        hits = mesh(c.corners, scale).intersect(scale * c.origins, c.directions)
        np.testing.assert_array_equal(hits["p"] / scale, reference["p"])
        np.testing.assert_array_equal(hits["n"], reference["n"])


def test_the_mark_sees_points_computed_in_single_precision() -> None:
    """The power twin: the textbook formula in float32, for the same triangles."""
    c = case()
    o, d, v = (x.astype(np.float32) for x in (c.origins, c.traced, c.corners[c.which]))
    n = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    t = (n * (v[:, 0] - o)).sum(axis=1) / (n * d).sum(axis=1)
    off = roundings((o + t[:, None] * d).astype(np.float64), c.points, c.slope, EXTENT)
    assert (off > 1.0).mean() > 0.5


@pytest.mark.parametrize("aspect", [2.0**10, 2.0**14, 2.0**20])
def test_slivers_are_met_and_have_the_normal_of_their_corners(aspect: float) -> None:
    """A band of triangles as thin as `aspect` says, side by side, turned out of the axes (G7, G11)."""
    corners = band(aspect)
    rng = np.random.default_rng(5)
    which = np.arange(len(corners)).repeat(20)
    weights = rng.dirichlet((2, 2, 2), len(which))
    targets = np.einsum("nk,nkc->nc", weights, corners[which])
    origins = targets + rng.uniform(-0.3, 0.3, targets.shape) + normals(corners)[0]
    hits = mesh(corners, 1.0).intersect(origins, targets - origins)
    assert (hits["shape"] == 0).all()
    angles = [
        np.linalg.norm(np.cross(n, unit_normal(corners[k]))) for n, k in zip(hits["n"], hits["primitive"], strict=True)
    ]
    print(f"aspect {aspect:g}: normals off by at most {max(angles):.2g} rad")
    assert max(angles) < 1e-6


def test_the_mark_sees_a_normal_computed_in_single_precision() -> None:
    """The power twin: float32 loses the normal of a sliver away from the origin."""
    corners = band(2.0**20)
    c = corners.astype(np.float32)
    n = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]).astype(np.float64)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    angles = [np.linalg.norm(np.cross(a, unit_normal(b))) for a, b in zip(n, corners, strict=True)]
    assert max(angles) > 1e-4


def band(aspect: float) -> Array:
    """Return 64 triangles (64, 3, 3) between two lines about one long and 33 / aspect wide."""
    start, along = (np.round(np.array(v) * 2.0**23) / 2.0**23 for v in ((1.1, 1.2, 1.15), (0.71371, 0.51217, 0.23459)))
    steps = start + np.arange(34)[:, None] * np.array([0.25, -0.625, 0.5]) / aspect
    one, other = steps, steps + along
    lower = np.stack([one[:-2], other[:-2], other[1:-1]], axis=1)
    upper = np.stack([one[:-2], other[1:-1], one[1:-1]], axis=1)
    return np.concatenate([lower, upper])
