"""Facts about a mesh, such as its volume, and whether the mesh is closed.

The computation uses sums and hashes, with few sorts, so that its time is nearly linear in the number of triangles. Two
vertices are equal if the core rounds them to the same position. A sum of 64-bit hashes represents a multiset: two
different multisets have equal sums with a probability of about 2^-64.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.geometry import SphereSurface
from equaltime.scene.lint.parts import Part

__all__ = ["MOST_PLACES", "Finding", "MeshFacts", "Severity", "border", "encloses", "facts", "surrounds", "within"]

Severity = Literal["warning", "note"]
"""Warning: the image may be wrong or take long. Note: the renderer handles the hazard, or it may be intended."""

MOST_PLACES: Final = 8
"""Largest number of objects that a finding names; `Finding.count` counts all."""


@dataclass(frozen=True)
class Finding:
    """A hazard found in a scene, for the user: the check that found it, the objects concerned, a count, and advice.

    One finding covers all objects with the same hazard.
    """

    check: str
    """Id of the check, such as ``dark-lights``."""
    severity: Severity
    what: str
    """Description of the hazard, with figures."""
    where: tuple[str, ...]
    """The first `MOST_PLACES` shapes, BSDFs or lights, with their positions in the file."""
    count: int
    """Number of triangles, vertices, texels or objects, as `what` says."""
    becomes: str
    """Reaction of the renderer to the hazard."""
    advice: str
    """Advice to the user."""

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as a dictionary for JSON, with one key for each field."""
        return {**self.__dict__, "where": list(self.where)}


def first_places(places: Iterable[object]) -> tuple[str, ...]:
    """Return the first `MOST_PLACES` different items of `places` as text.

    Such an item is usually the name of an object with its position in the scene file.
    """
    return tuple(dict.fromkeys(map(str, places)))[:MOST_PLACES]


Array = NDArray[np.float64]

Hashes = NDArray[np.uint64]

CHUNK: Final = 1 << 16
"""Number of triangles that are processed at a time, so that intermediate results stay in the cache."""

UNCERTAIN: Final = 1e-2
"""Angle, in radians, above which a possible tilt of a triangle by the rounding of its vertices is reported."""


@dataclass(frozen=True, eq=False)
class MeshFacts:
    """Facts about a mesh, from which lint finds hazards such as gaps or a wrong orientation.

    They are the numbers of triangles with each hazard, the area and the volume, and whether the mesh is closed. Hashes
    of the triangles serve to compare the mesh with other meshes.
    """

    degenerate: int
    """Number of triangles without area, which the core drops."""
    slivers: int
    """Number of slivers: triangles with area that rounding may tilt by more than `UNCERTAIN`."""
    sliver_area: float
    """Fraction of the mesh's area, in [0, 1], that slivers have."""
    tilt: float
    """Largest angle, in radians, by which rounding may tilt a sliver."""
    backwards: int
    """Number of triangles whose three shading normals all point to the back."""
    area: float
    volume: float
    """Enclosed volume of a closed mesh; negative if the front sides of the triangles face inwards."""
    closed: bool
    """True if every edge occurs equally often in both directions, and at least one triangle has area."""
    faces: Hashes
    """Hash of each triangle (M,); equal for triangles with the same corners."""
    balance: int
    """Hash sum over the directed edges minus the sum over the reversed edges, modulo 2^64; 0 for a closed mesh.

    The balance of several meshes together is the sum of their balances.
    """


def facts(part: Part) -> MeshFacts:
    """Return facts about the mesh of `part`, the surface of a shape, for lint to find hazards.

    The facts are the mesh's area and volume, whether it is closed, and how many of its triangles have a hazard. Such
    triangles have no area, are slivers, or have shading normals that point to the back. All facts are computed in one
    pass over the triangles. `part` must have a mesh.
    """
    mesh = part.mesh
    assert mesh is not None
    points = part.points.astype(np.float64)
    places = _mixed(part.points.view(np.uint32).astype(np.uint64))
    hashes = np.empty(len(mesh.faces), np.uint64)
    degenerate = slivers = backwards = balance = 0
    area = sliver_area = volume = tilt = 0.0
    for start in range(0, len(mesh.faces), CHUNK):
        index = mesh.faces[start : start + CHUNK].astype(np.intp)
        a, b, c = (points[index[:, k]] for k in range(3))
        normal = _cross(b - a, c - a)
        size = np.sqrt(np.einsum("ij,ij->i", normal, normal))
        volume += float(np.einsum("ij,ij->", a, _cross(b, c))) / 6.0
        area += 0.5 * float(size.sum())
        flat = size == 0.0
        degenerate += int(flat.sum())
        error = _tilt(a, b, c, size)
        thin = (error > UNCERTAIN) & ~flat
        slivers += int(thin.sum())
        sliver_area += 0.5 * float(size[thin].sum())
        tilt = max(tilt, float(error[thin].max(initial=0.0)))
        if mesh.normals is not None:
            sides = [np.einsum("ij,ij->i", normal, mesh.normals[index[:, k]]) < 0.0 for k in range(3)]
            backwards += int((sides[0] & sides[1] & sides[2] & ~flat).sum())
        corners = places[index]
        hashes[start : start + CHUNK] = _mix(corners).sum(axis=1)
        balance += _balance(corners)
    balance %= 1 << 64
    share = sliver_area / area if area > 0.0 else 0.0
    closed = balance == 0 and degenerate < len(mesh.faces)
    return MeshFacts(degenerate, slivers, share, tilt, backwards, area, volume, closed, hashes, balance)


def border(parts: list[Part]) -> list[int]:
    """Return the number of border edges of each mesh in `parts`, which shows meshes with gaps.

    A border edge belongs to a single triangle among all these meshes, so edges at which two meshes meet do not count.
    """
    keys, owners = [], []
    for number, part in enumerate(parts):
        assert part.mesh is not None
        corners = _mixed(part.points.view(np.uint32).astype(np.uint64))[part.mesh.faces.astype(np.intp)]
        edges = np.concatenate([_mix(corners[:, k]) + _mix(corners[:, (k + 1) % 3]) for k in range(3)])
        keys.append(edges)
        owners.append(np.full(len(edges), number))
    _, first, counts = np.unique(np.concatenate(keys), return_index=True, return_counts=True)
    alone = np.concatenate(owners)[first[counts == 1]]
    return [int(count) for count in np.bincount(alone, minlength=len(parts))]


def within(place: Array, part: Part) -> bool:
    """Tell whether the point `place` (3,), in world space, is inside the sphere or closed mesh of `part`.

    Other shapes, and shapes of a group, have no inside: the result is False.
    """
    return encloses(part, place[None])


def encloses(part: Part, points: Array) -> bool:
    """Tell whether all `points` (N, 3), in world space, are inside the shape of `part`.

    Only spheres and closed meshes have an inside. The result is False for shapes of a group, because their coordinates
    are in the group's own space.
    """
    if part.grouped:
        return False
    if isinstance(part.surface, SphereSurface):
        return bool((np.linalg.norm(points - part.surface.center, axis=1) < part.surface.radius).all())
    if part.mesh is None or not all(in_bounds(point, part) for point in points):
        return False
    return facts(part).closed and all(surrounds(part, point) for point in points)


def in_bounds(place: Array, part: Part) -> bool:
    """Tell whether the point `place` (3,), in world space, is inside the bounding box of the shape of `part`."""
    return bool(((part.bounds[0] < place) & (place < part.bounds[1])).all())


def surrounds(part: Part, place: Array) -> bool:
    """Tell whether the point `place` (3,), in world space, is inside the mesh of `part`, which must be closed.

    The test is the solid angle of the mesh as seen from the point (Van Oosterom & Strackee 1983).
    """
    mesh = part.mesh
    assert mesh is not None
    if not in_bounds(place, part):
        return False
    total = 0.0
    for start in range(0, len(mesh.faces), CHUNK):
        index = mesh.faces[start : start + CHUNK].astype(np.intp)
        a, b, c = (mesh.vertices[index[:, k]] - place for k in range(3))
        la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
        above = np.einsum("ij,ij->i", a, _cross(b, c))
        below = la * lb * lc + sum(
            np.einsum("ij,ij->i", one, other) * third for one, other, third in ((a, b, lc), (b, c, la), (c, a, lb))
        )
        total += 2.0 * float(np.arctan2(above, below).sum())
    return abs(total) > 2.0 * np.pi


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products of rows, faster than NumPy's."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _tilt(a: Array, b: Array, c: Array, size: Array) -> Array:
    """Return the angle, in radians, by which one rounding step of the vertices may tilt each triangle."""
    edges = [np.einsum("ij,ij->i", e, e) for e in (b - a, c - b, a - c)]
    longest = np.sqrt(np.maximum(np.maximum(edges[0], edges[1]), edges[2]))
    largest = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c)).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(largest * 2.0**-24 * longest / size)


def _mix(words: Hashes) -> Hashes:
    """Return a hash of each word (the finaliser of SplitMix64)."""
    mixed = words ^ (words >> np.uint64(30))
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    mixed ^= mixed >> np.uint64(27)
    mixed *= np.uint64(0x94D049BB133111EB)
    mixed ^= mixed >> np.uint64(31)
    return mixed


def _mixed(rows: Hashes) -> Hashes:
    """Return a hash of each row of three words."""
    x, y, z = rows.T
    return _mix(_mix(_mix(x + np.uint64(0x9E3779B97F4A7C15)) + y) + z)


def _balance(corners: Hashes) -> int:
    """Return the hash sum over directed edges of triangles (n, 3) minus the sum over their reverses, modulo 2^64."""
    total = np.uint64(0)
    turned = np.roll(corners, -1, axis=1)
    with np.errstate(over="ignore"):
        total = (_mix(corners * np.uint64(3) + turned) - _mix(turned * np.uint64(3) + corners)).sum(dtype=np.uint64)
    return int(total)
