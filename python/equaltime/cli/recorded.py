"""Scene of a saved render, as its file is now, and the options of the command that rendered it."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any, Final

from equaltime.errors import EqualtimeError
from equaltime.quoting.pilot import TARGETS
from equaltime.rendering.origin import Origin
from equaltime.scene import Scene, load_file
from equaltime.scene.effects.leaving import leave_out
from equaltime.scene.frame_scenes import frames_of
from equaltime.scene.frames import Frame, frame_pattern
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = [
    "CHANGED",
    "copied_scene",
    "error_limit",
    "new_name",
    "next_error",
    "plain",
    "recorded_command",
    "recorded_exposure",
    "recorded_options",
    "recorded_scene",
    "shown_path",
    "shown_scene",
]

CHANGED: Final = "has changed since, or was read with options that the record does not have"
"""Predicate of a scene for which `recorded_scene` returns None."""


_SMALLER: Final = 0.9
"""Largest share of the present error that is worth further samples."""


def next_error(error: float) -> float | None:
    """Return the error to which a render with this ``error`` may go on; None if all usual ones are larger."""
    return next((target for target in TARGETS if target < _SMALLER * error), None)


def error_limit(error: float, bias: Interval | None, fixed: bool) -> list[str]:
    """Return the options that end a render at an error: ``error`` by noise, together with a measured ``bias``.

    ``fixed`` tells whether a pilot chooses the number of samples.
    """
    whole = error if bias is None else math.hypot(error, bias.high)
    return ["--error", f"{100.0 * whole:.6g}%", *(["--stop", "fixed"] if fixed else [])]


def recorded_command(record: Mapping[str, Any], output: str, limits: Sequence[str]) -> list[str]:
    """Return the command that renders the scene of a ``record`` into the file ``output``.

    ``limits`` are the options that end the render. A frame of an animation gets the option that chooses it.
    """
    frame, seed = Origin.from_record(record).frame, record["seed"]
    if frame is not None:
        folder, name = Path(output).parent, Path(output).name
        output, seed = str(folder / frame_pattern(name, frame.number)), seed - frame.number
    words = ["equaltime", "render", shown_path(Path(record["scene"])), "-o", output, *limits, *_frame(frame)]
    return [*words, *recorded_options(record, max(0, seed)), *recorded_exposure(record)]


def shown_path(path: Path) -> str:
    """Return a path relative to the working directory if it is within, else the path as it is.

    In the root directory every path is within. There it stays absolute, as users write it.
    """
    here = Path.cwd()
    return str(path.relative_to(here) if here != Path(here.anchor) and path.is_relative_to(here) else path)


def new_name(path: Path) -> Path:
    """Return the file that a command may write in place of ``path``: ``NAME-kept.exr`` for a kept copy ``NAME.exr~``.

    Files that are no kept copies are returned unchanged.
    """
    return path.with_name(f"{path.stem}-kept{path.suffix[:-1]}") if path.suffix.endswith("~") else path


def shown_scene(path: str | None) -> str:
    """Return the scene of a record in words: its file, or that it had none."""
    return "a scene made in memory" if path is None else shown_path(Path(path))


def _frame(frame: Frame | None) -> Iterator[str]:
    """Yield the options that choose the frame of an animation; none for other renders."""
    if frame is None:
        return
    yield from ("--frames", str(frame.number))
    if frame.fps != Frame.fps:
        yield from ("--fps", plain(frame.fps))
    if frame.blur != Frame.blur:
        yield from ("--blur", plain(frame.blur))


def plain(number: float) -> str:
    """Return a number with all its digits, but a whole one without its ``.0``."""
    return str(number).removesuffix(".0")


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


def recorded_exposure(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the option that gives the preview the exposure that was asked for; none if it was automatic."""
    if record["exposure"] is not None:
        yield from ("--exposure", plain(record["exposure"]))


def copied_scene(record: Mapping[str, Any], picture: Path) -> Mapping[str, Any] | None:
    """Return the record with a copy of its scene's file in place of that file; None if there is no copy.

    A copy lies beside the ``picture`` or in the working directory, and has the content of the record. It has the name
    of the recorded file, or this name or the picture's with ``.toml`` or ``.xml``.
    """
    if record["scene"] is None:
        return None
    original = Path(record["scene"])
    texts = (Path(stem).with_suffix(suffix).name for stem in (original, picture) for suffix in (".toml", ".xml"))
    names = dict.fromkeys((original.name, *texts))
    baked: dict[str, Any] = {"defines": {}, "substitutions": []}  # `convert` writes their values into the copy
    for file in (Path(os.path.abspath(folder / name)) for folder in (picture.parent, Path()) for name in names):
        if original.exists() and file.exists() and file.samefile(original):
            return None
        for copied in ({**record, "scene": str(file)}, {**record, "scene": str(file), **baked}):
            with suppress(EqualtimeError):
                if file.exists() and recorded_scene(copied) is not None:
                    return copied
    return None


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
