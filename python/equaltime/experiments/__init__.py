"""Experiments that measure the time to a given accuracy, their statistics and their reports.

Every number in a report comes from recorded runs. It has an interval, or the reason why no interval can be trusted.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from equaltime.cluster import check_machines
from equaltime.errors import EqualtimeWarning
from equaltime.scene import Scene

if TYPE_CHECKING:
    from equaltime.experiments.model.experiment import Experiment
    from equaltime.experiments.model.summary import Summary
    from equaltime.experiments.run.runner import Begins, ProgressCallback

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
    targets: Sequence[float | str] | float | str | None = None,
    strategies: Sequence[str] = (),
    define: Mapping[str, object] | None = None,
    substitute: bool = False,
    counts: str | os.PathLike[str] | None = None,
    progress: ProgressCallback | None = None,
    command: str = "",
    begins: Begins = lambda experiment, peers, machines: None,
    cluster: Any = None,
) -> Summary:
    """Measure how long several strategies take to reach an error, and write a report.

    Every strategy renders every scene several times, in turn with the other strategies. The error of each render is
    measured at rising sample counts. Call again with the same folder to continue an experiment that was stopped.

    Parameters
    ----------
    source
        An `equaltime.experiments.model.experiment.Experiment`, a scene, the path of a file of either, or a scene as a
        dict with Mitsuba's keys. For a scene the presets are compared, from naive to best. The ``experiment.json`` of
        a folder is the experiment as it was run there, whatever its file holds now.
    folder
        Folder for records, images, figures and ``report.html``. Other files in it are left alone.
    quick
        Shrink the experiment so that it ends in under a minute for one scene.
    size
        Width and height of the films, instead of the scenes' own.
    budget
        Seconds of each run, or text such as ``"10s"``.
    repeats, threads
        Number of renders of each strategy on each scene, and of worker threads; 0 threads stand for one per processor.
        Intervals need 3 repeats, and medians of typical runs 6.
    targets
        Relative errors to which times are given, such as ``[0.05, "2%"]`` or ``"5%"``, instead of the experiment's;
        for a scene the default is 10 %, 5 %, 2 % and 1 %.
    strategies
        Strategies to compare instead of all in ``source``: labels of its strategies, or texts for `Strategy.parse`.
    define
        Values for the variables of a scene file.
    substitute
        Replace the parts of a scene file that cannot be rendered by similar ones that can.
    counts
        Folder of an earlier experiment. Each strategy takes the samples per pixel that it has in the records there,
        whatever time they take here: the images have the same bits on another machine with the same build and
        instruction set. The clock gives the counts of strategies and scenes that the folder lacks.
    progress
        Function that is called with the progress of the experiment (`RunProgress`): present run, time left and so on.
    command
        Command line that started the experiment, for the report's provenance.
    begins
        Function that is called before the first render, with the experiment, as the options changed it, the measured
        times of other renderers that take part (`PeerTimes`), and the number of machines that take runs.
    cluster
        Machines that take the runs, one run at a time: the address of a scheduler of Dask, a ``distributed.Client``, a
        cluster of Dask such as ``SLURMCluster``, an `equaltime.open_cluster` of Dask, or ``local:1``. A worker takes
        part only if its machine and build are like this one's (`equaltime.cluster`). References and films are rendered
        in this process.

    Returns
    -------
    Summary
        The results, with intervals; ``.verdict`` sums them up in a line or two, and ``.verdict_notes`` tells what
        limits it.

    Raises
    ------
    ExperimentError, SceneError
        If a file cannot be read, or the folder belongs to another experiment, build or machine. With a cluster also if
        a strategy is another renderer or an estimator in Python.
    RenderError
        If a render fails, or no machine of the cluster can take runs.
    EqualtimeError
        If the packages of ``equaltime[report]`` are missing, or Dask for a cluster.
    ValueError
        If ``cluster`` is several processes of one machine, or does not tell its machines.

    Warns
    -----
    EqualtimeWarning
        If the repeats are too few for intervals or for medians, unless ``command`` is given: commands tell it with
        their plan.

    Examples
    --------
    >>> summary = et.cost("scene.toml", "report", quick=True, budget="20ms", strategies=("naive", "best"))
    >>> [strategy.label for strategy in summary.scenes[0].strategies]
    ['naive', 'best']
    >>> answer = " ".join((summary.verdict, *summary.verdict_notes))  # the notes tell what limits the verdict
    >>> time = f"{summary.scenes[0].strategies[1].time_to[0.1]:s}"  # with its unit and its interval
    """
    from equaltime.experiments.analysis.summarise import conclude
    from equaltime.experiments.model.plan import too_few
    from equaltime.experiments.model.reader import (  # imported late: rendering alone does not need it
        check_installed,
        make_experiment,
    )
    from equaltime.experiments.model.sources import strategy_files
    from equaltime.experiments.run.folder import ExperimentFolder
    from equaltime.experiments.run.record import counts_of
    from equaltime.experiments.run.runner import run, tell_report

    check_installed()
    check_machines(cluster)  # before the scene is read: without Dask, nothing else is of use
    asked: dict[str, Any] = {
        "quick": quick,
        "size": size,
        "budget": budget,
        "repeats": repeats,
        "threads": threads,
        "targets": targets,
        "strategies": strategies,
        "define": define,
        "substitute": substitute,
    }
    taken = None if counts is None else counts_of(ExperimentFolder(Path(counts)).records)
    experiment = make_experiment(source, **asked, counts=taken)
    if counts is not None:
        asked["counts"] = os.fspath(counts)
    if not command and (few := too_few(experiment.repeats, "repeats=")):
        warnings.warn(few, EqualtimeWarning, stacklevel=2)
    made_from = strategy_files(Path(source), strategies) if isinstance(source, str | os.PathLike) else ()
    record = ExperimentFolder(Path(folder)).experiment.resolve()  # which is written anew, so it is no source of itself
    files = [path for path in made_from if path.resolve() != record]
    call = "" if command else _call(source, asked)
    run(experiment, Path(folder), progress, command=command, begins=begins, files=files, cluster=cluster, call=call)
    return conclude(experiment, Path(folder), command, partial(tell_report, experiment, progress))


def _call(source: object, asked: Mapping[str, Any]) -> str:
    """Return the text of a call of `cost` with the options ``asked``, to repeat it; the folder is named ``folder``."""
    from equaltime.experiments.model.experiment import Experiment

    if isinstance(source, str | os.PathLike):
        name = repr(os.fspath(source))
    else:
        name = "experiment" if isinstance(source, Experiment) else "scene"
    options = (
        f"{key}={value!r}"
        for key, value in asked.items()
        if not (value is None or value is False or value in ((), [], {}))
    )
    return f"et.cost({', '.join((name, 'folder', *options))})"
