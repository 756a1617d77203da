"""Saved renders: `SavedRender` can be resumed or merged, and `read` returns the result that `Result.save` wrote.

A resumed render has the same bits as one that was never stopped. Other functions accept results and files alike.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.film.error import UNKNOWN_ERROR, standard_error
from equaltime.film.focus import Focus
from equaltime.film.moments import nonfinite
from equaltime.film.parts_of_merge import MergedFilm, statistics_of
from equaltime.film.second_nets import SecondNets
from equaltime.images.image_files import RGB, SOFTWARE, Picture
from equaltime.rendering.budget import Look, Stop
from equaltime.rendering.decision import Decision
from equaltime.rendering.film_picture import ALPHA, FilmPicture
from equaltime.rendering.origin import Origin
from equaltime.rendering.render_file import RenderFile, SavedFilm, read_film, read_outputs, read_picture
from equaltime.rendering.render_record import checked
from equaltime.rendering.result import Result, Stats
from equaltime.statistics.intervals import Interval
from equaltime.strict_json import json_text

__all__ = ["Render", "SavedRender", "as_checkpoint", "as_picture", "differences", "looks_of", "name_of", "read"]

_SAME = ("size", "crop", "max_depth", "strategy", "without", "replicates", "nets", "backend")
"""Keys of a record that must be equal in all parts of one render, beside the scene."""
_IN_DIGEST = {"size", "crop", "max_depth", "without"}
_BACKGROUNDS = {True: "a transparent background", False: "an opaque background"}
_NAMES = {
    **{"max_depth": "max depth", "without": "left out"},
    **{"nets": "point sets in a pixel:", "numbers": "random numbers of version"},
}


@dataclass(frozen=True, eq=False)
class SavedRender:
    """Content of a saved render, with the moments (count, mean, deviation of samples) to resume or merge it."""

    path: Path
    record: Mapping[str, Any]
    """Record of the render (`Result.record`): JSON data that tell how it was made. Its keys and values were checked."""
    moments: NDArray[Any]
    """(R, H, W): count, mean and deviation of the samples of each pixel in each of R replicates (parts of the samples),
    of the type `equaltime.film.moments.DTYPE`."""
    missed: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """Images of the light that samples may have missed, (H, W, C) by name; such light raises the error's upper limit.
    """
    parts: NDArray[Any] | None = None
    """(H, W): sums over the renders that were merged, from which variances follow; None if not merged, or saved by
    equaltime 0.1.0."""
    alpha: NDArray[np.float32] | None = None
    """(H, W): opacity of each pixel, in [0, 1]; None if the film did not ask for it."""
    second: SecondNets | None = None
    """Second nets: further samples of some pixels, not in the image, that show its noise. None if there are none."""

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> SavedRender:
        """Return the content of a file that `Result.save` wrote, to resume or merge the render.

        Raises `ImageError` if the file is damaged, or was saved with ``small``, without the data for resuming.
        """
        file = RenderFile.read(path)
        return cls.of(file, Path(path))

    @classmethod
    def of(cls, file: RenderFile, path: Path) -> SavedRender:
        """Return the content of a saved render, from the content of its file, after checking it.

        ``path`` is the name of the file in errors. Raises `ImageError` if the data for resuming are missing or
        contradict each other.
        """
        moments, parts, missed = file.moments, file.parts, file.missed
        if moments is None:
            raise ImageError(
                f"{path}: holds no moments, only an image, as --small saves it: it can be neither resumed nor merged"
            )
        _, _, width, height = file.record["crop"]
        planes = (*missed.values(), *(() if parts is None else (parts,)))
        sizes = {(height, width), *(plane.shape[:2] for plane in planes)}
        if sizes != {moments.shape[1:]} or file.record["replicates"] != len(moments):
            raise ImageError(f"{path}: its parts are not of one size")
        if wrong := nonfinite(moments):
            raise ImageError(f"{path}: pixel {wrong[0]},{wrong[1]} has moments that are not finite")
        if parts is not None and not MergedFilm(moments, parts).consistent:
            raise ImageError(f"{path}: the sums over what was merged do not belong to its samples")
        return cls(path, file.record, moments, missed, parts, file.alpha, file.second)

    @property
    def film(self) -> MergedFilm:
        """Samples of the render, as a film that can be merged with the films of other renders.

        The film of a render that was not merged counts as one part.
        """
        return MergedFilm.of(self.moments, self.second) if self.parts is None else MergedFilm(self.moments, self.parts)

    @property
    def picture(self) -> FilmPicture:
        """Colours, alpha and precision of the picture that the render's film asked for."""
        return FilmPicture.from_dict(self.record["picture"])

    @property
    def seconds(self) -> float:
        """Rendering time of all runs of the saved render, in seconds."""
        return float(self.record["seconds"])

    @property
    def runs(self) -> int:
        """Number of runs that took the samples of the saved render."""
        return int(self.record["runs"])

    @property
    def looks(self) -> tuple[Look, ...]:
        """Looks of the saved render: each is an estimate of its error, made to decide whether to stop."""
        return looks_of(self.record)

    @property
    def decision(self) -> Decision:
        """Decisions that the strategy left to the saved render: on splitting of paths, and on sample counts."""
        return Decision.from_dict(self.record["decision"])

    @property
    def stop(self) -> Stop | None:
        """Rule by which the saved render was to stop at an error; None without an error target."""
        return None if self.record["stop"] is None else Stop.from_dict(self.record["stop"])

    @property
    def position(self) -> tuple[int, int, int]:
        """Position from which passes resume: samples per pixel, samples of the running pass, next block.

        Raises `ImageError` if the file states no position.
        """
        if self.record["position"] is None:
            raise ImageError(f"{self.path}: cannot be resumed: its record lacks the position of its passes")
        done, target, next_block = self.record["position"]
        return done, target, next_block

    def check(self, wanted: Mapping[str, Any]) -> None:
        """Raise `ImageError`, with the differences, if this saved render cannot be resumed as the wanted render.

        ``wanted`` holds the values that the record (JSON data on how it was made) of the wanted render has. A merged
        render cannot be resumed.
        """
        if self.record["sources"]:
            raise ImageError(
                f"{self.path}: cannot be resumed: it was merged; render with another seed, and merge again"
            )
        if different := differences(self.record, wanted, ("seed", "numbers", "substitutions", "build")):
            raise ImageError(f"{self.path}: cannot be resumed: it has {'; '.join(different)}")


def looks_of(record: Mapping[str, Any]) -> tuple[Look, ...]:
    """Return the looks of a saved render: estimates of its error at which it might have stopped.

    ``record`` is the JSON data in its file that tell how the render was made.
    """
    return tuple(
        Look(samples, math.nan if value is None else value, math.inf if high is None else high, brightest or 0.0)
        for samples, value, high, brightest in record["looks"]
    )


def differences(found: Mapping[str, Any], wanted: Mapping[str, Any], more: Iterable[str] = ()) -> list[str]:
    """Return the differences between a saved render and a wanted render, in words; the list is empty without any.

    Without differences the saved render can be resumed as the wanted render, or merged with it. ``found`` and
    ``wanted`` are the records of both: JSON data on how a render was made. ``more`` lists keys of the records to
    compare besides the usual ones. The scene counts as different if the digest differs, and either the file has another
    name or no other difference explains the digest. Backgrounds are compared only if the digest differs: without a sky,
    a transparent background changes no sample.
    """
    differing = [key for key in (*_SAME, *more) if _differ(found[key], wanted[key])]
    if {"size", "crop"} <= {*differing}:
        differing.remove("crop")  # the crop mostly follows from the size
    if "nets" in differing and not {"size", "crop", "strategy"}.isdisjoint(differing):
        differing.remove("nets")  # the number of nets follows from these
    if {"numbers", "strategy"} <= {*differing}:
        differing.remove("numbers")  # each sampler has its own
    said = [words for key in differing for words in _difference(key, found[key], wanted[key])]
    named = [Path(each["scene"]).name for each in (found, wanted) if each["scene"] is not None]
    if found["digest"] == wanted["digest"]:
        return said
    theirs, ours = (bool(each.get("transparent")) for each in (found, wanted))
    if theirs != ours:
        said.append(f"{_BACKGROUNDS[theirs]}, not {_BACKGROUNDS[ours]}")
    defined = _defined(found.get("defines") or {}, wanted.get("defines") or {})
    said += defined
    if len({*named}) == 2 or (theirs == ours and not defined and _IN_DIGEST.isdisjoint(differing)):
        said.append(f"another scene{_scenes(found['scene'], wanted['scene'])}")
    return said


def _defined(found: Mapping[str, str], wanted: Mapping[str, str]) -> list[str]:
    """Return the definitions (``-D``) that differ, in words."""
    said = []
    for name in [name for name in {**found, **wanted} if found.get(name) != wanted.get(name)]:
        theirs, ours = (f"-D {name}={each[name]}" if name in each else "" for each in (found, wanted))
        said.append(f"{theirs}, not {ours}" if theirs and ours else theirs or f"no {ours}")
    return said


def _differ(found: object, wanted: object) -> bool:
    """Tell whether values differ; mappings are compared by common names alone, as earlier versions recorded fewer."""
    if isinstance(found, Mapping) and isinstance(wanted, Mapping):
        return any(found[name] != wanted[name] for name in {*found} & {*wanted})
    return found != wanted


def _difference(key: str, found: object, wanted: object) -> list[str]:
    if isinstance(found, Mapping) and isinstance(wanted, Mapping):
        both = [(name, found[name], wanted[name]) for name in found if name in wanted]
        return [f"{key} {name} {theirs}, not {ours}" for name, theirs, ours in both if theirs != ours]
    return [f"{_NAMES.get(key, key)} {_said(key, found)}, not {_said(key, wanted)}"]


def _said(key: str, value: object) -> str:
    """Return a value in the notation of the command line."""
    if not isinstance(value, list):
        return str(value)
    return {"size": "x", "crop": ","}.get(key, ", ").join(map(str, value)) or "nothing"


def _scenes(found: str | None, wanted: str | None) -> str:
    if found is None or wanted is None:
        return ""
    return f" ({found}, with other content)" if found == wanted else f" ({found}, not {wanted})"


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
        saved=Path(path).absolute(),
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
        revisions=tuple(record["revisions"]),
        runs=record["runs"],
    )


def as_checkpoint(render: Render) -> SavedRender:
    """Return the content of a render that resuming and merging need.

    ``render`` is a result or the path of its file. Raises `ImageError` if the data for resuming are missing.
    """
    if not isinstance(render, Result):
        return SavedRender.read(render)
    file, name = render.file, name_of(render)
    record = checked(json.loads(json_text(dict(file.record))), name)
    return SavedRender.of(replace(file, record=record), name)


def as_picture(render: Render) -> tuple[Picture, SavedFilm]:
    """Return a render's picture, with standard errors and sample counts, and the samples behind it.

    ``render`` is a result or the path of an image file. An image of another renderer has no samples: all fields of the
    `SavedFilm` are None.
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
    """Return a render's name for messages: the path of a file, or ``the render with seed N`` for a result."""
    return Path(f"the render with seed {render.origin.seed}") if isinstance(render, Result) else Path(render)
