"""Sentence on the planned runs of an experiment and their approximate time, to be shown before the first run."""

from __future__ import annotations

from equaltime.experiments.model.experiment import DEFAULT_BUDGET, Experiment
from equaltime.words import duration

__all__ = ["planned", "planned_runs", "planned_seconds"]

_REPORT_SECONDS = 5.0
"""Seconds that loading and the report of a small experiment take."""


def planned(experiment: Experiment) -> str:
    """Return a sentence on the planned references and runs; with a time budget, it gives the total time.

    The time is mostly an upper limit: references may end earlier, and runs that a folder already holds are not
    repeated.
    """
    runs = planned_runs(experiment)
    said = f"{runs} run{'s' * (runs != 1)}"
    references = _reference_seconds(experiment)
    before = f"references of up to {duration(references)} each, then " if references else ""
    if experiment.spp is not None:
        return f"{before}{said} of {experiment.spp[-1]:,} samples a pixel"
    whole = duration(round(planned_seconds(experiment) or 0.0))
    return f"about {whole}: {before}{said} of {duration(experiment.budget or DEFAULT_BUDGET)}"


def planned_seconds(experiment: Experiment) -> float | None:
    """Return the total time in seconds, mostly an upper limit as in `planned`; None if the experiment has no budget."""
    if experiment.spp is not None:
        return None
    rendering = planned_runs(experiment) * (experiment.budget or DEFAULT_BUDGET)
    return _reference_seconds(experiment) * len(experiment.scenes) + rendering + _REPORT_SECONDS


def planned_runs(experiment: Experiment) -> int:
    """Return the number of runs of an experiment: repeats of each strategy on each scene."""
    return experiment.repeats * len(experiment.scenes) * len(experiment.strategies)


def _reference_seconds(experiment: Experiment) -> float:
    """Return the longest time to render one reference; 0 if the reference is a file."""
    return 0.0 if experiment.reference.file is not None else experiment.reference.seconds
