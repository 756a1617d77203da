"""What accuracy costs in time: metrics, statistics, experiments and their reports.

A number that is shown comes from a record, and has an interval, or says why none can be trusted.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from equaltime.scene import Scene

if TYPE_CHECKING:
    from equaltime.experiments.model.experiment import Experiment
    from equaltime.experiments.model.summary import Summary
    from equaltime.experiments.run.runner import ProgressCallback

__all__ = ["cost"]


def cost(
    source: Experiment | Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str],
    *,
    quick: bool = False,
    size: tuple[int, int] | None = None,
    budget: float | str | None = None,
    repeats: int | None = None,
    threads: int | None = None,
    strategies: Sequence[str] = (),
    define: Mapping[str, object] | None = None,
    substitute: bool = False,
    progress: ProgressCallback | None = None,
    command: str = "",
) -> Summary:
    """Measure what accuracy costs in time with several strategies, and write a report of it.

    Every strategy renders every scene several times, in turn, and its error is measured at rising sample counts. An
    experiment that was stopped goes on where it was when it is called again with the same folder.

    Parameters
    ----------
    source
        An `equaltime.experiments.model.experiment.Experiment`, a scene, the path of a file of either, or a scene as a
        dict in Mitsuba's words. For a scene the presets are compared, from naive to best.
    folder
        Where records, images, figures and ``report.html`` go. Nothing else in it is touched.
    quick
        Make it so small that it ends in under a minute (for one scene): a first look.
    size
        Width and height of the films, instead of the scenes' own.
    budget
        Seconds of each run, or text such as ``"10s"``.
    repeats, threads
        Of each strategy on each scene; worker threads, 0 is one for each processor.
    strategies
        What is compared, instead: labels of the experiment's strategies, or strategies as for `Strategy.parse`.
    define
        Values for the variables of a scene file.
    substitute
        Replace what a scene file has and cannot be rendered, as `equaltime.load` does.
    progress
        Called with an `equaltime.experiments.run.runner.RunProgress` as the experiment goes on.
    command
        The command line that asked for it; the report's provenance has it.

    Returns
    -------
    Summary
        All that was found, with intervals; ``.verdict`` says it in a sentence.

    Raises
    ------
    ExperimentError, SceneError
        If something cannot be read, or the folder belongs to another experiment, build or machine.
    RenderError
        If a render fails.
    EqualtimeError
        If the packages of ``equaltime[report]`` are missing.
    """
    from equaltime.experiments.analysis.conclusion import conclude
    from equaltime.experiments.model.making import (  # of no use to those who only render
        check_installed,
        make_experiment,
    )
    from equaltime.experiments.run.runner import run

    check_installed()
    experiment = make_experiment(
        source,
        quick=quick,
        size=size,
        budget=budget,
        repeats=repeats,
        threads=threads,
        strategies=strategies,
        define=define,
        substitute=substitute,
    )
    run(experiment, Path(folder), progress, command=command)
    return conclude(experiment, Path(folder), command)
