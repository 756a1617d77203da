"""The command ``equaltime render``: renders a scene to an EXR with its error bar."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from equaltime.cli.messages import print_connecting
from equaltime.cli.options import (
    AovNames,
    Crop,
    Define,
    ErrorTarget,
    ExposureStops,
    MaxDepth,
    OnCluster,
    Overwrite,
    SceneFile,
    Seed,
    Size,
    Small,
    StrategyWords,
    Substitute,
    Tev,
    Threads,
    Time,
    Transparent,
    Without,
    parse_definitions,
    parse_duration,
    parse_frame_numbers,
    parse_number,
    parse_percent,
    parse_whole,
)
from equaltime.cli.render_picture import Order, render_frames, render_picture
from equaltime.examples import example_of
from equaltime.rendering.budget import StopRule
from equaltime.rendering.job import Backend, Traps
from equaltime.rendering.output_files import AovPicture, check_output
from equaltime.scene import load_file
from equaltime.scene.frame_scenes import frames_of
from equaltime.scene.frames import Frame, frame_files
from equaltime.scene.model import MOST_SAMPLES
from equaltime.strategy import Strategy

__all__ = ["render"]


def render(
    scene: SceneFile,
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            show_default=False,
            help="FILE.exr: image, standard error, sample counts, how it was made, and a preview FILE.png beside it. "
            "FILE.png, FILE.jpg: the preview alone.",
        ),
    ],
    spp: Annotated[
        int | None,
        typer.Option(
            parser=parse_whole(1, MOST_SAMPLES),
            metavar="N",
            show_default=False,
            help="Samples a pixel [default: the scene's, or 64]. On average: noisy pixels get more, in whole passes.",
        ),
    ] = None,
    time: Time = None,
    error: ErrorTarget = None,
    stop: Annotated[
        StopRule,
        typer.Option(
            help="How --error ends the render. look: when the picture's own error is small enough, which favours "
            "pictures that missed rare bright light. fixed: a pilot with other samples chooses the number of samples "
            "first, whatever the picture then shows: unbiased."
        ),
    ] = "look",
    size: Size = None,
    crop: Crop = None,
    max_depth: MaxDepth = None,
    strategy: StrategyWords = "best",
    seed: Seed = 0,
    threads: Threads = 0,
    cluster: OnCluster = None,
    define: Define = None,
    substitute: Substitute = False,
    frames: Annotated[
        Any,
        typer.Option(
            parser=parse_frame_numbers,
            metavar="A-B",
            show_default=False,
            help="Frames of an animation: 0-47, 0-47:2 (every second) or 1,5,9. Each gets a file: FILE_0012.exr, or "
            "the number in place of ####. Frame n has the seed --seed + n.",
        ),
    ] = None,
    fps: Annotated[
        float,
        typer.Option(
            parser=parse_number(1e-3, 1e6), metavar="N", help="Frames a second: frame n is at n / fps seconds."
        ),
    ] = Frame.fps,
    blur: Annotated[
        float,
        typer.Option(
            parser=parse_number(0.0, 1.0),
            metavar="SHARE",
            help="Share of a frame for which the shutter is open: 0 makes stills, 0.5 is usual for films.",
        ),
    ] = Frame.blur,
    transparent: Transparent = False,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Continue FILE.exr, if it is there, towards the limits given now: --spp and --error count all runs "
            "together, --time counts this run. The preview keeps the exposure that was asked for.",
        ),
    ] = False,
    checkpoint: Annotated[
        float | None,
        typer.Option(
            parser=parse_duration,
            metavar="DURATION",
            show_default=False,
            help="How often the render so far is saved to FILE.exr [default: 60s].",
        ),
    ] = None,
    exposure: ExposureStops = None,
    aov: AovNames = None,
    small: Small = False,
    overwrite: Overwrite = False,
    backend: Annotated[
        Backend, typer.Option(help="embreex is a slow cross-check in float64; it takes --spp and --seed only.")
    ] = "core",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record and the quote as JSON, and nothing else.")
    ] = False,
    without: Without = None,
    within: Annotated[
        float | None,
        typer.Option(
            parser=parse_percent,
            metavar="PERCENT",
            show_default=False,
            help="Leave out effects that together change the picture by less than this, as a pilot measures, and tell "
            "which and why. The pilot's seconds are not part of --time.",
        ),
    ] = None,
    tev: Tev = None,
    traps: Annotated[
        Traps,
        typer.Option(
            help="Look for floating-point faults: check names the first sample that raises one; stop ends the process "
            "there (SIGFPE), for a debugger."
        ),
    ] = "ignore",
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
    verbose: Annotated[
        bool,
        typer.Option(
            "--verbose", "-v", help="Print also times, speed, every key of the strategy, and what it chose by itself."
        ),
    ] = False,
) -> int:
    """Render a scene, and tell how accurate the picture is.

    Say how long (`--time 30s`), how accurate (`--error 2%`) or how many samples (`--spp 64`); the first that is reached
    ends the render. Ctrl-C ends it too, and keeps the picture so far; `--resume` continues it.

    For instance:

    * `equaltime render cornell-box.toml -o out.exr --time 10s`

    * `equaltime render cornell-box.toml -o out.exr --error 2% --resume`

    * `equaltime render model.glb -o out.png --spp 256 --size 640x480`

    * `equaltime render scene.toml -o out.exr --strategy best,technique=bsdf --seed 7 --json`

    Strategies: the presets best (MIS, a lattice, lights by a tree, roulette; paths are split, and noisy pixels get
    more samples, where that pays), mis, bsdf and light (each plain), naive (uniform directions, roulette by albedo),
    and

    * technique=uniform|bsdf|light|mis|mixture, heuristic=balance|power (if technique=mis; the preset mis has balance;
      default power)

    * lights=uniform|power|tree, environment=plain|compensated (if technique=mis or mixture; the preset mis has plain;
      default compensated)

    * sampler=independent|stratified|sobol|lattice

    * roulette=none|constant|albedo|throughput|efficiency (splits paths)|automatic (where that pays),
      roulette_depth=N (first depth at which it may end a path; default 5), survival=P (of constant; default 0.75)

    * adaptive=none|error (more samples where the neighbours are noisy), neighbours|history|cutoff (biased)

    * truncate=none|N (cuts paths: biased)

    The values of all keys in each preset: scenes/experiments/README.md, Strategies.
    """
    if stop == "fixed" and error is None:
        raise typer.BadParameter("needs an error to reach: give --error, such as --error 2%, too", param_hint="--stop")
    pictures = cast(set[AovPicture], {*(aov or ())})
    if pictures and backend != "core":
        raise typer.BadParameter(
            f"the backend {backend} does not report the variance of its samples", param_hint="--aov"
        )
    exr = check_output(output, aov=pictures).exr
    if transparent and exr is None and output.suffix.lower() != ".png":
        way = "write FILE.png or FILE.exr; `equaltime convert FILE.exr FILE.jpg --background white` then gives a JPEG"
        raise typer.BadParameter(f"a JPEG has no transparency: {way}", param_hint="--transparent")
    if resume and exr is None:
        raise typer.BadParameter("only FILE.exr can be continued: write FILE.exr", param_hint="--resume")
    order = Order(
        spp=spp,
        time=time,
        error=error,
        stop=stop,
        strategy=Strategy.parse(strategy),
        threads=threads,
        without=without or (),
        within=within,
        exposure=exposure,
        aov=pictures,
        resume=resume,
        checkpoint=checkpoint or 60.0,
        small=small,
        overwrite=overwrite,
        backend=backend,
        cluster=cluster,
        traps=traps,
        tev=tev,
        json=as_json,
        quiet=quiet,
        verbose=verbose,
        words=(*(word for pair in define or () for word in ("-D", pair)), *(["--substitute"] * substitute)),
    )
    if not quiet:
        print_connecting(cluster)
    definitions = parse_definitions(define or ())
    changes = {"size": size, "crop": crop, "max_depth": max_depth, "transparent": transparent}
    if frames is None:
        if (fps, blur) != (Frame.fps, Frame.blur):
            raise typer.BadParameter("--fps and --blur belong to --frames: give --frames too")
        loaded = load_file(scene, definitions, substitute=substitute)
        return render_picture(loaded, changes, output, order, seed)
    try:
        files = dict(zip(frames, frame_files(output, frames), strict=True))
    except ValueError as wrong:
        raise typer.BadParameter(str(wrong), param_hint="-o") from None
    shown = [Frame(number, fps, blur) for number in frames]
    scenes = frames_of(scene, shown, definitions, substitute=substitute)
    return render_frames(os.path.abspath(example_of(scene) or scene), scenes, changes, files, order, seed)
