"""Reader of experiments from TOML; also makes experiments from a scene and options.

An experiment can continue the records in a folder only if both have the same identity (see `identity_of`).
"""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from equaltime.errors import EqualtimeError, ExperimentError, Problem, StrategyError
from equaltime.experiments.model.experiment import (
    Experiment,
    QuickWish,
    ReferenceWish,
    SceneEntry,
    StrategyEntry,
    Window,
)
from equaltime.experiments.model.recorded import is_recorded, read_recorded
from equaltime.experiments.model.sources import PROGRAM_FILES, program_files, sha256_of
from equaltime.extras import install
from equaltime.rendering.core_subject import Subject
from equaltime.scene import Scene
from equaltime.scene.changes import smaller_film
from equaltime.scene.toml_reader import line_numbers, malformed, nearest
from equaltime.strategy import PRESETS, Strategy
from equaltime.words import seconds_of

__all__ = [
    "DEFAULT_STRATEGIES",
    "DEPTH_WITHOUT_ROULETTE",
    "Source",
    "check_installed",
    "default_experiment",
    "ends_its_paths",
    "film_seed",
    "identity_of",
    "is_experiment",
    "make_experiment",
    "quicker",
    "read_experiment",
    "run_seeds",
    "split_strategies",
    "with_roulette",
]


def identity_of(
    experiment: Experiment, scenes: Sequence[Scene], subjects: Sequence[Subject], threads: int
) -> dict[str, Any]:
    """Return every setting that affects the records of an experiment, as JSON data.

    An experiment may be continued in a folder only if this identity is the same. ``scenes`` are its loaded scenes, and
    ``subjects`` the renderers of its strategies. Titles, targets, crops, the baseline and the number of repeats do not
    affect records, and may change between calls. Other renderers have the SHA-256 of the files of their programs
    (`sources.program_files`).
    """
    wish = experiment.reference
    return {
        "scenes": {
            entry.name: {
                "digest": scene.digest,
                "size": list(scene.size),
                "crop": list(scene.model.sensor.film.crop),
                "max_depth": scene.max_depth,
            }
            for entry, scene in zip(experiment.scenes, scenes, strict=True)
        },
        "strategies": {
            entry.label: {"renderer": subject.renderer, "name": subject.name, **_program(entry, experiment.folder)}
            for entry, subject in zip(experiment.strategies, subjects, strict=True)
        },
        "budget": experiment.budget,
        "spp": None if experiment.spp is None else list(experiment.spp),
        "reference": {
            "error": wish.error,
            "seconds": wish.seconds,
            "file": None if wish.file is None else _sha256(wish.file),
        },
        "threads": threads,
        **({"counts": experiment.model_dump(mode="json", include={"counts"})["counts"]} if experiment.counts else {}),
    }


def run_seeds(scene: str, strategy: str, repeats: int) -> tuple[int, ...]:
    """Return one seed for each repeat of a strategy on a scene.

    Seeds are distinct 31-bit numbers, which every renderer accepts. A seed is a hash of scene name, strategy label and
    number of the repeat. Adding strategies or repeats therefore changes no seed.
    """
    seeds: dict[int, None] = {}
    for repeat in range(repeats):
        seed, again = _hashed(scene, strategy, str(repeat)), 0
        while seed in seeds:
            again += 1
            seed = _hashed(scene, strategy, str(repeat), str(again))
        seeds[seed] = None
    return tuple(seeds)


def film_seed(scene: str, strategy: str) -> int:
    """Return the 31-bit seed of the separate run that shows how a strategy's image of a scene converges (its film)."""
    return _hashed(scene, strategy, "-1")


def _hashed(*words: str) -> int:
    """Return a 31-bit hash of words."""
    text = "\0".join(("equaltime cost", *words))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big") >> 1


def _program(entry: StrategyEntry, folder: Path) -> dict[str, Any]:
    """Return the SHA-256 of the files of an entry's program, as a part of the identity; empty without such files."""
    sums = {name: sha256_of(path) for name, path in program_files(entry, folder).items()}
    return {PROGRAM_FILES: sums} if sums else {}


def _sha256(path: Path) -> str:
    try:
        return sha256_of(path)
    except OSError as error:
        text = f"{path}: cannot be read: {error.strerror or error}"
        raise ExperimentError((Problem("reference.file", text),)) from error


DEFAULT_STRATEGIES: Final = ("naive", "bsdf", "light", "mis", "best")

# In a closed room a path without a depth limit goes on until its throughput underflows in float32: hundreds of bounces.
DEPTH_WITHOUT_ROULETTE: Final = 64
_QUICK_ERROR: Final = 0.01
"""Error at which a quick experiment's reference is good enough, if the experiment asks for none."""


def is_experiment(path: Path, unreadable: bool = False) -> bool:
    """Tell whether a file is an experiment, and not a scene: a TOML file with a list of scenes or of strategies.

    The ``experiment.json`` of a folder is one, too. The value of ``unreadable`` is returned for a TOML file that cannot
    be read.
    """
    if path.suffix.lower() != ".toml":
        return is_recorded(path)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return unreadable  # the reader that is called next reports the problem with its line
    return any(isinstance(table.get(key), list) for key in ("scenes", "strategies"))


def read_experiment(path: Path) -> Experiment:
    """Read an experiment from a TOML file; paths in the file are relative to its folder.

    Raises
    ------
    ExperimentError
        With every problem: file, line, path of keys and message.
    """
    text = ""
    try:
        text = path.read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
    except OSError as error:
        raise ExperimentError((Problem(str(path), f"cannot be read: {error.strerror or error}"),)) from error
    except tomllib.TOMLDecodeError as error:
        number, message = malformed(error, text)
        raise ExperimentError((Problem(f"{path}:{number}", message),)) from error
    except (ValueError, RecursionError) as error:
        raise ExperimentError((Problem(str(path), f"not well-formed TOML: {error}"),)) from error
    lines = line_numbers(text)
    try:
        experiment = Experiment.model_validate(_located(table, path.parent))
        places = (_place(path, f"strategies[{number}]", lines) for number in range(len(experiment.strategies)))
        return experiment.replace(strategies=tuple(map(StrategyEntry.at, experiment.strategies, places)))
    except ExperimentError as error:
        problems = (*error.problems, *_missing_scenes(table, path.parent))
        found = sorted(problems, key=lambda problem: nearest(lines, problem.place) or 0)
        raise ExperimentError(tuple(Problem(_place(path, p.place, lines), p.message) for p in found)) from None


def _missing_scenes(table: Mapping[str, Any], folder: Path) -> Iterator[Problem]:
    """Find scene files that do not exist, to be told with the other problems of an experiment in ``folder``."""
    scenes = table.get("scenes")
    for number, entry in enumerate(scenes if isinstance(scenes, list) else ()):
        short = isinstance(entry, str)
        name = entry.get("path") if isinstance(entry, Mapping) else entry
        if isinstance(name, str) and not os.path.exists(folder / name):
            yield Problem(f"scenes[{number}]{'' if short else '.path'}", f"there is no such file: {folder / name}")


def _place(path: Path, keys: str, lines: Mapping[str, int]) -> str:
    """Return ``FILE:LINE: KEYS``, without the parts that are unknown."""
    line = nearest(lines, keys)
    file = str(path) if line is None else f"{path}:{line}"
    return f"{file}: {keys}" if keys else file


def _located(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the table with its paths made relative to the working directory."""
    scenes, strategies, reference = (table.get(key) for key in ("scenes", "strategies", "reference"))
    given = table.get("folder", "")
    located = {**table, "folder": str(folder / given) if isinstance(given, str) else given}
    if isinstance(scenes, list):
        located["scenes"] = [_join({"path": one} if isinstance(one, str) else one, "path", folder) for one in scenes]
    if isinstance(strategies, list):
        located["strategies"] = [_join(_file_of_strategy(entry, folder), "python", folder) for entry in strategies]
    if reference is not None:
        located["reference"] = _join(reference, "file", folder)
    return located


def _join(entry: object, key: str, folder: Path) -> object:
    if isinstance(entry, Mapping) and isinstance(entry.get(key), str):
        return {**entry, key: str(folder / entry[key])}
    return entry


def _file_of_strategy(entry: object, folder: Path) -> object:
    if isinstance(entry, str) and entry.endswith(".toml"):
        return {"label": Path(entry).stem, "strategy": str(folder / entry)}
    if isinstance(entry, Mapping) and isinstance(text := entry.get("strategy"), str) and text.endswith(".toml"):
        return {"label": Path(text).stem, **entry, "strategy": str(folder / text)}
    return entry


def default_experiment(scene: SceneEntry, strategies: tuple[str, ...] = ()) -> Experiment:
    """Return the default experiment for a scene: the presets from naive to best, or the strategies given.

    Raises
    ------
    SceneError, ExperimentError
        If the scene or a strategy cannot be read.
    """
    loaded = scene.load()
    given = strategies or tuple(name for name in DEFAULT_STRATEGIES if name in PRESETS)
    entry = scene.model_copy(update={"scene": loaded, "size": None, "crop": None, "max_depth": None})
    name = scene.name or (loaded.source.stem if loaded.source else "scene")
    return Experiment(
        title=f"What accuracy costs on {name}",
        description=(
            "Each strategy renders the same scene several times, and each run has the same time. The curves show how "
            "the root mean square of the runs' errors falls, and dotted lines the errors whose times the tables give."
        ),
        scenes=(entry.model_copy(update={"name": name}),),
        strategies=tuple(_suited(text, loaded) for text in given),
    )


def _suited(text: str, scene: Scene) -> StrategyEntry:
    """Return the strategy; a preset without roulette gets one if its paths would have no end."""
    try:
        entry = StrategyEntry(label=text, strategy=text)  # type: ignore[arg-type]  # the validator reads it
    except ValueError as error:
        raise ExperimentError((Problem("strategies", str(error)),)) from None
    if text not in PRESETS or entry.strategy is None:
        return entry
    return entry.model_copy(update={"strategy": with_roulette(entry.strategy, scene)})


def with_roulette(strategy: Strategy, scene: Scene) -> Strategy:
    """Return the strategy, with Russian roulette added if the scene's ``max_depth`` is unlimited or above 64.

    Paths of such a scene would hardly end without roulette. A strategy that already has roulette is returned unchanged.
    """
    if ends_its_paths(strategy, scene.max_depth):
        return strategy
    return strategy.model_copy(update={"roulette": "throughput"})


def ends_its_paths(strategy: Strategy, max_depth: int) -> bool:
    """Tell whether a strategy's paths end soon: by roulette, or by a limit ``max_depth`` of 64 or less (-1: none)."""
    return strategy.roulette != "none" or 0 <= max_depth <= DEPTH_WITHOUT_ROULETTE


def quicker(experiment: Experiment) -> Experiment:
    """Return the quick version of the experiment, within the limits that its field ``quick`` sets.

    With a time budget, the quick version of a small experiment ends in under a minute. Films shrink, and enlarged
    windows with them, unless the reference is a file, whose size is fixed. Budgets shrink until all runs together take
    ``quick.seconds``. Sample counts (``spp``) above ``quick.spp`` are left out. References end at the error that the
    experiment asks for, else at 1 %, or when their time is over.
    """
    quick, wish = experiment.quick, experiment.reference
    scenes = tuple(entry for entry in experiment.scenes if not quick.scenes or entry.name in quick.scenes)
    strategies = tuple(
        entry for entry in experiment.strategies if not quick.strategies or entry.label in quick.strategies
    )
    repeats = min(experiment.repeats, quick.repeats)
    ladder: dict[str, object] = {}
    if experiment.spp is None:
        share = quick.seconds / (repeats * len(scenes) * len(strategies))
        ladder["budget"] = min(experiment.budget or quick.seconds, share)
    elif quick.spp is not None:
        ladder["spp"] = tuple(count for count in experiment.spp if count <= quick.spp) or experiment.spp[:1]
    seconds = min(wish.seconds, quick.reference / len(scenes))
    own = wish.error if "error" in wish.model_fields_set else None
    return experiment.replace(
        scenes=scenes
        if wish.file is not None
        else tuple(_smaller(entry, quick.size, experiment.crops) for entry in scenes),
        strategies=strategies,
        repeats=repeats,
        reference=ReferenceWish(error=own or _QUICK_ERROR, seconds=seconds, file=wish.file),
        quick=QuickWish(),  # which is done
        **ladder,
    )


def _smaller(entry: SceneEntry, longest: int, crops: Sequence[Window]) -> SceneEntry:
    """Return a scene whose film has no side above ``longest`` pixels; its enlarged windows shrink with it.

    ``crops`` are the windows of the experiment.
    """
    film = entry.load().model.sensor.film
    scale = longest / max(film.crop[2:])
    if scale >= 1.0:
        return entry
    size, crop = smaller_film((film.width, film.height), film.crop, scale)
    shown = tuple(_scaled(window, scale) for window in (crops if entry.crops is None else entry.crops))
    return entry.model_copy(update={"size": size, "crop": crop, "crops": shown or None})


def _scaled(window: Window, scale: float) -> Window:
    x, y, width, height = (round(scale * length) for length in window)
    return x, y, max(width, 1), max(height, 1)


Source = Experiment | Scene | str | os.PathLike[str] | Mapping[str, Any]
"""An experiment, a scene, or a file of either; a mapping is a scene with Mitsuba's keys."""


def make_experiment(
    source: Source,
    *,
    quick: bool = False,
    size: tuple[int, int] | None = None,
    budget: float | str | None = None,
    repeats: int | None = None,
    threads: int | None = None,
    targets: Sequence[float | str] | float | str | None = None,
    strategies: Sequence[str] = (),
    define: Mapping[str, object] | None = None,
    substitute: bool = False,
    counts: Mapping[str, Mapping[str, Sequence[int]]] | None = None,
) -> Experiment:
    """Return the experiment that ``source`` describes; the options override values of the file.

    Parameters
    ----------
    quick
        Whether to shrink the experiment so that it ends in under a minute for one scene.
    size
        Width and height of the films, in pixels.
    budget
        Seconds of each run, or text such as ``"10s"``.
    repeats, threads
        Number of renders of each strategy on each scene, and of worker threads; 0 threads stand for one per processor.
    targets
        Relative errors to which times are given: fractions, or texts in per cent.
    strategies
        Labels of the experiment's strategies, or texts for `Strategy.parse`.
    define
        Values for the variables of a scene file.
    substitute
        Whether to replace the parts of a scene file that cannot be rendered.
    counts
        Samples per pixel at the checkpoints of earlier runs, by scene and label, to be taken instead of the budget's.

    Raises
    ------
    ExperimentError, SceneError
        If a file cannot be read or a value is invalid.
    """
    experiment = _experiment(source, tuple(strategies), {"define": dict(define or {}), "substitute": substitute})
    if quick:
        experiment = quicker(experiment)
    changes: dict[str, object] = {}
    if size is not None:
        update = {"size": size, "crop": None, "crops": None}
        changes["scenes"] = tuple(entry.model_copy(update=update) for entry in experiment.scenes)
        changes["crops"] = ()
    if budget is not None:
        changes["budget"] = seconds_of(budget) if isinstance(budget, str) else float(budget)
    if counts is not None:
        changes["counts"] = _shared(counts, experiment)
    for name, value in (("repeats", repeats), ("threads", threads), ("targets", targets)):
        if value is not None:
            changes[name] = value
    return experiment.replace(**changes) if changes else experiment


def _shared(
    counts: Mapping[str, Mapping[str, Sequence[int]]], experiment: Experiment
) -> dict[str, dict[str, Sequence[int]]]:
    """Return the counts of the scenes and strategies that the experiment has.

    Raises
    ------
    ExperimentError
        If the experiment has none of them.
    """
    labels = {entry.label for entry in experiment.strategies}
    found = {
        entry.name: kept
        for entry in experiment.scenes
        if (kept := {label: count for label, count in counts.get(entry.name, {}).items() if label in labels})
    }
    if not found:
        there = "; ".join(f"{', '.join(of)} on {name}" for name, of in counts.items())
        raise ExperimentError((Problem("counts", f"the earlier experiment has no run of this one, only {there}"),))
    return found


def check_installed() -> None:
    """Raise EqualtimeError if a package is not installed that the report will need after the runs."""
    missing = [name for name in ("flip_evaluator", "matplotlib", "jinja2") if find_spec(name) is None]
    if missing:
        raise EqualtimeError(f"this needs the packages {', '.join(missing)}: {install('report')}")


def split_strategies(text: str) -> tuple[str, ...]:
    """Split text such as ``naive,best,heuristic=balance,mis`` into the texts of strategies.

    An item with ``=`` belongs to the strategy before it: here ``naive``, ``best,heuristic=balance`` and ``mis``.
    """
    strategies: list[str] = []
    for part in text.split(","):
        if "=" in part and strategies:
            strategies[-1] += f",{part.strip()}"
        else:
            strategies.append(part.strip())
    return tuple(strategies)


def _experiment(source: Source, strategies: tuple[str, ...], options: dict[str, object]) -> Experiment:
    if isinstance(source, Scene):
        return default_experiment(SceneEntry(scene=source), strategies)
    if isinstance(source, Mapping):
        return default_experiment(SceneEntry(scene=dict(source)), strategies)
    if not isinstance(source, Experiment):
        path = Path(source)
        if not is_experiment(path):
            return default_experiment(SceneEntry.model_validate({"path": path, **options}), strategies)
        if any(options.values()):
            problem = "definitions belong to scenes: write them in the experiment, and substitute too"
            raise ExperimentError((Problem(str(path), problem),))
        source = read_recorded(path) if is_recorded(path) else read_experiment(path)
    return _chosen(source, strategies) if strategies else source


def _chosen(experiment: Experiment, strategies: tuple[str, ...]) -> Experiment:
    """Return the experiment with the strategies of these labels; other texts are read as new strategies."""
    present = {entry.label: entry for entry in experiment.strategies}
    chosen, problems = [], []
    for text in strategies:
        try:
            chosen.append(present.get(text) or StrategyEntry(label=text, strategy=Strategy.parse(text)))
        except StrategyError as error:
            labels = ", ".join(present)
            problems.append(Problem("strategies", f"{error}; the experiment has {labels}"))
    if problems:
        raise ExperimentError(tuple(problems))
    return experiment.replace(strategies=tuple(chosen))
