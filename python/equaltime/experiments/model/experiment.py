"""The settings of an experiment: scenes, strategies, number of repeats, budget of each run, and the results wanted.

`equaltime.experiments.model.reader` reads an experiment from TOML. In Python the same keys are keyword arguments. All
values are checked on construction, and one error lists every problem by its path of keys.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationError,
    field_validator,
    model_validator,
)

from equaltime.errors import ExperimentError, Problem, SceneError, StrategyError
from equaltime.experiments.model.problems import DEFAULT_TARGETS, crossed, explained, name_of_scene, name_of_strategy
from equaltime.rendering.job import MOST_SECONDS, MOST_THREADS, check_fraction
from equaltime.scene import Scene, load_dict, load_file
from equaltime.scene.model import MOST_SAMPLES
from equaltime.strategy import Strategy
from equaltime.words import error_of, seconds_of

__all__ = [
    "DEFAULT_BUDGET",
    "MOST_REPEATS",
    "Experiment",
    "Peer",
    "Quantity",
    "Question",
    "QuickWish",
    "ReferenceWish",
    "SceneEntry",
    "StrategyEntry",
    "TheirNumber",
    "Theirs",
    "Value",
]

Quantity = Literal[
    "slope",
    "speed-up",
    "efficiency",
    "fewer samples",
    "time",
    "samples",
    "time of a sample",
    "error",
    "last error",
    "bias",
    "p",
]
"""Quantity of a strategy on a scene that is compared with a published number. ``slope``, ``error`` (at equal time) and
``last error`` (at the end of the runs) belong to the error curve. ``speed-up``, ``efficiency``, ``fewer samples`` and
``time of a sample`` are relative to the baseline. ``time`` and ``samples`` are those needed for an error. ``p`` is the
p-value of the test whether the expected image is the standard strategy's."""

Question = Literal["time", "bias", "samples", "efficiency", "combination"]
"""An experiment's question: ``time`` to an error, strategies with ``bias``, ``samples`` to an error, ``efficiency``
(the inverse of squared error times time), or ``combination``. The last asks how far the baseline, a combination of
techniques, is behind the better of its parts."""

_Counts = Annotated[tuple[Annotated[int, Field(ge=1, le=MOST_SAMPLES)], ...], Field(strict=False, min_length=1)]
DEFAULT_BUDGET = 10.0
MOST_REPEATS = 100_000

Positive = Annotated[int, Field(ge=1)]
Natural = Annotated[int, Field(ge=0)]
Seconds = Annotated[float, Field(gt=0.0, le=MOST_SECONDS)]
Error = Annotated[
    float,
    Field(gt=0.0),
    BeforeValidator(lambda value: error_of(value) if isinstance(value, str) else value),
    AfterValidator(check_fraction),
]
"""A relative error below 1, as a fraction, or as a text in per cent: 0.05 or ``"5%"``."""
Window = Annotated[tuple[Natural, Natural, Positive, Positive], Field(strict=False)]
Words = Annotated[str, Field(min_length=1)]
File = Annotated[Path, Field(strict=False)]


class Value(BaseModel):
    """Base class of settings: a pydantic model that is immutable and refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, arbitrary_types_allowed=True)


LEAST_CROP = 8
"""Shortest side, in pixels, of an enlarged window on a scene of its own size: fewer pixels do not show a detail."""


class SceneEntry(Value):
    """Entry of an experiment's ``scenes``: a scene, and settings that override the settings in its file."""

    path: File | None = None
    """Path of a scene file; in an experiment file, relative to the folder of that file."""
    scene: Scene | dict[str, Any] | None = None
    """The scene itself, instead of ``path``: loaded, or as a Mitsuba dictionary. A scene loaded from ``path`` stands
    beside it, so that its file is not read twice."""
    name: str = ""
    """Name of the scene in results and reports; by default the file's name without its suffix."""
    size: Annotated[tuple[Positive, Positive], Field(strict=False)] | None = None
    """Width and height of the film, in pixels; by default the scene's own."""
    max_depth: Annotated[int, Field(ge=-1)] | None = None
    crop: Window | None = None
    """Window to render, in pixels: x, y, width, height."""
    define: dict[str, Any] = Field(default_factory=dict)
    """Values for the variables of the scene file, by name."""
    substitute: bool = False
    """Whether to replace parts of the scene file that cannot be rendered, such as an unknown BSDF by a similar one."""
    crops: Annotated[tuple[Window, ...], Field(strict=False)] | None = None
    """Windows that the report shows enlarged, instead of the experiment's ``crops``: x, y, width, height.

    A window with a side below `LEAST_CROP` pixels is left out, and the report says so."""

    def load(self) -> Scene:
        """Return the scene, with the entry's size, crop and max_depth; raises SceneError for an invalid scene."""
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
    """Another renderer that takes part in an experiment: Mitsuba 3, or any command that writes an image file."""

    renderer: Literal["mitsuba"] | None = None
    variant: str | None = None
    """Mitsuba variant, such as ``llvm_ad_rgb``."""
    integrator: str | None = None
    sampler: str | None = None
    command: str | None = None
    """A command line in which ``{scene}``, ``{spp}``, ``{seed}`` and ``{out}`` are filled in for each render."""
    limit: Seconds | None = None
    """Longest time of one render, in seconds, before the renderer is ended.

    Default: 20 times the experiment's budget plus 60, or one hour if ``spp`` gives the counts. The default is never
    less than ``reference.seconds`` plus 60. Starting and loading have at least 30 minutes.
    """

    _duration = field_validator("limit", mode="before")(lambda value: _seconds(value))


@dataclass(frozen=True)
class _Origin:
    """Place of an entry in its file; ignored when entries are compared."""

    place: str = field(default="", compare=False)


class StrategyEntry(Value):
    """Entry of an experiment's ``strategies``: a strategy of equaltime, another renderer, or your own Python code."""

    label: str = ""
    """Name of the strategy in results and reports; by default the strategy's own text."""
    strategy: Strategy | None = None
    peer: Peer | None = None
    python: str | None = None
    """``FILE.py:NAME``: a function that takes the label and returns an object that renders, a
    `equaltime.rendering.core_subject.Subject`."""
    _origin: _Origin = PrivateAttr(default_factory=_Origin)

    @property
    def place(self) -> str:
        """File, line and keys at which the entry was read, ``FILE:LINE: strategies[N]``; empty if it was not read."""
        return self._origin.place

    def at(self, place: str) -> Self:
        """Return a copy of the entry with the place at which it was read, for error messages.

        ``place`` is text such as ``FILE:LINE: strategies[N]``.
        """
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
    """Wanted accuracy of references (precise images against which errors are measured), or an image to use as one."""

    error: Error = 0.005
    """Relative error at which rendering a reference stops (0.005 is 0.5 %)."""
    seconds: Seconds = 60.0
    """Longest time to render a reference, in seconds."""
    file: File | None = None
    """Image to use as the reference, for an experiment of one scene; standard errors in an EXR count as its noise."""

    _duration = field_validator("seconds", mode="before")(lambda value: _seconds(value))


class QuickWish(Value):
    """Settings of the quick version of an experiment (``--quick``): its scenes and strategies, and its time.

    The defaults suit most experiments: about 35 s in all with the report, on a machine with two processors.
    """

    scenes: Annotated[tuple[Words, ...], Field(strict=False)] = ()
    """Names of the scenes that the quick version renders; by default all."""
    strategies: Annotated[tuple[Words, ...], Field(strict=False)] = ()
    """Labels of the strategies that the quick version compares; by default all."""
    size: Positive = 96
    """Longest side of a film, in pixels; larger films are shrunk to it."""
    repeats: Annotated[int, Field(ge=1, le=MOST_REPEATS)] = 6
    """Largest number of repeats (renders of each strategy on each scene); 6 are the fewest that give an interval of a
    median."""
    seconds: Seconds = 18.0
    """Longest time of all runs together, in seconds; for experiments with a budget."""
    spp: Annotated[int, Field(ge=1, le=MOST_SAMPLES)] | None = None
    """Largest sample count of the experiment's ``spp`` that the quick version renders; by default it renders all."""
    reference: Seconds = 10.0
    """Longest time to render all references together, in seconds."""

    _duration = field_validator("seconds", "reference", mode="before")(lambda value: _seconds(value))

    def of(self, labels: Iterable[str], scenes: Iterable[str]) -> QuickWish:
        """Return a copy for some strategies and scenes: the lists lose all other labels and names.

        An experiment that is cut to fewer strategies or scenes needs this copy.
        """
        labels, scenes = set(labels), set(scenes)
        kept = {
            "strategies": tuple(label for label in self.strategies if label in labels),
            "scenes": tuple(scene for scene in self.scenes if scene in scenes),
        }
        return self.model_copy(update=kept)


class TheirNumber(Value):
    """One published number, and the quantity that the experiment measures to compare with it."""

    what: Words
    """Description, such as ``speed-up of light sampling over none``."""
    says: str = ""
    """Published value as printed, or the value that `Theirs.heading` names; empty without one."""
    ours: Quantity
    """Measured quantity that is compared with the published number."""
    strategy: Words
    """Label of the measured strategy."""
    scene: str = ""
    """Name of the scene; by default the first."""
    target: Error | None = None
    """Target error of a time to an error, one of the experiment's targets; by default the smallest with a trusted
    number."""


class Theirs(Value):
    """A published claim that an experiment tests, in equaltime's terms, with the figures that its authors published."""

    source: Words
    """Author or publication of the claim."""
    claim: Words
    figures: str = ""
    """All published figures in one sentence; empty if there are none."""
    heading: Words = "they say"
    """Heading of the column of ``says`` in the report, such as ``in closed form`` for values that no one published."""
    numbers: Annotated[tuple[TheirNumber, ...], Field(strict=False)] = ()

    def of(self, labels: Iterable[str], scenes: Iterable[str], targets: Iterable[float | None]) -> Theirs:
        """Return a copy of the claim with only the numbers on these strategies (by label) and scenes (by name).

        ``targets`` are the target errors of the experiment: numbers for other targets are left out.
        """
        labels, scenes, targets = set(labels), {"", *scenes}, {None, *targets}
        kept = tuple(
            number
            for number in self.numbers
            if number.strategy in labels and number.scene in scenes and number.target in targets
        )
        return self.model_copy(update={"numbers": kept})


class Experiment(Value):
    """Settings of an experiment, which compares strategies: strategies, scenes, budget, number of repeats and so on."""

    title: str = ""
    description: str = ""
    """Paragraph for students: the comparison, what to look for, and why."""
    theirs: Theirs | None = None
    """Published claim that the experiment tests, with its figures; the report shows measured numbers beside them."""
    scenes: Annotated[tuple[SceneEntry, ...], Field(strict=False, min_length=1)]
    strategies: Annotated[tuple[StrategyEntry, ...], Field(strict=False, min_length=1)]
    baseline: str = ""
    """Label of the strategy with which all others are compared; by default ``naive``, else the first other than
    ``best``."""
    budget: Seconds | None = None
    """Seconds of a run from its first sample to its end; 10 if neither this nor ``spp`` is given."""
    spp: _Counts | None = None
    """Samples per pixel at all checkpoints (moments at which errors are measured), instead of ``budget``."""
    counts: Mapping[str, Mapping[str, _Counts]] = {}
    """Samples per pixel at the checkpoints, by scene and label, of an earlier experiment that is to be repeated
    exactly.

    The budget gives the counts of strategies and scenes that are missing here.
    """
    repeats: Annotated[int, Field(ge=1, le=MOST_REPEATS)] = 8
    """Number of renders of each strategy on each scene, with different seeds; intervals come from their spread."""
    targets: Annotated[tuple[Error, ...], Field(strict=False)] = DEFAULT_TARGETS
    """Relative errors to which the report gives times (0.02 or ``"2%"``); one alone may stand without a list."""
    crops: Annotated[tuple[Window, ...], Field(strict=False)] = ()
    """Windows that the report shows enlarged: x, y, width, height."""
    figures: Annotated[tuple[Literal["directions"], ...], Field(strict=False)] = ()
    """Optional figures of the report; ``directions`` shows where uniform and BSDF sampling send rays on each scene."""
    animate: bool = False
    """Whether the report shows films of how the images converge, side by side at equal time."""
    question: Question = "time"
    """Question that the verdict answers: ``time`` to an error, ``bias``, ``samples``, ``efficiency`` or
    ``combination``.

    ``bias`` asks which strategies have another expected image than the standard strategy, which is ``best`` if that is
    unbiased. ``samples`` asks how many samples each strategy needs. ``efficiency`` asks by which factor squared error
    times time is below the baseline's, over all scenes. ``combination`` asks by which factor the baseline's squared
    error exceeds that of the better of its parts, on the worst scene. The parts are the strategies of one technique.
    """
    reference: ReferenceWish = ReferenceWish()
    quick: QuickWish = QuickWish()
    """Settings of the quick version of the experiment (``--quick``)."""
    threads: Annotated[int, Field(ge=0, le=MOST_THREADS)] = 0
    """Worker threads; 0 for one per processor."""

    folder: File = Path()
    """Folder in which commands of other renderers run; by default the folder of the experiment file."""

    _duration = field_validator("budget", mode="before")(lambda value: _seconds(value))

    @model_validator(mode="wrap")
    @classmethod
    def _check(cls, values: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """Fill in names and defaults, validate, and raise one `ExperimentError` with every problem."""
        values = _in_full(values) if isinstance(values, Mapping) else values
        problems = crossed(values) if isinstance(values, Mapping) else ()
        try:
            experiment = validate(_named(values) if isinstance(values, Mapping) else values)
        except ValidationError as error:
            raise ExperimentError((*explained(cls, error), *problems)) from None
        if problems:
            raise ExperimentError(problems)
        return experiment

    def replace(self, **changes: object) -> Experiment:
        """Return a copy of the experiment with some values changed; the values of the copy are checked again."""
        fields = {name: getattr(self, name) for name in self.model_fields_set}
        if {"budget", "spp"} & changes.keys():
            fields |= {"budget": None, "spp": None}
        changed = fields | changes
        labels = [name_of_strategy(entry) for entry in changed["strategies"]]
        scenes = [name_of_scene(entry, number) for number, entry in enumerate(changed["scenes"])]
        if "baseline" not in changes and self.baseline not in labels:
            changed["baseline"] = ""
        if "theirs" not in changes and self.theirs is not None:
            targets = Experiment.model_validate({**changed, "theirs": None}).targets
            changed["theirs"] = self.theirs.of(labels, scenes, targets)
        if "quick" in changed and "quick" not in changes:
            changed["quick"] = self.quick.of(labels, scenes)
        return Experiment.model_validate(changed)

    def load_scenes(self) -> tuple[Scene, ...]:
        """Return all scenes, read from their files; raises `ExperimentError` with the problems of all scenes."""
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


def _in_full(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with short forms written in full.

    A file's name among the scenes becomes a table with ``path``, and a text among the strategies a table with that text
    as label and as strategy. A single target becomes a list.
    """
    full = dict(values)
    if isinstance(scenes := values.get("scenes"), list | tuple):
        full["scenes"] = tuple({"path": one} if isinstance(one, str | PathLike) else one for one in scenes)
    if isinstance(strategies := values.get("strategies"), list | tuple):
        full["strategies"] = tuple(
            {"label": one, "strategy": one} if isinstance(one, str) else one for one in strategies
        )
    if isinstance(target := values.get("targets"), str | int | float):
        full["targets"] = (target,)
    return full


def _named(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with defaults for labels, baseline, scene names and budget, as far as they can be derived."""
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
