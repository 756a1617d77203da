"""The command ``equaltime effects``: lists the effects, such as motion blur, that a scene uses, with their costs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from equaltime.cli.messages import WAYS, plain_console, print_json, print_warnings
from equaltime.cli.options import (
    AsJson,
    Define,
    MaxDepth,
    SceneFile,
    Seed,
    Size,
    StrategyWords,
    Substitute,
    Threads,
    parse_definitions,
)
from equaltime.cli.progress import progress_bar
from equaltime.errors import ImageError
from equaltime.images import image_files as images
from equaltime.images import preview
from equaltime.pricing import Price, PriceList
from equaltime.pricing import effects as measure_effects
from equaltime.rendering.output_files import check_spares
from equaltime.rendering.stated import other_depth
from equaltime.scene import load_file
from equaltime.statistics.intervals import Interval
from equaltime.words import percent

__all__ = ["effects"]

_MOST_REASONS = 3
_SHARES = {
    "length": "by the length of the path (2: direct light)",
    "way": "by how the light was found",
    "bsdf": "by the last surface that scattered it",
    "light": "by the light",
}


def effects(
    scene: SceneFile,
    quick: Annotated[bool, typer.Option("--quick", help="A first look, in seconds.")] = False,
    size: Size = None,
    max_depth: MaxDepth = None,
    strategy: StrategyWords = "best",
    seed: Seed = 0,
    threads: Threads = 0,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            show_default=False,
            help="Folder for pictures of what changes without each effect: without-EFFECT.exr, the image without it "
            "less the image, and .png, its absolute value.",
        ),
    ] = None,
    define: Define = None,
    substitute: Substitute = False,
    as_json: AsJson = False,
) -> int:
    """List the effects, such as motion blur, that a scene uses, and what each costs in time, in noise and in memory.

    The scene is rendered in turn with and without each effect that can be left out, on a smaller film. Effects that the
    scene does not use cost nothing.


    For instance: `equaltime effects scene.toml --quick`
    """
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    if output is not None:
        _check_folder(output)
        places = (path for path in output.iterdir() if path.suffix in (".exr", ".png"))
        check_spares(places, loaded.files, "the scene is made of this file")
    print_warnings(loaded)
    loaded = loaded.with_(max_depth=max_depth)
    with progress_bar() as progress:
        found = measure_effects(
            loaded, quick=quick, size=size, strategy=strategy, seed=seed, threads=threads, progress=progress
        )
    if as_json:
        print_json(found)
    else:
        _print(found)
    if output is not None:
        _write_differences(found, output)
    return 0


def _check_folder(folder: Path) -> None:
    """Make a folder; raise ImageError before any measurement if it cannot be written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ImageError(f"{folder}: {error.strerror or error}") from error
    images.check_writable(folder / "without.exr", (".exr",))


def _write_differences(found: PriceList, folder: Path) -> None:
    for price in found.prices:
        if price.difference is None:
            continue
        name = f"without-{price.kind.name}"
        images.write_exr(folder / f"{name}.exr", price.difference, name)
        preview.write_png(folder / f"{name}.png", np.abs(price.difference), name)


def _print(found: PriceList) -> None:
    console = plain_console()
    table = Table(box=None, pad_edge=False)
    table.add_column("effect", no_wrap=True)
    for heading in ("time", "variance", "memory", "error without"):
        table.add_column(heading, justify="right", no_wrap=True)
    for price in found.prices:
        table.add_row(*_cells(price))
    console.print(table)
    for price in found.prices:
        reasons = [str(reason) for reason in price.reasons[:_MOST_REASONS]]
        more = len(price.reasons) - len(reasons)
        words = "; ".join(reasons) + (f"; and {more:,} more" if more else "")
        end = f"without it: {price.instead}" if price.instead else "cannot be left out"
        console.print(f"{price.kind.name}: {price.kind.title}, for {words}; {end}", soft_wrap=True)
    console.print(f"free, since nothing calls for them: {', '.join(found.free)}", soft_wrap=True)
    for kind, title in _SHARES.items():
        if len(found.shares[kind]) > 1:
            console.print(f"variance {title}: {'; '.join(_shares(found.shares[kind]))}", soft_wrap=True)
    if found.truncated:
        cut = "; ".join(f"{depth}: {_brief(error)}" for depth, error in found.truncated.items())
        console.print(f"error of paths cut at depth {cut}", soft_wrap=True)
    if found.outputs:
        times = "; ".join(f"{name} {_brief(share)}" for name, share in found.outputs.items())
        console.print(f"time of outputs beside the image, each by itself: {times}", soft_wrap=True)
    if depth := other_depth(found.max_depth, found.scene_max_depth):
        console.print(f"all of this is of {depth}", soft_wrap=True)
    width, height = found.size
    measured = f"{found.repeats} repeats of {found.samples} samples a pixel of {width}x{height}, {found.strategy}"
    console.print(f"shares and errors with their 95 % intervals, from {measured}", style="dim", soft_wrap=True)


def _cells(price: Price) -> tuple[str, ...]:
    return (
        price.kind.name,
        _brief(price.time),
        _brief(price.variance),
        "" if price.memory is None else f"{price.memory / 1e3:,.0f} kB",
        _brief(price.change),
    )


def _shares(shares: Mapping[str, Interval]) -> Iterator[str]:
    """Yield the shares as text, the largest first; lengths of paths keep their order."""
    lengths = all(what.split()[0].isdigit() for what in shares)
    ordered = shares.items() if lengths else sorted(shares.items(), key=lambda item: -item[1].value)
    for what, share in ordered:
        yield f"{WAYS.get(what, what)} {_brief(share)}"


def _brief(interval: Interval | None) -> str:
    if interval is None:
        return ""
    if not math.isfinite(interval.value):
        return "unknown"
    half = 0.5 * (interval.high - interval.low)
    value = interval.value if abs(interval.value) > 1e-3 * half else 0.0
    return f"{percent(value)} ±{100.0 * half:.2g}"
