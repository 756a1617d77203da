"""Converts a scene model to nested dictionaries with Mitsuba's names.

The dictionaries are valid JSON; read again, they give the same scene. For example, a reference is
``{"type": "ref", "id": name}``, and a colour ``{"type": "rgb", "value": [r, g, b]}``. A transform is a nested list,
which `with_transforms` replaces by Mitsuba's own type. ``mitsuba.load_dict`` accepts all other values unchanged.

`mitsuba_dict` writes two things that make other renderers compute the same image: clipping distances always, and the
field of view along x.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from equaltime.scene.assets import Assets
from equaltime.scene.model import (
    Animation,
    Deformation,
    Instance,
    Perspective,
    Plugin,
    Projective,
    SceneModel,
    Sensor,
    Shape,
    ThinLens,
    poses,
)
from equaltime.scene.motion import still

__all__ = ["TRANSFORMS", "VECTORS", "Dict", "PlainWriter", "mitsuba_dict", "scene_dict", "with_transforms"]

Dict = dict[str, Any]

VECTORS: Final = frozenset({"position", "direction", "center", "p0", "p1"})
"""Parameters of three numbers that are not colours."""
NUMBERS: Final = frozenset({"values"})
"""Parameters of any number of numbers, which Mitsuba wants as a text."""
TRANSFORMS: Final = frozenset({"to_world", "to_uv"})
ALWAYS: Final = frozenset({"radiance", "intensity", "irradiance"})
"""Parameters that are written even at their default, because Mitsuba's default is a spectrum and not a colour."""
RESERVED: Final = frozenset({"type", "id", "default", "include", "path", "alias", "scene"})
"""Names that objects cannot have, because they have another meaning at the top level of a file."""


def scene_dict(model: SceneModel, name_file: Callable[[str], str]) -> Dict:
    """Return the scene `model` as a nested dictionary with Mitsuba's names, which `equaltime.load_dict` reads.

    `name_file` is called with each file name in the model, and returns the file name for the dictionary.
    """
    writer = PlainWriter(name_file)
    parts: list[tuple[str, Plugin]] = [("integrator", model.integrator), ("sensor", model.sensor)]
    parts += [(f"shape_{i}", shape) for i, shape in enumerate(model.shapes)]
    parts += [(f"emitter_{i}", emitter) for i, emitter in enumerate(model.emitters)]
    names = [writer.unique(part.id or name) for name, part in parts]
    written = {name: writer.node(part) for name, (_, part) in zip(names, parts, strict=True)}
    first = {name: written.pop(name) for name in names[:2]}
    return {"type": "scene", **first, **writer.shared, **written}


def with_transforms(node: Mapping[str, Any], transform: Callable[[list[list[float]]], Any]) -> Dict:
    """Return a copy of the dictionary `node` in which `transform` was applied to every transform.

    The function `transform` takes a nested list (4, 4); an example is ``mitsuba.ScalarTransform4f``. Raises ValueError
    for an animated transform, which Mitsuba does not have.
    """

    def converted(name: str, value: Any) -> Any:
        if name in TRANSFORMS and isinstance(value, Mapping):
            raise ValueError(f"'{name}' is animated: Mitsuba 3 has no transforms that change with time")
        if name in TRANSFORMS:
            return transform(value)
        return with_transforms(value, transform) if isinstance(value, Mapping) else value

    return {name: converted(name, value) for name, value in node.items()}


class PlainWriter:
    """Converter of scene nodes to dictionaries.

    Nested BSDFs, textures and media with a name are written once, into the dictionary `shared`, and so are shape
    groups. References replace them elsewhere.
    """

    def __init__(self, name_file: Callable[[str], str]) -> None:
        self._name_file = name_file
        self._names: dict[Plugin, str] = {}
        self._taken: set[str] = set(RESERVED)
        self.shared: Dict = {}

    def unique(self, name: str) -> str:
        """Return an unused name for an object: `name`, or `name` with a number if `name` is used.

        The returned name then counts as used. Dots become underscores, because Mitsuba separates keys by dots.
        """
        unique = plain = name.replace(".", "_") or "unnamed"
        number = 1
        while unique in self._taken:
            number += 1
            unique = f"{plain}_{number}"
        self._taken.add(unique)
        return unique

    def node(self, plugin: Plugin) -> Dict:
        """Return a node as a dictionary of its type and of the parameters that the scene sets.

        Other parameters are left out, because they have the same default in Mitsuba. The parameters in `ALWAYS` are
        written in any case, because their defaults differ.
        """
        result: Dict = {"type": plugin.title}
        for name in type(plugin).model_fields:
            value = getattr(plugin, name)
            if name in ("id", "type") or value is None or name not in plugin.model_fields_set | ALWAYS:
                continue
            if isinstance(value, tuple) and all(isinstance(item, Plugin) for item in value):
                many = len(value) > 1
                result |= {f"{name}_{i}" if many else name: self._nested(item) for i, item in enumerate(value)}
            else:
                result[name] = self._nested(value) if isinstance(value, Plugin) else self._value(name, value)
        return result

    def share(self, plugin: Plugin, name: str) -> Dict:
        """Write a node into `shared`, under `name` or a similar name, and return a reference to the written node.

        Nodes that differ only in their names are written once.
        """
        nameless = plugin.model_copy(update={"id": None})
        if nameless not in self._names:
            self._names[nameless] = self.unique(name)
            self.shared[self._names[nameless]] = self.node(nameless)
        return {"type": "ref", "id": self._names[nameless]}

    def _nested(self, plugin: Plugin) -> Dict:
        if plugin.kind in ("bsdf", "texture", "medium") and plugin.id is not None:
            return self.share(plugin, plugin.id)
        if plugin.kind == "shape" and "shapes" in type(plugin).model_fields:
            return self.share(plugin, plugin.id or "group")
        return self.node(plugin)

    def _value(self, name: str, value: object) -> object:
        if isinstance(value, Deformation):
            files = zip(value.times, map(self._name_file, value.filenames), strict=True)
            held = {} if value.held is None else {"time": value.held}
            return {"animation": [{"time": time, "filename": file} for time, file in files], **held}
        if name == "filename":
            return self._name_file(str(value))
        if name == "focal_length":
            return f"{value!r}mm"
        if isinstance(value, Animation):
            keys = zip(value.times, value.matrices, strict=True)
            return {"animation": [{"time": time, "transform": list(map(list, matrix))} for time, matrix in keys]}
        if not isinstance(value, tuple):
            return value
        if name in NUMBERS:
            return ", ".join(map(repr, value))
        if name in TRANSFORMS:
            return [list(row) for row in value]
        return list(value) if name in VECTORS else {"type": "rgb", "value": list(value)}


# -- Mitsuba's own renderer --------------------------------------------------------------------------------------------

NEAR, FAR = 1e-12, 1e12
"""Clipping distances for scenes without any, since Mitsuba always has some. They cost Mitsuba's rays no accuracy."""


def mitsuba_dict(model: SceneModel, assets: Assets) -> Dict:
    """Return the scene `model` as Mitsuba's dictionary, from which another renderer computes the same image.

    It has the camera, film, filter, shapes and lights. Integrator and sampler are left out, because each renderer has
    its own. Equal BSDFs are written once, and shapes refer to them. Files are named by absolute paths. Raises
    ValueError if a file is missing or has changed, or if the scene is animated.
    """
    if still(model) is not model:
        raise ValueError("Mitsuba 3 has no transforms that change with time, nor meshes")
    if any(isinstance(getattr(node, "filename", None), Deformation) for node in model.nodes()):
        raise ValueError("Mitsuba 3 cannot hold a mesh between two poses")
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
