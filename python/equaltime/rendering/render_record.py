"""Validation of the record of a saved render: the JSON data in its file that tell how it was made."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from equaltime.errors import ImageError, StrategyError
from equaltime.film.sums import MOST_PIXELS_A_SECOND_NET
from equaltime.images.exposure import MOST_STOPS
from equaltime.rendering.budget import StoppedBy, StopRule
from equaltime.rendering.decision import Counts
from equaltime.revision import UNKNOWN_REVISION
from equaltime.scene.model import MOST_SAMPLES
from equaltime.strategy import Strategy
from equaltime.validation import explain

__all__ = ["checked"]


def _strategy(name: str) -> str:
    try:
        Strategy.parse(name)
    except StrategyError as error:
        raise ValueError(str(error)) from error
    return name


Count = Annotated[int, Field(ge=0, lt=2**64)]
Pixels = Annotated[int, Field(ge=0, lt=2**31)]
Seconds = Annotated[float, Field(ge=0.0)]


_Position = Annotated[tuple[Count, Count, Count], Field(strict=False)]


class _Facts(BaseModel):
    """Facts by name; unknown names are allowed."""

    model_config = ConfigDict(extra="allow", strict=True, allow_inf_nan=False)


def _whole_look(look: Any) -> Any:
    """Complete a look of an earlier version, which lacks its brightest path."""
    return [*look, None] if isinstance(look, list) and len(look) == 3 else look


_Look = Annotated[
    tuple[Count, float | None, float | None, float | None], Field(strict=False), BeforeValidator(_whole_look)
]


class _Stop(_Facts):
    rule: StopRule
    error: Annotated[float, Field(gt=0.0)]
    spp: Annotated[int, Field(ge=1, le=MOST_SAMPLES)] | None = None
    pilot_seed: Count | None = None
    pilot_spp: Count | None = None
    pilot_seconds: Seconds = 0.0


class _Focus(_Facts):
    paths: float
    light: float
    share: float
    surfaces: str | None = None


class _Source(_Facts):
    seed: Count
    samples: dict[str, int]
    spp: Annotated[float, Field(ge=0.0)] | None = None
    stopped_by: StoppedBy | None = None
    stop: _Stop | None = None
    position: _Position | None = None
    seconds: Seconds
    build: dict[str, Any] | None = None


class _Interval(_Facts):
    value: float | None
    low: float | None
    high: float | None
    doubt: str = ""
    trusted: bool = True


def _is_interval(data: dict[str, Any]) -> dict[str, Any]:
    _Interval.model_validate(data)
    return data


_Error = Annotated[dict[str, Any], AfterValidator(_is_interval)]
"""An interval that is checked and kept as it was written."""


class _Decision(_Facts):
    roulette: Literal["throughput", "efficiency"] | None = None
    splitting: Annotated[float, Field(gt=0.0)] | None = None
    counts: Counts | None = None


class _Picture(_Facts):
    colors: Literal["rgb", "luminance", "xyz"]
    alpha: bool
    half: bool


class _Frame(_Facts):
    number: Count
    fps: Annotated[float, Field(gt=0.0)]
    blur: Annotated[float, Field(ge=0.0, le=1.0)]


class _Record(_Facts):
    """Keys that resuming and merging need; `equaltime.rendering.render_file` describes them."""

    format: Annotated[int, Field(ge=1)] = 1
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
    nets: Annotated[int, Field(ge=1)] = 2
    numbers: Annotated[int, Field(ge=1)] = 1
    second_net: Annotated[int, Field(ge=0, le=MOST_PIXELS_A_SECOND_NET)] = 0
    backend: str
    without: list[str] = []
    transparent: bool = False
    defines: dict[str, str] = {}
    frame: _Frame | None = None
    substitutions: list[str]
    sources: list[_Source]
    exposure: Annotated[float, Field(ge=-MOST_STOPS, le=MOST_STOPS)] | None = None
    picture: _Picture | None = None
    samples: dict[str, int]
    stopped_by: StoppedBy
    error: _Error | None = None
    degrees: Annotated[float, Field(gt=0.0)] | None = None
    bias: _Interval | None = None
    stop: _Stop | None = None
    decision: _Decision | None = None
    looks: list[_Look]
    common_doubt: Annotated[float, Field(ge=0.0)] = 0.0
    focus: _Focus | None = None
    position: _Position | None = None
    seconds: Seconds
    runs: Annotated[int, Field(ge=1)] = 1
    phases: dict[str, Seconds] | None = None
    paths: Count
    rays: Count
    shadow_rays: Count
    threads: int
    kernel: str
    effects: list[str]
    build: dict[str, Any] | None
    revisions: list[str] = [UNKNOWN_REVISION]


_BEST_BEFORE = {"roulette": "throughput", "sampler": "sobol", "adaptive": "none"}
"""Defaults of the preset ``best`` for records without nets."""


def _in_todays_words(record: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the record with a strategy name that means today what it meant when it was written."""
    name = record.get("strategy")
    if "nets" in record or not isinstance(name, str) or name.partition(",")[0] != "best":
        return record
    words = [f"{key}={word}" for key, word in _BEST_BEFORE.items() if f",{key}=" not in name]
    with suppress(StrategyError):
        return {**record, "strategy": Strategy.parse(",".join([name, *words])).name}
    return record


def checked(record: Mapping[str, Any], path: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return the record of a saved render (JSON data on how it was made) after checking it.

    Missing optional keys are filled in. ``path`` is the file, for messages. Raises `ImageError` with all problems
    found.
    """
    try:
        return _Record.model_validate(_in_todays_words(record)).model_dump()
    except ValidationError as error:
        raise ImageError(f"{path}: its record is damaged: {'; '.join(_problems(error))}") from None


def _problems(error: ValidationError) -> Iterator[str]:
    for details in error.errors(include_url=False):
        key = ".".join(map(str, details["loc"]))
        yield f"'{key}'{' ' if details['type'] == 'missing' else ': '}{explain(details)}"
