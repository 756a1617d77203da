"""Experiments as their folders record them, in ``experiment.json``: written there, and read again as a source.

The record holds the experiment of the last call, as its options changed it, with absolute paths. An experiment can so
be had again after its file has changed. Scenes and programs are recorded by their paths alone.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from equaltime.errors import ExperimentError, Problem
from equaltime.experiments.model.experiment import Experiment

__all__ = ["is_recorded", "read_recorded", "to_record"]


def to_record(experiment: Experiment) -> dict[str, Any]:
    """Return an experiment as JSON data, with absolute paths, and without the content of scenes made in Python."""
    content = {"scenes": {"__all__": {"scene"}}}
    values = experiment.model_dump(mode="json", exclude_none=True, exclude=content, fallback=str)
    values["folder"] = _absolute(values["folder"])
    for entries, key in ((values["scenes"], "path"), (values["strategies"], "python"), ([values["reference"]], "file")):
        for entry in entries:
            if key in entry:
                entry[key] = _absolute(entry[key])
    return values


def _absolute(path: str) -> str:
    return str(Path(path).absolute())


def is_recorded(path: Path) -> bool:
    """Tell whether a file is the record of an experiment: JSON with the table ``experiment``."""
    if path.suffix.lower() != ".json":
        return False
    try:
        return "experiment" in _content(path)
    except ExperimentError:
        return False


def read_recorded(path: Path) -> Experiment:
    """Read the experiment of a folder's ``experiment.json``.

    Raises
    ------
    ExperimentError
        If the file cannot be read or is damaged, or if a scene was made in Python, so that no file holds it.
    """
    values = _content(path).get("experiment")
    place = f"{path}: experiment"
    scenes = values.get("scenes") if isinstance(values, Mapping) else None
    for entry in scenes if isinstance(scenes, list) else ():
        if isinstance(entry, Mapping) and "path" not in entry:
            text = f"the scene {entry.get('name')} was made in Python, so that no file holds it; call et.cost with it"
            raise ExperimentError((Problem(f"{place}.scenes", text),))
    try:
        return Experiment.model_validate(values)
    except ExperimentError as error:
        found = (Problem(f"{place}.{p.place}" if p.place else place, p.message) for p in error.problems)
        raise ExperimentError(tuple(found)) from None


def _content(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ExperimentError((Problem(str(path), f"cannot be read: {error}"),)) from error
    if not isinstance(content, dict):
        raise ExperimentError((Problem(str(path), "expected a table"),))
    return content
