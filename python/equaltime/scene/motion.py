"""Motion: where what is animated is at a time, and what of it happens while the shutter is open.

A transform is taken apart into a rotation after a symmetric stretch, and where the origin goes (polar decomposition);
the core (``cpp/math/motion.h``) does the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.model import Animation, Matrix, Plugin, SceneModel, Sensor, as_array

__all__ = ["animation", "at_time", "center", "closed_shutter", "in_shutters", "moves", "pose", "still"]

Array = NDArray[np.float64]


def animation(keys: Sequence[tuple[float, Array]]) -> Animation:
    """Return the animation of keys, each a time and a transform (4, 4), as they were given: the model checks them."""
    matrices: list[Any] = [tuple(map(tuple, matrix.tolist())) for _, matrix in keys]
    return Animation(tuple(time for time, _ in keys), tuple(matrices))


def pose(placement: Matrix | Animation, time: float) -> Array:
    """Return the transform (4, 4) at a time; at a key, and beyond the last, it is that key's to the bit."""
    if not isinstance(placement, Animation):
        return as_array(placement)
    times = np.array(placement.times)
    after = int(np.searchsorted(times, time, side="right"))
    before = max(after - 1, 0)
    if after == len(times) or after == 0 or times[before] == time:
        return as_array(placement.matrices[before])
    first, last = as_array(placement.matrices[before]), as_array(placement.matrices[after])
    share = (time - times[before]) / (times[after] - times[before])
    return _between(first, last, share)


def _between(first: Array, last: Array, share: float) -> Array:
    from scipy.linalg import polar  # late: it takes long to import
    from scipy.spatial.transform import Rotation, Slerp

    flip = np.diag([1.0, 1.0, -1.0 if np.linalg.det(first[:3, :3]) < 0.0 else 1.0])
    turns, stretches = zip(*(polar(m[:3, :3] @ flip) for m in (first, last)), strict=True)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack(turns)))(share).as_matrix()
    result = np.eye(4)
    result[:3, :3] = turn @ ((1.0 - share) * stretches[0] + share * stretches[1]) @ flip
    result[:3, 3] = (1.0 - share) * first[:3, 3] + share * last[:3, 3]
    return result


def center(sensor: Sensor) -> float:
    """Return the time halfway between opening and closing of the shutter."""
    return 0.5 * (sensor.shutter_open + sensor.shutter_close)


def moves(node: Plugin, sensor: Sensor) -> bool:
    """Tell whether `node` is animated and is not the same all the while that the shutter is open."""
    placement = getattr(node, "to_world", None)
    return isinstance(placement, Animation) and isinstance(_in_shutters(placement, sensor), Animation)


def closed_shutter(model: SceneModel) -> str | None:
    """Return what is to be said of animations that the scene has while its shutter is open for no time."""
    begin, end = model.sensor.shutter_open, model.sensor.shutter_close
    if begin < end or still(model) is model:
        return None
    return f"the scene is animated, but nothing moves: its shutter opens and closes at {begin:g}; see 'shutter_close'"


def in_shutters(model: SceneModel) -> SceneModel:
    """Return the scene with the times of its animations counted from 0, when the shutter opens, to 1, when it closes.

    What does not move meanwhile has the transform of a scene without animations. The model itself if it has none.
    """
    return _placed(model, lambda animation: _in_shutters(animation, model.sensor))


def still(model: SceneModel) -> SceneModel:
    """Return the scene as it is halfway between opening and closing of the shutter; itself if nothing is animated."""
    return at_time(model, center(model.sensor))


def at_time(model: SceneModel, time: float) -> SceneModel:
    """Return the scene as it is at a time; itself if nothing is animated."""
    return _placed(model, lambda animation: pose(animation, time))


def _placed(model: SceneModel, place: Callable[[Animation], object]) -> SceneModel:
    def changed(node: Plugin) -> Plugin:
        before = getattr(node, "to_world", None)
        return node.replace(to_world=place(before)) if isinstance(before, Animation) else node

    shapes, sensor = tuple(map(changed, model.shapes)), changed(model.sensor)
    same = sensor is model.sensor and all(a is b for a, b in zip(shapes, model.shapes, strict=True))
    return model if same else model.replace(shapes=shapes, sensor=sensor)


def _in_shutters(placement: Animation, sensor: Sensor) -> object:
    begin, end = sensor.shutter_open, sensor.shutter_close
    times = np.array(placement.times)
    first = max(int(np.searchsorted(times, begin, side="right")) - 1, 0)
    last = min(int(np.searchsorted(times, end, side="left")), len(times) - 1)
    if len(set(placement.matrices[first : last + 1])) == 1:
        return placement.matrices[first]
    if end == begin:
        return pose(placement, begin)
    shares = tuple(((times[first : last + 1] - begin) / (end - begin)).tolist())
    return Animation(shares, placement.matrices[first : last + 1])
