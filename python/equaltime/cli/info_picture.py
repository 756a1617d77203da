"""Summary of a PNG or JPEG file that equaltime wrote, from the tags in the file."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TypedDict

from equaltime.cli.info_render import repeating, seeds
from equaltime.errors import ImageError
from equaltime.images import image_files, preview
from equaltime.rendering.picture_tag import from_repeat

__all__ = ["PictureFacts", "picture_facts", "picture_summary"]


class PictureFacts(TypedDict):
    """JSON data on a picture; None stands for what the file does not tell."""

    file: str
    scene: str | None
    """The scene's file, as an absolute path."""
    description: str | None
    """Size, samples, error and strategy of the render, in words."""
    software: str
    record: str | None
    """The EXR file of the same render beside the picture, with the whole record."""
    seed: int | None
    """The seed; of a merged render, of its first part."""
    repeat: list[str]
    """Lines on the seeds and the commands that repeat the render."""


def picture_facts(path: Path) -> PictureFacts:
    """Return the tags of the picture at ``path``; raises `ImageError` if equaltime did not write the file."""
    tags = image_files.read_attributes(path)
    software = tags.get("Software", "")
    if not software.startswith("equaltime "):
        raise ImageError(f"{path}: was not rendered by equaltime")
    return {
        "file": str(path),
        "scene": tags.get(preview.SOURCE),
        "description": tags.get("ImageDescription"),
        "software": software,
        "record": _record_beside(path, tags),
        **_repeat(path, tags.get(preview.REPEAT)),
    }


class _Repeat(TypedDict):
    seed: int | None
    repeat: list[str]


def _repeat(path: Path, tag: str | None) -> _Repeat:
    """Return what a picture's tag tells of its render; pictures of earlier versions have no such tag."""
    if tag is None:
        return {"seed": None, "repeat": []}
    record, stops = from_repeat(tag, path)
    background, is_jpeg = record["background"], path.suffix.lower() != ".png"
    converted = background is not None or (is_jpeg and record["transparent"])  # which render does not write
    named = path.with_suffix(".exr") if record["sources"] or converted else path  # only an EXR file can be merged
    lines = [*repeating(named, record, verbose=False, exposure=None if converted else stops)]
    if converted:
        words = ["equaltime", "convert", named.name, path.name, "--exposure", f"{stops:g}"]
        words += [] if background is None else ["--background", ",".join(f"{value:g}" for value in background)]
        words += ["--overwrite"] if named.with_suffix(".png") == path else []  # the preview of that EXR
        lines.append(f"then      {shlex.join(words)}")
    return {"seed": record["seed"], "repeat": [f"strategy  {record['strategy']}, {seeds(record)}", *lines]}


def _record_beside(path: Path, tags: Mapping[str, str]) -> str | None:
    """Return the EXR file beside a picture if it is of the same render: one that has the same description."""
    saved = path.with_suffix(".exr")
    try:
        of_render = image_files.read_attributes(saved).get("ImageDescription", "")
    except ImageError:
        return None
    return str(saved) if of_render and tags.get("ImageDescription", "").startswith(of_render) else None


def picture_summary(facts: PictureFacts) -> Iterator[str]:
    """Yield lines on a picture: its error, its scene, the program, what repeats it, and where the whole record is."""
    yield f"{facts['file']}: {facts['description'] or 'a picture without a description'}"
    yield f"shows     {facts['scene'] or 'a scene made in memory'}"
    yield f"made by   {facts['software']}"
    yield from facts["repeat"]
    saved = facts["record"]
    where = "only -o FILE.exr keeps one" if saved is None else f"equaltime info {shlex.quote(saved)}"
    yield f"record    {where}"
