"""The command ``equaltime quote``: predicts time or error of a render."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import Annotated

import typer

from equaltime.cli.lines import in_columns
from equaltime.cli.messages import print_aside, print_connecting, print_json, print_lines, print_remarks
from equaltime.cli.options import (
    AsJson,
    Crop,
    Define,
    MaxDepth,
    OnCluster,
    SceneFile,
    Seed,
    Size,
    StrategyWords,
    Substitute,
    Threads,
    Transparent,
    Verbose,
    Without,
    parse_definitions,
    parse_duration,
    parse_percent,
    parse_whole,
)
from equaltime.cli.progress import progress_bar
from equaltime.cli.quote_answer import Asked, answer
from equaltime.cli.quote_details import details
from equaltime.cli.recorded import plain, recorded_options, shown_path
from equaltime.quoting.left_out import samples_to_measure
from equaltime.quoting.pilot import FEWEST, Quote
from equaltime.quoting.quote import DEFAULT_SECONDS, USUAL_SECONDS, seconds_of_pilot
from equaltime.quoting.quote import quote as quote_scene
from equaltime.scene import Scene, load_file
from equaltime.scene.model import MOST_SAMPLES
from equaltime.statistics.in_words import rounded
from equaltime.strategy import Strategy

__all__ = ["quote"]


def quote(
    scene: SceneFile,
    time: Annotated[
        float | None,
        typer.Option(
            parser=parse_duration,
            metavar="DURATION",
            show_default=False,
            help="How accurate after this long? Such as 30s, 500ms, 1h30m.",
        ),
    ] = None,
    error: Annotated[
        float | None,
        typer.Option(
            parser=parse_percent,
            metavar="PERCENT",
            show_default=False,
            help="How long does this accuracy take? Such as 2%.",
        ),
    ] = None,
    spp: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(1, MOST_SAMPLES),
            metavar="N",
            show_default=False,
            help="How accurate, and how long, with this many samples a pixel?",
        ),
    ] = None,
    size: Size = None,
    crop: Crop = None,
    max_depth: MaxDepth = None,
    define: Define = None,
    substitute: Substitute = False,
    transparent: Transparent = False,
    strategy: StrategyWords = "best",
    seed: Seed = 0,
    threads: Threads = 0,
    cluster: OnCluster = None,
    without: Without = None,
    why: Annotated[
        bool | None,
        typer.Option(
            "--why/--no-why",
            show_default=False,
            help="Find which light makes the noise, even if that doubles the time of the quote; or never. "
            "By default, only if it takes little time.",
        ),
    ] = None,
    verbose: Verbose = False,
    as_json: AsJson = False,
) -> int:
    """Predict how accurate a picture will be, or how long it takes, before rendering.

    Renders a small test first, usually under ten seconds, and predicts the rest from it. Without `--time`, `--error`
    and `--spp` it predicts the error after 30 s, and the times to 10, 5, 2 and 1 %. After Ctrl-C, it predicts from the
    samples so far.

    For instance:

    * `equaltime quote scene.toml`

    * `equaltime quote scene.toml --error 2%`

    * `equaltime quote scene.toml --time 30s --size 1920x1080`

    * `equaltime quote scene.toml --without lens`
    """
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    print_remarks(loaded)
    loaded = loaded.with_(size=size, crop=crop, max_depth=max_depth, transparent=transparent)
    chosen = Strategy.parse(strategy)
    samples = FEWEST + (samples_to_measure(loaded) if without else 0)
    if (expected := seconds_of_pilot(loaded, chosen, threads, samples)) > USUAL_SECONDS:
        print_aside(f"this quote takes about {rounded(expected)} s, as {samples} samples a pixel do")
    if time is None and error is None and spp is None:
        time = DEFAULT_SECONDS
    print_connecting(cluster)
    with progress_bar(as_json) as progress:
        found = quote_scene(
            loaded,
            error=error,
            time=time,
            spp=spp,
            strategy=chosen,
            seed=seed,
            threads=threads,
            progress=progress,
            why=why,
            cluster=cluster,
            without=without or (),
        )
    if as_json:
        print_json(found)
    else:
        print_lines(answer(found, Asked(time, error, spp, tuple(without or ())), verbose))
        if verbose:
            print_lines(["", *in_columns(details(found, why))])
        if found.origin.without and loaded.source is not None:
            print_lines([f"to render it: {shlex.join(_command(found, loaded, (time, error, spp)))}"])
    return 130 if found.interrupted else 0


def _command(found: Quote, scene: Scene, limits: tuple[float | None, float | None, int | None]) -> Iterator[str]:
    """Yield the words of the command that makes the quoted render; ``limits`` are its time, error and samples."""
    time, error, spp = limits
    assert scene.source is not None
    yield from ("equaltime", "render", shown_path(scene.source), "-o", f"{scene.source.stem}.exr")
    yield from () if time is None else ("--time", f"{plain(time)}s")
    yield from () if error is None else ("--error", f"{100.0 * error:.6g}%")
    yield from () if spp is None else ("--spp", str(spp))
    usual = {"defines": {}, "transparent": False, "crop": [*scene.model.sensor.film.crop]}
    yield from recorded_options({**usual, **found.origin.record}, found.origin.seed)
