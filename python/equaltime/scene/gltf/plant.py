"""Creates objects of the scene tree from Python values."""

from __future__ import annotations

from equaltime.scene.model import Kind
from equaltime.scene.tree import Child, Object, Place, Plain, Ref

__all__ = ["add", "plant"]


def plant(kind: Kind, type_: str, place: Place, id_: str | None = None, **fields: object) -> Object:
    """Return a new object of the scene tree, with plugin family `kind` (such as ``bsdf``) and plugin type `type_`.

    `place` is the object's position in the file, for error messages. The `fields` are the object's parameters: plain
    values, objects or references. A field that is None is left out.
    """
    result = Object(place, type_, kind, id=id_)
    for name, value in fields.items():
        add(result, name, value)
    return result


def add(parent: Object, name: str | None, value: object) -> None:
    """Add `value` to `parent`: as the parameter `name`, or as an unnamed nested object if `name` is None.

    A `value` of None is not added.
    """
    if value is None:
        return
    node = value if isinstance(value, Object | Ref | Plain) else Plain(parent.place, value)
    parent.children.append(Child(name, node))
