"""What a saved render says of how it was made, checked where it is read: the file may be damaged, or another's."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from equaltime.error_estimate import Unit
from equaltime.errors import ImageError, StrategyError
from equaltime.result import StoppedBy
from equaltime.scene.known import shortened
from equaltime.scene.model import MOST_SAMPLES
from equaltime.stopping import StopRule
from equaltime.strategy import Strategy

__all__ = ["checked", "differences"]

_SAME = ("size", "crop", "max_depth", "strategy", "without", "replicates", "backend")
"""What renders that are parts of one have in common, beside the scene: keys of a record."""
_IN_DIGEST = {"size", "crop", "max_depth", "without"}
_NAMES = {"max_depth": "max depth", "without": "left out"}


def _strategy(name: str) -> str:
    try:
        Strategy.parse(name)
    except StrategyError as error:
        raise ValueError(str(error)) from error
    return name


Count = Annotated[int, Field(ge=0, lt=2**64)]
Pixels = Annotated[int, Field(ge=0, lt=2**31)]
Seconds = Annotated[float, Field(ge=0.0)]


class _Facts(BaseModel):
    """Facts by name; more of them than are asked for do no harm."""

    model_config = ConfigDict(extra="allow", strict=True, allow_inf_nan=False)


def _whole_look(look: Any) -> Any:
    """Complete a look of an earlier version, which did not tell of its brightest path."""
    return [*look, None] if isinstance(look, list) and len(look) == 3 else look


_Look = Annotated[
    tuple[Count, float | None, float | None, float | None], Field(strict=False), BeforeValidator(_whole_look)
]


class _Source(_Facts):
    seed: Count
    samples: dict[str, int]
    seconds: Seconds
    build: dict[str, Any] | None


class _Interval(_Facts):
    value: float | None
    low: float | None
    high: float | None
    doubt: str = ""
    unit: Unit = "%"


class _Stop(_Facts):
    rule: StopRule
    error: Annotated[float, Field(gt=0.0)]
    spp: Annotated[int, Field(ge=1, le=MOST_SAMPLES)] | None = None
    pilot_seed: Count | None = None
    pilot_spp: Count | None = None
    pilot_seconds: Seconds = 0.0


class _Record(_Facts):
    """What taking up and merging go by, as `Result.record` writes it."""

    scene: str | None
    digest: str
    size: Annotated[list[Pixels], Field(min_length=2, max_length=2)]
    crop: Annotated[list[Pixels], Field(min_length=4, max_length=4)]
    max_depth: int
    scene_max_depth: int | None = None
    strategy: Annotated[str, AfterValidator(_strategy)]
    biased: bool
    seed: Count
    replicates: int
    backend: str
    without: list[str] = []
    substitutions: list[str]
    sources: list[_Source]
    samples: dict[str, int]
    stopped_by: StoppedBy
    bias: _Interval | None = None
    stop: _Stop | None = None
    looks: list[_Look]
    focus: dict[str, float] | None = None
    position: Annotated[tuple[Count, Count, Count] | None, Field(strict=False)] = None
    seconds: Seconds
    paths: Count
    rays: Count
    shadow_rays: Count
    threads: int
    kernel: str
    effects: list[str]
    build: dict[str, Any] | None


def checked(record: Mapping[str, Any], path: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return a file's record, whole; raises `ImageError` with all that is wrong with it."""
    try:
        return _Record.model_validate(record).model_dump()
    except ValidationError as error:
        raise ImageError(f"{path}: its record is damaged: {'; '.join(_problems(error))}") from None


def _problems(error: ValidationError) -> Iterator[str]:
    for details in error.errors(include_url=False):
        key = ".".join(map(str, details["loc"]))
        if details["type"] == "missing":
            yield f"'{key}' is missing"
        else:
            yield f"'{key}' {details['msg'].removeprefix('Input ')}, found {shortened(details['input'], 80)}"


def differences(found: Mapping[str, Any], wanted: Mapping[str, Any], more: Iterable[str] = ()) -> list[str]:
    """Say in words in what a record differs from that of a part of the render that is wanted, and in ``more`` keys.

    That it is of another scene is said where its file has another name, or nothing else tells why the digest differs.
    """
    differing = [key for key in (*_SAME, *more) if found[key] != wanted[key]]
    if {"size", "crop"} <= {*differing}:
        differing.remove("crop")  # the one follows from the other, mostly
    said = [words for key in differing for words in _difference(key, found[key], wanted[key])]
    named = [Path(each["scene"]).name for each in (found, wanted) if each["scene"] is not None]
    if found["digest"] != wanted["digest"] and (len({*named}) == 2 or _IN_DIGEST.isdisjoint(differing)):
        said.append(f"another scene{_scenes(found['scene'], wanted['scene'])}")
    return said


def _difference(key: str, found: object, wanted: object) -> list[str]:
    if isinstance(found, Mapping) and isinstance(wanted, Mapping):
        both = ((name, found.get(name), wanted.get(name)) for name in {**found, **wanted})
        return [f"{key} {name} {theirs}, not {ours}" for name, theirs, ours in both if theirs != ours]
    return [f"{_NAMES.get(key, key)} {_said(key, found)}, not {_said(key, wanted)}"]


def _said(key: str, value: object) -> str:
    """Write a value as the command line has it."""
    if not isinstance(value, list):
        return str(value)
    return {"size": "x", "crop": ","}.get(key, ", ").join(map(str, value)) or "nothing"


def _scenes(found: str | None, wanted: str | None) -> str:
    if found is None or wanted is None:
        return ""
    return f" ({found}, with other content)" if found == wanted else f" ({found}, not {wanted})"
