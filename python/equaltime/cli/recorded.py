"""Scene of a saved render, as its file is now, and the options of the command that rendered it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, Final

from equaltime.rendering.origin import Origin
from equaltime.scene import Scene, load_file
from equaltime.scene.effects.leaving import leave_out
from equaltime.scene.frame_scenes import frames_of
from equaltime.strategy import Strategy

__all__ = ["CHANGED", "recorded_options", "recorded_scene"]

CHANGED: Final = "has changed since, or was read with options that the record does not have"
"""Predicate of a scene for which `recorded_scene` returns None."""


def recorded_options(record: Mapping[str, Any], seed: int) -> Iterator[str]:
    """Yield the options that choose the picture's part of the scene, the strategy and the ``seed``."""
    (width, height), crop, asked = record["size"], record["crop"], record.get("scene_max_depth")
    yield from ("--size", f"{width}x{height}")
    if crop != [0, 0, width, height]:
        yield from ("--crop", ",".join(map(str, crop)))
    if asked is not None and asked != record["max_depth"]:
        yield from ("--max-depth", str(record["max_depth"]))
    if record["strategy"] != "best":
        yield from ("--strategy", record["strategy"])
    for name, value in record["defines"].items():
        yield from ("-D", f"{name}={value}")
    if record["substitutions"]:
        yield "--substitute"
    if record["transparent"]:
        yield "--transparent"
    for effect in record.get("without") or ():
        yield from ("--without", effect)
    yield from ("--seed", str(seed))
    if record["backend"] != "core":
        yield from ("--backend", record["backend"])


def recorded_scene(record: Mapping[str, Any]) -> Scene | None:
    """Return the scene of a saved render, with the effects that the render left out; None if the scene has changed.

    ``record`` is complete, and names a file that exists. Raises `EqualtimeError` if the file cannot be read.
    """
    strategy, without = Strategy.parse(record["strategy"]), record["without"]
    for scene in _as_asked(_loaded(record), record):
        if leave_out(scene, strategy, without)[0].digest == record["digest"]:
            return scene
    return None


def _loaded(record: Mapping[str, Any]) -> Scene:
    """Return the scene's file, as it is now, read with the options of the record."""
    path, defines, substitute = Path(record["scene"]), record["defines"], bool(record["substitutions"])
    if (frame := Origin.from_record(record).frame) is not None:
        return next(frames_of(path, [frame], defines, substitute=substitute))
    return load_file(path, defines, substitute=substitute)


def _as_asked(scene: Scene, record: Mapping[str, Any]) -> Iterator[Scene]:
    """Yield the scene with every set of options that a render with this record may have had.

    An option with the scene's own value gives the same picture, but another digest than no option.
    """
    size, crop = tuple(record["size"]), tuple(record["crop"])
    films: tuple[dict[str, Any], ...] = ({}, {"size": size}, {"size": size, "crop": crop})
    for film, depth in product(films, (None, record["max_depth"])):
        yield scene.with_(**film, max_depth=depth, transparent=record["transparent"])
