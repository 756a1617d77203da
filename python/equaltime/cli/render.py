"""The command ``equaltime render``: renders a scene to an EXR with its error bar."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from equaltime.api import render as render_scene
from equaltime.cli.lint import print_hazards
from equaltime.cli.messages import (
    Written,
    doubts,
    kept_elsewhere,
    left_by_interrupt,
    print_error,
    print_json,
    print_lines,
    print_no_quote,
    print_quote,
    print_warning,
    print_warnings,
    while_heard,
)
from equaltime.cli.options import (
    AovNames,
    Crop,
    Define,
    ErrorTarget,
    ExposureStops,
    MaxDepth,
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
    parse_percent,
    parse_whole,
)
from equaltime.cli.progress import progress_bar
from equaltime.cli.render_outcome import details, outcome
from equaltime.errors import BrightImage, ImageError, RenderError, SampleError
from equaltime.images.variance_picture import is_known, scale_in_words
from equaltime.interrupts import held_back
from equaltime.quoting.observer import Observer
from equaltime.quoting.pilot import Quote
from equaltime.rendering.black_picture import black_picture, reasons, unwarned
from equaltime.rendering.budget import StopRule
from equaltime.rendering.job import Backend, Traps
from equaltime.rendering.output_files import AovPicture, check_output, check_replaceable, check_spares
from equaltime.rendering.passes import ProgressCallback
from equaltime.rendering.result import Result
from equaltime.rendering.tev import Viewer
from equaltime.scene import Scene, load_file
from equaltime.scene.lint import Finding
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
            help="Samples a pixel [default: the scene's, or 64].",
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
    define: Define = None,
    substitute: Substitute = False,
    transparent: Transparent = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue FILE.exr, if it is there, towards the limits given now.")
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
    exposure: ExposureStops = "auto",
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
            help="Leave out what changes the picture by less than this, by a pilot, and say what and why.",
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
        bool, typer.Option("--verbose", "-v", help="Print also times, speed, and what the strategy chose by itself.")
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

    * technique=uniform|bsdf|light|mis|mixture, heuristic=balance|power (of mis)

    * lights=uniform|power|tree, environment=plain|compensated (of mis and mixture)

    * sampler=independent|stratified|sobol|lattice

    * roulette=none|constant|albedo|throughput|efficiency (splits paths)|automatic (where that pays),
      roulette_depth=N, survival=P (of constant)

    * adaptive=none|error (more samples where the neighbours are noisy), neighbours|history|cutoff (biased)

    * truncate=none|N (cuts paths: biased)
    """
    if stop == "fixed" and error is None:
        raise typer.BadParameter("needs an error to reach: give --error, such as --error 2%, too", param_hint="--stop")
    chosen = Strategy.parse(strategy)
    pictures = cast(set[AovPicture], {*(aov or ())})
    if pictures and backend != "core":
        raise typer.BadParameter(f"the backend {backend} knows no variance of its samples", param_hint="--aov")
    paths = check_output(output, aov=pictures)
    if transparent and paths.exr is None and output.suffix.lower() != ".png":
        raise typer.BadParameter("a JPEG has no transparency: write FILE.png or FILE.exr", param_hint="--transparent")
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute).with_(transparent=transparent)
    check_spares(paths.all, loaded.files, "the scene is made of this file")
    findings: tuple[Finding, ...] = ()
    if not quiet:
        print_warnings(loaded)
        findings = print_hazards(loaded)
    loaded = loaded.with_(size=size, crop=crop, max_depth=max_depth)
    if not overwrite:
        check_replaceable(paths.pictures if resume else paths.all, os.path.abspath(scene), loaded.digest)
    failure: SampleError | BrightImage | None = None
    exr = paths.exr
    if resume and exr is None:
        raise typer.BadParameter("only FILE.exr can be continued: write FILE.exr", param_hint="--resume")
    viewer = None if tev is None else _viewer(tev, output)
    teller = _Teller({} if as_json else None, quiet, verbose, findings, resumable=exr is not None and not small)
    # hold back a second Ctrl-C from the last sample to the last line: it must not lose the samples that the first kept
    with ExitStack() as ending:
        try:
            with progress_bar(quiet) as progress, unwarned():  # a black picture is reported below
                result = render_scene(
                    loaded,
                    spp=spp,
                    time=time,
                    error=error,
                    strategy=chosen,
                    seed=seed,
                    threads=threads,
                    observer=teller.observer(progress),
                    resume=exr if resume and output.exists() else None,
                    checkpoint=exr if backend == "core" else None,
                    checkpoint_every=checkpoint or 60.0,
                    checkpoint_exposure=exposure,
                    without=without or (),
                    within=within,
                    stop=stop,
                    show=viewer,
                    traps=traps,
                    backend=backend,
                )
                signals = ending.enter_context(held_back())
        except (SampleError, BrightImage) as found:
            if found.result is None:  # raised by a pilot
                raise
            failure, result = found, cast(Result, found.result)
            signals = ending.enter_context(held_back())
        begin, stops = clock.perf_counter(), result.exposure(exposure)
        scale = _scale(result) if "variance" in pictures else ""
        try:
            files = result.save(output, small, exposure=stops, aov=pictures if scale else ())
        except ImageError as problem:
            print_error(f"{problem}{kept_elsewhere(result)}")
            return 1
        writing = clock.perf_counter() - begin
        if isinstance(failure, BrightImage):
            raise failure.with_result(result, str(output))
        if viewer is not None and viewer.problem is not None:
            print_warning(viewer.problem)
        teller.tell(result, loaded, writing, Written(files, stops, scale))
    if failure is not None:
        raise failure.with_words(
            *(word for pair in define or () for word in ("-D", pair)), *(["--substitute"] * substitute)
        )
    return 130 if signals or result.stopped_by == "interrupt" else 0


def _scale(result: Result) -> str:
    """Return the scale of the variance picture in words; without any variance, warn, and return an empty text."""
    variance = result.variance
    if variance is None or not is_known(variance):
        print_warning("there is no picture of the variance: no pixel has the 3 samples that a variance needs")
        return ""
    return scale_in_words(variance)


def _warn_of_checkpoints(why: str) -> None:
    print_warning(f"what is done so far cannot be saved, and the render goes on: {why}")


def _viewer(address: str, output: Path) -> Viewer:
    try:
        return Viewer(address, output.name)
    except RenderError as problem:
        raise typer.BadParameter(str(problem), param_hint="--tev") from problem


@dataclass
class _Teller:
    """Printer of what a render tells: a JSON record if there is one, else lines, or nothing if quiet.

    Checkpoints that cannot be saved are always reported on stderr.
    """

    record: dict[str, Any] | None = field(hash=False)
    """Quotes and decisions, which are printed with the record of the result."""
    quiet: bool
    verbose: bool
    findings: Sequence[Finding]
    resumable: bool
    """Whether the saved render can be continued."""
    quote: Quote | None = None
    """Quote that the render gave of itself, once there is one."""

    def observer(self, progress: ProgressCallback | None) -> Observer:
        """Return the observer of the render."""
        unsaved = while_heard(_warn_of_checkpoints)
        if (record := self.record) is not None:
            return Observer.of(
                progress=progress,
                quoted=lambda quote: record.update(quote=quote.as_dict()),
                unquoted=lambda why: record.update(unquoted=why),
                decided=lambda lines: record.update(decisions=list(lines)),
                unsaved=unsaved,
            )
        if self.quiet:
            return Observer.of(progress=progress, unsaved=unsaved)
        return Observer.of(
            progress=progress,
            quoted=while_heard(self._quoted),
            unquoted=while_heard(print_no_quote),
            decided=while_heard(print_lines),
            unsaved=unsaved,
        )

    def _quoted(self, quote: Quote) -> None:
        self.quote = quote
        print_quote(quote)

    def tell(self, result: Result, scene: Scene, writing: float, written: Written) -> None:
        """Print the outcome; ``writing`` is the seconds that it took to write the files."""
        phases = {**result.stats.phases, "write": writing}
        if self.record is not None:
            told = {"phases": phases, "files": written.files, "exposure": written.stops}
            print_json({**result.record, **told, **self.record})
        elif not self.quiet:
            print_lines(
                [*outcome(result, written, self.quote if self.resumable else None), *doubts(result, self.findings)]
            )
            print_lines([*left_by_interrupt(result, scene), *(details(result, phases) if self.verbose else ())])
        if not self.quiet and not reasons(self.findings) and (black := black_picture(result, scene, self.findings)):
            print_warning(black)
