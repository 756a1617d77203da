"""Replaces Mitsuba's shape ``merge``, which joins shapes into one mesh for speed, by the shapes in it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from equaltime.scene.known import mitsuba_kind
from equaltime.scene.tree import Child, Object, Report, Value

__all__ = ["unmerged"]

HOLDERS = ("scene", "shapegroup")
"""Types of objects that contain shapes."""


def unmerged(root: Object, report: Report) -> Object:
    """Return the scene `root` without any ``merge``; contents that a ``merge`` cannot have are reported."""
    if not any(node.type == "merge" for node in root.objects()):
        return root
    return dataclasses.replace(root, children=list(_opened(root, report)))


def _opened(holder: Object, report: Report) -> Iterator[Child]:
    """Iterate over the children of a scene, a group or a ``merge``, with every ``merge`` replaced by its shapes."""
    for child in holder.children:
        node = child.node
        if not isinstance(node, Object) or node.type not in ("merge", *HOLDERS):
            yield child
        elif node.type == "merge" and node.kind in (None, "shape"):
            parts = dataclasses.replace(node, children=[part for part in node.children if _fits(part, report)])
            yield from (Child(None, part.node) for part in _opened(parts, report))
        else:
            yield Child(child.name, dataclasses.replace(node, children=list(_opened(node, report))))


def _fits(part: Child, report: Report) -> bool:
    if isinstance(part.node, Value):
        report.add(part.node.place, f"unknown parameter '{part.name}' of 'merge', which takes shapes alone")
        return False
    if not isinstance(part.node, Object):
        return True
    kind = part.node.kind or mitsuba_kind(part.node.type)
    if kind not in (None, "shape"):
        report.add(part.node.place, f"'merge' cannot contain a {kind} ('{part.node.type}'): it takes shapes alone")
    return kind in (None, "shape")
