"""A scene as the dictionary of plain values that Mitsuba 3 reads: for peers, and for whoever wants the data.

Everything is spelt in Mitsuba's words and is JSON as it stands. The one thing that ``mitsuba.load_dict`` does not take
as it is are the transforms, nested lists under ``to_world``, which `with_transforms` replaces by Mitsuba's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from equaltime.scene.assets import Assets
from equaltime.scene.model import Bsdf, Filter, HdrFilm, Perspective, Plugin, SceneModel, Shape, TwoSided

__all__ = ["mitsuba_dict", "with_transforms"]

Dict = dict[str, Any]

COLORS: Final = frozenset(
    {"reflectance", "eta", "k", "specular_reflectance", "specular_transmittance", "radiance", "intensity"}
)
ALWAYS: Final = frozenset({"radiance", "intensity"})
"""Parameters to spell out even at their default: Mitsuba's is a spectrum, ours the colour that it makes of it."""
NOT_FOR_MITSUBA: Final = frozenset({"id", "type", "bsdf", "emitter", "material"})
NEAR, FAR = 1e-12, 1e12
"""Clips apply only when the scene gives them; Mitsuba always has some, and these cost its rays no accuracy."""


def mitsuba_dict(model: SceneModel, assets: Assets) -> Dict:
    """Return what Mitsuba calls the scene `model`: its camera, film, filter, shapes and lights.

    Integrator and sampler are left out, since they are how a renderer samples. BSDFs that are equal are written once
    and referred to. Files are named by their absolute paths; raises ValueError if one is gone or has changed.
    """
    bsdfs: dict[Bsdf, str] = {}
    shapes = {f"shape_{i:06}": _shape(shape, bsdfs, assets) for i, shape in enumerate(model.shapes)}
    emitters = {f"emitter_{i:06}": _parameters(emitter, assets) for i, emitter in enumerate(model.emitters)}
    materials = {name: _bsdf(bsdf, assets) for bsdf, name in bsdfs.items()}
    return {"type": "scene", "sensor": _sensor(model.sensor), **materials, **shapes, **emitters}


def with_transforms(node: Mapping[str, Any], transform: Callable[[list[list[float]]], Any]) -> Dict:
    """Return the dictionary `node` with every transform handed to `transform`, such as mitsuba.ScalarTransform4f."""
    return {
        key: transform(value)
        if key == "to_world"
        else with_transforms(value, transform)
        if isinstance(value, Mapping)
        else value
        for key, value in node.items()
    }


def _parameters(plugin: Plugin, assets: Assets) -> Dict:
    """Return type and parameters that the scene gives; what it leaves out has the same default in Mitsuba."""
    result: Dict = {"type": plugin.model_dump()["type"]}
    for name in type(plugin).model_fields:
        value = getattr(plugin, name)
        if name in NOT_FOR_MITSUBA or value is None or name not in plugin.model_fields_set | ALWAYS:
            continue
        if name in COLORS:
            result[name] = {"type": "rgb", "value": list(value)}
        elif name == "filename":
            result[name] = str(assets.path(value).absolute())
        elif name == "to_world":
            result[name] = [list(row) for row in value]
        else:
            result[name] = list(value) if isinstance(value, tuple) else value
    return result


def _shape(shape: Shape, bsdfs: dict[Bsdf, str], assets: Assets) -> Dict:
    result = _parameters(shape, assets)
    if shape.bsdf is not None:
        nameless = shape.bsdf.model_copy(update={"id": None})
        name = bsdfs.setdefault(nameless, f"bsdf_{len(bsdfs):06}")
        result["bsdf"] = {"type": "ref", "id": name}
    if shape.emitter is not None:
        result["emitter"] = _parameters(shape.emitter, assets)
    return result


def _bsdf(bsdf: Bsdf, assets: Assets) -> Dict:
    if isinstance(bsdf, TwoSided):
        return {"type": "twosided"} | {f"side_{i}": _parameters(side, assets) for i, side in enumerate(bsdf.bsdf)}
    return _parameters(bsdf, assets)


def _sensor(sensor: Perspective) -> Dict:
    return {
        "type": sensor.type,
        "to_world": [list(row) for row in sensor.to_world],
        "fov": sensor.x_fov,
        "fov_axis": "x",
        "near_clip": sensor.near_clip or NEAR,
        "far_clip": sensor.far_clip or FAR,
        "principal_point_offset_x": sensor.principal_point_offset_x,
        "principal_point_offset_y": sensor.principal_point_offset_y,
        "film": _film(sensor.film),
    }


def _film(film: HdrFilm) -> Dict:
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
        "rfilter": _filter(film.rfilter),
    }


def _filter(rfilter: Filter) -> Dict:
    return {name: value for name, value in rfilter.model_dump().items() if name != "id"}
