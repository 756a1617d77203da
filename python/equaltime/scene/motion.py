"""Motion of animated shapes and cameras: their state at a given time, and their motion while the shutter is open.

To interpolate between two keys, a transform is decomposed into a symmetric stretch, then a rotation, then a translation
(polar decomposition). The core, the renderer in C++, does the same (``cpp/equaltime/math/motion.h``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.model import (
    Animation,
    Deformation,
    Instance,
    Matrix,
    Plugin,
    SceneModel,
    Sensor,
    ShapeGroup,
    as_array,
)

__all__ = [
    "animation",
    "at_time",
    "center",
    "closed_shutter",
    "in_shutters",
    "moves",
    "pose",
    "posed",
    "span",
    "still",
    "times_of_keys",
]

Array = NDArray[np.float64]
CHANGING: Final = (Animation, Deformation)


def animation(keys: Sequence[tuple[float, Array]]) -> Animation:
    """Return an `Animation` with these keys, each a time and a transform (4, 4) to world space.

    The keys are not checked.
    """
    matrices: list[Any] = [tuple(map(tuple, matrix.tolist())) for _, matrix in keys]
    return Animation(tuple(time for time, _ in keys), tuple(matrices))


def pose(placement: Matrix | Animation, time: float) -> Array:
    """Return the transform (4, 4) from local to world space that `placement` has at a time.

    At the time of a key, and before the first or after the last key, it is exactly the nearest key's transform.
    """
    if not isinstance(placement, Animation):
        return as_array(placement)
    before, share = span(placement.times, time)
    if share == 0.0:
        return as_array(placement.matrices[before])
    first, last = as_array(placement.matrices[before]), as_array(placement.matrices[before + 1])
    return _between(first, last, share)


def span(times: Sequence[float], time: float) -> tuple[int, float]:
    """Return the index of the last key at or before `time`, and the fraction in [0, 1) of the way to the next key.

    `times` are the increasing times of the keys. Before the first or after the last key, return the index of the
    nearest key, and 0.
    """
    after = int(np.searchsorted(times, time, side="right"))
    before = max(after - 1, 0)
    if after == len(times) or after == 0 or times[before] == time:
        return before, 0.0
    return before, float((time - times[before]) / (times[after] - times[before]))


def posed(mesh: str | Deformation, time: float) -> str | Deformation:
    """Return `mesh` as it is at `time`: a file name, or a deformation that is frozen between the poses of two files.

    `time` is ignored for a mesh that is already frozen at a time of its own.
    """
    if not isinstance(mesh, Deformation):
        return mesh
    before, share = span(mesh.times, time if mesh.held is None else mesh.held)
    pair = mesh.filenames[before : before + 2]
    return pair[0] if share == 0.0 or pair[0] == pair[1] else Deformation((0.0, 1.0), pair, share)


def _between(first: Array, last: Array, share: float) -> Array:
    from scipy.linalg import polar  # imported late, because the import is slow
    from scipy.spatial.transform import Rotation, Slerp

    flip = np.diag([1.0, 1.0, -1.0 if np.linalg.det(first[:3, :3]) < 0.0 else 1.0])
    turns, stretches = zip(*(polar(m[:3, :3] @ flip) for m in (first, last)), strict=True)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack(turns)))(share).as_matrix()
    result = np.eye(4)
    result[:3, :3] = turn @ ((1.0 - share) * stretches[0] + share * stretches[1]) @ flip
    result[:3, 3] = (1.0 - share) * first[:3, 3] + share * last[:3, 3]
    return result


def center(sensor: Sensor) -> float:
    """Return the time halfway between the opening and the closing of the shutter, in the scene's units of time."""
    return 0.5 * (sensor.shutter_open + sensor.shutter_close)


def moves(node: Plugin, sensor: Sensor) -> bool:
    """Tell whether `node` changes its transform or mesh between opening and closing of the shutter of `sensor`."""
    if isinstance(node, ShapeGroup):
        return any(moves(shape, sensor) for shape in node.shapes)
    if isinstance(node, Instance) and moves(node.shapegroup, sensor):
        return True
    found = (_in_shutters(changing, sensor) for changing in _changing(node).values())
    return any(isinstance(seen, Animation) or (isinstance(seen, Deformation) and seen.held is None) for seen in found)


def closed_shutter(model: SceneModel) -> str | None:
    """Return a warning, as text, if the scene is animated but its shutter opens and closes at one time, else None."""
    begin, end = model.sensor.shutter_open, model.sensor.shutter_close
    if begin < end or still(model) is model:
        return None
    return f"the scene is animated, but nothing moves: its shutter opens and closes at {begin:g}; see 'shutter_close'"


def in_shutters(model: SceneModel) -> SceneModel:
    """Return the scene with animation times in units of the shutter: 0 when it opens, 1 when it closes.

    A shape or camera that does not move between 0 and 1 gets a single transform or file, if one is enough. If nothing
    is animated, return `model` itself.
    """
    return _changed(model, lambda changing: _in_shutters(changing, model.sensor))


def still(model: SceneModel) -> SceneModel:
    """Return the scene without motion, as it is at the time halfway between opening and closing of the shutter.

    If nothing is animated, return `model` itself.
    """
    return at_time(model, center(model.sensor))


def at_time(model: SceneModel, time: float) -> SceneModel:
    """Return the scene without motion, as it is at one time; if nothing is animated, return `model` itself.

    The unit of `time` is that of the animations and of the shutter in `model`.
    """

    def at(changing: Animation | Deformation) -> object:
        if isinstance(changing, Animation):
            return pose(changing, time)
        return changing if changing.held is not None else posed(changing, time)

    return _changed(model, at)


def times_of_keys(model: SceneModel) -> tuple[float, float]:
    """Return the times of the first and of the last key of an animated scene, in the units of its shutter.

    Shapes, groups of shapes and the camera count. Raises ValueError if nothing is animated.
    """
    groups = (part for shape in model.shapes if isinstance(shape, Instance) for part in shape.shapegroup.shapes)
    changing = [each for node in (model.sensor, *model.shapes, *groups) for each in _changing(node).values()]
    return min(each.times[0] for each in changing), max(each.times[-1] for each in changing)


def _changing(node: Plugin) -> dict[str, Animation | Deformation]:
    """Return the animated parameters of a node, by name."""
    found = ((name, vars(node).get(name)) for name in ("to_world", "filename"))
    return {name: value for name, value in found if isinstance(value, CHANGING)}


def _changed(model: SceneModel, change: Callable[[Animation | Deformation], object]) -> SceneModel:
    """Return the model with `change` applied to every animated parameter; shared groups stay shared."""
    groups: dict[int, ShapeGroup] = {}

    def changed(node: Plugin) -> Plugin:
        changes = {name: new for name, old in _changing(node).items() if (new := change(old)) is not old}
        if isinstance(node, Instance) and (group := within(node.shapegroup)) is not node.shapegroup:
            changes["shapegroup"] = group
        return node.replace(**changes) if changes else node

    def within(group: ShapeGroup) -> ShapeGroup:
        if id(group) not in groups:
            shapes = tuple(map(changed, group.shapes))
            groups[id(group)] = group if _same(shapes, group.shapes) else group.replace(shapes=shapes)
        return groups[id(group)]

    shapes, sensor = tuple(map(changed, model.shapes)), changed(model.sensor)
    same = sensor is model.sensor and _same(shapes, model.shapes)
    return model if same else model.replace(shapes=shapes, sensor=sensor)


def _same(these: Sequence[Plugin], those: Sequence[Plugin]) -> bool:
    return all(a is b for a, b in zip(these, those, strict=True))


def _in_shutters(changing: Animation | Deformation, sensor: Sensor) -> object:
    begin, end = sensor.shutter_open, sensor.shutter_close
    if isinstance(changing, Deformation) and changing.held is not None:
        return posed(changing, changing.held)
    times = np.array(changing.times)
    first = max(int(np.searchsorted(times, begin, side="right")) - 1, 0)
    last = min(int(np.searchsorted(times, end, side="left")), len(times) - 1)
    keys: Sequence[object] = changing.matrices if isinstance(changing, Animation) else changing.filenames
    if len(set(keys[first : last + 1])) == 1:
        return keys[first]
    if end == begin:
        return pose(changing, begin) if isinstance(changing, Animation) else posed(changing, begin)
    shares = tuple(((times[first : last + 1] - begin) / (end - begin)).tolist())
    if isinstance(changing, Animation):
        return Animation(shares, changing.matrices[first : last + 1])
    return Deformation(shares, changing.filenames[first : last + 1])
