"""Strategies: the methods by which a render samples paths, as one immutable value; every output names its strategy.

A strategy changes the cost of an image, but not the expected image. Two fields of `Strategy` are exceptions:
``truncate`` cuts paths, and some rules of ``adaptive`` are biased; see `Strategy.biased`. To add a value to a field,
add it to the field's ``Literal`` and to the compiled core. Some fields only have a meaning for certain values of
another field. Otherwise such a field is None, and setting it is an error.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
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
from pydantic_core import ErrorDetails

from equaltime.errors import StrategyError
from equaltime.validation import explain
from equaltime.words import suggestion

__all__ = ["PRESETS", "Strategy"]


class Strategy(BaseModel):
    """A choice of methods for sampling light paths, on which the cost of an image depends; immutable.

    ``Strategy()`` is the preset ``best``. `Strategy.parse` reads ``preset,key=value,…`` or a TOML file. ``str()`` of a
    strategy gives a text from which `Strategy.parse` makes an equal strategy. The expected image is the same with all
    strategies whose `biased` is False.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    technique: Literal["uniform", "bsdf", "light", "mis", "mixture"] = "mis"
    """Technique that finds light at each vertex of a path. ``uniform`` and ``bsdf`` follow a ray, whose direction is
    uniform or drawn from the BSDF. ``light`` adds a ray to a light source, which finds all direct light. ``mis`` traces
    both rays, and combines the direct light that they find by weights. ``mixture`` draws one of the two rays at random
    and follows that ray; the weight divides by the mean of both densities. All techniques follow perfect mirrors and
    glass, and sample point lights directly. If lights cover a small solid angle at every vertex, the weights of
    ``mixture`` double with every bounce."""
    heuristic: Literal["balance", "power"] | None = None
    """Weights that combine the two rays of ``mis``: balance or power heuristic. The default is power, but the preset
    ``mis`` has balance. None for other techniques."""
    lights: Literal["uniform", "power", "tree"] = "tree"
    """Probability of choosing a light source. ``uniform`` gives all sources the same probability. ``power`` uses the
    power of the source. ``tree`` uses an upper bound of the light that reaches the point from the source, by a tree of
    lights (Conty Estevez & Kulla 2018, without splitting). Its time grows with the number of lights."""
    environment: Literal["plain", "compensated"] | None = None
    """Density by which directions of an environment image are drawn. ``plain`` uses the radiance. ``compensated``
    (default) uses the radiance above the mean, and leaves the rest to the BSDF's rays (Karlík et al. 2019). None for
    techniques other than ``mis`` and ``mixture``."""
    roulette: Literal["none", "constant", "albedo", "throughput", "efficiency", "automatic"] = "automatic"
    """Survival probability of Russian roulette, which is unbiased. ``none`` uses no roulette. ``constant`` uses
    `survival`. ``albedo`` uses the largest component of the surface's albedo. ``throughput`` uses the path's
    throughput. ``efficiency`` uses the throughput too, and splits a path at its first scattering. A pilot (short
    render) chooses the number of copies for the least variance times rays. ``automatic`` is ``efficiency`` if a pilot
    shows that splitting pays, else ``throughput``."""
    roulette_depth: int | None = Field(default=None, ge=1, lt=2**31)
    """First depth at which the roulette may end a path. The default is 5, and None without roulette."""
    survival: float | None = Field(default=None, gt=0.0, lt=1.0)
    """Survival probability p of the ``constant`` roulette. The default is 0.75, and None for other kinds of roulette.
    If the albedo is above p, weights grow from bounce to bounce. If the albedo's square is above p, paths without a
    limit have infinite variance."""
    truncate: int | None = Field(default=None, ge=1, lt=2**31)
    """Depth at which every path is cut, counted like the scene's ``max_depth``; the smaller of the two counts. The
    image is biased."""
    sampler: Literal["independent", "stratified", "sobol", "lattice"] = "lattice"
    """Kind of random numbers. ``independent`` numbers have no structure. ``stratified`` uses jittered strata: one for
    each sample, if the sample count is a power of four. ``sobol`` uses one Sobol sequence for all choices at the first
    eight vertices, with Owen's scrambling (directions: Joe & Kuo 2008). ``lattice`` uses one lattice with random shifts
    for them (Cools, Kuo & Nuyens 2006). Both have Sobol pairs of their own for each later choice."""
    adaptive: Literal["none", "error", "neighbours", "history", "cutoff"] = "error"
    """Rule by which pixels get more samples after a pilot, a short render with equal counts
    (`equaltime.film.adaptive`). ``none`` gives all pixels the same number. ``error`` prefers pixels whose neighbours
    showed a large error, if the pilot shows a gain. ``error`` is unbiased; a crop has other sample counts than the
    whole image. The other rules are biased, and exist for comparison. ``neighbours`` prefers pixels around which the
    values scatter. ``history`` prefers pixels with a large error of their own. ``cutoff`` skips pixels that seem
    converged, as most renderers do."""

    @model_validator(mode="wrap")
    @classmethod
    def _report_in_our_words(cls, values: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """Raise `StrategyError` with every problem instead of pydantic's error."""
        settled, problems = _settle(values)
        try:
            strategy = validate(settled)
        except ValidationError as error:
            problems += [_problem(problem) for problem in error.errors()]
        if problems:
            raise StrategyError("\n".join(problems)) from None
        return strategy

    @field_validator("roulette_depth", "truncate", "survival", mode="before")
    @classmethod
    def _number_from_text(cls, value: object, info: ValidationInfo) -> object:
        """Let ``key=value`` text carry numbers, and ``none`` for no truncation."""
        if not isinstance(value, str):
            return value
        if info.field_name == "survival":
            return _float_or_text(value)
        if value.lower() == "none" and info.field_name == "truncate":
            return None
        return int(value) if value.isascii() and value.isdigit() else value

    @property
    def biased(self) -> bool:
        """Whether the expected image is wrong: True with ``truncate``, or with a biased rule of ``adaptive``."""
        return self.truncate is not None or self.adaptive in _LOOK_AT_THEMSELVES

    @property
    def name(self) -> str:
        """Text with the fewest keys from which `Strategy.parse` makes this strategy, such as ``mis,sampler=sobol``."""
        candidates = [_text_as_variation(self, preset) for preset in PRESETS]
        return min(candidates, key=lambda text: text.count(","))

    @property
    def in_full(self) -> str:
        """Text from which `parse` makes this strategy, with every key that has a value, whatever the presets mean."""
        return ",".join(f"{key}={str(value).lower()}" for key, value in self.model_dump(exclude_none=True).items())

    def __str__(self) -> str:
        return self.name

    @classmethod
    def of(cls, strategy: Strategy | str) -> Strategy:
        """Return ``strategy`` itself if it is a `Strategy`, or else the strategy that `parse` reads from the text.

        Raises `StrategyError` for a text that describes no strategy.
        """
        return strategy if isinstance(strategy, Strategy) else cls.parse(strategy)

    @classmethod
    def parse(cls, text: str | Path) -> Strategy:
        """Return the strategy that a text or a TOML file describes.

        A text is ``preset``, ``preset,key=value,…``, ``key=value,…`` or the path of a file (``.toml``). The keys of a
        text or a file are the fields of `Strategy`. A file names its preset by ``preset = "…"``. All other fields have
        the preset's values. The preset is ``best`` if none is named.

        Raises
        ------
        StrategyError
            If a name or a value is unknown, or the file cannot be read. The message lists all unknown names and values,
            each with the nearest known one.
        TypeError
            If ``text`` is neither text nor a path.
        """
        if not isinstance(text, str | Path):
            raise TypeError(f"a strategy is a Strategy, or text such as 'best,sampler=sobol'; found {text!r}")
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


@dataclass(frozen=True)
class _Condition:
    """When a field has a meaning: only if `field` has one of `words`."""

    field: str
    words: tuple[str, ...]
    default: object
    reason: str
    """Why not otherwise."""

    def holds(self, values: Mapping[str, Any]) -> bool:
        return values.get(self.field, Strategy.model_fields[self.field].default) in self.words

    def refuses(self, values: Mapping[str, Any]) -> bool:
        """Tell whether the deciding field has one of its other words; a word that is none is a problem by itself."""
        word = values.get(self.field, Strategy.model_fields[self.field].default)
        return word in _words(self.field) and word not in self.words


_CONDITIONS: Mapping[str, _Condition] = {
    "heuristic": _Condition("technique", ("mis",), "power", "only mis weights the samples of two techniques"),
    "environment": _Condition(
        "technique", ("mis", "mixture"), "compensated", "only mis and mixture trace the BSDF's rays too"
    ),
    "roulette_depth": _Condition(
        "roulette", ("constant", "albedo", "throughput", "efficiency", "automatic"), 5, "there is no roulette"
    ),
    "survival": _Condition("roulette", ("constant",), 0.75, "only the constant roulette uses it"),
}
_LOOK_AT_THEMSELVES = ("neighbours", "history", "cutoff")
""""Adaptive metrics by which the number of a pixel's samples depends on these samples."""


def _settle(values: Any) -> tuple[Any, list[str]]:
    """Give fields that depend on others their defaults, or None where they have no meaning; name those given there."""
    if not isinstance(values, Mapping):
        return values, []
    settled, problems = dict(values), list[str]()
    if values.get("roulette") == "efficiency" and (technique := values.get("technique")) in ("uniform", "mixture"):
        problems.append(f"roulette=efficiency has no meaning with technique={technique}: it splits the BSDF's rays")
    for key, condition in _CONDITIONS.items():
        given = values.get(key)
        if condition.holds(values):
            settled[key] = condition.default if given is None else given
            continue
        settled[key] = None
        if given is not None and str(given).lower() != "none" and condition.refuses(values):
            decided = f"{condition.field}={values[condition.field]}"
            problems.append(f"{key}={given} has no meaning with {decided}: {condition.reason}")
    return settled, problems


def _words(key: str) -> tuple[str, ...]:
    """Return the words that a field may have."""
    parts = get_args(Strategy.model_fields[key].annotation)
    return tuple(word for part in parts for word in (get_args(part) or (part,)) if isinstance(word, str))


PRESETS: Mapping[str, Strategy] = {
    "best": Strategy(),
    "mis": Strategy(
        technique="mis",
        heuristic="balance",
        lights="uniform",
        environment="plain",
        roulette="none",
        sampler="independent",
        adaptive="none",
    ),
    "bsdf": Strategy(technique="bsdf", lights="uniform", roulette="none", sampler="independent", adaptive="none"),
    "light": Strategy(technique="light", lights="uniform", roulette="none", sampler="independent", adaptive="none"),
    "naive": Strategy(technique="uniform", lights="uniform", roulette="albedo", sampler="independent", adaptive="none"),
}
"""Named strategies. ``best`` is the default. ``mis``, ``bsdf`` and ``light`` are textbook techniques with all other
methods switched off, for comparisons. ``naive`` samples without knowledge of lights and BSDFs, and is the baseline of
speed-ups."""


def _text_as_variation(strategy: Strategy, preset: str) -> str:
    """Spell ``strategy`` as a preset and what differs from it, without what follows from the rest."""
    base = PRESETS[preset]
    words = [preset]
    for key in Strategy.model_fields:
        value, condition = getattr(strategy, key), _CONDITIONS.get(key)
        follows = condition is not None and (
            value is None or (getattr(base, key) is None and value == condition.default)
        )
        if value != getattr(base, key) and not follows:
            words.append(f"{key}={str(value).lower()}")
    return ",".join(words)


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
        raise StrategyError(f"{place}: unknown strategy '{preset}'{suggestion(str(preset), PRESETS)}")
    values = PRESETS[preset].model_dump() | dict(changes)
    for key, condition in _CONDITIONS.items():
        if key not in changes and not condition.holds(values):
            values[key] = None  # the preset's, not the user's
    try:
        return Strategy.model_validate(values)
    except StrategyError as error:
        raise StrategyError("\n".join(f"{place}: {line}" for line in str(error).splitlines())) from None


def _problem(problem: ErrorDetails) -> str:
    """Turn one of pydantic's errors into a sentence with the nearest known name."""
    key, found = str(problem["loc"][0]), problem["input"]
    if problem["type"] == "extra_forbidden":
        return explain(problem, Strategy.model_fields)
    if problem["type"] == "literal_error":
        return f"unknown {key} '{found}'{suggestion(str(found), _words(key))}"
    if key == "survival":
        return f"survival must be a number between 0 and 1, found '{found}'"
    if problem["type"] == "less_than":
        return f"{key} must be below 2^31, found '{found}'"
    return f"{key} must be a whole number of at least 1{' or none' if key == 'truncate' else ''}, found '{found}'"


def _float_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
