"""Names for the shapes, instances and lights of a scene, which the core (the renderer in C++) knows by numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from equaltime.scene.inert import shown
from equaltime.scene.model import (
    Animation,
    Constant,
    Directional,
    EnvMap,
    Instance,
    Obj,
    Plugin,
    Point,
    Shape,
    ShapeGroup,
    Solid,
    Spot,
)
from equaltime.scene.motion import in_shutters
from equaltime.scene.scene import Scene

__all__ = ["Name", "Names"]


@dataclass(frozen=True, slots=True)
class Name:
    """Name and type of an object of a scene, and the file and line where the object is described, for messages."""

    id: str | None
    type: str
    place: str
    """File and line, or path of keys; empty if the scene was made in memory."""

    @classmethod
    def of(cls, part: Plugin, place: str) -> Name:
        """Return the name of an object described at ``place``; a part of an OBJ file may have its material's."""
        material = part.material if isinstance(part, Obj) else None
        return cls(part.id or material or None, part.title, place)

    def __str__(self) -> str:
        what = f"{self.type}, {self.place}" if self.place else self.type
        return f"'{self.id}' ({what})" if self.id else what


class Names:
    """Names of a scene's shapes, instances and lights, found by their numbers in the core, for messages to the user."""

    def __init__(self, scene: Scene) -> None:
        model = scene.model
        self._scene = scene
        places: list[str | None] = [None] * len(model.shapes)
        if len(scene.places.shapes) == len(places):
            places = [str(place) for place in scene.places.shapes]
        numbers, seen = list(shown(model)), in_shutters(model).shapes
        own: list[tuple[Shape, str | None]] = [(model.shapes[number], places[number]) for number in numbers]
        moving = [isinstance(seen[number].to_world, Animation) for number in numbers]
        still = [part for part, moves in zip(own, moving, strict=True) if isinstance(part[0], Instance) and not moves]
        self._instances = [*still, *(part for part, moves in zip(own, moving, strict=True) if moves)]
        groups: dict[ShapeGroup, None] = {}
        grouped: list[tuple[Shape, str | None]] = []
        for number, part, moves in zip(numbers, own, moving, strict=True):
            shape, built = part[0], seen[number]
            if isinstance(shape, Instance) and isinstance(built, Instance):
                grouped += [(inner, None) for inner in shape.shapegroup.shapes if built.shapegroup not in groups]
                groups[built.shapegroup] = None
            elif moves:
                grouped.append(part)  # the core puts a moving shape into its own group
        self._shapes, self._own = (*own, *grouped), len(own)
        shining = [
            emitter for emitter in model.emitters if isinstance(emitter, Point | Spot) and any(emitter.intensity)
        ]
        self._deltas = [
            *(emitter for emitter in shining if isinstance(emitter, Point)),
            *(emitter for emitter in shining if isinstance(emitter, Spot)),
            *(emitter for emitter in model.emitters if isinstance(emitter, Directional) and any(emitter.irradiance)),
        ]

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """Return all shapes in the core's order, which puts shapes of groups after all others; instances are shapes."""
        return tuple(shape for shape, _ in self._shapes)

    def solids(self) -> Iterator[tuple[Solid, Name, bool]]:
        """Yield every shape with a surface as a tuple: the shape, its name, and whether the shape is in a group."""
        for index, (shape, place) in enumerate(self._shapes):
            again = index >= self._own and place is not None
            if not isinstance(shape, Instance) and not again:
                yield shape, self._name(shape, place), index >= self._own

    def shape(self, index: int) -> Name:
        """Return the name of shape number `index` in the core, which numbers shapes of groups after all others."""
        return self._name(*self._shapes[index])

    def instance(self, index: int) -> Name:
        """Return the name of instance number `index` in the core, which also makes an instance of each moving shape.

        Instances that do not move come first.
        """
        return self._name(*self._instances[index])

    def delta_light(self, index: int) -> Name:
        """Return the name of delta light number `index` in the core.

        Point lights come first, then spot lights, then directional lights. Lights of zero power are not counted.
        """
        return self._name(self._deltas[index])

    def environment(self) -> Name:
        """Return the name of the scene's environment emitter, which must exist."""
        return self._name(next(e for e in self._scene.model.emitters if isinstance(e, Constant | EnvMap)))

    def _name(self, part: Plugin, place: str | None = None) -> Name:
        return Name.of(part, self._scene.place_of(part) if place is None else place)
