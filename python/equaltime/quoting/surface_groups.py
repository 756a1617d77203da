"""Groups of a scene's surfaces, whose shares of the noise are measured: shapes, or materials if there are many shapes.

The number of groups is limited, since the memory that shares take grows with it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from equaltime.scene import Scene
from equaltime.scene.model import Plugin, Shape, Solid
from equaltime.scene.naming import Name, Names

__all__ = ["SurfaceGroups", "described"]

MOST: Final = 24
"""Largest number of groups."""


@dataclass(frozen=True)
class SurfaceGroups:
    """Groups of a scene's shapes, numbered from 0, with their names."""

    of_shape: tuple[int, ...]
    """Group of each shape, in the core's order."""
    names: tuple[str, ...]
    """Name of each group, such as ``shape 3: floor (/tmp/scene.toml:12)``, ``material 1: gold`` or ``others``."""

    @classmethod
    def of(cls, scene: Scene) -> SurfaceGroups:
        """Return the groups of a scene: each shape alone, or if there are more than `MOST`, the shapes of a material.

        If there are more than `MOST` materials too, the last group has those with the fewest shapes.
        """
        shapes = Names(scene).shapes
        once = {id(shape): shape for shape in shapes}  # the core has a shape that moves twice
        if len(once) > MOST:
            return _by_material(shapes, scene)
        numbers = {key: number for number, key in enumerate(once)}
        names = (f"shape {number}: {described(shape, number, scene)}" for number, shape in enumerate(once.values()))
        return cls(tuple(numbers[id(shape)] for shape in shapes), tuple(names))


def _by_material(shapes: Sequence[Shape], scene: Scene) -> SurfaceGroups:
    """Return groups of shapes with the same material; the last group has the least common materials of many."""
    materials = [_material(shape) for shape in shapes]
    keys = [material.id or id(material) for material in materials]
    first = dict(zip(reversed(keys), reversed(materials), strict=True))
    ordered = [key for key, _ in Counter(keys).most_common()]
    kept = ordered if len(ordered) <= MOST else ordered[: MOST - 1]
    numbers = {key: number for number, key in enumerate(kept)}
    names = [f"material {number}: {described(first[key], number, scene)}" for number, key in enumerate(kept)]
    others = ["others"] if len(kept) < len(ordered) else []
    return SurfaceGroups(tuple(numbers.get(key, len(kept)) for key in keys), (*names, *others))


def _material(shape: Shape) -> Plugin:
    """Return the BSDF of a shape, or the shape itself if it states none."""
    return shape.bsdf if isinstance(shape, Solid) and shape.bsdf is not None else shape


def described(part: Plugin, number: int, scene: Scene) -> str:
    """Return the name of a part of a scene with its place, such as ``floor (/tmp/scene.toml:12)``.

    A part of an OBJ file may have its material's name. A part without a name is named by its type and ``number``. A
    scene made in memory has no places.
    """
    place = "" if scene.source is None else scene.place_of(part).partition(": ")[0]
    return (Name.of(part, place).id or f"{part.title} {number}") + (f" ({place})" if place else "")
