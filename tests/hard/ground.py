"""Ground that a camera looks down at; tests put lamps over it."""

from __future__ import annotations

from typing import Any

__all__ = ["ground"]


def ground(width: int, height: int, max_depth: int, **more: Any) -> dict[str, Any]:
    """Return the scene as `equaltime.load_dict` takes it, without light, and with more elements by their names."""
    view = {"look_at": {"origin": [0, -2, 3], "target": [0, 0, 0], "up": [0, 0, 1]}}
    film = {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": max_depth},
        "sensor": {"type": "perspective", "fov": 40.0, "to_world": [view], "film": film},
        "ground": {"type": "rectangle", "to_world": [{"scale": 5}], "bsdf": {"type": "diffuse"}},
        **more,
    }
