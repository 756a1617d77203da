"""Finds the effects (features such as lens or media) that a scene uses, and the objects that use each effect."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from equaltime.scene import Scene
from equaltime.scene.compile_media import sees_media
from equaltime.scene.effects.kinds import KINDS, Effect, kind_of
from equaltime.scene.inert import is_inert, shown
from equaltime.scene.model import Plugin, ThinDielectric
from equaltime.scene.motion import moves

__all__ = ["Reason", "derive"]


@dataclass(frozen=True)
class Reason:
    """An object of the scene that uses an effect, such as a BSDF, with its position in the scene file."""

    place: str
    """Position of the object in its file: ``file:line`` or ``file: key.path``; empty for a scene made in memory."""
    what: str
    """Family and type of the object, such as ``bsdf 'dielectric'``."""

    def __str__(self) -> str:
        return f"{self.place}: {self.what}" if self.place else self.what


def derive(scene: Scene) -> Mapping[str, tuple[Reason, ...]]:
    """Return the effects that a scene uses: a mapping from the name of an effect to the objects that use the effect.

    An effect that no single object uses has the scene as a whole as its only entry. Objects that change nothing in the
    image are left out (see `equaltime.scene.inert`). Raises SceneError if the core cannot use the scene.
    """
    nodes = list(_nodes(scene))
    called = {name: kind_of(name) for name, used in scene.core.effects().items() if used}
    if scene.core.lights > 1:
        called["many_lights"] = KINDS["many_lights"]
    found = {name: tuple(_reasons(scene, kind, nodes)) for name, kind in called.items()}
    if outputs := tuple(_reasons(scene, KINDS["outputs"], nodes)):
        found["outputs"] = outputs
    if scene.max_depth == -1 or scene.max_depth > 2:
        limit = "without limit" if scene.max_depth == -1 else f"of up to {scene.max_depth} segments"
        found["long_paths"] = (Reason(scene.place_of(scene.model.integrator), f"paths {limit}"),)
    whole = Reason(str(scene.source or ""), "the scene as a whole")
    ordered = [name for name in (*KINDS, *called) if name in found]
    return {name: found[name] or (whole,) for name in dict.fromkeys(ordered)}


def _nodes(scene: Scene) -> Iterator[Plugin]:
    """Iterate over all nodes that are built, each once."""
    model, seen = scene.model, set[int]()
    shapes = (model.shapes[number] for number in shown(model))
    for part in (model.integrator, model.sensor, *shapes, *model.emitters):
        yield from _within(part, seen)


def _within(node: Plugin, seen: set[int]) -> Iterator[Plugin]:
    """Iterate over a node and the nodes in it, without those seen before: groups and materials are shared."""
    if id(node) in seen:
        return
    seen.add(id(node))
    yield node
    for name in type(node).model_fields:
        value = getattr(node, name)
        for item in value if isinstance(value, tuple) else (value,):
            if isinstance(item, Plugin):
                yield from _within(item, seen)


def _reasons(scene: Scene, kind: Effect, nodes: list[Plugin]) -> Iterator[Reason]:
    for node in nodes:
        rests = kind.name == "motion" and not moves(node, scene.model.sensor)
        if kind.name == "masks" and isinstance(node, ThinDielectric):  # a vertex of the path, unless media are seen
            rests = not sees_media(scene.model.integrator)
        if kind.calls(node) and not rests and not is_inert(node, scene.assets):
            yield Reason(scene.place_of(node), f"{node.kind} '{node.title}'")
