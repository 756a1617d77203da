"""Transforms of cameras as ``look_at``: origin, target and up direction instead of a matrix.

A matrix that `equaltime.scene.transforms.look_at` made has many origins, targets and up directions that give the same
matrix again. `with_look_at` looks for vectors with few digits. Reading them gives the matrix to the last bit; a matrix
for which no such vectors are found stays a matrix.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.model import PLUGINS

__all__ = ["look_at_of", "with_look_at"]

Array = NDArray[np.float64]
LookAt = dict[str, list[float]]
"""The vectors ``origin``, ``target`` and ``up``, 3 numbers each."""

_RIGID: Final = 1e-9
"""Largest deviation of a camera's axes from perpendicular unit vectors; rounding makes about 1e-15."""
_DECIMALS: Final = 6
"""Most decimals of a target with few digits."""
_GRID: Final = 5
"""Numbers of decimals that are tried, from 0, for the coordinate of the target that changes most along the axis."""
_ALONG: Final = 10_000
"""Reach of that coordinate, in units of the last decimal, either side of 0 and of the origin's coordinate."""
_MOST_SHORT: Final = 1000
"""Most targets, or up directions, with few digits that are tried. Points far apart on the axis may all have few digits,
and many are rounded to another axis."""
_DISTANCES: Final = (*range(1, 51), *(10.0**n for n in range(2, 7)), *(2.0**n for n in range(-3, 21)))
"""Distances of targets with all digits from the origin: each choice is rounded in another way."""
_SHORT_UPS: Final = np.array(list(product(range(-10, 11), repeat=3)), dtype=np.float64) / 10.0
"""Up directions with few digits: up to 1 along each axis, in steps of 0.1."""
_LENGTHS: Final = (1.0, *(1.0 + n / 16.0 for n in range(1, 16)))
_LEANS: Final = (0.0, *(sign * n / 8.0 for n in range(1, 8) for sign in (1.0, -1.0)))
"""Lengths of up directions with all digits, and how far these lean forward: each choice is rounded in another way."""


def with_look_at(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a scene's dictionary whose cameras have ``{"look_at": …}`` in place of a matrix, if possible.

    Vectors are easier to read and edit. ``scene`` is a dictionary made by `equaltime.scene.export.plain.scene_dict`.
    Keys of animations are replaced too.
    """
    return {name: _camera(part) if _is_camera(part) else part for name, part in scene.items()}


def _is_camera(part: object) -> bool:
    return isinstance(part, Mapping) and part["type"] in PLUGINS and PLUGINS[part["type"]].kind == "sensor"


def _camera(part: Mapping[str, Any]) -> dict[str, Any]:
    placed = part.get("to_world")
    if isinstance(placed, Mapping):
        keys = [{**key, "transform": _shown(key["transform"])} for key in placed["animation"]]
        return {**part, "to_world": {**placed, "animation": keys}}
    return dict(part) if placed is None else {**part, "to_world": _shown(placed)}


def _shown(matrix: list[list[float]]) -> object:
    found = look_at_of(matrix)
    return matrix if found is None else {"look_at": found}


def look_at_of(matrix: Sequence[Sequence[float]]) -> LookAt | None:
    """Return the origin, target and up vector of a camera with this matrix (4, 4); None if no such vectors are found.

    The vectors have few digits, and `equaltime.scene.transforms.parse` gives the matrix again from them, bit by bit. A
    mirrored or scaled matrix has no such vectors.
    """
    wanted = np.array(matrix, dtype=np.float64)
    turn, origin = wanted[:3, :3], wanted[:3, 3]
    with np.errstate(over="ignore", invalid="ignore"):
        rigid = np.allclose(turn.T @ turn, np.eye(3), rtol=0.0, atol=_RIGID) and np.linalg.det(turn) > 0.0
        if not rigid or not np.array_equal(wanted[3], (0.0, 0.0, 0.0, 1.0)):
            return None
        target = next((point for point in _targets(origin, turn[:, 2]) if _looks_along(wanted, point)), None)
    if target is None:
        return None
    tried = ({"origin": origin.tolist(), "target": target.tolist(), "up": up.tolist()} for up in _ups(turn))
    return next((found for found in tried if transforms.parse({"look_at": found}).tobytes() == wanted.tobytes()), None)


def _looks_along(wanted: Array, target: Array) -> bool:
    """Tell whether the camera's axis is the same, to the last bit, with this target; up has no influence on it."""
    upward, origin = wanted[:3, 1], wanted[:3, 3]
    if np.array_equal(target, origin) or not np.isfinite(target).all():
        return False
    made = transforms.look_at(origin.tolist(), target.tolist(), upward.tolist())
    return np.array_equal(made[:, 2], wanted[:, 2])


def _targets(origin: Array, forward: Array) -> Iterator[Array]:
    """Yield points on the camera's axis, those with few digits first."""
    axis = int(np.argmax(np.abs(forward)))
    steps = np.arange(-_ALONG, _ALONG + 1, dtype=np.float64)
    found: list[Array] = []
    for unit in 10.0 ** np.arange(_GRID):
        grid = np.concatenate([steps, np.round(origin[axis] * unit) + steps]) / unit
        distances = (grid - origin[axis]) / forward[axis]
        found.append(_short(origin + distances[distances > 0.0, None] * forward))
    yield from _shortest(np.concatenate(found), np.zeros(3))
    for distance in _DISTANCES:
        yield origin + distance * forward


def _short(points: Array) -> Array:
    """Return the points that have few decimals, but for rounding errors, without these errors."""
    rounded = np.round(points, _DECIMALS)
    errors = np.abs(points - rounded).max(axis=1)
    few: Array = rounded[errors <= 2e-15 * (1.0 + np.abs(points).max(axis=1))]
    return few + 0.0  # 0 in place of -0


def _ups(turn: Array) -> Iterator[Array]:
    """Yield directions in the upper half of the plane that halves the picture, those with few digits first."""
    left, upward, forward = turn.T
    found = _SHORT_UPS[(np.abs(_SHORT_UPS @ left) <= 1e-12) & (_SHORT_UPS @ upward > _RIGID)]
    yield from _shortest(found, upward)
    for length, lean in product(_LENGTHS, _LEANS):
        yield length * (upward + lean * forward)


def _shortest(vectors: Array, near: Array) -> list[Array]:
    """Return vectors with few digits: those with the fewest first, then whole numbers, then those near to `near`."""
    digits = np.ceil(np.log10(np.floor(np.abs(vectors)) + 1.0))  # before the point
    for decimals in range(_DECIMALS):
        digits += np.round(vectors, decimals) != vectors
    fractions = np.count_nonzero(vectors % 1.0, axis=1)
    distances = np.linalg.norm(vectors - near, axis=1)
    return list(vectors[np.lexsort((distances, fractions, digits.sum(axis=1)))][:_MOST_SHORT])
