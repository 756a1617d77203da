"""Summary of a PNG or JPEG file that equaltime wrote, from the tags in the file."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TypedDict

from equaltime.cli.info_render import repeating, seeds, with_scene
from equaltime.cli.recorded import new_name, plain, shown_path, shown_scene
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
    """The EXR file of the same render with the whole record: beside the picture, or that from which it was made."""
    made_from: str | None
    """The EXR file from which the picture was made, which may be gone; None if the picture was rendered."""
    seed: int | None
    """The seed; of a merged render, of its first part."""
    repeat: list[str]
    """Lines on the seeds and the commands that repeat the render."""


def picture_facts(path: Path) -> PictureFacts:
    """Return the tags of the picture at ``path``; raises `ImageError` if equaltime did not write the file."""
    tags = image_files.read_attributes(path)
    software = tags.get("Software", "")
    if not software.startswith("equaltime "):
        raise ImageError(f"{path}: was not rendered by equaltime, or was written with --no-metadata")
    return {
        "file": str(path),
        "description": tags.get("ImageDescription"),
        "software": software,
        **_repeat(path, tags),
    }


class _Repeat(TypedDict):
    scene: str | None
    record: str | None
    made_from: str | None
    seed: int | None
    repeat: list[str]


def _repeat(path: Path, tags: Mapping[str, str]) -> _Repeat:
    """Return what a picture's tags tell of its render; pictures of earlier versions have no tag that repeats it."""
    beside = path.with_suffix(".exr")
    if (tag := tags.get(preview.REPEAT)) is None:
        scene = tags.get(preview.SOURCE)
        return {"scene": scene, "record": _of_render([beside], tags), "made_from": None, "seed": None, "repeat": []}
    record, changed = with_scene(from_repeat(tag, path), path)
    background, is_jpeg = record["background"], image_files.extension(path) != ".png"
    converted = background is not None or (is_jpeg and record["transparent"])  # which render does not write
    picture = new_name(path)
    named = picture.with_suffix(".exr") if record["sources"] or converted else picture  # only an EXR can be merged
    shown = record if named == picture else {**record, "exposure": None}  # the EXR may have another
    lines = [*repeating(named, shown, verbose=False, changed=changed)]
    if converted:
        words = [
            "equaltime",
            "convert",
            shown_path(named),
            shown_path(picture),
            "--exposure",
            plain(record["exposure"]),
        ]
        words += [] if background is None else ["--background", ",".join(map(plain, background))]
        words += ["--overwrite"] if named.with_suffix(".png") == picture else []  # the preview of that EXR
        lines.append(f"then      {shlex.join(words)}")
    made_from = record["saved"]
    return {
        "scene": record["scene"],
        "record": _of_render([beside, *([] if made_from is None else [Path(made_from)])], tags),
        "made_from": made_from,
        "seed": record["seed"],
        "repeat": [f"strategy  {record['strategy']}, {seeds(record)}", *lines],
    }


def _of_render(files: Sequence[Path], tags: Mapping[str, str]) -> str | None:
    """Return the first EXR file of the render that a picture shows: one that has the same description."""
    for file in files:
        with suppress(ImageError):
            of_render = image_files.read_attributes(file).get("ImageDescription", "")
            if of_render and tags.get("ImageDescription", "").startswith(of_render):
                return str(file)
    return None


def picture_summary(facts: PictureFacts) -> Iterator[str]:
    """Yield lines on a picture: its error, its scene, the program, what repeats it, and where the whole record is."""
    yield f"{facts['file']}: {facts['description'] or 'a picture without a description'}"
    yield f"shows     {shown_scene(facts['scene'])}"
    yield f"made by   {facts['software']}"
    yield from facts["repeat"]
    if facts["record"] is not None:
        yield f"record    equaltime info {shlex.quote(facts['record'])}"
    elif facts["made_from"] is not None:
        yield f"record    was in {facts['made_from']}, which is not there or shows another render now"
    else:
        yield "record    only -o FILE.exr keeps one"
