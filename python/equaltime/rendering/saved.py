"""Saved renders as results: `read` returns what `Result.save` wrote. Other functions accept results and files alike."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from equaltime.film.error import UNKNOWN_ERROR, standard_error
from equaltime.film.focus import Focus
from equaltime.film.parts_of_merge import statistics_of
from equaltime.images.image_files import RGB, SOFTWARE, Picture
from equaltime.rendering.budget import Stop
from equaltime.rendering.checkpoint import SavedRender, looks_of
from equaltime.rendering.decision import Decision
from equaltime.rendering.film_picture import ALPHA
from equaltime.rendering.render_file import RenderFile, SavedFilm, read_film, read_outputs, read_picture
from equaltime.rendering.render_record import checked
from equaltime.rendering.result import Origin, Result, Stats
from equaltime.statistics.intervals import Interval
from equaltime.strict_json import json_text

__all__ = ["Render", "as_checkpoint", "as_picture", "name_of", "read"]

Render = Result | str | os.PathLike[str]
"""A result, or the path of the file that it was saved to."""


def read(path: str | os.PathLike[str]) -> Result:
    """Return a render that `Result.save` wrote.

    The result can be shown, compared, merged and saved again. It can be continued with ``resume=`` of
    `equaltime.render`. A file that was saved with ``small=True`` has the rounded image and no moments: it can be shown
    and compared.

    Raises
    ------
    ImageError
        If the file is missing, is not a render of equaltime, is damaged, or was written by a later version.

    Examples
    --------
    >>> result = et.read("a.exr")
    >>> result.spp, result.error.known
    (16.0, True)
    >>> et.render("scene.toml", spp=32, resume=result).spp
    32.0
    """
    file = RenderFile.read(path)
    record, errors, degrees = file.record, file.standard_error, file.record["degrees"]
    if file.moments is not None:
        SavedRender.of(file, Path(path))  # whose checks hold here too
        pixels = statistics_of(file.moments, file.parts, file.second)
        errors, degrees = standard_error(pixels), pixels.degrees  # the file has them rounded
    error = UNKNOWN_ERROR if record["error"] is None else Interval.from_dict(record["error"])
    alpha = {} if file.alpha is None else {ALPHA: file.alpha}
    return Result(
        image=file.image,
        standard_error=errors,
        samples=file.samples,
        error=error,
        stats=_stats(record),
        stopped_by=record["stopped_by"],
        origin=Origin.from_record(record),
        moments=file.moments,
        looks=looks_of(record),
        bias=None if record["bias"] is None else Interval.from_dict(record["bias"]),
        position=record["position"],
        missed=file.missed,
        stop=None if record["stop"] is None else Stop.from_dict(record["stop"]),
        aovs={**alpha, **read_outputs(path)},
        degrees=record["replicates"] - 1.0 if degrees is None else degrees,
        parts=file.parts,
        common_doubt=record["common_doubt"],
        second=file.second,
        decision=Decision.from_dict(record["decision"]),
        focus=Focus.from_dict(record["focus"]),
    )


def _stats(record: Mapping[str, Any]) -> Stats:
    return Stats(
        phases=record["phases"] or {"render": record["seconds"]},
        paths=record["paths"],
        rays=record["rays"],
        shadow_rays=record["shadow_rays"],
        kernel=record["kernel"],
        threads=record["threads"],
        effects=tuple(record["effects"]),
        build=record["build"],
    )


def as_checkpoint(render: Render) -> SavedRender:
    """Return the data of a render that resuming and merging need.

    ``render`` is a result or the path of its file. Raises `ImageError` if moments are missing.
    """
    if not isinstance(render, Result):
        return SavedRender.read(render)
    file, name = render.file, name_of(render)
    record = checked(json.loads(json_text(dict(file.record))), name)
    return SavedRender.of(replace(file, record=record), name)


def as_picture(render: Render) -> tuple[Picture, SavedFilm]:
    """Return a render's picture, with standard errors and sample counts, and the samples behind it.

    ``render`` is a result or the path of an image file. An image of another renderer has no samples: all fields of the
    film are None.
    """
    if not isinstance(render, Result):
        picture = read_picture(render)
        return picture, read_film(render) if picture.record else SavedFilm(None, None, None)
    planes = {name: render.image[..., i] for i, name in enumerate(RGB)}
    planes |= {f"stderr.{name}": render.standard_error[..., i] for i, name in enumerate(RGB)}
    planes["samples"] = render.samples.astype(np.float32)
    record = json.loads(json_text(render.record))
    picture = Picture(planes, render.origin.window, SOFTWARE, record=record)
    return picture, SavedFilm(render.moments, render.parts, render.second)


def name_of(render: Render) -> Path:
    """Return the path of a file unchanged; for a result, the words ``the render with seed N`` instead."""
    return Path(f"the render with seed {render.origin.seed}") if isinstance(render, Result) else Path(render)
