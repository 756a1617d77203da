"""A JSON schema of scene files in TOML or JSON, for completion and checks in editors.

The schema covers every plugin, parameter, value and unit of the model. Some rules can only be checked when a scene is
loaded, such as whether a referenced name exists. In these cases the schema accepts any value.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from typing import Any, Final, get_args, get_type_hints

from pydantic import TypeAdapter

from equaltime.scene.export.plain import VECTORS
from equaltime.scene.model import PLUGINS, Animation, Color, Deformation, Matrix, Plugin
from equaltime.scene.model.textures import TexturePlugin
from equaltime.scene.resolve import VOLUMETRIC
from equaltime.scene.transforms import STEPS

__all__ = ["scene_schema"]

Schema = dict[str, Any]

NUMBER: Final[Schema] = {"type": "number"}
VARIABLE: Final[Schema] = {"$ref": "#/$defs/variable"}
NAME: Final[Schema] = {"type": "string", "description": "The name of an object."}
COLOR: Final[Schema] = {"$ref": "#/$defs/color"}
_COLORS: Final = "Grey, RGB (linear), #rrggbb (encoded sRGB) or a spectrum."
OBJECT: Final[Schema] = {"$ref": "#/$defs/object"}
REFERENCE: Final[Schema] = {"$ref": "#/$defs/reference"}
ANY: Final[Schema] = {"anyOf": [OBJECT, REFERENCE, {"type": "array", "items": {"anyOf": [OBJECT, REFERENCE]}}]}
"""Schema of an object, a reference to an object, or a list of these, under any key."""
MERGE: Final = "merge"
"""Type of a shape that is replaced before the model is made; see `equaltime.scene.resolve`."""
PARTS: Final = {"homogeneous": ("sigma_s", "sigma_a")}
"""Parameters that a plugin accepts in place of its own parameters, by plugin."""


def scene_schema() -> Schema:
    """Return the JSON schema (draft 2020-12) of scene files, as JSON data."""
    plugins = {f"{plugin.kind}.{name}": _plugin(name, plugin) for name, plugin in PLUGINS.items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "equaltime scene",
        "description": "Every table is an object, and its key is its name.",
        "type": "object",
        "properties": {
            "type": {"const": "scene"},
            "default": {"type": "object", "description": "Variables ($name) and their values, for -D name=value."},
            "include": _strings("Other files whose objects are part of this scene."),
            "path": {"anyOf": [_strings("Folders where files are looked for first."), OBJECT]},
            "alias": {"type": "object", "description": 'Further names of objects: new = "known".'},
        },
        "additionalProperties": ANY,
        "$defs": {**_shared(), **_families(), **plugins, f"shape.{MERGE}": _merge()},
    }


def _strings(description: str) -> Schema:
    return {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}], "description": description}


def _families() -> dict[str, Schema]:
    """Return the schemas of an object of any family and of each family; its type selects the plugin's schema."""
    kinds: dict[str, str] = {name: plugin.kind for name, plugin in PLUGINS.items()}
    kinds[MERGE] = "shape"
    families = {family: [name for name, kind in kinds.items() if kind == family] for family in kinds.values()}
    return {"object": _one_of(kinds)} | {
        family: _one_of(dict.fromkeys(names, family)) for family, names in families.items()
    }


def _one_of(kinds: Mapping[str, str]) -> Schema:
    cases = [
        {"if": {"properties": {"type": {"const": name}}}, "then": {"$ref": f"#/$defs/{kind}.{name}"}}
        for name, kind in kinds.items()
    ]
    types = {"anyOf": [{"enum": list(kinds)}, VARIABLE]}
    return {"type": "object", "properties": {"type": types}, "required": ["type"], "allOf": cases}


def _array(items: Schema, *counts: int) -> Schema:
    lengths = [{"type": "array", "items": items, "minItems": count, "maxItems": count} for count in counts]
    return lengths[0] if len(lengths) == 1 else {"anyOf": lengths}


def _shared() -> dict[str, Schema]:
    """Return the definitions that plugins share."""
    rgb = {"properties": {"type": {"const": "rgb"}, "value": {}}, "required": ["type", "value"]}
    spectrum = {
        "properties": {"type": {"const": "spectrum"}, "value": {}, "filename": {"type": "string"}},
        "required": ["type"],
    }
    spectra = [{"$ref": f"#/$defs/{plugin.kind}.{name}"} for name, plugin in PLUGINS.items() if _is_spectrum(plugin)]
    closed = [{"type": "object", "additionalProperties": False, **made} for made in (rgb, spectrum)]
    number = {"anyOf": [NUMBER, VARIABLE]}
    hexadecimal = {"type": "string", "pattern": "^#([0-9a-fA-F]{3}){1,2}$"}
    step: Schema = {"anyOf": [{"type": "object", "properties": {name: {}}, "required": [name]} for name in STEPS]}
    return {
        "variable": {"type": "string", "pattern": r"^\$\w+$", "description": "A variable."},
        "reference": {
            "type": "object",
            "properties": {"type": {"const": "ref"}, "id": {"type": "string"}},
            "required": ["type", "id"],
            "additionalProperties": False,
        },
        "vector": {"anyOf": [_array(number, 3), VARIABLE]},
        "color": {"anyOf": [number, _array(number, 3), hexadecimal, *closed, *spectra], "description": _COLORS},
        "transform": {"anyOf": [step, {"type": "array", "items": {"anyOf": [step, _array(number, 4, 3)]}}, VARIABLE]},
        "placement": {"anyOf": [{"$ref": "#/$defs/transform"}, _animation(number)]},
        "mesh": {"anyOf": [{"type": "string"}, _deformation(number)]},
    }


def _animation(number: Schema) -> Schema:
    """Return the schema of a transform that changes with time."""
    properties = {"time": number, "transform": {"$ref": "#/$defs/transform"}, **{name: {} for name in STEPS}}
    key = {
        "type": "object",
        "properties": properties,
        "required": ["time"],
        "minProperties": 2,
        "maxProperties": 2,
        "additionalProperties": False,
    }
    return {
        "type": "object",
        "properties": {"animation": {"type": "array", "items": key, "minItems": 2}},
        "required": ["animation"],
        "additionalProperties": False,
        "description": "Transforms at two times or more; an extension to Mitsuba.",
    }


def _deformation(number: Schema) -> Schema:
    """Return the schema of the files of a mesh that deforms."""
    key = {
        "type": "object",
        "properties": {"time": number, "filename": {"type": "string"}},
        "required": ["time", "filename"],
        "additionalProperties": False,
    }
    return {
        "type": "object",
        "properties": {"animation": {"type": "array", "items": key, "minItems": 2}, "time": number},
        "required": ["animation"],
        "additionalProperties": False,
        "description": "Mesh files at two times or more, or the mesh at a time between them; an extension to Mitsuba.",
    }


def _is_spectrum(plugin: type[Plugin]) -> bool:
    return plugin.kind == "texture" and not issubclass(plugin, TexturePlugin)


def _plugin(name: str, plugin: type[Plugin]) -> Schema:
    """Return the schema of a plugin's table."""
    hints = get_type_hints(plugin, include_extras=True)
    fields = {field: info for field, info in plugin.model_fields.items() if field not in ("type", "id")}
    meanings = {key: text for each in reversed(plugin.__mro__) for key, text in _meanings(each).items()}
    properties = {
        field: _field(plugin, field, hints[field]) | ({"description": meanings[field]} if field in meanings else {})
        for field in fields
    }
    properties |= dict.fromkeys(PARTS.get(name, ()), COLOR)
    by_kind = set(plugin.roles.values())
    required = [field for field, info in fields.items() if info.is_required() and field not in by_kind]
    return {
        "type": "object",
        "description": (plugin.__doc__ or "").split("\n")[0],
        "properties": {"type": {"const": name}, "id": {"type": "string"}, **properties},
        "required": ["type", *required],
        "additionalProperties": ANY if plugin.roles else False,
    }


def _merge() -> Schema:
    """Return the schema of a ``merge``; each shape in it is a part of the scene."""
    part: Schema = {"anyOf": [{"$ref": "#/$defs/shape"}, REFERENCE]}
    return {
        "type": "object",
        "description": "Any number of shapes, which take the place of this one.",
        "properties": {"type": {"const": MERGE}, "id": {"type": "string"}},
        "required": ["type"],
        "additionalProperties": {"anyOf": [part, {"type": "array", "items": part}]},
    }


@cache
def _meanings(plugin: type) -> dict[str, str]:
    """Return the docstrings of a plugin's own parameters, from its source code; only a schema needs them."""
    if not issubclass(plugin, Plugin):
        return {}
    definition = ast.parse(inspect.getsource(plugin)).body[0]
    assert isinstance(definition, ast.ClassDef), "a plugin is a class at the top of its module"
    return {
        field.target.id: inspect.cleandoc(below.value.value)
        for field, below in pairwise(definition.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(below, ast.Expr)
        and isinstance(below.value, ast.Constant)
        and isinstance(below.value.value, str)
    }


def _field(plugin: type[Plugin], name: str, hint: Any) -> Schema:
    """Return the schema of a parameter of type `hint`."""
    if name in plugin.roles.values():
        kinds = [kind for kind, field in plugin.roles.items() if field == name]
        return _nested(kinds, many=name in plugin.lists)
    if plugin.kind in VOLUMETRIC and (_holds(hint, Color) or name == "weight"):
        return {"anyOf": [COLOR, REFERENCE, {"$ref": "#/$defs/volume"}]}
    if found := plugin.slots().get(name):
        constant: list[Schema] = [COLOR] if _holds(hint, Color) or _holds(hint, float) else []
        return {"anyOf": [*constant, *_nested(sorted(found), many=False)["anyOf"]]}
    if _holds(hint, Animation):
        return {"$ref": "#/$defs/placement"}
    if _holds(hint, Deformation):
        return {"$ref": "#/$defs/mesh"}
    if _holds(hint, Matrix):
        return {"$ref": "#/$defs/transform"}
    if _holds(hint, tuple[float, ...]):
        return {"anyOf": [{"type": "string"}, {"type": "array", "items": NUMBER}]}
    if _holds(hint, Color):
        return {"$ref": "#/$defs/vector"} if name in VECTORS else COLOR
    if name in LOOSE:
        return {"type": ["string", "number"]}
    return {"anyOf": [TypeAdapter(hint).json_schema(), VARIABLE]}


LOOSE: Final = frozenset({"int_ior", "ext_ior", "focal_length", "material"})
"""Parameters that are a number or a string."""


def _nested(kinds: list[Any], *, many: bool) -> Schema:
    """Return the schema of an object of one of these families or its name; with `many`, also of a list of them."""
    objects = [{"$ref": f"#/$defs/{kind}"} for kind in kinds]
    one = [NAME, REFERENCE, *objects]
    return {"anyOf": [*one, {"type": "array", "items": {"anyOf": one}}] if many else one}


def _holds(hint: object, wanted: object) -> bool:
    """Tell whether `wanted` is part of a type, through unions and annotations."""
    return hint == wanted or any(_holds(argument, wanted) for argument in get_args(hint) if hint != Color)
