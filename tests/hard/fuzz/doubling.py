"""Small files that would become large: parts that share what is in them, level by level."""

from __future__ import annotations

import random
from typing import Any, Final

__all__ = ["MARK", "doubled_json", "doubled_toml", "doubled_xml"]

MARK: Final = "doubled"
"""Key of a dictionary of JSON that stands for another, joined with itself so many times."""
_CHAINS: Final = (
    ("bsdf", "diffuse", "blendbsdf", ("", ""), '<float name="weight" value="0.5"/>'),
    ("bsdf", "diffuse", "twosided", ("", ""), ""),
    ("bsdf", "diffuse", "mask", ("",), '<float name="opacity" value="0.5"/>'),
    ("bsdf", "diffuse", "bumpmap", ("",), '<texture type="checkerboard"/>'),
    ("bsdf", "diffuse", "normalmap", ("",), '<texture name="normalmap" type="checkerboard"/>'),
    ("phase", "isotropic", "blendphase", ("", ""), '<float name="weight" value="0.5"/>'),
    ("texture", "checkerboard", "checkerboard", ('name="color0"', 'name="color1"'), ""),
    ("shape", "sphere", "shapegroup", ("", ""), ""),
    ("shape", "sphere", "merge", ("", ""), ""),
)
"""Tag, type of the first, type of the others, names of their references, what else they have."""


def doubled_xml(content: bytes, chance: random.Random) -> bytes:
    """Add a chain of parts that refer to the one before, or of variables, or let the file include itself."""
    levels = chance.choice((2, 5, 12, 40, 60))
    kind = chance.randrange(len(_CHAINS) + 2)
    if kind == len(_CHAINS):
        made = [f'<default name="v{i + 1}" value="$v{i}$v{i}"/>' for i in range(levels)]
        made.append(f'<shape type="sphere"><float name="radius" value="$v{levels}"/></shape>')
        text = f'<default name="v0" value="1 "/>{"".join(made)}'
    elif kind > len(_CHAINS):
        text = '<include filename="input.xml"/>' * chance.choice((1, 2, 8))
    else:
        tag, first, other, names, more = _CHAINS[kind]
        made = [f'<{tag} type="{first}" id="n0"/>']
        for i in range(levels):
            references = "".join(f'<ref {name} id="n{i}"/>' for name in names)
            made.append(f'<{tag} type="{other}" id="n{i + 1}">{more}{references}</{tag}>')
        text = f'{"".join(made)}<shape type="sphere"><ref id="n{levels}"/></shape>'
    head, end, tail = content.rpartition(b"</scene>")
    return head + text.encode() + end + tail


def doubled_toml(content: bytes, chance: random.Random) -> bytes:
    """Do the same to TOML."""
    levels = chance.choice((2, 5, 12, 40, 60))
    kind = chance.randrange(4)
    if kind == 0:
        return b'include = ["input.toml", "input.toml"]\n' + content
    if kind == 1:
        made = [f'v{i + 1} = "$v{i}$v{i}"' for i in range(levels)]
        return content + "\n".join(["\n[default]", 'v0 = "1"', *made, f'[x]\ntype = "$v{levels}"\n']).encode()
    key, first, other = ("color0", "checkerboard", "checkerboard") if kind == 2 else ("bsdf", "diffuse", "blendbsdf")
    second = "color1" if kind == 2 else "bsdf2"
    made = []
    for i in range(levels):
        before = f'{{ type = "ref", id = "n{i}" }}'
        made.append(f'[n{i + 1}]\ntype = "{other}"\n{key} = {before}\n{second} = {before}')
    return content + "\n".join(["", f'[n0]\ntype = "{first}"', *made, ""]).encode()


def doubled_json(document: Any, chance: random.Random) -> Any:
    """Write parts of a glTF file many times, or mark a part of a scene as one that is to be joined with itself."""
    if not isinstance(document, dict):
        return document
    if "asset" in document:
        lists = [value for value in document.values() if isinstance(value, list) and value]
        if lists:
            chosen = chance.choice(lists)
            chosen.extend([chance.choice(chosen)] * chance.choice((10, 200)))
        for accessor in document.get("accessors", []):
            if isinstance(accessor, dict) and chance.random() < 0.5:
                accessor.pop("bufferView", None)
                accessor["count"] = chance.choice((3, 3000, 1 << 20))
        return document
    keys = [key for key, value in document.items() if isinstance(value, dict | list)]
    if keys:
        key = chance.choice(keys)
        document[key] = {MARK: chance.choice((2, 5, 12, 40, 60)), "of": document[key]}
    return document
