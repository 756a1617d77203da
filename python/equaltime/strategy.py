"""A strategy: how paths are sampled, as a frozen value that every output names.

A strategy never changes what is computed, only at what cost, with one exception that says so by name: ``truncate``
cuts paths and is biased. To add a word to a field, add it to its ``Literal`` (and to the core).
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, Self, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from equaltime.errors import StrategyError

__all__ = ["PRESETS", "Strategy"]


class Strategy(BaseModel):
    """How light paths are sampled.

    ``Strategy()`` is the preset ``best``. `Strategy.parse` reads ``preset,key=value,…`` or a TOML file, and ``str()``
    writes the shortest such text, so that ``Strategy.parse(str(s)) == s``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    technique: Literal["bsdf", "light", "mis"] = "mis"
    """Directions from the BSDF alone, light sources alone (where that is possible), or both combined."""
    heuristic: Literal["balance", "power"] = "power"
    """Weights of the combination; only for ``mis``."""
    lights: Literal["uniform", "power"] = "power"
    """How a light source is picked: all alike, or in proportion to the power that it emits."""
    roulette: Literal["none", "throughput"] = "throughput"
    """Russian roulette: never, or with the path's throughput as the probability to go on. Unbiased."""
    roulette_depth: int = Field(default=5, ge=1, lt=2**31)
    """The first depth at which a path may be ended by the roulette."""
    truncate: int | None = Field(default=None, ge=1, lt=2**31)
    """Cut every path at this depth, counted like the scene's ``max_depth``, which holds in any case; biased."""
    sampler: Literal["independent", "sobol"] = "sobol"
    """Independent numbers, or Owen-scrambled Sobol points."""

    @model_validator(mode="wrap")
    @classmethod
    def _report_in_our_words(cls, values: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """Raise `StrategyError` with every problem instead of pydantic's error."""
        try:
            return validate(values)
        except ValidationError as error:
            raise StrategyError("\n".join(_explain(problem) for problem in error.errors())) from None

    @field_validator("roulette_depth", "truncate", mode="before")
    @classmethod
    def _integer_from_text(cls, value: object, info: ValidationInfo) -> object:
        """Let ``key=value`` text carry whole numbers, and ``none`` for no truncation."""
        if not isinstance(value, str):
            return value
        if value.lower() == "none" and info.field_name == "truncate":
            return None
        return int(value) if value.isascii() and value.isdigit() else value

    @property
    def biased(self) -> bool:
        """Whether the image converges to something else than the scene's light transport."""
        return self.truncate is not None

    @property
    def name(self) -> str:
        """The shortest text that `parse` reads back as this strategy, such as ``mis,sampler=independent``."""
        candidates = [_text_as_variation(self, preset) for preset in PRESETS]
        return min(candidates, key=lambda text: text.count(","))

    def __str__(self) -> str:
        return self.name

    @classmethod
    def parse(cls, text: str | Path) -> Strategy:
        """Read a strategy from ``preset``, ``preset,key=value,…``, ``key=value,…`` or the path of a TOML file.

        A TOML file has the fields as keys, and ``preset = "…"`` for where to start (``best`` if absent).

        Raises
        ------
        StrategyError
            With every unknown name and value, each with the nearest known one.
        """
        if isinstance(text, Path) or text.endswith(".toml"):
            return _from_file(Path(text))
        preset: str = "best"
        changes: dict[str, str] = {}
        for position, part in enumerate(text.split(",")):
            key, equals, value = (piece.strip() for piece in part.partition("="))
            if equals:
                if key in changes:
                    raise StrategyError(f"strategy '{text}': '{key}' is given twice")
                changes[key] = value
            elif position == 0:
                preset = key
            else:
                raise StrategyError(f"strategy '{text}': expected key=value after the preset, found '{part}'")
        return _vary(preset, changes, f"strategy '{text}'")


PRESETS: Mapping[str, Strategy] = {
    "best": Strategy(),
    "mis": Strategy(technique="mis", heuristic="balance", lights="uniform", roulette="none", sampler="independent"),
    "bsdf": Strategy(technique="bsdf", heuristic="balance", lights="uniform", roulette="none", sampler="independent"),
    "light": Strategy(technique="light", heuristic="balance", lights="uniform", roulette="none", sampler="independent"),
}
"""``best``, and the textbook techniques with nothing else switched on, for comparisons."""


def _text_as_variation(strategy: Strategy, preset: str) -> str:
    """Spell ``strategy`` as a preset and what differs from it."""
    base = PRESETS[preset]
    differing = [key for key in Strategy.model_fields if getattr(strategy, key) != getattr(base, key)]
    words = (f"{key}={str(getattr(strategy, key)).lower()}" for key in differing)
    return ",".join([preset, *words])


def _from_file(path: Path) -> Strategy:
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StrategyError(f"{path}: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise StrategyError(f"{path}: {error}") from error
    preset = table.pop("preset", "best")
    return _vary(preset, table, str(path))


def _vary(preset: object, changes: Mapping[str, Any], place: str) -> Strategy:
    """Apply ``changes`` to a preset; every problem is reported together, prefixed by ``place``."""
    if not isinstance(preset, str) or preset not in PRESETS:
        raise StrategyError(f"{place}: unknown strategy '{preset}'{_nearest(str(preset), PRESETS)}")
    try:
        return Strategy.model_validate(PRESETS[preset].model_dump() | dict(changes))
    except StrategyError as error:
        raise StrategyError("\n".join(f"{place}: {line}" for line in str(error).splitlines())) from None


def _explain(problem: Mapping[str, Any]) -> str:
    """Turn one of pydantic's errors into a sentence with the nearest known name."""
    key, found = str(problem["loc"][0]), problem["input"]
    if problem["type"] == "extra_forbidden":
        return f"unknown key '{key}'{_nearest(key, Strategy.model_fields)}"
    if problem["type"] == "literal_error":
        return f"unknown {key} '{found}'{_nearest(str(found), get_args(Strategy.model_fields[key].annotation))}"
    if problem["type"] == "less_than":
        return f"{key} must be below 2^31, found '{found}'"
    return f"{key} must be a whole number of at least 1{' or none' if key == 'truncate' else ''}, found '{found}'"


def _nearest(word: str, known: Iterable[str]) -> str:
    """Return ``; did you mean …?``, or the whole list if nothing is near."""
    known = tuple(known)
    close = difflib.get_close_matches(word.lower(), known, n=1, cutoff=0.5)
    return f"; did you mean '{close[0]}'?" if close else f"; known are {', '.join(known)}"
