"""Saved renders, which can be resumed: the resumed render has the same bits as one that was never stopped."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.film.moments import nonfinite
from equaltime.film.parts_of_merge import MergedFilm
from equaltime.film.second_nets import SecondNets
from equaltime.rendering.budget import Look, Stop
from equaltime.rendering.decision import Decision
from equaltime.rendering.film_picture import FilmPicture
from equaltime.rendering.render_file import RenderFile

__all__ = ["SavedRender", "differences", "looks_of"]

_SAME = ("size", "crop", "max_depth", "strategy", "without", "replicates", "nets", "backend")
"""Keys of a record that must be equal in all parts of one render, beside the scene."""
_IN_DIGEST = {"size", "crop", "max_depth", "without"}
_NAMES = {"max_depth": "max depth", "without": "left out"}


@dataclass(frozen=True, eq=False)
class SavedRender:
    """Content of a saved render with its moments (count, mean and deviation of each pixel's samples)."""

    path: Path
    record: Mapping[str, Any]
    """The provenance, as `Result.record` has it, checked."""
    moments: NDArray[Any]
    """(R, H, W), as `equaltime.film.moments` describes them."""
    missed: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """Light that samples may have missed, as in `Result.missed`."""
    parts: NDArray[Any] | None = None
    """Sums over merged parts (`equaltime.film.parts_of_merge`), (H, W); None if not merged, or saved by equaltime
    0.1.0."""
    alpha: NDArray[np.float32] | None = None
    """(H, W): opacity of each pixel, if the film asked for it."""
    second: SecondNets | None = None
    """Second nets of some pixels; None if there are none."""

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> SavedRender:
        """Return the content of a file that `Result.save` wrote.

        Raises `ImageError` if the file is damaged or holds no moments.
        """
        file = RenderFile.read(path)
        return cls.of(file, Path(path))

    @classmethod
    def of(cls, file: RenderFile, path: Path) -> SavedRender:
        """Return the content of a saved render, from the content of its file, after checking it.

        ``path`` is the name of the file in errors. Raises `ImageError` as `read` does.
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
        """Samples of the render, as a film that can be merged.

        The film of a render that was not merged has one part.
        """
        return MergedFilm.of(self.moments, self.second) if self.parts is None else MergedFilm(self.moments, self.parts)

    @property
    def picture(self) -> FilmPicture:
        """Colours, alpha and precision of the picture that the render's film asked for."""
        return FilmPicture.from_dict(self.record["picture"])

    @property
    def seconds(self) -> float:
        """Rendering time of the saved render, in seconds."""
        return float(self.record["seconds"])

    @property
    def looks(self) -> tuple[Look, ...]:
        """Looks of the saved render: the estimates of its error at which it might have stopped."""
        return looks_of(self.record)

    @property
    def decision(self) -> Decision:
        """Decisions that the strategy left to the saved render: on splitting of paths, and on sample counts."""
        return Decision.from_dict(self.record["decision"])

    @property
    def stop(self) -> Stop | None:
        """Rule by which the render was to stop at an error; None if it had no error limit."""
        return None if self.record["stop"] is None else Stop.from_dict(self.record["stop"])

    @property
    def position(self) -> tuple[int, int, int]:
        """Position in the passes, as in `Result.position`: samples per pixel, samples of the running pass, next block.

        Raises `ImageError` if the record has no position.
        """
        if self.record["position"] is None:
            raise ImageError(f"{self.path}: cannot be taken up: it does not tell where its passes stood")
        done, target, next_block = self.record["position"]
        return done, target, next_block

    def check(self, wanted: Mapping[str, Any]) -> None:
        """Raise `ImageError`, with the differences, if this saved render cannot be resumed as the wanted render.

        ``wanted`` holds the values that the record of the wanted render has. A merged render cannot be resumed.
        """
        if self.record["sources"]:
            raise ImageError(
                f"{self.path}: cannot be taken up: it was merged; render with another seed, and merge again"
            )
        if different := differences(self.record, wanted, ("seed", "substitutions", "build")):
            raise ImageError(f"{self.path}: cannot be taken up: it has {'; '.join(different)}")


def looks_of(record: Mapping[str, Any]) -> tuple[Look, ...]:
    """Return the looks (estimates of the error on the way) that the record of a saved render lists."""
    return tuple(
        Look(samples, math.nan if value is None else value, math.inf if high is None else high, brightest or 0.0)
        for samples, value, high, brightest in record["looks"]
    )


def differences(found: Mapping[str, Any], wanted: Mapping[str, Any], more: Iterable[str] = ()) -> list[str]:
    """Return the differences between a saved render and a wanted render, in words; the list is empty without any.

    ``found`` and ``wanted`` are their records: JSON data that tell how a render was made. Without differences the saved
    render can be resumed as the wanted one, or merged with it. ``more`` lists keys of the records to compare besides
    the usual ones. The scene counts as different if the digest differs, and either the file has another name or no
    other difference explains the digest.
    """
    differing = [key for key in (*_SAME, *more) if _differ(found[key], wanted[key])]
    if {"size", "crop"} <= {*differing}:
        differing.remove("crop")  # the crop mostly follows from the size
    said = [words for key in differing for words in _difference(key, found[key], wanted[key])]
    named = [Path(each["scene"]).name for each in (found, wanted) if each["scene"] is not None]
    if found["digest"] != wanted["digest"] and (len({*named}) == 2 or _IN_DIGEST.isdisjoint(differing)):
        said.append(f"another scene{_scenes(found['scene'], wanted['scene'])}")
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
