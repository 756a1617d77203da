"""Summaries of experiments for ``equaltime info``: of a folder that ``equaltime cost`` made, and of a file."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from equaltime.cli.cost_table import every_row, legend
from equaltime.cli.recorded import shown_path
from equaltime.experiments.model.experiment import Experiment, StrategyEntry
from equaltime.experiments.model.plan import planned, planned_runs, planned_seconds
from equaltime.experiments.model.reader import quicker
from equaltime.experiments.model.recorded import is_recorded
from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.report.telling import is_quick
from equaltime.experiments.report.words import error_cell, worker_runs
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.stored import StoredExperiment
from equaltime.scene import Scene
from equaltime.statistics.intervals import sound, sound_below
from equaltime.strict_json import json_text, to_json
from equaltime.words import duration, percent

__all__ = [
    "experiment_facts",
    "experiment_summary",
    "experiment_table",
    "folder_facts",
    "folder_summary",
    "folder_table",
    "verdicts",
]

_MOST_NAMES = 6
_THIN = "\N{NARROW NO-BREAK SPACE}"
_MEASURED_ON = {"machines": ("cpu",), "builds": ("version", "compiler", "target", "embree", "embree_isa")}


_BEFORE = {"embree": "Embree ", "embree_isa": "which takes "}
"""Words before a fact that does not tell itself."""


def folder_summary(stored: StoredExperiment, verbose: bool = False) -> Iterator[str]:
    """Yield lines on a folder's experiment: the verdict, then at most ten lines on its scenes, runs and commands.

    ``verbose`` tells that `folder_table` follows, so that no line mentions ``-v``.
    """
    summary, experiment, done = stored.summary, stored.experiment, len(stored.runs)
    yield _verdict(stored)
    look = " (a first look, --quick)" if is_quick(summary) else ""
    yield f"experiment  {experiment.title or stored.folder.resolve().name}{look}"
    names = [entry.name for entry in experiment.scenes]
    yield f"scenes      {_listed(names)}{_size(stored.identity['scenes'][name] for name in names)}"
    yield f"strategies  {_strategies(experiment)}{'' if verbose else '; -v for more'}"
    if summary.scenes:
        yield f"error       {_errors(summary)}"
    runs = f"all {_many(done, 'run')}" if stored.complete else f"{done} of {stored.planned} runs, not complete"
    yield f"ran         {runs}" + (
        f", {duration(stored.seconds)} of rendering, begun {stored.begun[:10]}" if done else ""
    )
    if stored.earlier:
        yield f"earlier     records of {_listed(stored.earlier)} remain that the last command did not ask for"
    if machines := _measured_on(summary, "machines"):
        yield f"machine     {machines}, {_many(stored.identity.get('threads', 0), 'thread')}"
    if builds := _measured_on(summary, "builds"):
        yield f"build       equaltime {builds}"
    if verbose and (revisions := stored.revisions):
        yield f"commit      {'; '.join(revisions)}"
    yield _command(stored)
    if stored.changes:
        yield f"changed     {_changes(stored)}"
    yield f"report      equaltime open {shlex.quote(str(stored.folder))}"


def _verdict(stored: StoredExperiment) -> str:
    if not stored.runs:
        return f"{stored.folder}: no run of this experiment is finished"
    return stored.summary.verdict


def _command(stored: StoredExperiment) -> str:
    """Return a line with the command that goes on with the experiment, or repeats it in another folder.

    If files have changed since, it takes the folder's record of the experiment.
    """
    name = "repeat" if stored.complete else "go on"
    return f"{name:<12}{_from_record(stored) or _last(stored)}"


def _last(stored: StoredExperiment) -> str:
    """Return the last of the commands that made the experiment, or the call in Python.

    If the experiment is complete, its results go to another folder. If the command was given in another directory, it
    begins with a change to it.
    """
    if not stored.commands and stored.call:
        return _in_python(stored)
    if not stored.commands:
        return "with the call that made it: the folder does not record a command"
    last, others = stored.commands[-1], len(stored.commands) - 1
    before = f" (and {_many(others, 'command')} before; see -v)" if others else ""
    command = _elsewhere(last) if stored.complete else last
    if stored.directory not in (None, Path.cwd()):
        command = f"cd {shlex.quote(str(stored.directory))} && {command}"
    return f"{command}{before}"


def _from_record(stored: StoredExperiment) -> str:
    """Return the command that takes the folder's record of an experiment whose files have changed.

    The text is empty if none has changed, or if the record cannot be taken: if objects of Python were given.
    """
    if not stored.changes or (not stored.commands and _source(stored) in _OBJECTS):
        return ""
    return _of_record(ExperimentFolder(stored.folder).experiment, stored.complete)


def _of_record(record: Path, complete: bool) -> str:
    """Return the command that takes the file ``experiment.json`` of a folder, and another folder if it is complete."""
    folder = record.parent if record.parent.name not in ("", "..") else record.parent.resolve()
    command = f"equaltime cost {shlex.quote(str(record))} -o {shlex.quote(str(folder))}"
    return _elsewhere(command) if complete else command


_OBJECTS = {"scene": "the same scene or dict, which no file holds,", "experiment": "the same experiment"}
"""First argument of a call of ``et.cost`` that is no path, and what it stands for."""


def _source(stored: StoredExperiment) -> str:
    """Return the first argument of the call of ``et.cost``."""
    return stored.call.removeprefix("et.cost(").partition(",")[0]


def _in_python(stored: StoredExperiment) -> str:
    """Return the call in Python that repeats the experiment, or goes on with it, and the objects that it needs."""
    source = _source(stored)
    needs = [_OBJECTS[source]] if source in _OBJECTS else []
    needs.append("another folder" if stored.complete else "the same folder")
    if source not in _OBJECTS and stored.directory not in (None, Path.cwd()):
        needs.append(f"in {stored.directory}")
    return f"in Python, with {' and '.join(needs)}: {stored.call}"


def _changes(stored: StoredExperiment) -> str:
    """Return a sentence on the files that have changed or are gone since the last command, and on that command."""
    told = [
        f"{shown_path(path)} {'has changed' if state == 'changed' else 'is gone'}"
        for path, state in stored.changes.items()
    ]
    more = f" and {len(told) - _MOST_NAMES} more" if len(told) > _MOST_NAMES else ""
    changed = f"{', '.join(told[:_MOST_NAMES])}{more} since the last command"
    if not _from_record(stored):
        return f"{changed}, which may now give another experiment"
    name = "repeat" if stored.complete else "go on"
    return (
        f"{changed}; `{name}` takes the experiment as it was, with scenes and programs as they are now. The last "
        f"command may now give another experiment: {_last(stored)}"
    )


def _elsewhere(command: str) -> str:
    """Return a command of ``cost`` with another folder for its results: in the same folder it repeats nothing."""
    words = shlex.split(command)
    for number, word in enumerate(words):
        if word in ("-o", "--output") and number + 1 < len(words):
            words[number + 1] = f"{words[number + 1].rstrip('/')}-again"
        elif word.startswith(("--output=", "-o")):
            words[number] = f"{word.rstrip('/')}-again"
    return shlex.join(words)


def _measured_on(summary: Summary, section: str) -> str:
    """Return the main facts of the machines or builds on which the runs were made."""
    found = summary.provenance.get(section, {}).values()
    told = (
        ", ".join(f"{_BEFORE.get(name, '')}{facts[name]}" for name in _MEASURED_ON[section] if name in facts)
        for facts in found
    )
    return "; ".join(dict.fromkeys(told))


def _errors(summary: Summary) -> str:
    """Return the error that each strategy reached; on several scenes, the smallest and the largest."""
    budgets = {scene.budget_s for scene in summary.scenes}
    after = f"after {duration(*budgets)}" if len(budgets) == 1 else "at equal time"
    several = f" on {len(summary.scenes)} scenes" if len(summary.scenes) > 1 else ""
    found: dict[str, list[StrategyResult]] = {}
    for scene in summary.scenes:
        for result in scene.strategies:
            found.setdefault(result.label if several else result.named, []).append(result)
    apart = "; some runs ended earlier or later" * any(scene.other_ends or scene.late for scene in summary.scenes)
    most = list(found.items())[:_MOST_NAMES]
    more = f" and {len(found) - len(most)} more" if len(most) < len(found) else ""
    return f"{after}{several}: {', '.join(f'{label} {_reached(results)}' for label, results in most)}{more}{apart}"


def _reached(results: Sequence[StrategyResult]) -> str:
    """Return the error of a strategy on one scene, or the smallest and the largest of its errors on several scenes.

    Errors of which only the lower end is known stand apart, with that end, after ``at least``.
    """
    errors = [result.error_at_budget for result in results]
    if len(errors) == 1:
        (error,) = errors
        return str(error_cell(error)).replace(_THIN, " ") + " extrapolated" * (error.trusted and error.reach > 1.0)
    known = [error.value for error in errors if sound(error)]
    limits = [error.low for error in errors if not sound(error) and sound_below(error)]
    told = " and ".join((*_ends(known), *(f"at least {ends}" for ends in _ends(limits))))
    unknown = len(errors) - len(known) - len(limits)
    return f"{told} (not trusted on {unknown} of them)" if told and unknown else told or "not trusted"


def _ends(errors: Sequence[float]) -> list[str]:
    """Return the smallest and the largest of some errors in one text; none without errors."""
    return [" to ".join(dict.fromkeys((percent(min(errors)), percent(max(errors)))))] if errors else []


def folder_table(stored: StoredExperiment) -> Iterator[Table | str]:
    """Yield the description of a folder's experiment, the table of all errors and times, and what made them.

    These are the defines of scenes, the strategies in full, what they decided by themselves, and all commands. The runs
    of each worker of a cluster stand before the commands.
    """
    if stored.experiment.description:
        yield stored.experiment.description.strip()
    yield (table := every_row(stored.summary))
    if stored.summary.scenes:
        yield "\n".join(legend(stored.summary, table))
    if told := _defines(stored.experiment):
        yield told
    if stored.strategies_in_full:
        yield "\n".join(f"{label}: {words}" for label, words in stored.strategies_in_full.items())
    if decided := [f"{scene.name}: {scene.decisions}" for scene in stored.summary.scenes if scene.decisions]:
        yield "\n".join(decided)
    if workers := worker_runs(stored.summary):
        yield "\n".join(f"{address} on {runs}" for address, runs in workers.items())
    yield "\n".join(stored.commands)


def folder_facts(stored: StoredExperiment) -> dict[str, Any]:
    """Return the data of a folder's experiment for ``info --json``: its results, and how many runs are finished."""
    return {
        **to_json(stored.summary),
        "verdict": _verdict(stored),
        "folder": str(stored.folder),
        "defines": {entry.name: entry.define for entry in stored.experiment.scenes if entry.define},
        "complete": stored.complete,
        "runs": len(stored.runs),
        "planned_runs": stored.planned,
        "earlier": list(stored.earlier),
        "seconds": stored.seconds,
        "commands": list(stored.commands),
        "changes": [{"path": str(path), "state": state} for path, state in stored.changes.items()],
    }


def verdicts(folder: Path, found: Sequence[StoredExperiment]) -> Iterator[str]:
    """Yield a line with the verdict of each experiment in the subfolders of a folder, and which commands show more."""
    for stored in found:
        yield f"{stored.folder.name}: {_verdict(stored)}{'' if stored.complete else ' (not complete)'}"
    one, whole = (shlex.quote(str(path)) for path in (found[0].folder, folder))
    yield f"More of one: equaltime info {one}; all of them: equaltime open {whole}"


def experiment_summary(
    path: Path, experiment: Experiment, scenes: Sequence[Scene], verbose: bool = False
) -> Iterator[str]:
    """Yield at most ten lines on the experiment file ``path``: its runs, how long these take, and how to run it.

    ``verbose`` tells that `experiment_table` follows, so that no line mentions ``-v``.
    """
    yield f"{path}: {planned(experiment)}"
    if experiment.title:
        yield f"experiment  {experiment.title}"
    yield f"scenes      {_listed(entry.name for entry in experiment.scenes)}{_size(map(_film, scenes))}"
    yield f"strategies  {_strategies(experiment)}{'' if verbose else '; -v for more'}"
    yield f"repeats     {experiment.repeats} of each strategy on each scene"
    if experiment.question == "time":
        yield f"times       to errors of {', '.join(map(percent, sorted(experiment.targets, reverse=True)))}"
    if experiment.theirs is not None:
        yield f"claim       {experiment.theirs.source}: {experiment.theirs.claim}"
    recorded = is_recorded(path)
    if not (recorded and _was_quick(path.parent)):
        yield f"--quick     {planned(quicker(experiment))}"
    run = f"equaltime cost {shlex.quote(str(path))} -o {shlex.quote(path.stem)}"
    yield f"run         {_of_record(path, complete=True) if recorded else run}"


def _was_quick(folder: Path) -> bool:
    """Tell whether the experiment in a folder was made with ``--quick``, so that its record is the quick version."""
    place = ExperimentFolder(folder)
    if not (place.experiment.exists() and place.records.exists()):
        return False
    stored = StoredExperiment.read(folder)
    return any("--quick" in shlex.split(command) for command in stored.commands) or "quick=True" in stored.call


def experiment_table(experiment: Experiment) -> Iterator[Table | str]:
    """Yield the description of an experiment, a table with its strategies in full, and the defines of its scenes."""
    if experiment.description:
        yield experiment.description.strip()
    table = Table(show_header=False, box=None)
    for entry in experiment.strategies:
        table.add_row(entry.label, _in_full(entry))
    yield table
    if told := _defines(experiment):
        yield told


def _defines(experiment: Experiment) -> str:
    """Return a line for each scene whose file gets values for its variables, with these values; empty without any."""
    return "\n".join(
        f"{entry.name}: {', '.join(f'{name} = {json_text(value)}' for name, value in entry.define.items())}"
        for entry in experiment.scenes
        if entry.define
    )


def experiment_facts(path: Path, experiment: Experiment, scenes: Sequence[Scene]) -> dict[str, Any]:
    """Return the data of an experiment file: its settings, the number of runs, and the seconds that they take."""
    entries = zip(experiment.scenes, scenes, strict=True)
    quick = quicker(experiment)
    return {
        "experiment": str(path),
        "title": experiment.title,
        "description": experiment.description,
        "question": experiment.question,
        "scenes": [
            {
                "name": entry.name,
                "path": str(scene.source),
                **_film(scene),
                "max_depth": scene.max_depth,
                **({"define": entry.define} if entry.define else {}),
            }
            for entry, scene in entries
        ],
        "strategies": [{"label": entry.label, "name": _in_full(entry)} for entry in experiment.strategies],
        "baseline": experiment.baseline,
        "budget": experiment.budget,
        "spp": to_json(experiment.spp),
        "repeats": experiment.repeats,
        "targets": to_json(experiment.targets),
        "reference": to_json(experiment.reference),
        "theirs": to_json(experiment.theirs),
        "runs": planned_runs(experiment),
        "seconds": planned_seconds(experiment),
        "quick": {"runs": planned_runs(quick), "seconds": planned_seconds(quick)},
    }


def _in_full(entry: StrategyEntry) -> str:
    """Return the full text of a strategy, the command of another renderer, or its name with its words."""
    if entry.strategy is not None:
        return entry.strategy.name
    if entry.peer is None:
        return str(entry.python)
    words = (entry.peer.command, entry.peer.renderer, entry.peer.variant, entry.peer.integrator, entry.peer.sampler)
    return " ".join(filter(None, words))


def _film(scene: Scene) -> dict[str, Any]:
    return {"size": list(scene.size), "crop": list(scene.model.sensor.film.crop)}


def _strategies(experiment: Experiment) -> str:
    labels = [entry.label for entry in experiment.strategies]
    return _listed(labels) + (f"; compared with {experiment.baseline}" if len(labels) > 1 else "")


def _listed(names: Iterable[str]) -> str:
    """Return names, the first few of many, after their number if there are several."""
    names = list(names)
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    number = f"{len(names)}: " if len(names) > 1 else ""
    return f"{number}{', '.join(names[:_MOST_NAMES])}{more}"


def _size(films: Iterable[Mapping[str, Any]]) -> str:
    """Return the size in pixels of the rendered windows, if all scenes have one."""
    sizes = {tuple(film["crop"][2:]) for film in films}
    return f", {'x'.join(map(str, *sizes))} pixels" if len(sizes) == 1 else ""


def _many(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'s' * (number != 1)}"
