"""Makes the experiment from a user's input: a scene, an experiment, a file of either, and options."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from equaltime.errors import EqualtimeError, ExperimentError, Problem, StrategyError
from equaltime.experiments.model.experiment import Experiment, SceneEntry, StrategyEntry
from equaltime.experiments.model.reader import default_experiment, is_experiment, quicker, read_experiment
from equaltime.scene import Scene
from equaltime.strategy import Strategy
from equaltime.words import seconds_of

__all__ = ["Source", "check_installed", "make_experiment", "split_strategies"]

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
    strategies: Sequence[str] = (),
    define: Mapping[str, object] | None = None,
    substitute: bool = False,
) -> Experiment:
    """Return the experiment; options given here override the file's.

    Parameters
    ----------
    strategies
        Labels of the experiment's strategies, or texts for `Strategy.parse`.
    define
        Variables of a scene file.
    substitute
        Replace the parts of a scene file that cannot be rendered.

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
        update = {"size": size, "crop": None}
        changes["scenes"] = tuple(entry.model_copy(update=update) for entry in experiment.scenes)
        changes["crops"] = ()
    if budget is not None:
        changes["budget"] = seconds_of(budget) if isinstance(budget, str) else float(budget)
    for name, value in (("repeats", repeats), ("threads", threads)):
        if value is not None:
            changes[name] = value
    return experiment.replace(**changes) if changes else experiment


def check_installed() -> None:
    """Raise EqualtimeError if the report needs a missing package, before the first run."""
    missing = [name for name in ("scipy", "flip_evaluator", "matplotlib", "jinja2") if find_spec(name) is None]
    if missing:
        raise EqualtimeError(f"this needs the packages {', '.join(missing)}: pip install equaltime[report]")


def split_strategies(text: str) -> tuple[str, ...]:
    """Split ``naive,best,heuristic=balance,mis`` into strategies; a part with ``=`` belongs to the one before it."""
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
        source = read_experiment(path)
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
