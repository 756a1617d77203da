"""Scenes and subjects of an experiment. A subject renders with a strategy, a peer (another renderer) or your code."""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from equaltime.errors import ExperimentError, Problem
from equaltime.experiments.model.experiment import Experiment, Peer, StrategyEntry
from equaltime.experiments.model.problems import unfit_character
from equaltime.rendering.core_subject import CoreSubject, Subject
from equaltime.scene import Scene

__all__ = ["close_subjects", "make_subjects", "scenes_of"]

_LOG = logging.getLogger(__name__)


def scenes_of(experiment: Experiment) -> tuple[Scene, ...]:
    """Return the scenes of an experiment in order, read from their files.

    If the experiment has a peer (another renderer), the scenes get a box filter, the only filter that all renderers
    treat alike.
    """
    scenes = experiment.load_scenes()
    if not any(entry.peer for entry in experiment.strategies):
        return scenes
    from equaltime.experiments.peers.common import with_box_filter

    return tuple(map(with_box_filter, scenes))


def make_subjects(experiment: Experiment) -> tuple[Subject, ...]:
    """Return one subject (an object that renders) for each strategy of an experiment, in order.

    Raises ExperimentError with all problems, such as names that a record cannot hold. A renderer that is not installed
    is reported later, when the renderer is prepared for a scene. If one file of several strategies cannot be imported,
    that is one problem.
    """
    subjects: list[Subject] = []
    problems: list[Problem] = []
    for number, entry in enumerate(experiment.strategies):
        try:
            subjects.append(_checked(_subject(entry, experiment), entry.label))
        except ExperimentError as error:
            place = entry.place or f"strategies[{number}]"
            told = {problem.message for problem in problems}
            problems += [Problem(f"{place}.{p.place}", p.message) for p in error.problems if p.message not in told]
    if problems:
        raise ExperimentError(tuple(problems))
    return tuple(subjects)


def close_subjects(subjects: Sequence[Subject]) -> None:
    """Call ``close`` of all subjects (objects that render) that have this method, which ends their processes."""
    for subject in subjects:
        if close := getattr(subject, "close", None):
            close()


def _subject(entry: StrategyEntry, experiment: Experiment) -> Subject:
    if entry.strategy is not None:
        return CoreSubject(entry.label, entry.strategy)
    if entry.peer is not None:
        return _peer(entry.label, entry.peer, experiment)
    assert entry.python is not None, "a checked entry has one of the three"
    return _own(entry.label, entry.python)


def _peer(label: str, peer: Peer, experiment: Experiment) -> Subject:
    """Return another renderer; without a limit of its own it has the limit of `time_limit`."""
    from equaltime.experiments.peers.command import CommandPeer
    from equaltime.experiments.peers.mitsuba import MitsubaPeer
    from equaltime.experiments.peers.process import time_limit

    limit = time_limit(experiment.budget, experiment.reference.seconds) if peer.limit is None else peer.limit
    if peer.command is not None:
        return CommandPeer(label, peer.command, experiment.folder, limit)
    given: dict[str, Any] = {"variant": peer.variant, "integrator": peer.integrator, "sampler": peer.sampler}
    return MitsubaPeer(label, **{name: word for name, word in given.items() if word}, limit=limit)


def _checked(subject: Subject, label: str) -> Subject:
    """Return the subject; raises ExperimentError if records cannot hold its name, or its label is not the given one."""
    name, own_label = getattr(subject, "name", None), getattr(subject, "label", None)
    if not isinstance(name, str) or not name or (character := unfit_character(name)):
        found = f"{character} in {name!r}" if isinstance(name, str) and name else repr(name)
        text = f"the name of a subject must be text of one line without control characters, found {found}"
        raise ExperimentError((Problem("name", text),))
    if own_label != label:
        text = f"the label of a subject must be the one that it was made with, '{label}', found {own_label!r}"
        raise ExperimentError((Problem("label", text),))
    return subject


def _own(label: str, place: str) -> Subject:
    """Call ``FILE.py:NAME`` with the label."""
    file, colon, name = place.rpartition(":")
    if not colon or not name.isidentifier():
        raise ExperimentError((Problem("python", f"expected FILE.py:NAME, found '{place}'"),))
    make: Any = getattr(_module(Path(file)), name, None)
    if make is None:
        raise ExperimentError((Problem("python", f"{file} has no '{name}'"),))
    try:
        subject: Subject = make(label)
    except Exception as error:
        raise _told(Path(file), error) from error
    return subject


def _module(file: Path) -> ModuleType:
    """Import a file by its path, once; an error in the file is reported with its line."""
    name = f"equaltime_subject_{hashlib.sha256(str(file.resolve()).encode()).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None or not file.is_file():
        raise ExperimentError((Problem("python", f"no such Python file: {file}"),))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # before execution: dataclasses look up their module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise _told(file, error) from error
    return module


def _told(file: Path, error: Exception) -> ExperimentError:
    """Log an error's traceback from the user's file on; return an error that names the file's line.

    The error of an import says all there is to say, and has no traceback.
    """
    frames, first = [*traceback.walk_tb(error.__traceback__)], error.__traceback__
    lines = [line for frame, line in frames if frame.f_code.co_filename == str(file)]
    while lines and first is not None and first.tb_frame.f_code.co_filename != str(file):
        first = first.tb_next
    place = f"{file}:{lines[-1]}" if lines else str(file)
    if isinstance(error, ImportError):
        return ExperimentError((Problem("python", f"{place}: {error}"),))
    _LOG.error("%s failed", file, exc_info=(type(error), error, first))
    return ExperimentError((Problem("python", f"{place}: {type(error).__name__}: {error}"),))
