"""Converts cameras and lights of glTF files to sensors and emitters of the scene tree."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.ids import Ids
from equaltime.scene.gltf.nodes import Placed, rigid
from equaltime.scene.model import Animation
from equaltime.scene.motion import animation
from equaltime.scene.studio import ASPECT, film
from equaltime.scene.tree import Object, Place, plant

__all__ = ["light", "sensor"]

Array = NDArray[np.float64]

WIDEST: Final = 1000.0
TURNED: Final[Array] = np.diag([-1.0, 1.0, -1.0, 1.0])
"""Transform (4, 4) from Mitsuba's cameras and lights (along +z, x to the left) to glTF's (along -z, x to the right)."""


def sensor(document: Document, at: Placed, place: Place, times: tuple[float, ...] = ()) -> Object:
    """Return the camera of the node `at` in `document` as a sensor of the scene tree.

    If the node moves, the sensor is animated with one key for each of the `times`, in seconds. `place` is the position
    of the file in the scene's description, for messages.
    """
    camera = document.gltf.cameras[at.node.camera]
    place = place.key("cameras").key(at.node.camera)
    view = camera.orthographic if camera.type == "orthographic" else camera.perspective
    if view is None:
        raise Malformed((f"cameras[{at.node.camera}]", f"needs '{camera.type}'"))
    if camera.type == "orthographic":
        return _orthographic(view, at, place, times)
    return plant(
        "sensor",
        "perspective",
        place,
        to_world=_where(at, times, TURNED),
        fov=math.degrees(view.yfov),
        fov_axis="y",
        near_clip=view.znear or None,
        far_clip=view.zfar or None,
        film=film(view.aspectRatio or ASPECT, place),
    )


def _where(at: Placed, times: tuple[float, ...], own: Array) -> Array | Animation:
    """Return the placement of a camera: `own` first, then the node's transform."""
    if not at.moving:
        return rigid(at.to_world) @ own
    return animation([(time, rigid(to_world) @ own) for time, to_world in zip(times, at.moving, strict=True)])


def _orthographic(view: Any, at: Placed, place: Place, times: tuple[float, ...]) -> Object:
    width, height = abs(view.xmag), abs(view.ymag)
    if not min(width, height) > 0.0 or not 1.0 / WIDEST <= width / height <= WIDEST:
        message = f"xmag and ymag must not be 0, nor one of them {WIDEST:g} times the other"
        raise Malformed((f"cameras[{at.node.camera}].orthographic", message))
    to_world = _where(at, times, TURNED @ transforms.scale((width, width, 1.0)))
    return plant(
        "sensor",
        "orthographic",
        place,
        to_world=to_world,
        near_clip=view.znear or None,
        far_clip=view.zfar or None,
        film=film(width / height, place),
    )


def light(document: Document, at: Placed, place: Place, ids: Ids) -> Object | None:
    """Return the light of the node `at` (KHR_lights_punctual) as an emitter, or None if the node has no light.

    Returns None also for a spot light whose cone has no width. Numbers in candela and lux are used as W/sr and W/m² per
    channel, because only ratios of lights are visible in an image. `document` is the glTF file, `place` its position in
    the scene's description, and `ids` the maker of the scene's ids.
    """
    extension = (at.node.extensions or {}).get("KHR_lights_punctual")
    if extension is None:
        return None
    index = extension["light"]
    source = document.gltf.extensions["KHR_lights_punctual"]["lights"][index]
    place = place.key("extensions.KHR_lights_punctual.lights").key(index)
    name = at.node.name or source.get("name")
    id_ = ids.take(name) if name else None
    power = tuple(source.get("intensity", 1.0) * c for c in source.get("color", (1.0, 1.0, 1.0)))
    if "range" in source:
        document.note("the range of a light is not used: the light has no limit", place.path)
    if at.moving:
        document.note("lights do not move: they stand as when the shutter opens", f"nodes[{at.index}]")
    to_world = rigid(at.to_world) @ TURNED
    if source["type"] == "point":
        return plant("emitter", "point", place, id_, intensity=power, position=tuple(to_world[:3, 3].tolist()))
    if source["type"] == "directional":
        return plant("emitter", "directional", place, id_, irradiance=power, direction=tuple(to_world[:3, 2].tolist()))
    cone = source.get("spot", {})
    angles = cone.get("innerConeAngle", 0.0), cone.get("outerConeAngle", math.pi / 4.0)
    inner, outer = (min(math.degrees(angle), 90.0) for angle in angles)  # pi / 2 in float32 is more
    if outer <= 0.0:
        document.note("a spot whose cone is closed gives no light", place.path)
        return None
    if inner < outer:
        document.note("the light of a spot falls linearly with the angle, from the inner cone to the outer", place.path)
    elif inner > outer:
        document.note("the inner cone of a spot is wider than the outer: it counts as equal", place.path)
    return plant(
        "emitter",
        "spot",
        place,
        id_,
        intensity=power,
        cutoff_angle=outer,
        beam_width=min(inner, outer),
        to_world=to_world,
    )
