"""Work of ``equaltime render``: renders one picture or the frames of an animation, and prints the outcome."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Iterable, Mapping, Sequence, Set
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import typer

from equaltime.api import render
from equaltime.cli.lint import print_hazards
from equaltime.cli.messages import (
    Written,
    doubts,
    ended_by_interrupt,
    kept_elsewhere,
    left_by_interrupt,
    print_aside,
    print_error,
    print_json,
    print_lines,
    print_no_quote,
    print_quote,
    print_remarks,
    print_warning,
    print_warnings,
    while_heard,
)
from equaltime.cli.progress import progress_bar
from equaltime.cli.render_outcome import details, nothing_added, outcome
from equaltime.errors import BrightImage, ImageError, RenderError, SampleError
from equaltime.images.exposure import AUTO, MOST_STOPS, Exposure, white_share
from equaltime.images.variance_picture import is_known, scale_in_words
from equaltime.interrupts import held_back
from equaltime.quoting.observer import Observer
from equaltime.quoting.pilot import FEWEST, Quote
from equaltime.quoting.quote import seconds_of_pilot
from equaltime.rendering.black_picture import black_picture, reasons, unwarned
from equaltime.rendering.budget import StopRule
from equaltime.rendering.job import Backend, Traps
from equaltime.rendering.output_files import (
    AovPicture,
    OutputPaths,
    check_output,
    check_replaceable,
    check_spares,
    copies,
    replaced,
)
from equaltime.rendering.passes import ProgressCallback
from equaltime.rendering.render_file import read_record
from equaltime.rendering.result import Result
from equaltime.rendering.tev import Viewer
from equaltime.scene import Scene
from equaltime.scene.lint import Finding
from equaltime.strategy import Strategy
from equaltime.words import duration

__all__ = ["Order", "render_frames", "render_picture"]


@dataclass(frozen=True, kw_only=True)
class Order:
    """Options of ``equaltime render`` that all frames of an animation share: mostly arguments of `equaltime.render`."""

    spp: int | None
    time: float | None
    error: float | None
    stop: StopRule
    strategy: Strategy
    threads: int
    without: Sequence[str]
    within: float | None
    exposure: Exposure | None
    """Exposure of the preview. With None, a resumed render keeps its exposure, and a new one is automatic."""
    aov: Set[AovPicture]
    """Further pictures to write beside the image, such as ``variance``."""
    resume: bool
    checkpoint: float
    """Seconds between two checkpoints (saves of the render so far)."""
    small: bool
    overwrite: bool
    backend: Backend
    cluster: str | None
    """Cluster that takes the samples: ``local:N`` or the address of a scheduler of Dask; None for this process."""
    traps: Traps
    tev: str | None
    """Address of the viewer tev that shows the picture, ``HOST:PORT``; None for no viewer."""
    json: bool
    """Whether to print, as JSON and alone, how the render was made and what was predicted."""
    quiet: bool
    verbose: bool
    words: Sequence[str]
    """Words of the command line that changed how the scene's file was read, such as ``-D name=value``, for commands
    that repeat the render."""


def render_frames(
    source: str, scenes: Iterable[Scene], changes: Mapping[str, Any], files: Mapping[int, Path], order: Order, seed: int
) -> int:
    """Render frames, each into its file, and return the exit code.

    ``source`` is the absolute path of the scene's file, and ``scenes`` yields the scene of each frame. ``files`` gives
    the files by the frames' numbers. Frame n has the seed ``seed + n``. ``changes`` are the user's changes to each
    scene, as keywords of `Scene.with_`. The first frame that fails, or that Ctrl-C ends, is the last.
    """
    for file in files.values():
        _check_replaceable(check_output(file, aov=order.aov), source, None, order)
    begin, done, told = clock.perf_counter(), 0, set[str]()
    for scene, (number, file) in zip(scenes, files.items(), strict=True):
        if done and not order.quiet:  # a later frame may have a warning of its own, as that the animation is over
            print_warnings(replace(scene, warnings=tuple(line for line in scene.warnings if line not in told)))
        told.update(scene.warnings)
        code = render_picture(scene, changes, file, order, seed + number, first=done == 0)
        if code != 0:
            return code
        done += 1
    if not (order.quiet or order.json):
        spent = duration(clock.perf_counter() - begin) + " of this run" * order.resume
        print_lines([f"{done} frame{'s' * (done != 1)} in {spent}"])
    return 0


def render_picture(
    scene: Scene, changes: Mapping[str, Any], output: Path, order: Order, seed: int, first: bool = True
) -> int:
    """Render a scene into a file, print the outcome, and return the exit code.

    ``changes`` are the user's changes to the scene, as keywords of `Scene.with_`. ``first`` is true for a still and for
    the first of many frames. Only then are the scene's warnings and hazards printed, and only then does a measurement
    show whether the time limit is too short.
    """
    paths = check_output(output, aov=order.aov)
    check_spares(paths.all, scene.files, "the scene is made of this file")
    findings: tuple[Finding, ...] = ()
    resumed = paths.exr if order.resume and paths.exr is not None and paths.exr.exists() else None
    if first and not order.quiet:
        findings = _print_remarks(scene, changes.get("transparent", False), resumed is not None)
        if order.resume and resumed is None:
            print_aside(f"{paths.exr} is not there: there is nothing to resume, and a new render begins")
    scene = scene.with_(**changes)
    _check_replaceable(paths, None if scene.source is None else os.path.abspath(scene.source), scene.digest, order)
    if first and resumed is None and not (order.quiet or order.json):
        _warn_of_short_time(scene, order)
    viewer = None if order.tev is None else _viewer(order.tev, output)
    resumable = paths.exr is not None and not order.small
    old = {} if paths.exr is None else read_record(paths.exr)  # a checkpoint may replace it
    earlier = copies(paths.all)
    before = None if resumed is None else old.get("paths")
    exposure = _exposure(order, {} if resumed is None else old)
    teller = _Teller({} if order.json else None, order.quiet, order.verbose, findings, resumable, before, first)
    failure: SampleError | BrightImage | None = None
    # hold back a second Ctrl-C from the last sample to the last line: it must not lose the samples that the first kept
    with ExitStack() as ending:
        try:
            with progress_bar(order.quiet) as progress, unwarned():  # a black picture is reported below
                result = _rendered(scene, paths.exr, resumed, order, exposure, seed, teller.observer(progress), viewer)
                signals = ending.enter_context(held_back())
        except (SampleError, BrightImage) as found:
            if found.result is None:  # raised by a pilot
                raise
            failure, result = found, cast(Result, found.result)
            signals = ending.enter_context(held_back())
        begin, stops = clock.perf_counter(), result.exposure(exposure)
        scale = _scale(result) if "variance" in order.aov else ""
        try:
            files = result.save(output, order.small, exposure=exposure, aov=order.aov if scale else (), overwrite=True)
        except ImageError as problem:
            print_error(f"{problem}{kept_elsewhere(result)}")
            return 1
        kept = [copy for copy, changed in copies(paths.all).items() if earlier.get(copy) != changed]
        files = tuple(dict.fromkeys((*files, *kept)))  # a checkpoint may have kept a copy, too
        writing = clock.perf_counter() - begin
        if isinstance(failure, BrightImage):
            raise failure.with_result(result, str(output))
        if viewer is not None and viewer.problem is not None:
            print_warning(viewer.problem)
        opaque = exposure == AUTO and result.origin.picture.alpha
        exr = None if Path(f"{paths.exr}~") in kept else paths.exr
        lost = "" if exr is None else replaced(exr, result.record, old)
        again = order.exposure is None and exposure != AUTO
        white = white_share(result.image, stops)
        written = Written(files, stops, result.exposure(), scale, opaque, lost, white, again)
        teller.tell(result, scene, writing, written)
    if failure is not None:
        raise failure.with_words(*order.words)
    return 130 if signals or result.stopped_by == "interrupt" else 0


def _print_remarks(scene: Scene, transparent: bool, resumed: bool) -> tuple[Finding, ...]:
    """Print warnings and hazards of a scene, and last what this command makes of it; return the hazards.

    A resumed render counts the warnings, which the earlier run has printed.
    """
    (print_remarks if resumed else print_warnings)(scene)
    findings = print_hazards(scene)
    more = scene.with_(transparent=transparent).warnings[len(scene.warnings) :]
    print_warnings(replace(scene, warnings=more))
    return findings


def _check_replaceable(paths: OutputPaths, source: str | None, digest: str | None, order: Order) -> None:
    """Raise `ImageError` if a render would replace a file of another scene or program, or continue another scene's.

    An EXR whose record does not name a scene cannot be resumed; the error of reading it tells why.
    """
    if order.overwrite:
        return
    named = not order.resume or (paths.exr is not None and {"scene", "digest"} <= {*read_record(paths.exr)})
    how = "--overwrite without --resume" if order.resume else "--overwrite"
    check_replaceable(paths.all if named else paths.pictures, source, digest, how)


def _exposure(order: Order, resumed: Mapping[str, Any]) -> Exposure:
    """Return the exposure of the preview: if none is asked for, as in ``resumed``, the record of the earlier run."""
    if order.exposure is not None:
        return order.exposure
    stops = resumed.get("exposure")
    return stops if isinstance(stops, int | float) and abs(stops) <= MOST_STOPS else AUTO  # reading refuses others


def _rendered(
    scene: Scene,
    exr: Path | None,
    resumed: Path | None,
    order: Order,
    exposure: Exposure,
    seed: int,
    observer: Observer,
    viewer: Viewer | None,
) -> Result:
    return render(
        scene,
        spp=order.spp,
        time=order.time,
        error=order.error,
        strategy=order.strategy,
        seed=seed,
        threads=order.threads,
        observer=observer,
        resume=resumed,
        checkpoint=exr if order.backend == "core" else None,
        checkpoint_every=order.checkpoint,
        checkpoint_exposure=exposure,
        overwrite=True,  # what may not be replaced was refused before
        without=order.without,
        within=order.within,
        stop=order.stop,
        show=viewer,
        traps=order.traps,
        backend=order.backend,
        cluster=order.cluster,
    )


def _warn_of_short_time(scene: Scene, order: Order) -> None:
    """Warn before a render whose time limit comes before the samples that an error needs."""
    if order.time is None or order.cluster is not None:  # the speed of a cluster is not known
        return
    expected = seconds_of_pilot(scene, order.strategy, order.threads)
    if expected > order.time:
        needed = f"{FEWEST} samples a pixel, which an error takes, take about {duration(float(f'{expected:.1g}'))}"
        print_warning(f"the time of {duration(order.time)} may be too short to know the error: {needed}")


def _scale(result: Result) -> str:
    """Return the scale of the variance picture in words; without any variance, warn, and return an empty text."""
    variance = result.variance
    if variance is None or not is_known(variance):
        print_warning("there is no picture of the variance: no pixel has the 3 samples that a variance needs")
        return ""
    return scale_in_words(variance)


def _warn_of_checkpoints(why: str) -> None:
    print_warning(f"the checkpoint cannot be saved, and the render goes on: {why}")


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
    before: int | None
    """Paths of the saved render that is continued; None if there is none."""
    first: bool = True
    """Whether the render is a picture by itself, or the first of an animation's frames."""
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
        print_quote(quote, self.before is not None)

    def tell(self, result: Result, scene: Scene, writing: float, written: Written) -> None:
        """Print the outcome; ``writing`` is the seconds that it took to write the files."""
        phases = {**result.stats.phases, "write": writing}
        if self.record is not None:
            told = {"phases": phases, "files": written.files, "exposure": written.stops}
            print_json({**result.record, **told, **self.record})
        elif not self.quiet:
            said = outcome(result, written, self.quote, self.first, self.resumable)
            forecast = "" if self.quote is None else self.quote.error.doubt
            added = () if result.stats.paths != self.before else nothing_added(result, written)
            print_lines([*said, *added, *doubts(result, self.findings, forecast)])
            left = left_by_interrupt(result, scene) if self.resumable else ended_by_interrupt(result, written)
            print_lines([*left, *(details(result, phases) if self.verbose else ())])
        if not self.quiet and not reasons(self.findings) and (black := black_picture(result, scene, self.findings)):
            print_warning(black)
