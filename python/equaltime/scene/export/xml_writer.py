"""Converts the dictionary of a scene to Mitsuba 3's XML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from equaltime.scene.export.plain import TRANSFORMS, VECTORS
from equaltime.scene.model import PLUGINS

__all__ = ["write_xml"]

VERSION: Final = "3.0.0"
INDENT: Final = "    "
BY_NAME: Final = frozenset({"texture", "medium"})
"""Kinds of objects that Mitsuba assigns by parameter name; objects of other kinds are assigned by kind."""


def write_xml(scene: Mapping[str, Any]) -> str:
    """Return the XML text, for Mitsuba 3, of `scene`: a dictionary made by `equaltime.scene.export.plain.scene_dict`.

    Cameras may have ``look_at`` in place of a matrix.
    """
    kinds = {name: PLUGINS[part["type"]].kind for name, part in scene.items() if name != "type"}
    lines = [f'<scene version="{VERSION}">']
    for name, kind in kinds.items():
        lines += _object(scene[name], f"id={_quoted(name)}", kind, kinds, 1)
    return "\n".join([*lines, "</scene>", ""])


def _object(table: Mapping[str, Any], name: str, kind: str, kinds: Mapping[str, str], depth: int) -> Iterator[str]:
    """Iterate over the lines of an object's element."""
    head = f"{INDENT * depth}<{kind} type={_quoted(table['type'])}{' ' if name else ''}{name}"
    inner = [line for key, value in table.items() if key != "type" for line in _part(key, value, kinds, depth + 1)]
    if not inner:
        yield f"{head}/>"
        return
    yield f"{head}>"
    yield from inner
    yield f"{INDENT * depth}</{kind}>"


def _part(key: str, value: Any, kinds: Mapping[str, str], depth: int) -> Iterator[str]:
    """Iterate over the lines of a parameter, or of an object inside another."""
    indent = INDENT * depth
    if isinstance(value, Mapping) and "animation" in value:
        held = f' time="{value["time"]!r}"' if "time" in value else ""
        yield f'{indent}<animation name="{key}"{held}>'
        for k in value["animation"]:
            time = f'time="{k["time"]!r}"'
            yield (
                _transform(time, k["transform"], depth + 1)
                if key in TRANSFORMS
                else f"{indent}{INDENT}<string {time} value={_quoted(k[key])}/>"
            )
        yield f"{indent}</animation>"
    elif key in TRANSFORMS:
        yield _transform(f'name="{key}"', value, depth)
    elif isinstance(value, Mapping) and value["type"] == "ref":
        name = f" name={_quoted(key)}" if kinds.get(value["id"]) in BY_NAME else ""
        yield f"{indent}<ref id={_quoted(value['id'])}{name}/>"
    elif isinstance(value, Mapping) and value["type"] != "rgb":
        kind = PLUGINS[value["type"]].kind
        yield from _object(value, f"name={_quoted(key)}" if kind in BY_NAME else "", kind, kinds, depth)
    else:
        yield f"{indent}<{_tag(key, value)} name={_quoted(key)} value={_quoted(_text(value))}/>"


def _transform(called: str, value: Any, depth: int) -> str:
    """Return the element of a transform, which is a matrix or a `look_at`."""
    indent = INDENT * depth
    if isinstance(value, Mapping):
        step = "lookat" + "".join(
            f' {name}="{", ".join(map(repr, vector))}"' for name, vector in value["look_at"].items()
        )
    else:
        rows = f"\n{indent}{INDENT * 4}".join(" ".join(map(repr, row)) for row in value)
        step = f'matrix value="{rows}"'
    return f"{indent}<transform {called}><{step}/></transform>"


def _tag(key: str, value: Any) -> str:
    if isinstance(value, Mapping):
        return "rgb"
    if isinstance(value, list):
        return ("vector" if key == "direction" else "point") if key in VECTORS else "rgb"
    names = {bool: "boolean", int: "integer", float: "float"}
    return names.get(type(value), "string")


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        value = value["value"]
    if isinstance(value, list):
        return " ".join(map(repr, value))
    return repr(value).lower() if isinstance(value, bool | int | float) else str(value)


def _quoted(text: str) -> str:
    """Return `text` as an attribute's value; dollar signs are escaped, so that none begins a variable."""
    return quoteattr(text.replace("$", r"\$"), {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})
