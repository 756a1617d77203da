"""Converts the dictionary of a scene to TOML, with one table for each object at the top level."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from equaltime.scene.export.plain import TRANSFORMS
from equaltime.scene.model import PLUGINS

__all__ = ["write_toml"]


def write_toml(scene: Mapping[str, Any]) -> str:
    """Return the TOML text of `scene`, a dictionary made by `equaltime.scene.export.plain.scene_dict`.

    Cameras may have ``look_at`` in place of a matrix.
    """
    tables = [_table(name, table) for name, table in scene.items() if name != "type"]
    return "\n".join(tables)


def _table(name: str, table: Mapping[str, Any]) -> str:
    slots = _slots(table)
    entries = (f"{_key(key)} = {_value(key, value, slots, lines=True)}\n" for key, value in table.items())
    return f"[{_key(name)}]\n" + "".join(entries)


def _slots(table: Mapping[str, Any]) -> frozenset[str]:
    """Return the parameters where the name of an object stands for the object."""
    plugin = PLUGINS.get(str(table.get("type")))
    return frozenset() if plugin is None else frozenset({*plugin.slots(), *plugin.roles.values()})


def _value(key: str, value: object, slots: frozenset[str], *, lines: bool = False) -> str:
    if key in TRANSFORMS and isinstance(value, list):
        rows = [_array(row) for row in value]
        return "[\n" + "".join(f"  {row},\n" for row in rows) + "]" if lines else f"[{', '.join(rows)}]"
    if isinstance(value, list):
        return _array(value)
    if isinstance(value, Mapping) and "animation" in value:
        return _animation(key, value, slots)
    if key in TRANSFORMS and isinstance(value, Mapping):
        vectors = ", ".join(f"{name} = {_array(vector)}" for name, vector in value["look_at"].items())
        return f"[{{ look_at = {{ {vectors} }} }}]"
    if isinstance(value, Mapping):
        return _nested(key, value, slots)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value.replace("$", r"\$"))
    return repr(value)


def _animation(key: str, value: Mapping[str, Any], slots: frozenset[str]) -> str:
    name = "transform" if key in TRANSFORMS else key
    keys = (f"{{ time = {k['time']!r}, {name} = {_value(key, k[name], slots)} }}" for k in value["animation"])
    held = f", time = {value['time']!r}" if "time" in value else ""
    return f"{{ animation = [{', '.join(keys)}]{held} }}"


def _array(numbers: list[Any]) -> str:
    return f"[{', '.join(map(repr, numbers))}]"


def _nested(key: str, value: Mapping[str, Any], slots: frozenset[str]) -> str:
    if value["type"] == "rgb":
        color = value["value"]
        return repr(color[0]) if len(set(color)) == 1 else _array(color)
    if value["type"] == "ref" and key in slots:
        return _string(value["id"].replace("$", r"\$"))
    inner = _slots(value)
    return "{ " + ", ".join(f"{_key(name)} = {_value(name, item, inner)}" for name, item in value.items()) + " }"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _string(name)


def _string(text: str) -> str:
    """Return a basic TOML string: quotes, backslashes and control characters are escaped."""

    def escaped(match: re.Match[str]) -> str:
        letter = match[0]
        return f"\\{letter}" if letter in '"\\' else f"\\u{ord(letter):04x}"

    return '"' + re.sub(r'["\\\x00-\x1f\x7f]', escaped, text) + '"'
