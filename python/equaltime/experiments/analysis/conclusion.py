"""Conclusion of an experiment: its summary, the comparison with published numbers, and the report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from equaltime.experiments import report
from equaltime.experiments.analysis import summarise as analysis
from equaltime.experiments.analysis.beside import beside
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.run import record
from equaltime.experiments.run.folder import ExperimentFolder

__all__ = ["conclude"]


def conclude(experiment: Experiment, folder: Path, command: str = "") -> Summary:
    """Summarise the records in ``folder``, write the report to the same folder, and return the summary.

    Parameters
    ----------
    command
        Command line that started the experiment, for the report's provenance.
    """
    rows = record.complete(record.load(ExperimentFolder(folder).records))
    summary = analysis.summarise(experiment, rows, folder)
    if command:
        summary = replace(summary, provenance={"command": command, **summary.provenance})
    summary = _with_pictures(summary, experiment, ExperimentFolder(folder))
    if experiment.theirs is not None:
        summary = replace(summary, theirs=experiment.theirs, beside=beside(experiment.theirs, summary))
    report.write_report(summary, folder)
    return summary


def _with_pictures(summary: Summary, experiment: Experiment, folder: ExperimentFolder) -> Summary:
    """Add the films and figures that the experiment asks for, if their files exist."""
    if experiment.animate:
        scenes = tuple(
            replace(
                scene, strategies=tuple(_with_film(one, folder.film(scene.name, one.label)) for one in scene.strategies)
            )
            for scene in summary.scenes
        )
        summary = replace(summary, scenes=scenes)
    if "directions" in experiment.figures and folder.directions.exists():
        summary = replace(summary, directions=folder.directions)
    return summary


def _with_film(strategy: StrategyResult, path: Path) -> StrategyResult:
    return replace(strategy, film=path) if path.exists() else strategy
