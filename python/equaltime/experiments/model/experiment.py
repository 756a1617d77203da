"""An experiment as a value: scenes x strategies x repeats, what each run may cost, and what is wanted of it.

`equaltime.experiments.model.reader` reads one from TOML; in Python the same words are keyword arguments. Everything is
checked when it is made, and every problem is told together, by its path of keys.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationError,
    field_validator,
    model_validator,
)

from equaltime.errors import ExperimentError, Problem, SceneError, StrategyError
from equaltime.experiments.model.problems import DEFAULT_TARGETS, crossed, explained, name_of_scene, name_of_strategy
from equaltime.experiments.model.summary import Question
from equaltime.experiments.model.theirs import Theirs
from equaltime.experiments.model.value import Value
from equaltime.rendering.arguments import MOST_SECONDS, MOST_THREADS, check_fraction
from equaltime.scene import Scene, load_dict, load_file
from equaltime.scene.model import MOST_SAMPLES
from equaltime.strategy import Strategy
from equaltime.words import seconds_of

__all__ = ["DEFAULT_BUDGET", "Experiment", "Peer", "ReferenceWish", "SceneEntry", "StrategyEntry"]

DEFAULT_BUDGET = 10.0

Positive = Annotated[int, Field(ge=1)]
Natural = Annotated[int, Field(ge=0)]
Seconds = Annotated[float, Field(gt=0.0, le=MOST_SECONDS)]
Error = Annotated[float, Field(gt=0.0), AfterValidator(check_fraction)]
Window = Annotated[tuple[Natural, Natural, Positive, Positive], Field(strict=False)]
File = Annotated[Path, Field(strict=False)]


class SceneEntry(Value):
    """A scene, and what is different from its file."""

    path: File | None = None
    """A scene file; in an experiment file, relative to its folder."""
    scene: Scene | dict[str, Any] | None = None
    """Or the scene itself: loaded, or as Mitsuba's dictionary."""
    name: str = ""
    """Its name in records and reports; the file's name without its ending, if not given."""
    size: Annotated[tuple[Positive, Positive], Field(strict=False)] | None = None
    """Film size in pixels."""
    max_depth: Annotated[int, Field(ge=-1)] | None = None
    crop: Window | None = None
    """x, y, width, height of what is rendered."""
    define: dict[str, Any] = Field(default_factory=dict)
    """Values for the variables of the file."""
    substitute: bool = False
    """Replace what cannot be rendered, as `equaltime.load` does."""

    def load(self) -> Scene:
        """Read the scene, and change what is to be changed; raises SceneError."""
        if isinstance(self.scene, Scene):
            scene = self.scene
        else:
            load_as = {"substitute": self.substitute}
            if self.scene is not None:
                scene = load_dict(self.scene, **load_as)
            else:
                scene = load_file(self.path or "", self.define, **load_as)
        changed = self.size is not None or self.crop is not None or self.max_depth is not None
        return scene.with_(size=self.size, crop=self.crop, max_depth=self.max_depth) if changed else scene


class Peer(Value):
    """Another renderer: Mitsuba 3, or any command that writes an EXR file."""

    renderer: Literal["mitsuba"] | None = None
    variant: str | None = None
    """Mitsuba's, such as ``llvm_ad_rgb``."""
    integrator: str | None = None
    sampler: str | None = None
    command: str | None = None
    """A command line in which ``{scene}``, ``{spp}``, ``{seed}`` and ``{out}`` are filled in."""
    limit: Seconds | None = None
    """Seconds that one render may take before the renderer is ended.

    If not given: 20 times the experiment's budget and 60 more, or one hour where ``spp`` gives the counts; never less
    than ``reference.seconds`` and 60 more. Starting and loading have at least 30 minutes.
    """

    _duration = field_validator("limit", mode="before")(lambda value: _seconds(value))


@dataclass(frozen=True)
class _Origin:
    """The place of an entry in its file. It does not count when entries are compared."""

    place: str = field(default="", compare=False)


class StrategyEntry(Value):
    """Something that is compared: one of equaltime's strategies, a peer, or a subject of your own."""

    label: str = ""
    """Its name in records and reports; the strategy's own text, if not given."""
    strategy: Strategy | None = None
    peer: Peer | None = None
    python: str | None = None
    """``FILE.py:NAME``, called with the label, gives an `equaltime.rendering.subject.Subject`."""
    _origin: _Origin = PrivateAttr(default_factory=_Origin)

    @property
    def place(self) -> str:
        """``FILE:LINE: strategies[N]`` if the entry was read from a file, else empty."""
        return self._origin.place

    def at(self, place: str) -> Self:
        """Return the entry with the place where it stands in its file."""
        entry = self.model_copy()
        entry._origin = _Origin(place)
        return entry

    @field_validator("strategy", mode="before")
    @classmethod
    def _read_strategy(cls, value: object) -> object:
        try:
            return Strategy.parse(value) if isinstance(value, str) else value
        except StrategyError as error:
            raise ValueError(str(error)) from None

    @field_validator("peer", mode="before")
    @classmethod
    def _name_peer(cls, value: object) -> object:
        return {"renderer": value} if isinstance(value, str) else value


class ReferenceWish(Value):
    """How exact the references shall be."""

    error: Error = 0.005
    """Relative error at which rendering a reference ends (0.005 is 0.5 %)."""
    seconds: Seconds = 60.0
    """Time after which it ends in any case."""
    file: File | None = None
    """An image to be used instead, for an experiment of one scene; an EXR's own standard errors count as its noise."""

    _duration = field_validator("seconds", mode="before")(lambda value: _seconds(value))


class Experiment(Value):
    """A comparison: of which strategies, on which scenes, for how long and how often."""

    title: str = ""
    description: str = ""
    """A paragraph for students: what is compared, what to see, why."""
    theirs: Theirs | None = None
    """The claim that the experiment goes back to, with its figures; ours are shown beside them."""
    scenes: Annotated[tuple[SceneEntry, ...], Field(strict=False, min_length=1)]
    strategies: Annotated[tuple[StrategyEntry, ...], Field(strict=False, min_length=1)]
    baseline: str = ""
    """Label of the strategy that all are compared with; if not given ``naive``, else the first that is not ``best``."""
    budget: Seconds | None = None
    """Seconds of a run, first sample to last checkpoint; 10 if nothing is given."""
    spp: (
        Annotated[tuple[Annotated[int, Field(ge=1, le=MOST_SAMPLES)], ...], Field(strict=False, min_length=1)] | None
    ) = None
    """Or the sample counts of all checkpoints."""
    repeats: Annotated[int, Field(ge=1, le=100_000)] = 8
    targets: Annotated[tuple[Error, ...], Field(strict=False)] = DEFAULT_TARGETS
    """Errors to which times are wanted (0.02 is 2 %)."""
    crops: Annotated[tuple[Window, ...], Field(strict=False)] = ()
    """Windows that the report shows large."""
    figures: Annotated[tuple[Literal["directions"], ...], Field(strict=False)] = ()
    """Further figures of the report: the directions in which uniform and BSDF sampling send rays, for each scene."""
    animate: bool = False
    """Whether the report shows the images forming, side by side at equal time."""
    question: Question = "time"
    """The verdict's question: ``time`` to an error, ``bias``, ``samples`` or ``efficiency``.

    ``bias``: which strategies are off the baseline, on scenes whose light all of them find. ``samples``: how many
    samples each strategy needs. ``efficiency``: how much smaller squared error times time is than the baseline's, over
    all scenes.
    """
    reference: ReferenceWish = ReferenceWish()
    threads: Annotated[int, Field(ge=0, le=MOST_THREADS)] = 0
    """Worker threads; 0 is one for each processor."""

    folder: File = Path()
    """Folder in which the commands of peers are run; by default the folder of the experiment file."""

    _duration = field_validator("budget", mode="before")(lambda value: _seconds(value))

    @field_validator("strategies", mode="before")
    @classmethod
    def _short_strategies(cls, value: object) -> object:
        """Let a text stand for a strategy that is labelled by it."""
        if not isinstance(value, list | tuple):
            return value
        return tuple({"label": entry, "strategy": entry} if isinstance(entry, str) else entry for entry in value)

    @model_validator(mode="wrap")
    @classmethod
    def _check(cls, values: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """Fill in names, and raise `ExperimentError` with every problem at once."""
        problems = crossed(values) if isinstance(values, Mapping) else ()
        try:
            experiment = validate(_named(values) if isinstance(values, Mapping) else values)
        except ValidationError as error:
            raise ExperimentError((*explained(cls, error), *problems)) from None
        if problems:
            raise ExperimentError(problems)
        return experiment

    def replace(self, **changes: object) -> Experiment:
        """Return the experiment with some values changed, checked anew."""
        fields = {name: getattr(self, name) for name in self.model_fields_set}
        if {"budget", "spp"} & changes.keys():
            fields |= {"budget": None, "spp": None}
        changed = fields | changes
        if "baseline" not in changes and self.baseline not in map(name_of_strategy, changed["strategies"]):
            changed["baseline"] = ""
        if "theirs" not in changes and self.theirs is not None:
            changed["theirs"] = self.theirs.of(map(name_of_strategy, changed["strategies"]))
        return Experiment.model_validate(changed)

    def load_scenes(self) -> tuple[Scene, ...]:
        """Read all scenes; raises `ExperimentError` with the problems of all of them."""
        scenes: list[Scene] = []
        problems: list[Problem] = []
        for number, entry in enumerate(self.scenes):
            try:
                scenes.append(entry.load())
            except SceneError as error:
                owner = str(entry.path or f"scenes[{number}]")
                problems += (
                    problem if owner in problem.place else Problem(f"{owner}: {problem.place}", problem.message)
                    for problem in error.problems
                )
        if problems:
            raise ExperimentError(tuple(problems))
        return tuple(scenes)


def _seconds(value: object) -> object:
    return seconds_of(value) if isinstance(value, str) else value


def _named(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with the names filled in that were not given, as far as they can be known."""
    filled = dict(values)
    strategies, scenes = values.get("strategies"), values.get("scenes")
    if isinstance(strategies, list | tuple):
        labels = [name_of_strategy(entry) for entry in strategies]
        filled["strategies"] = [_with(entry, "label", label) for entry, label in zip(strategies, labels, strict=True)]
        if not values.get("baseline"):
            plain = [label for label in labels if label != "best"]
            filled["baseline"] = "naive" if "naive" in labels else (*plain, *labels, "")[0]
    if isinstance(scenes, list | tuple):
        filled["scenes"] = [_with(entry, "name", name_of_scene(entry, number)) for number, entry in enumerate(scenes)]
    if values.get("budget") is None and values.get("spp") is None:
        filled["budget"] = DEFAULT_BUDGET
    return filled


def _with(entry: object, key: str, name: str) -> object:
    if isinstance(entry, Mapping):
        return {**entry, key: entry.get(key) or name}
    if isinstance(entry, SceneEntry | StrategyEntry):
        return entry if getattr(entry, key) else entry.model_copy(update={key: name})
    return entry
