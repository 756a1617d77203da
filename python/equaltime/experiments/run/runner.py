"""Runner of experiments: renders every strategy on every scene, repeat after repeat, and records each checkpoint.

The order of strategies alternates, so that a change of the machine's speed does not favour a strategy.
Recorded runs are not repeated. A run's clock is stopped while the image at a checkpoint is made, measured and
recorded. With a cluster, other machines take whole runs (`spread_runs`); all else is done in this process.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from equaltime.cluster import check_machines, open_machines
from equaltime.cluster.scene_text import SceneText
from equaltime.cluster.tasks import Ground
from equaltime.errors import ExperimentError, PeerError, Problem
from equaltime.experiments.model.experiment import DEFAULT_BUDGET, Experiment
from equaltime.experiments.model.plan import PeerTimes, planned_seconds
from equaltime.experiments.model.reader import identity_of, run_seeds
from equaltime.experiments.model.sources import made_from
from equaltime.experiments.peers.agreement import measured_times, pass_gates
from equaltime.experiments.run import reference as references
from equaltime.experiments.run.directions import write_directions
from equaltime.experiments.run.folder import (
    IN_FULL,
    OWN_DEPTHS,
    ExperimentFolder,
    build_facts,
    fingerprint,
    machine_facts,
)
from equaltime.experiments.run.forming import Studio
from equaltime.experiments.run.record import Key, Recorder, check_seeds
from equaltime.experiments.run.single_run import RunOrder, SingleRun, now, record
from equaltime.experiments.run.spread_runs import check_spread, finished_runs
from equaltime.experiments.run.stage import Stage
from equaltime.experiments.run.subjects import close_subjects, make_subjects, scenes_of
from equaltime.images.metrics import Reference
from equaltime.interrupts import put_off
from equaltime.machine import worker_threads
from equaltime.rendering.core_subject import Subject
from equaltime.revision import revision
from equaltime.scene import Scene

if TYPE_CHECKING:  # not everyone has Dask
    from equaltime.cluster.machines import Machines

__all__ = ["Begins", "ProgressCallback", "RunProgress", "Subject", "run", "tell_report"]

Phase = Literal["setup", "agreement", "own reference", "reference", "run", "film", "report"]


@dataclass(frozen=True)
class RunProgress:
    """Progress of an experiment, as its progress callback receives it."""

    phase: Phase
    """Present work of the experiment, such as ``reference``, ``run`` or ``report``."""
    scene: str
    """Name of the scene; empty while the report is written."""
    strategy: str
    """Label of the strategy; empty while the report is written."""
    repeat: int
    """Number of the current repeat, from 0."""
    done: int
    """Number of runs that are recorded so far."""
    total: int
    """Number of runs of the experiment."""
    fraction: float
    """Completed share of the phase, in [0, 1]: of the present test or reference, of the report, or of all runs."""
    time_left: float | None
    """Estimated seconds to the end of the last run, before the runs to the end of the report; None if unknown."""
    machines: int = 0
    """Number of machines of a cluster that take runs; 0 if this process does."""


ProgressCallback = Callable[[RunProgress], object]
Begins = Callable[[Experiment, PeerTimes, int], object]


def run(
    experiment: Experiment,
    folder: Path,
    progress: ProgressCallback | None = None,
    cache: Path | None = None,
    command: str = "",
    begins: Begins = lambda experiment, peers, machines: None,
    files: Iterable[Path] = (),
    cluster: Any = None,
    call: str = "",
) -> None:
    """Run the missing runs of an experiment, and write records and images to ``folder``.

    The experiment may be stopped at any moment, by Ctrl-C or a kill; the next call continues it.

    Parameters
    ----------
    progress
        Function that is called with a `RunProgress` as the experiment goes on.
    cache
        Folder where references are kept for other experiments; by default `reference.cache_folder`.
    command
        Command line that started the runs, for their provenance.
    begins
        Function that is called with the experiment, the measured times of its peers (other renderers), and the number
        of machines that take runs. It is called once all of them and the folder are known to be good, before the first
        test, reference or run.
    files
        Files from which the experiment was made, besides scenes and programs; their SHA-256 is recorded.
    cluster
        Place of the machines that take the runs, as for `equaltime.cluster.open_machines`; None for this process.
    call
        Text of the call in Python that started the runs, for their provenance.

    Raises
    ------
    ExperimentError
        If a scene cannot be read, the folder belongs to another experiment, build or machine, or another process runs
        an experiment in it. With a cluster also if a strategy is not equaltime's own.
    ValueError
        If ``cluster`` cannot take runs whose times are compared.
    SceneError, StrategyError, RenderError
        If a scene cannot be rendered.
    """
    _check_names(folder, command, call, *(entry.name for entry in experiment.scenes))
    if check_machines(cluster) is not None:
        check_spread(experiment)
    scenes = scenes_of(experiment)
    subjects = make_subjects(experiment)
    place = ExperimentFolder(folder)
    try:
        threads = worker_threads(experiment.threads)
        identity = identity_of(experiment, scenes, subjects, threads)  # before the folder is made: may raise
        with place.locked():
            place.claim(identity, experiment, made_from(experiment, scenes, files))
            place.failure.unlink(missing_ok=True)
            with Recorder(place.records) as recorder:
                place.tidy()
                asked = {"command": command} if command else {"call": call} if call else {}
                settings = (threads, place, recorder, progress, cache, asked, cluster)
                _Session(experiment, scenes, subjects, *settings).run(begins)
    finally:
        close_subjects(subjects)


def tell_report(experiment: Experiment, progress: ProgressCallback | None, share: float) -> None:
    """Call ``progress`` with the completed share, in [0, 1], of an experiment's report."""
    if progress is not None:
        runs = experiment.repeats * len(experiment.scenes) * len(experiment.strategies)
        progress(RunProgress("report", "", "", 0, runs, runs, share, None))


def _check_names(*names: object) -> None:
    """Raise `ExperimentError` for a name that cannot be written as UTF-8, the encoding of records."""
    for name in map(str, names):
        try:
            name.encode()
        except UnicodeEncodeError as error:
            raise ExperimentError((Problem(name, "is not UTF-8, as the records of an experiment are"),)) from error


@contextmanager
def _told_on(scene: str) -> Iterator[None]:
    """Add the scene's name to errors of other renderers."""
    try:
        yield
    except PeerError as error:
        raise PeerError(f"{scene}: {error}") from error


@dataclass(frozen=True)
class _Turn:
    repeat: int
    number: int
    """Index of the scene."""
    subject: Subject
    key: Key
    seed: int


@dataclass
class _Session:
    """One call of `run`, up to its end or an interruption."""

    experiment: Experiment
    scenes: Sequence[Scene]
    subjects: Sequence[Subject]
    threads: int
    folder: ExperimentFolder
    recorder: Recorder
    progress: ProgressCallback | None
    cache: Path | None
    asked: Mapping[str, str]
    """Command line or call that started the runs, by ``command`` or ``call``, for their provenance; may be empty."""
    cluster: Any

    def __post_init__(self) -> None:
        check_seeds(self.recorder.rows, self.folder.records)
        self._turns = tuple(self._all_turns())
        self._done = {row.key for row in self.recorder.rows if row.last} & {turn.key for turn in self._turns}
        self._seconds: dict[tuple[str, str], float] = {}
        self._counts: dict[tuple[str, str], tuple[int, ...]] = {}
        self._rendering = 0.0
        labels = {entry.label for entry in self.experiment.strategies if entry.peer is not None}
        self._peers = [subject for subject in self.subjects if subject.label in labels]
        self._end: float | None = None
        """Expected end of the report on the clock of `time.perf_counter`; None if unknown."""

    def run(self, begins: Begins) -> None:
        """Run the missing runs, then make films and figures."""
        origin = self._origin()
        for entry, scene in zip(self.experiment.scenes, self.scenes, strict=True):
            self.folder.note(OWN_DEPTHS, entry.name, {"max_depth": scene.own_max_depth})
        for strategy in self.experiment.strategies:
            if strategy.strategy is not None:
                self.folder.note(IN_FULL, strategy.label, {"words": strategy.strategy.in_full})
        left = [turn for turn in self._turns if turn.key not in self._done]
        with open_machines(self.cluster if left else None) as machines:
            size = 1 if machines is None else max(1, len(machines.present))
            if left:
                self._prepare()
            times = self._measure_peers() if left else PeerTimes()
            begins(self.experiment, times, size)
            if (seconds := planned_seconds(self.experiment, times, size)) is not None and not self._done:
                self._end = time.perf_counter() + seconds
            if left:
                self._pass_gates()
            known = [self._reference(number) for number in range(len(self.scenes))]
            if left:
                self._run_all(left, known, origin, machines)
        self._show(known)

    def _run_all(
        self, left: Sequence[_Turn], known: Sequence[Reference], origin: tuple[str, str], machines: Machines | None
    ) -> None:
        """Run the missing runs here or on ``machines``, and note the session, also after an interruption."""
        started, load, begin = now(), os.getloadavg()[0], time.perf_counter()
        before, code = len(self._done), revision()
        try:
            if machines is None:
                for position, turn in enumerate(left):
                    self._tell("run", turn, len(self._done) / len(self._turns), self._expected(left[position:]))
                    self._run(turn, known[turn.number], origin)
            else:
                self._spread(left, known, origin, machines)
        finally:
            elapsed = time.perf_counter() - begin
            facts = {
                "runs": len(self._done) - before,
                "elapsed_s": elapsed,
                "rendering_s": self._rendering,
                "revision": code,
            }
            asked = {**self.asked, "directory": str(Path.cwd())} if self.asked else {}
            self.folder.note("sessions", started, {**asked, "load_average_before": load, **facts})

    def _show(self, known: Sequence[Reference]) -> None:
        """Make the missing films and figures that the experiment asks for."""
        names = [entry.name for entry in self.experiment.scenes]
        if "directions" in self.experiment.figures and not self.folder.directions.exists():
            write_directions(self.folder.directions, names, self.scenes)
        if self.experiment.animate:
            films = Studio(self.experiment, self.scenes, self.folder, self.recorder.rows, known, self.threads)
            for turn in self._turns[: len(self.scenes) * len(self.subjects)]:
                if films.wants(turn.key):
                    self._tell("film", turn, 1.0, None)
                    films.shoot(turn.key, turn.number, turn.subject)

    def _all_turns(self) -> Iterator[_Turn]:
        repeats, scenes = self.experiment.repeats, self.experiment.scenes
        seeds = {
            (entry.name, subject.label): run_seeds(entry.name, subject.label, repeats)
            for entry in scenes
            for subject in self.subjects
        }
        for repeat in range(repeats):
            for number, entry in enumerate(scenes):
                for subject in self.subjects if repeat % 2 == 0 else self.subjects[::-1]:
                    key = (entry.name, subject.label, repeat)
                    yield _Turn(repeat, number, subject, key, seeds[key[:2]][repeat])

    def _run(self, turn: _Turn, known: Reference, origin: tuple[str, str]) -> None:
        own = self.folder.reference(turn.key[0], turn.key[1])
        if own.exists():
            known = references.read(own).reference
        begin = time.perf_counter()
        order = self._order(turn, origin)
        assert order is not None, "the first repeat is done"
        with _told_on(turn.key[0]):
            single = SingleRun(order, self.scenes[turn.number], turn.subject, known)
            self._rendering += record(single.checkpoints(), self.folder, self.recorder)
        self._seconds[turn.key[:2]] = time.perf_counter() - begin
        self._done.add(turn.key)

    def _spread(
        self, left: Sequence[_Turn], known: Sequence[Reference], origin: tuple[str, str], machines: Machines
    ) -> None:
        """Let machines take the missing runs, and record each one when it is finished."""
        turns = {turn.key: turn for turn in left}
        strategies = {entry.label: entry.strategy for entry in self.experiment.strategies if entry.strategy is not None}
        grounds = {
            entry.name: Ground(SceneText.of(scene), reference, Stage)
            for entry, scene, reference in zip(self.experiment.scenes, self.scenes, known, strict=True)
        }

        def order_of(key: Key) -> RunOrder | None:
            return self._order(turns[key], origin)

        def told(key: Key, size: int) -> None:
            seconds = self._expected([turn for turn in left if turn.key not in self._done]) / size
            self._tell("run", turns[key], len(self._done) / len(self._turns), seconds, size)

        for key, machine, found in finished_runs(machines, list(turns), order_of, grounds, strategies, told):
            with put_off():  # a run is recorded with its worker or not at all
                self._rendering += record(found.checkpoints(), self.folder, self.recorder)
                self.folder.note_worker(machine.address, machine.host, key)
                self._done.add(key)
            self._seconds[key[:2]] = found.last.wall_s

    def _order(self, turn: _Turn, origin: tuple[str, str]) -> RunOrder | None:
        """Return the order of a run; None if it needs the sample counts of a first repeat that is not finished."""
        scene, label, _ = turn.key
        fixed = self.experiment.spp or self.experiment.counts.get(scene, {}).get(label)
        ladder = fixed or self.experiment.budget or DEFAULT_BUDGET
        expected = None
        if turn.repeat > 0:
            expected = self._first_counts(turn) or fixed
            if expected is None:
                return None
            ladder = fixed or expected
        return RunOrder(turn.key, turn.seed, ladder, expected, self.threads, *origin)

    def _first_counts(self, turn: _Turn) -> tuple[int, ...]:
        """Return the sample counts of the first repeat; none if it is not finished."""
        place = turn.key[:2]
        if place not in self._counts and (*place, 0) in self._done:
            self._counts[place] = tuple(row.spp for row in self.recorder.rows if row.key == (*place, 0))
        return self._counts.get(place, ())

    def _origin(self) -> tuple[str, str]:
        """Return the keys of machine and build; raises ExperimentError if the records have other keys."""
        facts = {"machine": machine_facts(), "build": build_facts()}
        keys = {kind: fingerprint(value) for kind, value in facts.items()}
        for kind, key in keys.items():
            if any(getattr(row, kind) != key for row in self.recorder.rows):
                message = f"has times of another {kind}, which cannot be compared with new ones; use another folder"
                raise ExperimentError((Problem(str(self.folder.path), message),))
            self.folder.note(f"{kind}s", key, facts[kind])
        return keys["machine"], keys["build"]

    def _prepare(self) -> None:
        """Prepare every subject for every scene, so that problems show before hours of runs."""
        for turn in self._turns[: len(self.scenes) * len(self.subjects)]:
            self._tell("setup", turn, 0.0, None)
            with _told_on(turn.key[0]):
                turn.subject.prepare(self.scenes[turn.number], self.threads)

    def _measure_peers(self) -> PeerTimes:
        """Return the times of all peers on all scenes."""
        tests = renders = 0.0
        for entry, scene in zip(self.experiment.scenes, self.scenes, strict=True):
            with _told_on(entry.name):
                times = measured_times(self._peers, entry.name, scene, self.folder, self.threads)
            tests, renders = tests + times.tests, renders + times.small_renders
        return PeerTimes(tests, renders)

    def _pass_gates(self) -> None:
        """Compare every peer with equaltime on every scene."""
        gates = len(self._peers) * len(self.scenes)
        for number, entry in enumerate(self.experiment.scenes):
            told = partial(self._tell_of_peer, "agreement", number)
            told_reference = partial(self._tell_of_peer, "own reference", number)
            scene, wish = self.scenes[number], self.experiment.reference
            with _told_on(entry.name):
                pass_gates(self._peers, entry.name, scene, wish, self.folder, self.threads, gates, told, told_reference)

    def _reference(self, number: int) -> Reference:
        """Return the scene's reference; one in the folder is kept even if the cache has a better one."""
        turn = self._turns[number * len(self.subjects)]
        path = self.folder.reference(turn.key[0])
        if not path.exists():
            self._tell("reference", turn, 0.0, self._left())
            known = references.obtain(
                self.scenes[number],
                self.experiment.reference,
                self.cache,
                self.threads,
                lambda share: self._tell("reference", turn, share, self._left()),
            )
            self.folder.note("references", turn.key[0], known.facts)  # first: skipped once the file exists
            references.write(path, known)
        return references.read(path).reference

    def _expected(self, left: Sequence[_Turn]) -> float:
        """Estimate the seconds of the turns, from each one's last time, else the budget, else the mean time.

        The plan counts if it is later and some strategy has no time yet: peers take longer than the budget.
        """
        budget = self.experiment.budget
        mean = sum(self._seconds.values()) / len(self._seconds) if self._seconds else budget or 0.0
        known = sum(self._seconds.get(turn.key[:2], budget or mean) for turn in left)
        untried = any(turn.key[:2] not in self._seconds for turn in left)
        return max(known, self._left() or 0.0) if untried else known

    def _left(self) -> float | None:
        """Return the seconds to the expected end of the report; None if unknown."""
        return None if self._end is None else max(0.0, self._end - time.perf_counter())

    def _tell_of_peer(self, phase: Phase, number: int, peer: Subject, fraction: float) -> None:
        turn = self._turns[number * len(self.subjects) + self.subjects.index(peer)]
        self._tell(phase, turn, fraction, self._left())

    def _tell(self, phase: Phase, turn: _Turn, fraction: float, time_left: float | None, machines: int = 0) -> None:
        if self.progress is not None:
            place = (turn.key[0], turn.key[1], turn.repeat, len(self._done), len(self._turns))
            self.progress(RunProgress(phase, *place, fraction, time_left, machines))
