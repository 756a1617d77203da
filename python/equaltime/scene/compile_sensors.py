"""Hands the camera, its film and the reconstruction filter to the core."""

from __future__ import annotations

from equaltime.scene.builder import Builder
from equaltime.scene.model import (
    Animation,
    Box,
    CatmullRom,
    Filter,
    Gaussian,
    HdrFilm,
    Lanczos,
    Mitchell,
    Orthographic,
    Sensor,
    Spherical,
    Tent,
    ThinLens,
    as_array,
    poses,
)

__all__ = ["set_film", "set_sensor"]


def set_sensor(builder: Builder, sensor: Sensor) -> None:
    """Set the camera. Times of its animation are in units of the shutter time: 0 at opening, 1 at closing."""
    to_world, near, far = as_array(poses(sensor.to_world)[0]), sensor.near_clip, sensor.far_clip
    if isinstance(sensor.to_world, Animation):
        builder.move_sensor(sensor.to_world.times, sensor.to_world.matrices)
    if isinstance(sensor, Orthographic):
        builder.set_orthographic(to_world, near, far)
    elif isinstance(sensor, Spherical):
        builder.set_spherical(to_world, near, far)
    elif isinstance(sensor, ThinLens):
        builder.set_perspective(
            to_world,
            sensor.x_fov,
            near,
            far,
            aperture_radius=sensor.aperture_radius,
            focus_distance=sensor.focus,
            blades=sensor.blades or 0,
            rotation_degrees=sensor.rotation,
        )
    else:
        offset = (sensor.principal_point_offset_x, sensor.principal_point_offset_y)
        builder.set_perspective(to_world, sensor.x_fov, near, far, offset)


def set_film(builder: Builder, film: HdrFilm) -> None:
    """Set the film with its filter."""
    builder.set_film(film.width, film.height, film.crop, *_filter(film.rfilter))


def _filter(rfilter: Filter) -> tuple[str, float] | tuple[str, float, float]:
    """Return the core's name of the filter, and its parameters."""
    if isinstance(rfilter, Box):
        return "box", 0.5  # half its width
    if isinstance(rfilter, Tent):
        return "tent", rfilter.radius
    if isinstance(rfilter, Gaussian):
        return "gaussian", rfilter.stddev
    if isinstance(rfilter, Mitchell):
        return "mitchell", rfilter.B, rfilter.C
    if isinstance(rfilter, CatmullRom):
        return "mitchell", 0.0, 0.5
    assert isinstance(rfilter, Lanczos)
    return "lanczos", float(rfilter.lobes)
