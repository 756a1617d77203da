"""A scene as the dictionary of plain values that Mitsuba 3 reads: for peers, and for whoever wants the data.

Everything is spelt in Mitsuba's words and is JSON as it stands. The one thing that ``mitsuba.load_dict`` does not take
as it is are the transforms, nested lists under ``to_world``, which `with_transforms` replaces by Mitsuba's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from equaltime.scene.assets import Assets
from equaltime.scene.model import Orthographic, Perspective, Plugin, SceneModel, Sensor, ThinLens

__all__ = ["mitsuba_dict", "with_transforms"]

Dict = dict[str, Any]

VECTORS: Final = frozenset({"position", "direction", "center", "p0", "p1"})
"""Parameters of three numbers that are no colours."""
TRANSFORMS: Final = frozenset({"to_world", "to_uv"})
ALWAYS: Final = frozenset({"radiance", "intensity", "irradiance"})
"""Parameters to spell out even at their default: Mitsuba's is a spectrum, ours the colour that it makes of it."""
SHARED: Final = frozenset({"bsdf", "shapegroup"})
"""What shapes have in common is written once at the top and referred to, if it stands under these names."""
NEAR, FAR = 1e-12, 1e12
"""Clips apply only when the scene gives them; Mitsuba always has some, and these cost its rays no accuracy."""


def mitsuba_dict(model: SceneModel, assets: Assets) -> Dict:
    """Return what Mitsuba calls the scene `model`: its camera, film, filter, shapes and lights.

    Integrator and sampler are left out, since they are how a renderer samples. BSDFs that are equal are written once
    and referred to. Files are named by their absolute paths; raises ValueError if one is gone or has changed.
    """
    writer = _Writer(assets)
    shapes = {f"shape_{i:06}": writer.shape(shape) for i, shape in enumerate(model.shapes)}
    emitters = {f"emitter_{i:06}": writer.node(emitter) for i, emitter in enumerate(model.emitters)}
    return {"type": "scene", "sensor": _sensor(model.sensor, writer), **writer.shared, **shapes, **emitters}


def with_transforms(node: Mapping[str, Any], transform: Callable[[list[list[float]]], Any]) -> Dict:
    """Return the dictionary `node` with every transform handed to `transform`, such as mitsuba.ScalarTransform4f."""
    return {
        key: transform(value)
        if key in TRANSFORMS
        else with_transforms(value, transform)
        if isinstance(value, Mapping)
        else value
        for key, value in node.items()
    }


class _Writer:
    """Writes nodes as dictionaries; what is shared is collected in `shared`."""

    def __init__(self, assets: Assets) -> None:
        self._assets = assets
        self._names: dict[Plugin, str] = {}
        self.shared: Dict = {}

    def node(self, plugin: Plugin) -> Dict:
        """Return type and parameters that the scene gives; what it leaves out has the same default in Mitsuba."""
        result: Dict = {"type": plugin.model_dump(include={"type"})["type"]}
        for name in type(plugin).model_fields:
            value = getattr(plugin, name)
            if name in ("id", "type") or value is None or name not in plugin.model_fields_set | ALWAYS:
                continue
            if isinstance(value, tuple) and all(isinstance(item, Plugin) for item in value):
                result |= {f"{name}_{i}": self.node(item) for i, item in enumerate(value)}
            else:
                result[name] = self.node(value) if isinstance(value, Plugin) else self._value(name, value)
        return result

    def shape(self, shape: Plugin) -> Dict:
        """Return the dictionary of `shape`, with references to what it shares with others."""
        result = self.node(shape)
        for name in SHARED & result.keys():
            result[name] = {"type": "ref", "id": self._share(name, getattr(shape, name))}
        return result

    def _share(self, name: str, plugin: Plugin) -> str:
        nameless = plugin.model_copy(update={"id": None})
        if nameless not in self._names:
            self._names[nameless] = f"{name}_{len(self._names):06}"
            self.shared[self._names[nameless]] = self.node(nameless)
        return self._names[nameless]

    def _value(self, name: str, value: object) -> object:
        if name == "filename":
            return str(self._assets.path(str(value)).absolute())
        if not isinstance(value, tuple):
            return value
        if name in TRANSFORMS:
            return [list(row) for row in value]
        return list(value) if name in VECTORS else {"type": "rgb", "value": list(value)}


def _sensor(sensor: Sensor, writer: _Writer) -> Dict:
    result: Dict = {
        "type": sensor.type,
        "to_world": [list(row) for row in sensor.to_world],
        "near_clip": sensor.near_clip or NEAR,
        "far_clip": sensor.far_clip or FAR,
        "film": _film(sensor, writer),
    }
    if not isinstance(sensor, Orthographic):
        result |= {"fov": sensor.x_fov, "fov_axis": "x"}
    if isinstance(sensor, Perspective):
        x, y = sensor.principal_point_offset_x, sensor.principal_point_offset_y
        result |= {"principal_point_offset_x": x, "principal_point_offset_y": y}
    elif isinstance(sensor, ThinLens):
        result |= {"aperture_radius": sensor.aperture_radius, "focus_distance": sensor.focus}
    if sensor.medium is not None:
        result["medium"] = writer.node(sensor.medium)
    return result


def _film(sensor: Sensor, writer: _Writer) -> Dict:
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
