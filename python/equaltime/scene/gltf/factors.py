"""Caps factors of materials at 1: exporters exceed 1 by rounding or to mean light, and viewers read 1."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

__all__ = ["capped"]

UNIT_FACTORS = frozenset(
    {
        *("baseColorFactor", "metallicFactor", "roughnessFactor"),
        *("diffuseFactor", "specularFactor", "glossinessFactor"),
        *("clearcoatFactor", "clearcoatRoughnessFactor", "sheenColorFactor", "sheenRoughnessFactor"),
        *("transmissionFactor", "attenuationColor", "anisotropyStrength", "strength"),
    }
)
"""Factors that the specification keeps in [0, 1]."""
_DEEPEST = 3
"""Levels below a material that are searched: down to a texture of an extension."""


def capped(document: Mapping[str, Any]) -> list[str]:
    """Set factors of materials above 1 to 1, in place, and return their places."""
    materials = document.get("materials")
    if not isinstance(materials, list):
        return []
    return [place for i, material in enumerate(materials) for place in _capped(material, f"materials[{i}]", _DEEPEST)]


def _capped(node: Any, place: str, depth: int) -> Iterator[str]:
    if not isinstance(node, dict):
        return
    for key, value in node.items():
        if key in UNIT_FACTORS and _exceeds(value):
            node[key] = [min(v, 1.0) for v in value] if isinstance(value, list) else 1.0
            yield f"{place}.{key}"
        elif depth > 0 and key != "extras":
            yield from _capped(value, f"{place}.{key}", depth - 1)


def _exceeds(value: Any) -> bool:
    """Tell whether the value is a number above 1, or a list of numbers with one above 1."""
    values = value if isinstance(value, list) else [value]
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values) and any(v > 1.0 for v in values)
