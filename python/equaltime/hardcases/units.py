"""Scaling of a scene's lengths and of its lights' brightness, to test that units do not change an image.

Scaling all lengths does not change the image. Scaling the brightness multiplies the image by the same factor. A point
light's intensity is also multiplied by the square of the factor of lengths. Powers of two are exact in floating point.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from equaltime.scene import Scene
from equaltime.scene.model import (
    Animation,
    Area,
    Constant,
    Directional,
    EnvMap,
    FreeEmitter,
    Orthographic,
    Point,
    Sensor,
    Shape,
    Solid,
)
from equaltime.scene.model.animation import Placement
from equaltime.scene.model.values import Matrix

__all__ = ["in_units"]


def in_units(scene: Scene, length: float = 1.0, light: float = 1.0) -> Scene:
    """Return the scene with all lengths multiplied by the factor `length`, and all brightness by the factor `light`.

    The image of the new scene is that of the old one times `light`. Raises ValueError for lights whose radiance is a
    texture.
    """
    model = scene.model
    shapes = tuple(_shape(shape, length, light) for shape in model.shapes)
    emitters = tuple(_emitter(emitter, length, light) for emitter in model.emitters)
    sensor = _sensor(model.sensor, length)
    return dataclasses.replace(scene, model=model.replace(shapes=shapes, emitters=emitters, sensor=sensor))


def _shape(shape: Shape, length: float, light: float) -> Shape:
    changes: dict[str, Any] = {"to_world": _everywhere(_scaled, shape.to_world, length)}
    if isinstance(shape, Solid) and shape.emitter is not None:
        changes["emitter"] = _emitter(shape.emitter, length, light)
    return shape.replace(**changes)


def _emitter(emitter: Area | FreeEmitter, length: float, light: float) -> Area | FreeEmitter:
    if isinstance(emitter, Area | Constant):
        return emitter.replace(radiance=_times(emitter.radiance, light))
    if isinstance(emitter, Directional):
        return emitter.replace(irradiance=_times(emitter.irradiance, light))
    if isinstance(emitter, EnvMap):
        return emitter.replace(scale=emitter.scale * light)
    changes: dict[str, Any] = {"intensity": _times(emitter.intensity, light * length**2)}
    if isinstance(emitter, Point):
        changes |= {"position": _times(emitter.world_position, length), "to_world": None}
    else:
        changes["to_world"] = _moved(emitter.to_world, length)
    return emitter.replace(**changes)


def _sensor(sensor: Sensor, length: float) -> Sensor:
    move = _scaled if isinstance(sensor, Orthographic) else _moved
    names = [name for name in ("near_clip", "far_clip", "aperture_radius", "focus_distance") if hasattr(sensor, name)]
    given = {name: getattr(sensor, name) for name in names}
    lengths = {name: value * length for name, value in given.items() if value is not None}
    return sensor.replace(to_world=_everywhere(move, sensor.to_world, length), **lengths)


def _times(values: object, factor: float) -> tuple[float, ...]:
    if not isinstance(values, Sequence):
        raise ValueError("a light whose radiance is a texture cannot be made brighter")
    return tuple(factor * value for value in values)


def _everywhere(change: Callable[[Matrix, float], Matrix], placement: Placement, factor: float) -> Placement:
    if not isinstance(placement, Animation):
        return change(placement, factor)
    return Animation(placement.times, tuple(change(matrix, factor) for matrix in placement.matrices))


def _scaled(matrix: Matrix, factor: float) -> Matrix:
    """Return the transform followed by a uniform scale."""
    return _matrix(np.diag([factor, factor, factor, 1.0]) @ np.array(matrix))


def _moved(matrix: Matrix, factor: float) -> Matrix:
    """Return the transform with only its translation scaled: cameras and lights have no size."""
    out = np.array(matrix)
    out[:3, 3] *= factor
    return _matrix(out)


def _matrix(values: Any) -> Matrix:
    return cast("Matrix", tuple(tuple(map(float, row)) for row in values))
