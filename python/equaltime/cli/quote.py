"""``equaltime quote``."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from equaltime.cli.arguments import parse_definitions
from equaltime.cli.messages import duration, percent, print_warnings
from equaltime.cli.options import (
    Crop,
    Define,
    ErrorTarget,
    MaxDepth,
    SceneFile,
    Seed,
    Size,
    StrategyWords,
    Substitute,
    Threads,
    Time,
)
from equaltime.cli.progress import progress_bar
from equaltime.error_estimate import Estimate
from equaltime.noise_places import Places
from equaltime.quote import Quote
from equaltime.quote import quote as quote_scene
from equaltime.scene import load_file

__all__ = ["quote"]

_WORTH_TELLING = 0.01
"""A share of error²."""
_MOST_PIXELS = 3


def quote(
    scene: SceneFile,
    error: ErrorTarget = None,
    time: Time = None,
    size: Size = None,
    crop: Crop = None,
    max_depth: MaxDepth = None,
    strategy: StrategyWords = "best",
    seed: Seed = 0,
    threads: Threads = 0,
    define: Define = None,
    substitute: Substitute = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on stdout, and nothing else.")] = False,
) -> int:
    """Tell what an error will cost, or what a time will buy, before it is rendered.

    A pilot of 8 samples a pixel, or of a twentieth of the work, tells how fast the error falls.

    For instance:

    * `equaltime quote scene.toml --error 2%`

    * `equaltime quote scene.toml --time 30s --size 1920x1080`
    """
    if (error is None) == (time is None):
        raise typer.BadParameter("give --error or --time, one of them")
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    print_warnings(loaded)
    changes = {"size": size, "crop": crop, "max_depth": max_depth}
    loaded = loaded.with_(**{name: value for name, value in changes.items() if value is not None})
    with progress_bar(as_json) as progress:
        found = quote_scene(loaded, error, time, strategy, seed, threads, progress)
    if as_json:
        print(json.dumps(found.as_dict(), indent=2))
    else:
        _print(found)
    return 0


def _print(found: Quote) -> None:
    console = Console(highlight=False)
    law = found.law
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("time", _range(found.seconds, duration))
    table.add_row("samples per pixel", _range(found.spp, "{:.3g}".format))
    table.add_row("error", _range(found.error, percent))
    if found.error.doubt:
        table.add_row("in doubt", found.error.doubt)
    table.add_row("memory", f"{found.memory / 1e6:.3g} MB")
    speed = duration(law.seconds_per_sample)
    exponent = f"{law.exponent:.2f} ± {1.96 * law.exponent_doubt:.2f}"
    table.add_row("law", f"{percent(law.error)} at {law.samples} spp, falling as spp^-({exponent}); {speed} a sample")
    if found.places is not None:
        _add_places(table, found.places)
    for target, seconds in found.prices.items():
        table.add_row(f"{percent(target)} would take", _range(seconds, duration))
    table.add_row("this quote took", duration(found.pilot_seconds))
    console.print(table)


def _add_places(table: Table, places: Places) -> None:
    (least, worst), *others = places.noisiest.items()
    more = "".join(f", the noisiest {percent(part)} make {_share(share)}" for part, share in others)
    table.add_row("where", f"the noisiest {percent(least)} of the pixels make {_share(worst)} of error²{more}")
    held = places.rectangle
    if held.stands_out:
        across, down = (f"{first} to {last}" for first, last in (held.x, held.y))
        area = f"{100.0 * held.area:.2g} % of the picture"
        table.add_row("", f"x {across}, y {down}, which is {area}, make {_share(held.share)} of error²")
    else:
        table.add_row("", "no rectangle of the picture stands out")
    if places.single.value > _WORTH_TELLING:
        count = len(places.single_pixels)
        words = "a single pixel makes" if count == 1 else f"{count} single pixels make"
        at = "; ".join(f"{x},{y}" for x, y in places.single_pixels[:_MOST_PIXELS])
        more = "; …" if count > _MOST_PIXELS else ""
        table.add_row("", f"{words} {_share(places.single)} of error², far above those around: {at}{more}")


def _share(share: Estimate) -> str:
    return (
        rf"{_whole(share.value)} % \[{_whole(share.low)}, {_whole(share.high)}]" if share.known else "an unknown part"
    )


def _whole(share: float) -> str:
    """Write a share in whole per cent, or with two digits if it is less than ten."""
    return f"{100.0 * share:.0f}" if abs(share) >= 0.095 else f"{100.0 * share:.2g}"


def _range(estimate: Estimate, words: Callable[[float], str]) -> str:
    if not estimate.high > estimate.low:
        return words(estimate.value)
    return rf"{words(estimate.value)} \[{words(estimate.low)}, {words(estimate.high)}]"
