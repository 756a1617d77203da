"""Runner of all experiments of a folder: each has its own folder of results, and one index page shows them all."""

from __future__ import annotations

import logging
import re
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from equaltime.cluster import check_machines, open_cluster
from equaltime.errors import EqualtimeError, ExperimentError, Problem
from equaltime.experiments.analysis.summarise import conclude
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.plan import PeerTimes
from equaltime.experiments.model.reader import is_experiment, make_experiment, read_experiment
from equaltime.experiments.model.sources import strategy_files
from equaltime.experiments.report.index import Card, write_index
from equaltime.experiments.run.folder import ExperimentFolder, replacing
from equaltime.experiments.run.runner import Begins, ProgressCallback, run, tell_report
from equaltime.extras import install

__all__ = ["Changes", "experiments_in", "run_all"]

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Changes:
    """Options that change every experiment of a folder; None leaves the experiments' own values.

    ``quick`` shrinks an experiment so that it ends in under a minute. ``size`` is the films' width and height in
    pixels, ``budget`` the seconds of each run. ``repeats`` is the number of renders of each strategy on each scene, and
    ``threads`` of worker threads. ``targets`` are the relative errors to which times are given.
    """

    quick: bool = False
    size: tuple[int, int] | None = None
    budget: float | None = None
    repeats: int | None = None
    threads: int | None = None
    targets: tuple[float, ...] | None = None

    def of(self, experiment: Experiment) -> Experiment:
        """Return the experiment with these changes; the budget is ignored if the experiment gives sample counts."""
        return make_experiment(
            experiment,
            quick=self.quick,
            size=self.size,
            budget=self.budget if experiment.spp is None else None,
            repeats=self.repeats,
            threads=self.threads,
            targets=self.targets,
        )


def experiments_in(folder: Path) -> tuple[Path, ...]:
    """Return the paths of a folder's experiment files (TOML) in natural order: ``x2`` comes before ``x10``.

    Unreadable TOML files are included. Raises ExperimentError if there is no file.
    """
    found = sorted((path for path in folder.glob("*.toml") if is_experiment(path, unreadable=True)), key=_natural)
    if not found:
        record = ExperimentFolder(folder).experiment
        ran = f"; {record} is the experiment that was run there" if is_experiment(record) else ""
        problem = f"has no experiment: no TOML file with scenes and strategies{ran}"
        raise ExperimentError((Problem(str(folder), problem),))
    return tuple(found)


def run_all(
    source: Path,
    output: Path,
    changes: Changes = Changes(),
    progress: ProgressCallback | None = None,
    told: Callable[[Card], object] = lambda card: None,
    command: str = "",
    begins: Callable[[str, Experiment, PeerTimes, int], object] = lambda name, experiment, peers, machines: None,
    cluster: Any = None,
) -> tuple[Card, ...]:
    """Run or continue every experiment of a folder, and write the index page ``output/index.html``.

    The page is rewritten after each experiment, so that it is up to date if a run stops. If an experiment fails, the
    page shows its problem, and the next experiment runs.

    Parameters
    ----------
    source
        Folder of experiment files.
    output
        Folder of results; the experiment NAME.toml goes to ``output/NAME``.
    changes
        Options that change every experiment.
    told
        Function that is called with the card (entry of the index page) of each experiment when it has ended.
    progress
        Function that is called with a `RunProgress` as an experiment goes on.
    command
        Command line that started the experiments, for the reports.
    begins
        Function that is called before each experiment with its name, the experiment, the measured times of its peers
        (other renderers), and the number of machines that take runs.
    cluster
        Machines that take the runs of all experiments, as for `equaltime.experiments.cost`.

    Returns
    -------
    tuple of Card
        Outcome of each experiment.

    Raises
    ------
    ExperimentError
        If a file cannot be read: raised before the first run, with the problems of all files.
    ValueError
        If ``cluster`` cannot take runs whose times are compared.
    """
    if ExperimentFolder(output).experiment.exists():
        raise ExperimentError((Problem(str(output), "is the folder of one experiment; give another for all of them"),))
    paths = experiments_in(source)
    experiments = _read(paths, changes)
    cards = [
        Card(path.stem, experiment.title, "earlier" if (output / path.stem / "report.html").exists() else "waiting")
        for path, experiment in zip(paths, experiments, strict=True)
    ]
    output.mkdir(parents=True, exist_ok=True)
    write_index(cards, output, changes.quick, command)
    with open_cluster(check_machines(cluster)) as opened:
        for number, (card, experiment) in enumerate(zip(cards, experiments, strict=True)):
            path, begin = paths[number], partial(begins, card.name)
            cards[number] = _run(card, experiment, path, output / card.name, progress, command, begin, opened)
            told(cards[number])
            write_index(cards, output, changes.quick, command)
    return tuple(cards)


def _run(
    card: Card,
    experiment: Experiment,
    path: Path,
    folder: Path,
    progress: ProgressCallback | None,
    command: str,
    begins: Begins,
    cluster: Any,
) -> Card:
    """Run one experiment, which the file ``path`` describes, and return its outcome."""
    if missing := _missing(experiment):
        return replace(card, state="left out", problem=missing)
    failure = ExperimentFolder(folder).failure
    told = _named(card.name, progress)
    try:
        files = strategy_files(path)
        run(experiment, folder, told, command=command, begins=begins, files=files, cluster=cluster)
        summary = conclude(experiment, folder, command, partial(tell_report, experiment, told))
        return replace(card, state="done", summary=summary)
    except (EqualtimeError, OSError) as error:
        return replace(card, state="failed", problem=str(error))
    except Exception as error:  # any error: the other experiments must still run
        _LOG.exception("%s failed", card.name)
        kept = _keep_traceback(failure)
        return replace(card, state="failed", problem=f"{type(error).__name__}: {error}{kept}")


def _keep_traceback(path: Path) -> str:
    """Write the current error's traceback to ``path``; return a remark in brackets that names the file.

    The remark is empty if the file cannot be written.
    """
    try:
        with replacing(path) as file:
            file.write(traceback.format_exc().encode(errors="backslashreplace"))
    except OSError as error:
        _LOG.warning("%s cannot be written: %s", path, error.strerror or error)
        return ""
    return f" (traceback in {path})"


def _named(name: str, progress: ProgressCallback | None) -> ProgressCallback | None:
    """Return the callback with the experiment's name put before each scene's name, or instead of an empty one."""
    if progress is None:
        return None
    return lambda told: progress(replace(told, scene=f"{name} / {told.scene}" if told.scene else name))


def _missing(experiment: Experiment) -> str:
    """Return a sentence on the missing package that an experiment needs; empty if none is missing."""
    peers = {entry.peer.renderer for entry in experiment.strategies if entry.peer is not None}
    if "mitsuba" in peers and find_spec("mitsuba") is None:
        return f"it needs Mitsuba 3: {install('peers')}"
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
