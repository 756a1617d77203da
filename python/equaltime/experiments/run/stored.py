"""Experiment of a folder as the folder records it: its settings, its results, and how much of it has run.

The folder holds all settings. The experiment's file and its scenes may have changed since (`StoredExperiment.changes`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from equaltime.errors import ExperimentError, Problem
from equaltime.experiments.analysis.summarise import concluded
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.sources import sums_of
from equaltime.experiments.model.summary import Summary
from equaltime.experiments.report.telling import commands
from equaltime.experiments.run.folder import IN_FULL, ExperimentFolder
from equaltime.experiments.run.record import Row, load

__all__ = ["StoredExperiment", "stored_experiments"]


@dataclass(frozen=True)
class StoredExperiment:
    """A folder's experiment and the runs that it holds, to continue it or to report on it without its file."""

    folder: Path
    experiment: Experiment
    """The experiment of the last call. Only the names, crops and defines of its scenes are known, so it cannot be
    rendered."""
    identity: Mapping[str, Any] = field(hash=False)
    """All settings that affect records, as JSON data; a continued experiment must have the same."""
    runs: tuple[Row, ...]
    """Last row of the records of each finished run of the experiment."""
    earlier: tuple[str, ...]
    """Strategies and scenes, in words, of finished runs that the experiment of the last call no longer has."""
    files: Mapping[str, str] = field(hash=False)
    """SHA-256 of the files from which the last call made the experiment, by absolute path."""

    @classmethod
    def read(cls, folder: Path) -> StoredExperiment:
        """Read the experiment of a folder; raises `ExperimentError` if it is missing or damaged."""
        place = ExperimentFolder(folder)
        content = place.read_experiment()
        identity: Mapping[str, Any] = content["identity"]
        try:
            experiment = Experiment.model_validate(_named(content.get("experiment"), identity))
        except ExperimentError as error:
            keys = f"{place.experiment}: experiment"
            found = (Problem(f"{keys}.{p.place}" if p.place else keys, p.message) for p in error.problems)
            raise ExperimentError(tuple(found)) from None
        names, labels = _names_of(experiment)
        finished = [row for row in load(place.records) if row.last]
        runs = tuple(row for row in finished if row.scene in names and row.strategy in labels)
        earlier = tuple(dict.fromkeys(_left_over(row, names) for row in finished if row not in runs))
        return cls(
            folder, experiment, identity, runs, earlier, _sums(content.get("files", {}), f"{place.experiment}: files")
        )

    @property
    def planned(self) -> int:
        """Number of runs of the complete experiment, with equally many repeats of all strategies on all scenes."""
        repeats = max((self.experiment.repeats, *(row.repeat + 1 for row in self.runs)))
        return len(self.experiment.scenes) * len(self.experiment.strategies) * repeats

    @property
    def complete(self) -> bool:
        """Whether all planned runs of the experiment are finished."""
        return len(self.runs) >= self.planned

    @cached_property
    def summary(self) -> Summary:
        """Results of the finished runs, computed from the records when first asked for."""
        return concluded(self.experiment, self.folder)

    @cached_property
    def changes(self) -> Mapping[Path, Literal["changed", "gone"]]:
        """Files from which the experiment was made that have changed or are gone since the last call."""
        now = sums_of(map(Path, self.files))
        return {
            Path(path): "changed" if path in now else "gone"
            for path, sum_ in self.files.items()
            if now.get(path) != sum_
        }

    @property
    def strategies_in_full(self) -> Mapping[str, str]:
        """All words of each strategy of equaltime's own, by label; an earlier version did not record them."""
        recorded = self.summary.provenance.get(IN_FULL, {})
        return {label: str(facts.get("words", "")) for label, facts in recorded.items()}

    @property
    def commands(self) -> tuple[str, ...]:
        """Command lines that made the runs, each once, the last one last; empty if they were made from Python."""
        return commands(self.summary)

    @property
    def call(self) -> str:
        """Last call of ``et.cost`` that made runs, as text; empty if none is recorded."""
        sessions = self.summary.provenance.get("sessions", {}).values()
        return str(next((session["call"] for session in reversed(sessions) if "call" in session), ""))

    @property
    def revisions(self) -> tuple[str, ...]:
        """Commits of equaltime that made the runs, each once; an earlier version did not record them."""
        sessions = self.summary.provenance.get("sessions", {}).values()
        return tuple(dict.fromkeys(str(session["revision"]) for session in sessions if "revision" in session))

    @property
    def directory(self) -> Path | None:
        """Working directory of the last command or call, to which its paths are relative; None without a record."""
        sessions = self.summary.provenance.get("sessions", {}).values()
        found = [session["directory"] for session in sessions if "directory" in session]
        return Path(found[-1]) if found else None

    @property
    def seconds(self) -> float:
        """Seconds that all finished runs took, from first sample to last; references are not counted."""
        return sum(row.wall_s for row in self.runs)

    @property
    def begun(self) -> str:
        """Start of the first finished run: UTC, ISO 8601; empty without a finished run."""
        return min((row.started for row in self.runs), default="")


def stored_experiments(folder: Path) -> tuple[StoredExperiment, ...]:
    """Return the experiments in the subfolders of a folder, in the order of their names.

    Raises `ExperimentError` if there is none, or if one is damaged.
    """
    found = sorted(path.parent for path in folder.glob("*/experiment.json"))
    if not found:
        problem = "holds no experiment; `equaltime cost SCENE -o DIR` makes such a folder"
        raise ExperimentError((Problem(str(folder), problem),))
    return tuple(map(StoredExperiment.read, found))


def _sums(stored: object, place: str) -> Mapping[str, str]:
    """Return the stored SHA-256 of files; raises `ExperimentError` if they are not a table of texts."""
    if not isinstance(stored, dict) or not all(isinstance(value, str) for value in stored.values()):
        raise ExperimentError((Problem(place, "is damaged; put a copy of the file there, or use another folder"),))
    return stored


def _named(stored: object, identity: Mapping[str, Any]) -> object:
    """Return the stored values with scenes that have a name alone.

    Scenes and strategies come from the identity if the stored values lack them.
    """
    if not isinstance(stored, Mapping):
        return stored
    return {**stored, "scenes": list(_scenes(stored, identity)), "strategies": list(_strategies(stored, identity))}


def _scenes(stored: Mapping[str, Any], identity: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    entries = stored.get("scenes")
    known = {entry.get("name"): entry for entry in entries if isinstance(entry, dict)} if entries else {}
    for name in [name for name in known if name in identity["scenes"]] or identity["scenes"]:
        entry = known.get(name, {})
        yield {"name": name, "path": name, "crops": entry.get("crops"), "define": entry.get("define") or {}}


def _strategies(stored: Mapping[str, Any], identity: Mapping[str, Any]) -> Iterator[object]:
    entries = stored.get("strategies")
    known = {entry.get("label"): entry for entry in entries if isinstance(entry, dict)} if entries else {}
    for label in [label for label in known if label in identity["strategies"]] or identity["strategies"]:
        yield known.get(label, {"label": label, "python": str(identity["strategies"][label])})


def _names_of(experiment: Experiment) -> tuple[set[str], set[str]]:
    """Return the names of the scenes and the labels of the strategies."""
    return {entry.name for entry in experiment.scenes}, {entry.label for entry in experiment.strategies}


def _left_over(row: Row, names: Collection[str]) -> str:
    """Return what a run belongs to that the experiment no longer has: a scene if its name is not in ``names``."""
    return f"strategy {row.strategy}" if row.scene in names else f"scene {row.scene}"
