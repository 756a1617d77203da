"""Hands media to the core, the renderer in C++, and sets the media on both sides of shapes. Equal media are added once.

As in Mitsuba, only the volumetric integrators see media. For these integrators, crossing a null BSDF does not count
towards the path length.
"""

from __future__ import annotations

import re
from typing import Any

from equaltime.scene.core import SceneBuilder, Unsupported
from equaltime.scene.model import (
    BlendPhase,
    Integrator,
    Medium,
    Phase,
    SceneModel,
    Sensor,
    Solid,
    VolPath,
    VolPathMis,
)

__all__ = ["Media", "sees_media", "unseen_media"]


def sees_media(integrator: Integrator) -> bool:
    """Tell whether an integrator renders media: whether it, or one inside it, is ``volpath`` or ``volpathmis``."""
    within = getattr(integrator, "integrators", ())
    return isinstance(integrator, VolPath | VolPathMis) or any(map(sees_media, within))


def unseen_media(model: SceneModel) -> str | None:
    """Return a warning, as text, if the scene has media that its integrator ignores, else None."""
    if sees_media(model.integrator) or not any(node.kind == "medium" for node in model.nodes()):
        return None
    return (
        f"the integrator '{model.integrator.type}' does not see the media of the scene, here as in Mitsuba; "
        "'volpath' does"
    )


class Media:
    """Adds media to the core's scene builder, each once, and assigns them to shapes and to the camera.

    If the scene's integrator is not volumetric, media are ignored.
    """

    def __init__(self, builder: SceneBuilder, model: SceneModel) -> None:
        self._builder = builder
        self._seen = sees_media(model.integrator)
        self._known: dict[Medium, int] = {}
        self._nodes: dict[int, Medium] = {}
        if self._seen:
            builder.cross_freely()

    def bound(self, shape: Solid, index: int) -> None:
        """Set the media on both sides of `shape` in the core, and its priority among overlapping shapes.

        `index` is the shape's number in the core.
        """
        if shape.priority is not None:
            self._builder.set_priority(index, shape.priority)
        if self._seen and (shape.interior is not None or shape.exterior is not None):
            exterior, interior = self._index(shape.exterior), self._index(shape.interior)
            self._builder.set_media(index, exterior=exterior, interior=interior)

    def surround(self, sensor: Sensor) -> None:
        """Set the medium around the camera `sensor`, if the sensor names one and the integrator sees media."""
        index = self._index(sensor.medium) if self._seen else None
        if index is not None:
            self._builder.set_camera_medium(index)

    def at_place(self, error: ValueError) -> ValueError:
        """Return the core's error about a medium as `Unsupported`; return any other error unchanged.

        `Unsupported` holds the medium, so that the message can name its line in the scene file.
        """
        about = re.fullmatch(r"medium (\d+): (.*)", str(error), re.DOTALL)
        return Unsupported(self._nodes[int(about[1])], about[2]) if about else error

    def _index(self, medium: Medium | None) -> int | None:
        if medium is None:
            return None
        key = medium.model_copy(update={"id": None})
        if key not in self._known:
            sigma_t = tuple(medium.scale * sigma for sigma in medium.sigma_t)
            self._known[key] = self._builder.add_medium(sigma_t, medium.albedo, _lobes(medium.phase))
            self._nodes[self._known[key]] = medium
        return self._known[key]


def _lobes(phase: Phase, share: float = 1.0) -> list[tuple[float, str, dict[str, Any]]]:
    """Return the parts of a phase function as (share, name, parameters): one, or all that are blended."""
    if not isinstance(phase, BlendPhase):
        return [(share, phase.title, phase.parameters())] if share > 0.0 else []
    first, second = phase.phase
    return _lobes(first, share * (1.0 - phase.weight)) + _lobes(second, share * phase.weight)
