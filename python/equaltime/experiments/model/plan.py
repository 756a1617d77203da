"""Sentence on the planned runs of an experiment and their approximate time, to be shown before the first run."""

from __future__ import annotations

from equaltime.experiments.model.experiment import DEFAULT_BUDGET, Experiment
from equaltime.words import duration

__all__ = ["planned"]

_REPORT_SECONDS = 5.0
"""Seconds that loading and the report of a small experiment take."""


def planned(experiment: Experiment) -> str:
    """Return a sentence on the planned references and runs; with a time budget, it gives the total time.

    The time is mostly an upper limit: references may end earlier, and runs that a folder already holds are not
    repeated.
    """
    runs = experiment.repeats * len(experiment.scenes) * len(experiment.strategies)
    said = f"{runs} run{'s' * (runs != 1)}"
    references = 0.0 if experiment.reference.file is not None else experiment.reference.seconds
    before = f"references of up to {duration(references)} each, then " if references else ""
    if experiment.spp is not None:
        return f"{before}{said} of {experiment.spp[-1]:,} samples a pixel"
    budget = experiment.budget or DEFAULT_BUDGET
    whole = references * len(experiment.scenes) + runs * budget + _REPORT_SECONDS
    return f"about {duration(round(whole))}: {before}{said} of {duration(budget)}"
