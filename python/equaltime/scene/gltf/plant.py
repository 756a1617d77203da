"""Makes nodes of the scene tree from Python values."""

from __future__ import annotations

from equaltime.scene.model import Kind
from equaltime.scene.tree import Child, Object, Place, Reference, Value

__all__ = ["add", "plant"]


def plant(kind: Kind, type_: str, place: Place, id_: str | None = None, **fields: object) -> Object:
    """Return the object of this type with these parameters: plain values, objects, references; None adds nothing."""
    result = Object(place, type_, kind, id=id_)
    for name, value in fields.items():
        add(result, name, value)
    return result


def add(parent: Object, name: str | None, value: object) -> None:
    """Add a parameter, or an object without a name, to `parent`; None adds nothing."""
    if value is None:
        return
    node = value if isinstance(value, Object | Reference | Value) else Value(parent.place, value)
    parent.children.append(Child(name, node))
