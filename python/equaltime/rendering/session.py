"""Session: one render in the core, with its renderer and its passes, which can return its result so far.

`run` runs a session to its end, and makes the outputs beside the image.
"""

from __future__ import annotations

import os
import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import BrightImage, ImageError, RenderError
from equaltime.film.adaptive import PILOT
from equaltime.film.error import PixelStatistics, pixel_statistics
from equaltime.film.lamps import Lamps
from equaltime.film.second_nets import second_nets, statistics, statistics_so_far
from equaltime.film.unseen import Unseen, stated_error
from equaltime.images.exposure import AUTO, Exposure
from equaltime.images.image_files import Window
from equaltime.interrupts import held_back, put_off
from equaltime.machine import resident_bytes
from equaltime.rendering.budget import Limits, Stop, StoppedBy
from equaltime.rendering.core import (
    REPLICATES,
    AdaptiveRenderer,
    bad_sample,
    build_info,
    core_settings,
    decision_of,
    make_renderer,
    nets,
    numbers_version,
    second_net,
)
from equaltime.rendering.decision import Decision
from equaltime.rendering.film_picture import FilmPicture
from equaltime.rendering.job import Job
from equaltime.rendering.origin import Origin
from equaltime.rendering.outputs import asked_for, outputs
from equaltime.rendering.passes import Passes, ProgressCallback, Saving
from equaltime.rendering.result import Result, Stats, make_result
from equaltime.rendering.saved import SavedRender
from equaltime.rendering.spread import SpreadRenderer, spread_renderer
from equaltime.revision import revision
from equaltime.scene import Scene
from equaltime.scene.effects.focusing import focusing_surfaces
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["Checkpoints", "Session", "origin_of", "run"]

_SECONDS_A_PIXEL = 1e-6
"""Expected seconds per pixel of the first checkpoint."""


@dataclass(frozen=True)
class Checkpoints:
    """Settings of the checkpoints (saves) of a running render: file, interval, exposure of previews.

    A saved render can be resumed.
    """

    path: Path
    """EXR file in which the render so far is saved; each save replaces the previous one."""
    every: float = 60.0
    """Least seconds between two saves; more if saving would take more than half of the time."""
    exposure: Exposure = AUTO
    """Exposure of the previews beside the EXR file in stops (1 is twice as bright), or ``auto``."""
    unsaved: Callable[[str], object] | None = None
    """Function that is called with the reason when a save fails. After a failure the function is not called again until
    a save has worked."""


class Session:
    """A render in the core that runs pass by pass and can be asked for its result between passes.

    Parameters
    ----------
    job
        Scene, strategy, seed and limits of the render, and how to run it.
    progress
        Function that is called with the render's `Progress`, about ten times a second; None for none.

    Raises
    ------
    SceneError
        If the film is larger than this machine's memory.
    RenderError
        If there is not enough memory, or if the film is a single pixel and an error is the only limit.
    ImageError
        If the saved render that is to be resumed belongs to another render.
    """

    def __init__(self, job: Job, progress: ProgressCallback | None = None) -> None:
        self.job, scene, strategy, resumed = job, job.scene, job.strategy, job.resumed
        self._stop = resumed.stop if job.stop is None and resumed is not None else job.stop
        biased = strategy.biased or bool(job.without)
        origin = origin_of(scene, strategy.name, biased, job.seed, REPLICATES, "core", job.without)
        self._origin = replace(
            origin,
            nets=nets(scene, strategy),
            second_net=second_net(scene, strategy),
            numbers=numbers_version(strategy),
        )
        core = scene.core  # built now if needed
        self.bytes_before = resident_bytes()
        """Resident bytes of the process after the scene was built and before the film was allocated."""
        decided = strategy if resumed is None else resumed.decision.applied(strategy)
        if job.cluster is None:
            self._renderer = make_renderer(scene, decided, job.seed, job.threads, traps=job.traps)
        else:
            team = job.cluster.team(scene)
            self._renderer = spread_renderer(scene, decided, job.seed, job.threads, team, job.traps)
        self._resumed = Decision() if resumed is None else resumed.decision
        self._before, self._runs = (0.0, 0) if resumed is None else (resumed.seconds, resumed.runs)
        self._paths_before = 0 if resumed is None else int(resumed.record["paths"])
        earlier = () if resumed is None else resumed.record["revisions"]
        self._revisions = tuple(dict.fromkeys((*earlier, revision())))
        self._shown = 0.0
        if resumed is not None:
            self._take_up(resumed)
        _, height, width = self._renderer.moments.shape
        limits = job.limits
        if height * width == 1 and limits.error is not None and limits == Limits(error=limits.error):
            raise RenderError("the error of a single pixel cannot be known of two replicates: give another limit too")
        looks = () if resumed is None else resumed.looks
        done = self._renderer.position[0]
        self._unseen = Unseen.of(
            core, core_settings(scene, strategy), job.seed, job.threads, partial(focusing_surfaces, scene)
        )
        self.passes = Passes(
            self._renderer,
            height * width,
            limits,
            progress,
            samples=done,
            begun=self._renderer.position[2] > 0,
            looks=looks,
            hidden=self._unseen,
            breadth=1 if self._spread is None else self._spread.breadth,
            cluster=str if self._spread is None else self._spread.told,
        )

    @property
    def origin(self) -> Origin:
        """Origin of the render, which is stored with it: everything that decides its bits except the sample counts."""
        return self._origin

    @property
    def _spread(self) -> SpreadRenderer | None:
        """The renderer if other processes take its samples, else None."""
        return self._renderer if isinstance(self._renderer, SpreadRenderer) else None

    def _take_up(self, resumed: SavedRender) -> None:
        _, height, width = self._renderer.moments.shape
        window = self._origin.window
        crop = [window.x, window.y, width, height]
        resumed.check({"without": [], **self._origin.record, "crop": crop, "build": build_info()})
        self._renderer.moments[...] = resumed.moments
        if resumed.second is not None:
            self._renderer.second_moments[...] = resumed.second.moments
        try:
            numbers = {name: resumed.record[name] for name in ("paths", "rays", "shadow_rays")}
            self._renderer.resume(**numbers, position=resumed.position)
        except ValueError as error:
            raise ImageError(f"{resumed.path}: cannot be resumed: {error}") from error

    def run(
        self,
        checkpoints: Checkpoints | None = None,
        pass_ended: Sequence[Callable[[], object]] = (),
    ) -> Result:
        """Run all passes, call the functions of ``pass_ended`` after each, and return the result.

        ``checkpoints`` tells where and how often the render so far is saved, within passes too; None for no saves.
        After Ctrl-C the result holds the finished blocks of pixels. Raises `KeyboardInterrupt` if nothing is finished.
        Raises `SampleError` or `BrightImage`, which hold the result so far.
        """
        if checkpoints is not None:
            save, takes = partial(self._save, checkpoints), _SECONDS_A_PIXEL * self.passes.pixels
            self.passes.saving = Saving(save, checkpoints.every, takes, checkpoints.unsaved)
        stopped_by = self._run_passes(pass_ended)
        if stopped_by == "interrupt" and not self._renderer.counters["paths"]:
            raise KeyboardInterrupt
        with held_back() as late:  # another Ctrl-C changes nothing: the image is finished
            result = self.result(stopped_by)
            if checkpoints is not None and self._spread is not None:
                self.write(result, checkpoints)  # units that other processes rendered are kept until then
        return replace(result, stopped_by="interrupt") if late else result

    def _run_passes(self, pass_ended: Sequence[Callable[[], object]]) -> StoppedBy:
        try:
            for _ in self.passes:
                for hear in pass_ended:
                    hear()
        except KeyboardInterrupt:  # raised between two passes
            return "interrupt"
        assert self.passes.stopped_by is not None
        return self.passes.stopped_by

    def _save(self, checkpoints: Checkpoints) -> None:
        with put_off():  # or Ctrl-C would leave half a picture
            try:
                result = self._snapshot("unfinished")  # a copy of the film would be the peak of memory
            except BrightImage as error:
                self.write(cast(Result, error.result), checkpoints)
                raise
            self.write(result, checkpoints)

    def write(self, result: Result, checkpoints: Checkpoints) -> None:
        """Save ``result``, the render so far, in the file of ``checkpoints``; raise `ImageError` if that fails.

        With automatic exposure, the preview keeps the exposure of the previous save while that suits the image. So
        noise does not make the preview flicker. The exposure of the finished picture depends on that picture alone.
        """
        self._shown = result.exposure(checkpoints.exposure, self._shown)
        result.save(checkpoints.path, exposure=checkpoints.exposure, shown=self._shown, overwrite=True)
        if self._spread is not None:
            self._spread.saved()

    def error(self, lasting: bool = False) -> Interval:
        """Return the relative error that the render states so far, with its 95 % interval.

        With ``lasting``, the upper limit leaves out small lamps whose effect on the error vanishes after a few more
        samples. A prediction of later errors needs this limit.
        """
        pixels = statistics_so_far(self._renderer)
        return stated_error(pixels, self._unseen, lasting=lasting, brightest=self.passes.looks.brightest)

    def statistics(self) -> PixelStatistics:
        """Return mean, variance and sample count of every pixel so far."""
        return statistics_so_far(self._renderer)

    def rates(self, samples: float) -> NDArray[np.float64]:
        """Return how samples are distributed over pixels: each pixel's count divided by the mean count, (H, W).

        ``samples`` is the mean count. All ratios are 1 for even counts.
        """
        renderer = self._renderer
        if isinstance(renderer, AdaptiveRenderer):
            return renderer.rates(samples)
        return np.ones(renderer.moments.shape[1:])

    @property
    def samples_begun(self) -> float:
        """Samples per pixel so far, with the finished part of a pass that was cut short: a fraction of its samples."""
        done, end, _ = self._renderer.position
        if end <= done:
            return float(done)
        midway = 0.5 * (self._counts(done) + self._counts(end))
        return done + (end - done) * float((self.statistics().samples > midway).mean())

    def _counts(self, samples: int) -> NDArray[np.float64]:
        """Return each pixel's sample count, (H, W), if the mean count is ``samples``."""
        even = samples <= PILOT  # the first samples decide the shares of later ones
        return samples * (np.ones(self._renderer.moments.shape[1:]) if even else self.rates(samples))

    @property
    def lamps(self) -> Lamps:
        """Lamps that the camera sees, with the light of small lamps, which samples may miss."""
        return self._unseen.lamps

    @property
    def decided(self) -> Strategy:
        """Strategy of the job, with the render's decisions so far in place of automatic values.

        Decisions are on splitting of paths and on sample counts.
        """
        return self._decision.applied(self.job.strategy)

    @property
    def _decision(self) -> Decision:
        """Decisions so far, of this render or of the one that it resumed."""
        found, before = decision_of(self._renderer, self.job.strategy), self._resumed
        return found if before == Decision() else replace(before, counts=found.counts or before.counts)

    def image(self) -> NDArray[np.float64]:
        """Return the image so far, (H, W, 3), linear RGB."""
        return pixel_statistics(self._renderer.moments).mean

    @property
    def stop(self) -> Stop | None:
        """Rule by which this render, or the one that it resumes, stops at an error; None without an error target."""
        error = self.passes.limits.error
        return self._stop if error is None else Stop("look", error)

    def result(self, stopped_by: StoppedBy) -> Result:
        """Return the result so far, with ``stopped_by`` as the reason why the render ended.

        Raises `SampleError` if a sample was NaN or infinite, or raised a floating-point fault. Raises `BrightImage` if
        float32 cannot hold the image. Both errors hold the result. The result shares no memory with the film, which may
        go on changing, and does not keep the renderer in memory.
        """
        shared = self._snapshot(stopped_by)
        second = None if shared.second is None else shared.second.copy()
        result = replace(shared, moments=self._renderer.moments.copy(), second=second)
        self.check(result)
        return result

    def _snapshot(self, stopped_by: StoppedBy) -> Result:
        """Return the result so far, sharing the moments of the film."""
        counters = self._renderer.counters
        phases = {**self.job.scene.timings, "render": self._before + self.passes.total_seconds}
        if self.passes.saving is not None and self.passes.saving.seconds:
            phases["save"] = self.passes.saving.seconds
        stop = self.stop
        if stop is not None and stop.rule == "fixed":
            phases["stop_pilot"] = stop.pilot_seconds
            if stopped_by == "spp" and self.passes.limits.spp == stop.spp:
                stopped_by = "count"
        stats = Stats(
            phases=phases,
            paths=counters["paths"],
            rays=counters["rays"],
            shadow_rays=counters["shadow_rays"],
            kernel=self._renderer.kernel,
            threads=self._renderer.threads,
            cluster="" if self._spread is None else self._spread.told(),
            effects=tuple(name for name, used in self.job.scene.core.effects().items() if used),
            build=build_info(),
            revisions=self._revisions,
            runs=max(1, self._runs + (counters["paths"] > self._paths_before)),  # a run without samples is none
        )
        moments, second = self._renderer.moments, second_nets(self._renderer)
        try:
            return make_result(
                statistics(moments, second),
                stats,
                stopped_by,
                self._origin,
                moments,
                self.passes.looks.made,
                self.job.bias,
                self._renderer.position,
                self._unseen,
                stop=stop,
                second=second,
                decision=self._decision,
            )
        except BrightImage as error:
            found = cast(Result, error.result)
            raise error.with_result(replace(found, moments=moments.copy())) from None

    def check(self, result: Result | None = None) -> None:
        """Raise `SampleError` if a sample was NaN or infinite, or raised a floating-point fault.

        The error holds ``result``, the result so far.
        """
        if self._renderer.nonfinite or self._renderer.faulty:
            origin = self._origin
            raise bad_sample(self.job.scene, self.job.strategy, origin.seed, self._renderer, result, origin.without)


def origin_of(
    scene: Scene,
    strategy: str,
    biased: bool,
    seed: int,
    replicates: int,
    backend: str,
    without: tuple[str, ...] = (),
) -> Origin:
    """Return the origin of a render of the scene: everything that decides its bits except the sample counts.

    ``strategy`` is the strategy's name, and ``biased`` tells whether it is biased. ``seed`` is the render's seed.
    ``replicates`` is the number of parts of each pixel's samples, ``backend`` the renderer (``core`` or ``embreex``).
    ``without`` names the effects (features such as media) that were left out.
    """
    film = scene.model.sensor.film
    return Origin(
        scene=None if scene.source is None else os.path.abspath(scene.source),
        digest=scene.digest,
        window=Window(*film.crop[:2], *film.size),
        substitutions=tuple(map(str, scene.substitutions)),
        max_depth=scene.max_depth,
        strategy=strategy,
        biased=biased,
        seed=int(seed),  # records cannot hold NumPy's integers
        replicates=replicates,
        backend=backend,
        without=without,
        scene_max_depth=scene.own_max_depth,
        transparent=scene.transparent,
        defines=scene.defines,
        frame=scene.frame,
        picture=FilmPicture.of(film),
    )


def run(
    session: Session,
    asking: Scene,
    checkpoints: Checkpoints | None = None,
    pass_ended: Sequence[Callable[[], object]] = (),
    ended: Sequence[Callable[[Result], object]] = (),
) -> Result:
    """Run a session to its end, and return its result with the outputs that the scene ``asking`` asks for.

    Parameters
    ----------
    asking
        The user's scene. In the session's scene, effects (features such as media) may have been left out.
    checkpoints
        File and interval of saves of the render so far; None for no saves.
    pass_ended
        Called after each pass.
    ended
        Called with the finished image, before the outputs are made.

    Raises
    ------
    RenderError
        If there is not enough memory for the outputs.
    KeyboardInterrupt
        After Ctrl-C, if no block of pixels is finished.
    SampleError, BrightImage
        If a sample is NaN, infinite or raised a floating-point fault, or if float32 cannot hold the image. Both errors
        hold the result so far.
    """
    result = session.run(checkpoints, pass_ended)
    try:
        for hear in ended:
            hear(result)
        return _with_outputs(result, session, asking, checkpoints)
    except KeyboardInterrupt:  # the image is finished
        return replace(result, stopped_by="interrupt")


def _with_outputs(result: Result, session: Session, asking: Scene, checkpoints: Checkpoints | None) -> Result:
    """Add the outputs, except after Ctrl-C, since they may take as long as the image."""
    if result.stopped_by == "interrupt" or not asked_for(asking):
        return result
    if checkpoints is not None:  # outputs may also take as much memory as the image
        with suppress(ImageError):
            session.write(result, checkpoints)
    job, begin, worked = session.job, clock.perf_counter(), result.stats.seconds * result.stats.threads
    samples = max(1, round(float(result.samples.mean())))
    try:
        aovs = outputs(asking, job.scene, job.strategy, job.seed, job.threads, samples, worked)
    except MemoryError as problem:
        where = "" if checkpoints is None else f"; the image is in {checkpoints.path}"
        raise RenderError(f"not enough memory for the outputs beside the image{where}") from problem
    phases = {**result.stats.phases, "outputs": clock.perf_counter() - begin}
    return replace(result, aovs=aovs, stats=replace(result.stats, phases=phases))
