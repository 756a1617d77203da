"""A scene as the dictionary of plain values that Mitsuba 3 reads, for other renderers.

Everything is spelt as in `equaltime.scene.export.plain`, with two differences that make other renderers compute the
same image. Clipping distances are always written, and the field of view is along x. The function `with_transforms` in
that module replaces nested lists by Mitsuba's transforms.
"""

from __future__ import annotations

from typing import Any

from equaltime.scene.assets import Assets
from equaltime.scene.export.plain import PlainWriter, with_transforms
from equaltime.scene.model import (
    Deformation,
    Instance,
    Perspective,
    Projective,
    SceneModel,
    Sensor,
    Shape,
    ThinLens,
    poses,
)
from equaltime.scene.motion import still

__all__ = ["mitsuba_dict", "with_transforms"]

Dict = dict[str, Any]

NEAR, FAR = 1e-12, 1e12
"""Clipping distances for scenes without any, since Mitsuba always has some. They cost Mitsuba's rays no accuracy."""


def mitsuba_dict(model: SceneModel, assets: Assets) -> Dict:
    """Return the scene `model` as Mitsuba's dictionary: camera, film, filter, shapes and lights.

    Integrator and sampler are left out, because each renderer has its own. Equal BSDFs are written once, and shapes
    refer to them. Files are named by absolute paths. Raises ValueError if a file is missing or has changed, or if the
    scene is animated.
    """
    if still(model) is not model:
        raise ValueError("Mitsuba 3 has no transforms that change with time, nor meshes")
    if any(isinstance(getattr(node, "filename", None), Deformation) for node in model.nodes()):
        raise ValueError("Mitsuba 3 has no meshes that are held between two")
    writer = PlainWriter(lambda filename: str(assets.path(filename).absolute()))
    sensor = _sensor(model.sensor, writer)
    shapes = {f"shape_{i:06}": _shape(shape, writer) for i, shape in enumerate(model.shapes)}
    emitters = {f"emitter_{i:06}": writer.node(emitter) for i, emitter in enumerate(model.emitters)}
    return {"type": "scene", "sensor": sensor, **writer.shared, **shapes, **emitters}


def _shape(shape: Shape, writer: PlainWriter) -> Dict:
    result = writer.node(shape)
    if not isinstance(shape, Instance) and shape.bsdf is not None:
        result["bsdf"] = writer.share(shape.bsdf, "bsdf_1")
    return result


def _sensor(sensor: Sensor, writer: PlainWriter) -> Dict:
    result: Dict = {
        "type": sensor.type,
        "to_world": [list(row) for row in poses(sensor.to_world)[0]],
        "near_clip": sensor.near_clip or NEAR,
        "far_clip": sensor.far_clip or FAR,
        "film": _film(sensor, writer),
    }
    if isinstance(sensor, Projective):
        result |= {"fov": sensor.x_fov, "fov_axis": "x"}
    if isinstance(sensor, Perspective):
        x, y = sensor.principal_point_offset_x, sensor.principal_point_offset_y
        result |= {"principal_point_offset_x": x, "principal_point_offset_y": y}
    elif isinstance(sensor, ThinLens):
        result |= {"aperture_radius": sensor.aperture_radius, "focus_distance": sensor.focus}
    if sensor.medium is not None:
        result["medium"] = writer.node(sensor.medium)
    return result


def _film(sensor: Sensor, writer: PlainWriter) -> Dict:
    film = sensor.film
    x, y, width, height = film.crop
    return {
        "type": film.type,
        "width": film.width,
        "height": film.height,
        "crop_offset_x": x,
        "crop_offset_y": y,
        "crop_width": width,
        "crop_height": height,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": writer.node(film.rfilter),
    }
