"""Summary of a scene: its size, camera, lights, geometry, materials and effects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from equaltime.rendering.stated import paths_up_to
from equaltime.scene import Scene
from equaltime.scene.model.sensors import Projective
from equaltime.statistics.in_words import megabytes

__all__ = ["scene_summary"]


def scene_summary(scene: Scene, facts: Mapping[str, Any], verbose: bool = False) -> Iterator[str]:
    """Yield at most ten lines on a scene. ``facts`` holds the data that ``info --json`` prints.

    ``verbose`` tells that all facts follow, so that the lines do not point to ``-v``.
    """
    width, height = scene.size
    lights, triangles, shapes = facts["lights"], facts["triangles"], facts["shapes"]
    yield (
        f"{facts['scene'] or 'made in memory'}: {width}x{height} pixels, {_many(triangles, 'triangle')} in "
        f"{_many(shapes, 'shape')}, {_many(lights, 'light')}, {megabytes(facts['memory_bytes'])}"
    )
    yield f"camera     {_camera(scene)}"
    titles = {"emitter": "lights", "bsdf": "materials", "shape": "shapes", "texture": "textures", "medium": "media"}
    for family, title in titles.items():
        if counts := facts["plugins"][family]:
            yield f"{title:<11}{', '.join(f'{number:,} {plugin}' for plugin, number in counts.items())}"
    if facts["effects"]:
        yield f"effects    {', '.join(effect.replace('_', ' ') for effect in facts['effects'])}"
    if facts["substitutions"]:
        see = "below" if verbose else "-v"
        yield f"replaced   {_many(len(facts['substitutions']), 'part')} that cannot be rendered; see {see}"
    spp = "" if scene.spp is None else f", {scene.spp} samples a pixel"
    yield f"asks for   {paths_up_to(scene.max_depth)}{spp}{'' if verbose else '; -v for more'}"


def _camera(scene: Scene) -> str:
    """Return the kind of the camera, its field of view and its place."""
    sensor = scene.model.sensor
    view = f", {sensor.x_fov:.3g}° wide" if isinstance(sensor, Projective) else ""
    return f"{sensor.type}{view}"


def _many(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'s' * (number != 1)}"
