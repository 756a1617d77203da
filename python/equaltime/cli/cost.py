"""The command ``equaltime cost``: measures the time that strategies take to a given error."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from equaltime.cli.cost_folder import cost_folder
from equaltime.cli.cost_output import as_data, recorded
from equaltime.cli.cost_progress import cost_progress
from equaltime.cli.cost_table import print_summary
from equaltime.cli.messages import print_error
from equaltime.cli.options import Substitute, parse_definitions, parse_duration, parse_size, parse_whole
from equaltime.experiments import cost as measure_cost
from equaltime.experiments.model.reader import split_strategies
from equaltime.experiments.run.collection import Changes
from equaltime.rendering.arguments import MOST_THREADS
from equaltime.strict_json import json_text

__all__ = ["cost"]


def cost(
    context: typer.Context,
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE|EXPERIMENT|FOLDER",
            help="Scene file (TOML, Mitsuba 3 XML, or glTF), experiment file (TOML with scenes and strategies), or a "
            "folder of experiments.",
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
            help="Folder for report.html, records.csv, figures and images; made if it is not there. Nothing else in it "
            "is touched.",
        ),
    ],
    quick: Annotated[
        bool, typer.Option("--quick", help="A first look in under a minute: small film, short runs, few repeats.")
    ] = False,
    size: Annotated[
        Any,
        typer.Option(parser=parse_size, metavar="WxH", show_default=False, help="Film size, instead of the scene's."),
    ] = None,
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
            parser=parse_whole(1, 100_000),
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
    strategies: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,C",
            show_default=False,
            help="What to compare: strategies as for render, or labels of the experiment's. key=value belongs to the "
            "one before it [default: the experiment's, or the presets].",
        ),
    ] = None,
    define: Annotated[
        list[str] | None,
        typer.Option("-D", "--define", metavar="NAME=VALUE", show_default=False, help="Set a parameter of the scene."),
    ] = None,
    substitute: Substitute = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the summary as JSON on stdout, and nothing else.")
    ] = False,
) -> int:
    """Measure the time to a given accuracy: how the error of each strategy falls, with error bars.

    Every strategy renders the scene several times, in turn with the other strategies. Errors are measured against a
    reference, which is rendered first and kept for other experiments. The report has the curves, the times to a wanted
    error, the images at equal time and the provenance of all numbers. The last line is the verdict.

    Ctrl-C stops the experiment. The same command continues it and repeats nothing; more --repeats or other --strategies
    are added to the folder. A changed scene, budget, machine or build needs another folder.

    For instance:

    * `equaltime cost cornell-box.toml -o report --quick`

    * `equaltime cost scene.xml -o report --size 256x256 --budget 20s --strategies naive,mis,best`

    * `equaltime cost scene.toml -o report --strategies bsdf,best,best,lights=uniform --repeats 16`

    * `equaltime cost x3-light.toml -o x3`

    * `equaltime cost scenes/experiments -o experiments --quick`

    All experiments of a folder are run one after another, each into its own folder, and `index.html` shows them all.

    Keys of an experiment file (a misspelt key is reported with the nearest known one):

    * `scenes = [{ path = "scene.toml", name, size, max_depth, crop, define, substitute }]`

    * `strategies = ["naive", { label = "ours", strategy = "best,lights=uniform" },
      { label = "theirs", peer = { renderer = "mitsuba", variant, integrator, sampler } },
      { label = "any", peer = { command = "render {scene} {spp} {seed} {out}", limit = "5min" } }]`;
      without `limit`, a peer's render is ended after 60 s plus 20 times the budget (one hour if `spp` is given), but
      never before 60 s plus `reference.seconds`

    * `budget = "10s"` or `spp = [4, 16, 64]`; `repeats = 8`; `baseline = "naive"`; `targets = [0.1, 0.02]`;
      `reference = { error = 0.005, seconds = 60, file }`; `title`, `description`, `crops`, `threads`;
      `theirs = { source, claim, figures, numbers }`
    """
    if source.is_dir():
        if strategies is not None or define or substitute:
            raise typer.BadParameter(
                "--strategies, --define and --substitute are for one scene or experiment, not for a folder of them"
            )
        changes = Changes(quick, size, budget, repeats, threads)
        return cost_folder(source, output, changes, context.obj, as_json)
    try:
        with cost_progress() as progress:
            summary = measure_cost(
                source,
                output,
                quick=quick,
                size=size,
                budget=budget,
                repeats=repeats,
                threads=threads,
                strategies=split_strategies(strategies) if strategies is not None else (),
                define=parse_definitions(define or ()),
                substitute=substitute,
                progress=progress,
                command=context.obj,
            )
    except KeyboardInterrupt:
        print_error(f"interrupted; {recorded(output)}")
        return 130
    if as_json:
        print(json_text(as_data(summary), indent=2))
    else:
        print_summary(summary, output)
    return 0
