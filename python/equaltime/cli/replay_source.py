"""Source of a replayed sample if the user names a saved render: scene, strategy and seed by its record."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from equaltime.cli.recorded import CHANGED, recorded_options, recorded_scene
from equaltime.errors import ImageError
from equaltime.rendering.core import numbers_version
from equaltime.rendering.render_file import read_picture
from equaltime.rendering.render_record import checked
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["ReplaySource"]

Record = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class ReplaySource:
    """Scene, strategy and seed of a saved render, to trace its samples again with bit-identical results."""

    scene: Scene
    strategy: Strategy
    seed: int
    without: Sequence[str]
    samples: int | None
    """Number of samples that the render took of the pixel; None if the pixel is not in the picture. Merged renders tell
    only the most that a part took of any pixel."""

    @classmethod
    def read(cls, path: Path, pixel: tuple[int, int], seed: int | None) -> ReplaySource:
        """Return the source for a pixel (x, y) of the saved render at ``path``.

        ``seed`` chooses the part of a merged render; None stands for the render's only seed. Raises `ImageError` if
        the file is no saved render, if the seed is none of its seeds, or if the scene is not there or has changed.
        """
        picture = read_picture(path)
        if not picture.record:
            raise ImageError(f"{path}: was not rendered by equaltime")
        record = checked(picture.record, path)
        if record["backend"] != "core":
            raise ImageError(f"{path}: was rendered by {record['backend']}, whose paths cannot be replayed")
        strategy = Strategy.parse(record["strategy"])
        if record["numbers"] != (now := numbers_version(strategy)):
            versions = f"version {record['numbers']}, not {now}"
            raise ImageError(f"{path}: has random numbers of {versions}, so that its paths cannot be replayed")
        chosen, most = _seed_and_samples(path, record, seed)
        left, top, width, height = record["crop"]
        x, y = pixel[0] - left, pixel[1] - top
        inside = 0 <= x < width and 0 <= y < height
        if inside and picture.samples is not None and not record["sources"]:
            most = int(picture.samples[y, x])
        return cls(
            scene=_unchanged(path, record, pixel, chosen),
            strategy=strategy,
            seed=chosen,
            without=record["without"],
            samples=most if inside else None,
        )


def _seed_and_samples(path: Path, record: Record, seed: int | None) -> tuple[int, int]:
    """Return the seed of a render or of a part of a merged one, and the most samples that it took of a pixel."""
    seeds: dict[int, int] = {each["seed"]: each["samples"]["max"] for each in record["sources"] or [record]}
    chosen = next(iter(seeds)) if seed is None and len(seeds) == 1 else seed
    if chosen is None or chosen not in seeds:
        found = ", ".join(map(str, seeds))
        choose = f"the seeds {found}: choose one by --seed" if len(seeds) > 1 else f"the seed {found}, not {seed}"
        raise ImageError(f"{path}: was rendered with {choose}")
    return chosen, seeds[chosen]


def _unchanged(path: Path, record: Record, pixel: tuple[int, int], seed: int) -> Scene:
    """Return the scene of a saved render; raise `ImageError` if it is not there, or is not as it was rendered."""
    if record["scene"] is None:
        raise ImageError(f"{path}: its scene was made in memory: replay it in Python, by equaltime.replay(scene, …)")
    if not Path(record["scene"]).exists():
        raise ImageError(f"{path}: its scene, {record['scene']}, is not there")
    scene = recorded_scene(record)
    if scene is None:
        raise ImageError(f"{path}: its scene, {record['scene']}, {_as_it_is_now(record, pixel, seed)}")
    return scene


def _as_it_is_now(record: Record, pixel: tuple[int, int], seed: int) -> str:
    """Return that a scene has changed, and the command that replays the sample in the scene as it is now."""
    if record["frame"] is not None:
        return CHANGED
    (width, height), at = record["size"], f"{pixel[0]},{pixel[1]}"
    options = recorded_options({**record, "crop": [0, 0, width, height]}, seed)  # pixels count in the whole film
    return f"{CHANGED}; as it is now: {shlex.join(['equaltime', 'replay', record['scene'], '--pixel', at, *options])}"
