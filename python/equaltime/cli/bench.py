"""The command ``equaltime bench``: measures how fast scenes render."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from equaltime.bench import Benchmark, Measurement, measure
from equaltime.cli.messages import plain_console, print_json, print_line, print_remarks
from equaltime.cli.options import AsJson, Define, MaxDepth, Size, Substitute, Verbose, parse_definitions, parse_whole
from equaltime.cli.progress import progress_bar
from equaltime.rendering.job import MOST_THREADS
from equaltime.scene import load_file
from equaltime.scene.model import MOST_SAMPLES
from equaltime.statistics.in_words import figure, in_percent, span
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["bench"]

_FEWEST_FOR_INTERVALS = 6
"""Least number of repeats whose extremes hold the median in 95 % of cases."""


def parse_threads(text: str) -> tuple[int, ...]:
    """Parse thread counts separated by commas, such as ``1,2``, and return them as integers.

    0 stands for one thread per processor. Raises typer.BadParameter for any other text.
    """
    words = text.replace(" ", "").split(",")
    if not all(word.isascii() and word.isdigit() and int(word) <= MOST_THREADS for word in words):
        raise typer.BadParameter(f"'{text}' is no list of numbers of threads up to {MOST_THREADS}; write 1,2")
    return tuple(map(int, words))


def bench(
    scenes: Annotated[
        list[Path],
        typer.Argument(metavar="SCENE...", help="Scene files: TOML, Mitsuba 3 XML, or glTF.", show_default=False),
    ],
    threads: Annotated[
        Any,
        typer.Option(
            parser=parse_threads, metavar="N,N,…", help="Numbers of worker threads; 0 is one for each processor."
        ),
    ] = "0",
    repeats: Annotated[
        int,
        typer.Option(
            parser=parse_whole(1, 1000),
            metavar="N",
            help="Repeats of each scene and number of threads; 6 or more for 95 % intervals.",
        ),
    ] = 9,
    spp: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(1, MOST_SAMPLES),
            metavar="N",
            show_default=False,
            help="Samples per pixel in each repeat [default: what takes about half a second].",
        ),
    ] = None,
    size: Size = None,
    max_depth: MaxDepth = None,
    strategy: Annotated[str, typer.Option(metavar="S", help="As for render.")] = "best",
    define: Define = None,
    substitute: Substitute = False,
    as_json: AsJson = False,
    verbose: Verbose = False,
) -> int:
    """Measure how fast scenes render.

    Prints rays per second, with -v also paths per second, and the limit ratio: the time in which Embree alone traces
    the render's rays, divided by the time of the render. Repeats alternate between scenes and thread counts. The
    printed numbers are medians with their 95 % intervals.


    For instance: `equaltime bench cornell-box.toml veach-mis.toml --threads 1,2`
    """
    chosen = Strategy.parse(strategy)
    definitions = parse_definitions(define or ())
    loaded = [
        load_file(path, definitions, substitute=substitute).with_(size=size, max_depth=max_depth) for path in scenes
    ]
    for scene in loaded:
        print_remarks(scene)
    with progress_bar() as progress:
        report = measure(loaded, threads=threads, repeats=repeats, spp=spp, strategy=chosen, progress=progress)
    if as_json:
        print_json(report)
    else:
        _print(report, verbose)
    return 0


def _print(report: Benchmark, verbose: bool) -> None:
    """Print the speed of the first scene in a sentence, and a table if there is more than one measurement."""
    console = plain_console()
    print_line(console, _answer(report.scenes[0]))
    if verbose or len(report.scenes) > 1:
        console.print(_table(report.scenes, verbose))
    for line in (_measured(report), *_provenance(report)) if verbose else (_measured(report),):
        print_line(console, line, "dim")


def _answer(row: Measurement) -> str:
    rays = f"{figure(1e-6 * row.rays_per_s.value)} million rays a second {span(row.rays_per_s, 1e-6)}".rstrip()
    share = f"{in_percent(row.limit_ratio)} of the speed of Embree alone"
    return f"{Path(row.name).name}: {rays} on {_threads(row.threads)}, {share}."


def _threads(count: int) -> str:
    return f"{count} {'thread' if count == 1 else 'threads'}"


def _table(rows: Sequence[Measurement], verbose: bool) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("scene", overflow="fold")
    for heading in ("threads", *(("M paths/s",) if verbose else ()), "M rays/s", "limit ratio", "scaling"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        paths = (_interval(row.paths_per_s, 1e-6),) if verbose else ()
        speeds = (_interval(row.rays_per_s, 1e-6), _interval(row.limit_ratio), _interval(row.scaling))
        table.add_row(Path(row.name).name, str(row.threads), *paths, *speeds)
    return table


def _measured(report: Benchmark) -> str:
    """Return a line on the repeats, the meaning of the numbers, and the load of the machine."""
    repeats = report.scenes[0].repeats
    interval = "95 % intervals" if repeats >= _FEWEST_FOR_INTERVALS else "ranges"
    counted = f"{repeats} {'repeat' if repeats == 1 else 'repeats'}"
    machine = report.machine
    load = f"load {machine['load_average']:.2f} on {machine['processors']} processors"
    return f"Medians of {counted} with their {interval}, at {load}."


def _provenance(report: Benchmark) -> Iterator[str]:
    machine, build = report.machine, report.build
    yield f"limit ratio: time of Embree alone for the same rays, over the time of the render. {machine['cpu']}"
    yield f"equaltime {build['version']}, {build['compiler']}, {build['target']}, Embree {build['embree']}"


def _interval(value: Interval, scale: float = 1.0) -> str:
    return f"{figure(scale * value.value)} ±{50 * (value.high - value.low) / value.value:.2g}%"
