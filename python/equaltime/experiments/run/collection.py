"""A folder of experiments: each is run into a folder of its own, and one page shows them all."""

from __future__ import annotations

import logging
import re
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from equaltime.errors import EqualtimeError, ExperimentError, Problem
from equaltime.experiments.analysis.conclusion import conclude
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.making import make_experiment
from equaltime.experiments.model.reader import is_experiment, read_experiment
from equaltime.experiments.report.index import Card, write_index
from equaltime.experiments.run.folder import Folder, replacing
from equaltime.experiments.run.runner import ProgressCallback, run

__all__ = ["Changes", "experiments_in", "run_all"]

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Changes:
    """Changes to the experiments of the files; as for `equaltime.experiments.cost`."""

    quick: bool = False
    size: tuple[int, int] | None = None
    budget: float | None = None
    repeats: int | None = None
    threads: int | None = None

    def of(self, experiment: Experiment) -> Experiment:
        """Return the experiment so changed; one that counts samples instead of seconds keeps its counts."""
        return make_experiment(
            experiment,
            quick=self.quick,
            size=self.size,
            budget=self.budget if experiment.spp is None else None,
            repeats=self.repeats,
            threads=self.threads,
        )


def experiments_in(folder: Path) -> tuple[Path, ...]:
    """Return the files of a folder that are experiments, or cannot be read, x2 before x10; ExperimentError if none."""
    found = sorted((path for path in folder.glob("*.toml") if is_experiment(path, unreadable=True)), key=_natural)
    if not found:
        raise ExperimentError((Problem(str(folder), "has no experiment: no TOML file with scenes and strategies"),))
    return tuple(found)


def run_all(
    source: Path,
    output: Path,
    changes: Changes = Changes(),
    progress: ProgressCallback | None = None,
    told: Callable[[Card], object] = lambda card: None,
    command: str = "",
) -> tuple[Card, ...]:
    """Run every experiment of a folder, or what is left of each, and write ``output/index.html``.

    The page is written anew after each experiment, so that it shows what is done if one stops. An experiment that fails
    is told on the page and does not keep the others from running.

    Parameters
    ----------
    source
        Folder of experiment files.
    output
        The experiment NAME.toml goes to ``output/NAME``.
    told
        Called with the card of each experiment when it is done.

    Returns
    -------
    tuple of Card
        The outcome of each.

    Raises
    ------
    ExperimentError
        If a file cannot be read: before anything is run, with the problems of all files.
    """
    if Folder(output).experiment.exists():
        raise ExperimentError((Problem(str(output), "is the folder of one experiment; give another for all of them"),))
    paths = experiments_in(source)
    experiments = _read(paths, changes)
    cards = [
        Card(path.stem, experiment.title, "earlier" if (output / path.stem / "report.html").exists() else "waiting")
        for path, experiment in zip(paths, experiments, strict=True)
    ]
    output.mkdir(parents=True, exist_ok=True)
    write_index(cards, output, changes.quick, command)
    for number, (card, experiment) in enumerate(zip(cards, experiments, strict=True)):
        cards[number] = _run(card, experiment, output / card.name, progress, command)
        told(cards[number])
        write_index(cards, output, changes.quick, command)
    return tuple(cards)


def _run(card: Card, experiment: Experiment, folder: Path, progress: ProgressCallback | None, command: str) -> Card:
    """Run one experiment, and return its outcome."""
    if missing := _missing(experiment):
        return replace(card, state="left out", problem=missing)
    failure = Folder(folder).failure
    try:
        run(experiment, folder, _named(card.name, progress), command=command)
        return replace(card, state="done", summary=conclude(experiment, folder, command))
    except (EqualtimeError, OSError) as error:
        return replace(card, state="failed", problem=str(error))
    except Exception as error:  # of any kind: it must not end the other experiments
        _LOG.exception("%s failed", card.name)
        kept = _keep_traceback(failure)
        return replace(card, state="failed", problem=f"{type(error).__name__}: {error}{kept}")


def _keep_traceback(path: Path) -> str:
    """Write the traceback of the error that is being handled; return where it is, in brackets, if that worked."""
    try:
        with replacing(path) as file:
            file.write(traceback.format_exc().encode(errors="backslashreplace"))
    except OSError as error:
        _LOG.warning("%s cannot be written: %s", path, error.strerror or error)
        return ""
    return f" (traceback in {path})"


def _named(name: str, progress: ProgressCallback | None) -> ProgressCallback | None:
    """Let progress tell the experiment as well, with its scenes."""
    if progress is None:
        return None
    return lambda told: progress(replace(told, scene=f"{name} / {told.scene}"))


def _missing(experiment: Experiment) -> str:
    """Say what would have to be installed for an experiment, if something is missing."""
    peers = {entry.peer.renderer for entry in experiment.strategies if entry.peer is not None}
    if "mitsuba" in peers and find_spec("mitsuba") is None:
        return "it needs Mitsuba 3: pip install 'equaltime[peers]'"
    return ""


def _read(paths: Sequence[Path], changes: Changes) -> list[Experiment]:
    experiments: list[Experiment] = []
    problems: list[Problem] = []
    for path in paths:
        try:
            experiments.append(changes.of(read_experiment(path)))
        except ExperimentError as error:
            problems += error.problems
    if problems:
        raise ExperimentError(tuple(problems))
    return experiments


def _natural(path: Path) -> tuple[bool, list[tuple[int, str]]]:
    """Return a key that sorts ``x2`` before ``x10``, and names without a number last."""
    parts = [(int(digits or 0), text) for text, digits in re.findall(r"(\D*)(\d*)", path.stem)]
    return not re.match(r"x\d", path.stem), parts
