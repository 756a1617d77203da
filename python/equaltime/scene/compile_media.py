"""Hands media to the core: each once, and to the shapes that bound them.

As in Mitsuba, only the volumetric integrators see media, and for them the surfaces of nothing that a path crosses add
nothing to its length.
"""

from __future__ import annotations

from equaltime.scene.builder import Builder
from equaltime.scene.model import (
    HenyeyGreenstein,
    Integrator,
    Medium,
    SceneModel,
    Sensor,
    Solid,
    VolPath,
    VolPathMis,
)

__all__ = ["Media", "sees_media", "unseen_media"]


def sees_media(integrator: Integrator) -> bool:
    """Tell whether the integrator, or the one that it wraps, is a volumetric one."""
    within = getattr(integrator, "integrators", ())
    return isinstance(integrator, VolPath | VolPathMis) or any(map(sees_media, within))


def unseen_media(model: SceneModel) -> str | None:
    """Return what is to be said of media that the scene has and its integrator does not see."""
    if sees_media(model.integrator) or not any(node.kind == "medium" for node in model.nodes()):
        return None
    return (
        f"the integrator '{model.integrator.type}' does not see the media of the scene, here as in Mitsuba; "
        "'volpath' does"
    )


class Media:
    """The media that a builder has been given; equal ones share one index."""

    def __init__(self, builder: Builder, model: SceneModel) -> None:
        self._builder = builder
        self._seen = sees_media(model.integrator)
        self._known: dict[Medium, int] = {}
        if self._seen:
            builder.cross_freely()

    def bound(self, shape: Solid, index: int) -> None:
        """Tell what is on both sides of `shape`, which the core knows by `index`, and what of it is there at all."""
        if shape.priority is not None:
            self._builder.set_priority(index, shape.priority)
        if self._seen and (shape.interior is not None or shape.exterior is not None):
            exterior, interior = self._index(shape.exterior), self._index(shape.interior)
            self._builder.set_media(index, exterior=exterior, interior=interior)

    def surround(self, sensor: Sensor) -> None:
        """Put the camera into its medium, if it has one."""
        index = self._index(sensor.medium) if self._seen else None
        if index is not None:
            self._builder.set_camera_medium(index)

    def _index(self, medium: Medium | None) -> int | None:
        if medium is None:
            return None
        key = medium.model_copy(update={"id": None})
        if key not in self._known:
            g = medium.phase.g if isinstance(medium.phase, HenyeyGreenstein) else 0.0
            sigma_t = tuple(medium.scale * sigma for sigma in medium.sigma_t)
            self._known[key] = self._builder.add_medium(sigma_t, medium.albedo, g)
        return self._known[key]
