"""Transforms as users write them: a matrix, or steps such as ``translate`` that are applied one after the other.

All matrices are (4, 4) float64 arrays that map column vectors from local to world space. Angles are in degrees,
counter-clockwise about the axis. Invalid input raises ValueError with a readable message.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence, Set
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from equaltime.words import shortened, suggestion

__all__ = ["compose", "look_at", "matrix", "numbers", "parse", "parse_animation", "rotate", "scale", "translate"]

Matrix4 = NDArray[np.float64]

_overflowing = np.errstate(over="ignore", invalid="ignore")
"""Silences warnings about overflow of huge numbers; the model refuses such a transform with a message."""


def translate(offset: Sequence[float]) -> Matrix4:
    """Return the matrix (4, 4) of the translation by `offset` (3 numbers)."""
    result = np.eye(4)
    result[:3, 3] = offset
    return result


def scale(factors: float | Sequence[float]) -> Matrix4:
    """Return the matrix (4, 4) of the scaling by one factor for all axes, or by three factors, one for each axis."""
    result = np.eye(4)
    result[[0, 1, 2], [0, 1, 2]] = factors
    return result


def rotate(axis: Sequence[float], angle: float) -> Matrix4:
    """Return the matrix (4, 4) of the rotation by `angle` degrees about the vector `axis`, by Rodrigues' formula.

    `axis` is 3 numbers, not all zero. Its length does not matter.
    """
    length = math.hypot(*axis)
    if length == 0.0 or not math.isfinite(length):
        raise ValueError("the axis of a rotation must have a direction")
    x, y, z = (component / length for component in axis)
    turned = math.radians(math.remainder(angle, 360.0))
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result = np.eye(4)
    result[:3, :3] += math.sin(turned) * cross + 2.0 * math.sin(turned / 2.0) ** 2 * (cross @ cross)
    return result


@_overflowing
def look_at(origin: Sequence[float], target: Sequence[float], up: Sequence[float] | None = None) -> Matrix4:
    """Return the transform (4, 4) of a camera at `origin` that looks at `target`, with `up` upwards in the image.

    The camera looks along its own +z. Without `up`, or if `up` is zero, a direction perpendicular to the view is chosen
    as in Mitsuba 3 (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    """
    forward = np.subtract(target, origin).astype(np.float64)
    if not np.any(forward):
        raise ValueError("look_at needs a target that is not its origin")
    forward /= math.hypot(*forward)
    upward = perpendicular(forward) if up is None or not np.any(up) else np.asarray(up, dtype=np.float64)
    left = np.cross(upward / math.hypot(*upward), forward)
    if math.hypot(*left) <= 1e-12:
        raise ValueError("look_at cannot have its up direction along the line of sight")
    left /= math.hypot(*left)
    result = np.eye(4)
    result[:3, :4] = np.column_stack([left, np.cross(forward, left), forward, np.asarray(origin, dtype=np.float64)])
    return result


def perpendicular(n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a unit vector perpendicular to the unit vector `n`: the one that Mitsuba 3 chooses."""
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    return np.array([1.0 + sign * n[0] ** 2 * a, sign * n[0] * n[1] * a, -sign * n[0]])


def matrix(values: Sequence[float]) -> Matrix4:
    """Return the transform (4, 4) with the matrix `values`, row by row: 16 numbers, or 9 for a 3x3 matrix."""
    if len(values) not in (9, 16):
        raise ValueError(f"a matrix needs 9 or 16 numbers, found {len(values)}")
    if len(values) == 16:
        return np.array(values, dtype=np.float64).reshape(4, 4)
    result = np.eye(4)
    result[:3, :3] = np.reshape(values, (3, 3))
    return result


@_overflowing
def compose(steps: Sequence[Matrix4]) -> Matrix4:
    """Return the product (4, 4) of the transforms in `steps`, which applies the first step first."""
    result = np.eye(4)
    for step in steps:
        result = step @ result
    return result


def parse(value: object, *, flat: bool = False) -> Matrix4:
    """Return the transform (4, 4) that `value` describes in one of the spellings of scene files.

    `value` may be a 4x4 matrix (NumPy array, nested lists, an object with a ``matrix`` such as Mitsuba's transforms),
    one step, or a list of steps. A step is a table with one key:

    - ``{"translate": [x, y, z]}``
    - ``{"scale": s}`` or ``{"scale": [x, y, z]}``
    - ``{"rotate": {"axis": [x, y, z], "angle": degrees}}``
    - ``{"look_at": {"origin": …, "target": …, "up": …}}``
    - ``{"matrix": [...]}``

    With `flat`, for a map of the plane, a 3x3 matrix and steps with two numbers are accepted too. Raises ValueError for
    any other `value`.
    """
    if isinstance(value, Mapping):
        value = [value]
    if isinstance(value, list | tuple) and value and all(isinstance(step, Mapping) for step in value):
        return compose([_step(_spatial(step) if flat else step) for step in value])
    try:
        array = np.asarray(getattr(value, "matrix", value), dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape in ((4, 4, 1), (3, 3, 1)):  # Mitsuba's vectorised transforms
        array = array[..., 0]
    if flat and array.shape == (3, 3):
        return _lifted(array)
    if array.shape != (4, 4):
        raise ValueError("expected a 4x4 matrix or a list of steps such as {translate = [0, 1, 0]}")
    return array


def parse_animation(value: object) -> list[tuple[float, Matrix4]] | None:
    """Return the keys, each a time and a transform, of a dict ``{"animation": [{"time": t, "transform": …}, …]}``.

    Return None if `value` has no ``animation``. The ``transform`` of a key may be anything that `parse` accepts. A key
    may have a single step, such as ``"translate": [0, 1, 0]``, instead of ``transform``.
    """
    if not isinstance(value, Mapping) or "animation" not in value:
        return None
    keys = value["animation"]
    if set(value) != {"animation"} or not isinstance(keys, list | tuple):
        raise ValueError("an animation is a table with a list of keys and nothing else")
    return [_key(key) for key in keys]


def _key(key: object) -> tuple[float, Matrix4]:
    if not isinstance(key, Mapping) or "time" not in key or len(key) != 2:
        raise ValueError(
            "a key of an animation is a table with a time and a transform, such as "
            f"{{time = 0, translate = [0, 1, 0]}}, found {shortened(key, 80)}"
        )
    time = numbers(key["time"], 1)[0]
    placed = {name: step for name, step in key.items() if name != "time"}
    return time, parse(placed.get("transform", placed))


def _lifted(plane: Matrix4) -> Matrix4:
    """Return the (3, 3) map of (u, v, 1) as a map of space that keeps the third axis."""
    result = np.eye(4)
    result[np.ix_([0, 1, 3], [0, 1, 3])] = plane
    return result


def _spatial(step: Mapping[str, object]) -> Mapping[str, object]:
    """Return a step of the plane as a step of space; two numbers get a neutral third one."""
    thirds = {"translate": 0.0, "scale": 1.0}
    return {
        name: [*value, thirds[name]]
        if name in thirds and isinstance(value, list | tuple) and len(value) == 2
        else value
        for name, value in step.items()
    }


def _step(step: Mapping[str, object]) -> Matrix4:
    if len(step) != 1:
        raise ValueError(f"a step of a transform has one key, found {', '.join(map(str, step)) or 'none'}")
    name, argument = next(iter(step.items()))
    if name not in STEPS:
        raise ValueError(f"unknown transform step '{name}'{suggestion(str(name), STEPS)}")
    try:
        return STEPS[name](argument)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def numbers(value: object, *counts: int) -> list[float]:
    """Return the number, list or array `value` as a flat list of floats.

    Raises ValueError if a number is not finite, or if the length is not one of `counts`.
    """
    items = value.tolist() if isinstance(value, np.ndarray) else value
    if isinstance(items, list | tuple) and items and all(isinstance(row, list | tuple) for row in items):
        items = [number for row in items for number in row]
    if not isinstance(items, list | tuple):
        items = [items]
    if not all(isinstance(item, Real) and not isinstance(item, bool) and _finite(item) for item in items):
        raise ValueError(f"expected finite numbers, found {shortened(value, 80)}")
    if len(items) not in counts:
        raise ValueError(f"expected {' or '.join(map(str, counts))} numbers, found {len(items)}")
    return [float(item) for item in items]


def _finite(number: Real) -> bool:
    try:
        return math.isfinite(number)
    except OverflowError:  # an integer too large for float64
        return False


def _table(value: object, required: Set[str], optional: Set[str] = frozenset()) -> dict[str, object]:
    if not isinstance(value, Mapping) or not required <= set(value) <= required | optional:
        keys = ", ".join(sorted(required)) + "".join(f" and maybe {key}" for key in sorted(optional))
        raise ValueError(f"expected a table with {keys}")
    return dict(value)


def _rotate_step(value: object) -> Matrix4:
    table = _table(value, {"axis", "angle"})
    return rotate(numbers(table["axis"], 3), numbers(table["angle"], 1)[0])


def _scale_step(value: object) -> Matrix4:
    factors = numbers(value, 1, 3)
    return scale(factors[0] if len(factors) == 1 else factors)


def _look_at_step(value: object) -> Matrix4:
    table = _table(value, {"origin", "target"}, {"up"})
    up = numbers(table["up"], 3) if "up" in table else None
    return look_at(numbers(table["origin"], 3), numbers(table["target"], 3), up)


STEPS: dict[str, Callable[[object], Matrix4]] = {
    "translate": lambda value: translate(numbers(value, 3)),
    "scale": _scale_step,
    "rotate": _rotate_step,
    "look_at": _look_at_step,
    "matrix": lambda value: matrix(numbers(value, 9, 16)),
}
"""Functions that make the transform of a step, by the step's name."""
