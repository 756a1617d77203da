"""Sentence on the planned runs of an experiment and their approximate time, to be shown before the first run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from equaltime.experiments.model.experiment import DEFAULT_BUDGET, Experiment
from equaltime.statistics.intervals import FEWEST_FOR_MEDIAN, FEWEST_REPEATS
from equaltime.words import duration

__all__ = ["PeerTimes", "planned", "planned_runs", "planned_seconds", "too_few"]

_REPORT_SECONDS = 5.0
"""Seconds that loading and the report of one scene take, if its images are small."""
_EARLIER_CHECKPOINTS = 1.4
"""Time of the earlier checkpoints of a peer, as a multiple of the last one's time. Each checkpoint is a render of its
own with twice the samples of the one before. The last has up to twice the samples, 1.4 times on average."""
_CHECKPOINTS = 10
"""Typical number of checkpoints of a run; each starts the peer anew."""


_NOT_MEASURED = (
    "; other renderers take longer by their start and their tests: cost measures how long before it runs them"
)


@dataclass(frozen=True)
class PeerTimes:
    """Measured times of an experiment's other renderers (peers), in seconds, to predict its time; 0 without peers."""

    tests: float = 0.0
    """Time of all tests, still to be made, whether other renderers and equaltime have the same expected image."""
    small_renders: float = 0.0
    """Sum of the times of one small render by each of the other renderers on each scene: the time that a render takes
    beside its samples."""


def planned(experiment: Experiment, peers: PeerTimes | None = None, machines: int = 1) -> str:
    """Return a sentence on the planned tests, references and runs; with a time budget, it gives the total time.

    ``peers`` holds the measured times of other renderers; None if they are not measured, which the sentence then says.
    ``machines`` is the number of machines that take runs. The time is mostly an upper limit: references may end
    earlier, and runs that a folder already holds are not repeated. Two times are not included: references of renderers
    whose images differ, which the sentence names, and the measuring of errors. The sentence ends with a warning if
    there are too few repeats for trusted numbers.
    """
    unknown = peers is None and any(entry.peer is not None for entry in experiment.strategies)
    peers = peers or PeerTimes()
    runs = planned_runs(experiment)
    said = f"{runs} run{'s' * (runs != 1)}"
    on = f" on {machines} machines" if machines > 1 else ""
    references = _reference_seconds(experiment)
    first = []
    if peers.tests:
        first.append(f"tests of agreement with other renderers ({duration(_whole(peers.tests))})")
    if references:
        first.append(f"references of up to {duration(references)} each")
    before = f"{', '.join(first)}, then " if first else ""
    differs = f"; up to {duration(experiment.reference.seconds)} more for each renderer whose picture differs"
    after = (_NOT_MEASURED if unknown else differs if peers.tests else "") + (
        f"; {few}" if (few := too_few(experiment.repeats)) else ""
    )
    if experiment.spp is not None:
        return f"{before}{said} of {experiment.spp[-1]:,} samples a pixel{on}{after}"
    seconds = _whole(_seconds(experiment, peers, machines))
    about = f"{'more than' if unknown else 'about'} {duration(seconds)}"
    each = duration(experiment.budget or DEFAULT_BUDGET)
    ran = f"with the samples of earlier runs, which were made for {each}" if experiment.counts else f"of {each}"
    return f"{about}: {before}{said} {ran}{on}{after}"


def too_few(repeats: int, option: str = "--repeats ") -> str:
    """Return a sentence if repeats are too few for intervals or for medians; else an empty text.

    ``option`` is the text before the number of repeats that the sentence advises.
    """
    few = f"with {repeats} repeat{'s' * (repeats != 1)} there are no"
    if repeats < FEWEST_REPEATS:
        return f"{few} intervals: {option}{FEWEST_REPEATS} is the least, {FEWEST_FOR_MEDIAN} are better"
    if repeats < FEWEST_FOR_MEDIAN:
        return f"{few} trusted times where rare events make most of an error: {option}{FEWEST_FOR_MEDIAN} is the least"
    return ""


def planned_seconds(experiment: Experiment, peers: PeerTimes = PeerTimes(), machines: int = 1) -> float | None:
    """Return the seconds of all tests, references, runs, films and the report; None without a time budget.

    ``peers`` holds the measured times of other renderers. ``machines`` is the number of machines that take runs; one
    machine does all the rest.
    """
    return None if experiment.spp is not None else _seconds(experiment, peers, machines)


def planned_runs(experiment: Experiment) -> int:
    """Return the number of runs of an experiment: repeats of each strategy on each scene."""
    return experiment.repeats * len(experiment.scenes) * len(experiment.strategies)


def _seconds(experiment: Experiment, peers: PeerTimes, machines: int) -> float:
    budget = experiment.budget or DEFAULT_BUDGET
    scenes, strategies = len(experiment.scenes), len(experiment.strategies)
    others = sum(entry.peer is not None for entry in experiment.strategies)
    turns = max(math.ceil(planned_runs(experiment) / machines), min(experiment.repeats, 2))  # others follow the first
    runs = budget * (turns + experiment.repeats * scenes * _EARLIER_CHECKPOINTS * others)
    starts = experiment.repeats * _CHECKPOINTS * peers.small_renders
    films = scenes * strategies * budget if experiment.animate else 0.0
    return peers.tests + scenes * (_reference_seconds(experiment) + _REPORT_SECONDS) + runs + starts + films


def _reference_seconds(experiment: Experiment) -> float:
    """Return the longest time of one reference in seconds; 0 if a file gives the reference."""
    return 0.0 if experiment.reference.file is not None else experiment.reference.seconds


def _whole(seconds: float) -> float:
    """Round to whole seconds, at least 1."""
    return float(max(1, round(seconds)))
