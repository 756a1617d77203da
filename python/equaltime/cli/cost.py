"""The command ``equaltime cost``: measures the time that strategies take to a given error."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from equaltime.cli.cost_table import print_summary
from equaltime.cli.messages import print_aside, print_error, print_json, print_lines
from equaltime.cli.options import (
    Define,
    OnMachines,
    Size,
    Substitute,
    Verbose,
    parse_definitions,
    parse_duration,
    parse_percents,
    parse_whole,
)
from equaltime.cli.progress import progress_bar
from equaltime.errors import ExperimentError
from equaltime.examples import example_of, experiments_of
from equaltime.experiments import cost as measure_cost
from equaltime.experiments.model.experiment import MOST_REPEATS, Experiment
from equaltime.experiments.model.plan import PeerTimes, planned
from equaltime.experiments.model.reader import check_installed, split_strategies
from equaltime.experiments.report.index import Card
from equaltime.experiments.run.collection import Changes, run_all
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import load
from equaltime.rendering.job import MOST_THREADS

__all__ = ["cost"]


def cost(
    context: typer.Context,
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE|EXPERIMENT|FOLDER",
            help="Scene file (TOML, Mitsuba 3 XML, or glTF), experiment file (TOML with scenes and strategies, or "
            "DIR/experiment.json, the experiment as it was run in DIR), or a folder of experiments.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            show_default=False,
            help="Folder for report.html, records.csv, figures and images; made if missing. Other files in it stay as "
            "they are.",
        ),
    ],
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="A first look in under a minute: small film, short runs, few repeats. Other renderers take longer: "
            "the first line says how long.",
        ),
    ] = False,
    size: Size = None,
    budget: Annotated[
        float | None,
        typer.Option(
            parser=parse_duration,
            metavar="DURATION",
            show_default=False,
            help="Time of each run, first sample to last: 10s, 500ms, 2m [default: the experiment's, or 10s].",
        ),
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(1, MOST_REPEATS),
            metavar="N",
            show_default=False,
            help="Runs of each strategy on each scene; intervals come from their spread "
            "[default: the experiment's, or 8].",
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(0, MOST_THREADS),
            metavar="N",
            show_default=False,
            help="Worker threads; 0 is one for each processor [default: the experiment's, or 0].",
        ),
    ] = None,
    targets: Annotated[
        Any,
        typer.Option(
            parser=parse_percents,
            metavar="ERRORS",
            show_default=False,
            help="Errors to which times are given: 5%,2% [default: the experiment's, or 10%,5%,2%,1%].",
        ),
    ] = None,
    strategies: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,C",
            show_default=False,
            help="Strategies to compare, as for render, or labels of the experiment's. key=value belongs to the "
            "strategy before it. Ratios are over the experiment's baseline, else over naive, else over the first other "
            "than best [default: the experiment's, or the presets].",
        ),
    ] = None,
    cluster: OnMachines = None,
    define: Define = None,
    substitute: Substitute = False,
    counts: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            show_default=False,
            help="Folder of an earlier experiment whose counts of samples are taken, whatever time they need here: the "
            "same images on another machine, with the same build and instruction set.",
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the summary as JSON on stdout, and nothing else.")
    ] = False,
    verbose: Verbose = False,
) -> int:
    """Measure the time to a given accuracy: how the error of each strategy falls, with error bars.

    Every strategy renders the scene several times, in turn with the other strategies. Errors are measured against a
    reference, which is rendered first and kept for other experiments. The report has the curves, the times to a wanted
    error, the images at equal time and the provenance of all numbers. The first and the last line are the verdict.

    Ctrl-C stops the experiment. The same command continues it and repeats nothing; more --repeats or other --strategies
    are added to the folder. A changed scene, budget, machine or build needs another folder.

    With `--cluster`, runs are spread over machines like this one; unlike machines take no part, as times are compared.

    For instance:

    * `equaltime cost cornell-box.toml -o report --quick`

    * `equaltime cost scene.xml -o report --size 256x256 --budget 20s --strategies naive,mis,best`

    * `equaltime cost scene.toml -o report --strategies bsdf,best,best,lights=uniform --repeats 16`

    * `equaltime cost x3-light.toml -o x3`

    * `equaltime cost scenes/experiments -o experiments --quick`

    All experiments of a folder are run one after another, each into its own folder, and `index.html` shows them all.

    Keys of an experiment file (a misspelt key is reported with the nearest known one):

    * `scenes = ["scene.toml", { path = "other.toml", name, size, max_depth, crop, crops, define,
      substitute }]`

    * `strategies = ["naive", { label = "ours", strategy = "best,lights=uniform" },
      { label = "theirs", peer = { renderer = "mitsuba", variant, integrator, sampler } },
      { label = "any", peer = { command = "render {scene} {spp} {seed} {out}", limit = "5min" } }]`;
      without `limit`, a peer's render is ended after 60 s plus 20 times the budget (one hour if `spp` is given), but
      never before 60 s plus `reference.seconds`

    * `budget = "10s"` or `spp = [4, 16, 64]`; `repeats = 8`; `baseline = "naive"`; `targets = ["10%", "2%"]`;
      `reference = { error = 0.005, seconds = 60, file }`; `title`, `description`, `crops`, `threads`;
      `theirs = { source, claim, figures, numbers }`
    """
    if example := example_of(source) or experiments_of(source):
        print_aside(f"{source} is the example {example}")
        source = example
    if source.is_dir():
        if strategies is not None or define or substitute or counts is not None:
            raise typer.BadParameter(
                "--strategies, --define, --substitute and --counts are for one scene or experiment, not for a folder"
            )
        changes = Changes(quick, size, budget, repeats, threads, targets)
        return _cost_of_all(source, output, changes, context.obj, as_json, cluster)
    try:
        with progress_bar() as progress:
            summary = measure_cost(
                source,
                output,
                quick=quick,
                size=size,
                budget=budget,
                repeats=repeats,
                threads=threads,
                targets=targets,
                strategies=split_strategies(strategies) if strategies is not None else (),
                define=parse_definitions(define or ()),
                substitute=substitute,
                counts=counts,
                progress=progress,
                command=context.obj,
                begins=lambda *begun: print_aside(_plan(*begun)),
                cluster=cluster,
            )
    except KeyboardInterrupt:
        print_error(f"interrupted; {_recorded(output)}")
        return 130
    if as_json:
        print_json(summary)
    else:
        print_summary(summary, output, verbose, quick)
    return 0


def _cost_of_all(source: Path, output: Path, changes: Changes, command: str, as_json: bool, cluster: str | None) -> int:
    """Run or continue every experiment file in the folder ``source``, with results in ``output``.

    Returns the exit code: 0 if all ran, 1 if an experiment failed, 130 after Ctrl-C. ``command`` is the command line,
    which the reports show. ``cluster`` is the place of the machines that take the runs; None for this process.
    """
    check_installed()

    def announce(name: str, experiment: Experiment, peers: PeerTimes, machines: int) -> None:
        print_aside(f"{name}: {_plan(experiment, peers, machines)}")

    def tell(card: Card) -> None:
        if card.state == "failed":
            print_error(f"{card.name}: {card.problem}")
        elif not as_json:
            print_lines([f"{card.name}: {card.summary.verdict if card.summary else f'left out: {card.problem}'}"])

    try:
        with progress_bar() as progress:
            cards = run_all(source, output, changes, progress, tell, command, announce, cluster)
    except KeyboardInterrupt:
        print_error(f"interrupted; {_recorded(output)}")
        return 130
    if as_json:
        print_json(cards)
    else:
        print(f"All of them: open {output / 'index.html'}")
    return 1 if any(card.state == "failed" for card in cards) else 0


def _plan(experiment: Experiment, peers: PeerTimes, machines: int) -> str:
    """Return a sentence on the planned runs, and the strategy with which the others are compared."""
    compared = f"; the baseline of all ratios is {experiment.baseline}" if len(experiment.strategies) > 1 else ""
    return f"{planned(experiment, peers, machines)}{compared}"


def _recorded(folder: Path) -> str:
    """Return a sentence on how many finished runs the records of a folder and its subfolders hold."""
    runs = _runs(folder)
    if runs == 0:
        return "no run was finished"
    return f"{runs} {'run is' if runs == 1 else 'runs are'} recorded in {folder}; the same command goes on from there"


def _runs(folder: Path) -> int:
    """Count the recorded runs of a folder and of its subfolders."""
    try:
        records = [ExperimentFolder(folder).records, *folder.glob("*/records.csv")]
        return sum(row.last for path in records for row in load(path))
    except ExperimentError:
        return 0
