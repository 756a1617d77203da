"""Converts checked JSON into pygltflib's objects.

pygltflib's own decoder takes about a millisecond a node. Its checks are not needed here, because every value is known
to be of the right type.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from functools import cache
from typing import Any, get_args, get_type_hints

from pygltflib import GLTF2, Attributes, PbrMetallicRoughness

__all__ = ["typed"]


def typed(document: Mapping[str, Any]) -> GLTF2:
    """Return the `GLTF2` of a document that follows the schema; materials without metallic-roughness get its default.

    Properties that pygltflib does not know are left out.
    """
    gltf = _made(GLTF2, document)
    for material in gltf.materials:
        material.pbrMetallicRoughness = material.pbrMetallicRoughness or PbrMetallicRoughness()
    for node, given in zip(gltf.nodes, document.get("nodes", ()), strict=True):
        node.weights = given.get("weights")  # pygltflib has no such field
    return gltf


def _made(kind: type, value: Any) -> Any:
    """Return the JSON `value` as an object of pygltflib's class `kind`, or as a list of such objects."""
    if isinstance(value, list):
        return [_made(kind, item) for item in value]
    if kind is Attributes:
        return Attributes(**value)
    known = _fields(kind)
    return kind(**{name: _made(k, v) if (k := known[name]) else v for name, v in value.items() if name in known})


@cache
def _fields(kind: type) -> dict[str, type | None]:
    """Return the fields of a pygltflib class, with the class of their objects; None for plain values."""
    return {name: _class_in(hint) for name, hint in get_type_hints(kind).items()}


def _class_in(hint: Any) -> type | None:
    """Return the pygltflib class in a type such as ``Optional[List[Accessor]]``, or None."""
    if isinstance(hint, type) and (is_dataclass(hint) or hint is Attributes):
        return hint
    return next((found for part in get_args(hint) if (found := _class_in(part)) is not None), None)
