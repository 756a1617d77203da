"""Hands the camera, its film and the reconstruction filter to the core."""

from __future__ import annotations

from equaltime.scene.builder import Builder
from equaltime.scene.model import Box, Gaussian, HdrFilm, Perspective, Sensor, Tent, as_array
from equaltime.scene.unsupported import Unsupported

__all__ = ["set_film", "set_sensor"]


def set_sensor(builder: Builder, sensor: Sensor) -> None:
    """Set the camera; raises `Unsupported` for one that the core cannot use yet."""
    if sensor.medium is not None:
        raise Unsupported(sensor.medium)
    if not isinstance(sensor, Perspective):
        raise Unsupported(sensor)
    offset = (sensor.principal_point_offset_x, sensor.principal_point_offset_y)
    builder.set_perspective(as_array(sensor.to_world), sensor.x_fov, sensor.near_clip, sensor.far_clip, offset)


def set_film(builder: Builder, film: HdrFilm) -> None:
    """Set the film; raises `Unsupported` for a filter that the core cannot use yet."""
    rfilter = film.rfilter
    if isinstance(rfilter, Box):
        parameter = 0.5  # half its width
    elif isinstance(rfilter, Tent):
        parameter = rfilter.radius
    elif isinstance(rfilter, Gaussian):
        parameter = rfilter.stddev
    else:
        raise Unsupported(rfilter)
    builder.set_film(film.width, film.height, film.crop, rfilter.type, parameter)
