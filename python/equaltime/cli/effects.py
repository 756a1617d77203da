"""The command ``equaltime effects``: lists the effects, such as motion blur, that a scene uses, with their costs."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from equaltime.cli.effects_table import print_effects
from equaltime.cli.messages import print_json, print_remarks, softer_sun
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
    Verbose,
    parse_definitions,
)
from equaltime.cli.progress import progress_bar
from equaltime.errors import ImageError
from equaltime.images import image_files as images
from equaltime.images import preview
from equaltime.pricing import PriceList
from equaltime.pricing import effects as measure_effects
from equaltime.rendering.output_files import check_spares
from equaltime.scene import load_file

__all__ = ["effects"]


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
            help="Folder for pictures of the change that leaving out each effect makes: without-EFFECT.exr, the image "
            "without the effect less the full image, and .png, the absolute value.",
        ),
    ] = None,
    define: Define = None,
    substitute: Substitute = False,
    as_json: AsJson = False,
    verbose: Verbose = False,
) -> int:
    """List the effects, such as motion blur, that a scene uses, and what each costs in time, in noise and in memory.

    The scene is rendered in turn with and without each effect that can be left out, on a smaller film. Effects that the
    scene does not use cost nothing. The step that saves most is proposed, if the picture is then off by at most 10 %.

    For instance: `equaltime effects scene.toml --quick`
    """
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    if output is not None:
        _check_folder(output)
        places = (path for path in output.iterdir() if path.suffix in (".exr", ".png"))
        check_spares(places, loaded.files, "the scene is made of this file")
    print_remarks(loaded)
    loaded = loaded.with_(max_depth=max_depth)
    with progress_bar() as progress:
        found = measure_effects(
            loaded, quick=quick, size=size, strategy=strategy, seed=seed, threads=threads, progress=progress
        )
    if as_json:
        print_json(found)
    else:
        words = [word for pair in define or () for word in ("-D", pair)] + ["--substitute"] * substitute
        words += [] if size is None else ["--size", f"{size[0]}x{size[1]}"]
        words += [] if max_depth is None else ["--max-depth", str(max_depth)]
        words += [] if strategy == "best" else ["--strategy", strategy]
        command = shlex.join(["equaltime", "render", str(scene), "-o", f"{scene.stem}.exr", *words])
        print_effects(found, scene.name, command, verbose, softer_sun(loaded))
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
        preview.write(folder / f"{name}.png", np.abs(price.difference), name)
