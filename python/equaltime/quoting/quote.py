"""Quotes: the time to reach an error, or the error that a time reaches, predicted from a short pilot render."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from equaltime.cluster import open_cluster
from equaltime.quoting.left_out import measured
from equaltime.quoting.noise_places import places_of
from equaltime.quoting.pilot import FEWEST, USUAL_SECONDS, Pilot, Quote
from equaltime.rendering.budget import Limits
from equaltime.rendering.core import make_renderer
from equaltime.rendering.job import Job, as_scene, check_arguments
from equaltime.rendering.passes import ProgressCallback
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.scene.scene import smaller
from equaltime.strategy import Strategy

if TYPE_CHECKING:
    from equaltime.quoting.noise_light import NoiseLight

__all__ = ["DEFAULT_SECONDS", "USUAL_SECONDS", "quote", "seconds_of_pilot"]

DEFAULT_SECONDS = 30.0
"""Seconds of the quoted render if neither an error nor a time is given."""

_LEAST_TIMED = 2**17
"""Pixels of a film that is not timed beforehand: its pilot takes more than 10 s only in the slowest of scenes."""

_MOST_TIMED = 4096
"""Most pixels of the film on which the speed is measured beforehand: a few hundredths of a second."""

_SHARE_FOR_LIGHT = 0.1
"""Share of the allowance of pilot and probe that splitting the light takes."""


def quote(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    error: float | None = None,
    time: float | None = None,
    spp: int | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: ProgressCallback | None = None,
    why: bool | None = None,
    cluster: Any = None,
    without: Sequence[str] = (),
) -> Quote:
    """Predict the time to reach an error, or the error of a time or a sample count; find which light makes the noise.

    The prediction comes from a pilot (a short render) and a probe (some pixels rendered to the end). They have an
    allowance of samples: 5 % of the predicted samples of the render, but at least 8 per pixel. If the allowance takes
    more than 10 s, it is reduced to the samples that take 10 s, but never below 2 per pixel. A tenth of the allowance
    is reserved for finding which light makes the noise, on a small film (`equaltime.quoting.noise_light`).

    After Ctrl-C the prediction uses the samples rendered until then, and the quote's field ``interrupted`` is True.

    Parameters
    ----------
    scene
        A loaded scene, the path of a scene file, or a dict with Mitsuba's keys.
    strategy
        A `Strategy`, or text for `Strategy.parse`.
    seed, threads
        Seed of the render, and its number of worker threads; 0 is one for each processor.
    progress
        Function that is called with the pilot's `Progress`, about ten times a second.
    error, time, spp
        The relative error to reach (0.02 is 2 %), the seconds to spend, and the samples per pixel to take. With
        several, the quote is for a render that ends at the limit it meets first; with none, for one of 30 seconds.
    why
        Whether to find which light makes the noise. None: if enough of the allowance is left. True: always, even beyond
        the allowance. False: never.
    cluster
        Processes that render the pilot: ``local:N``, the address of a scheduler of Dask, a ``distributed.Client``, or a
        ``concurrent.futures.Executor``. The quote is for a render by these processes. None: this process.
    without
        Names of effects (features such as media) that the render leaves out, as for `equaltime.render`. The error
        includes the resulting bias, which is measured first, as the render measures it.

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    EffectError
        If an effect does not exist or cannot be left out, or if the bias is larger than ``error``.
    RenderError
        If the pilot saw no light, so that nothing can be predicted, or if the target is beyond reach.
    ValueError
        If an argument is out of range, or of another type.
    KeyboardInterrupt
        After Ctrl-C, if nothing can be predicted yet.

    Examples
    --------
    >>> quote = et.quote("scene.toml", error=0.2)
    >>> quote.error.value <= 0.2
    True
    """
    if error is None and time is None and spp is None:
        time = DEFAULT_SECONDS
    check_arguments(spp=spp, time=time, error=error, seed=seed, threads=threads, without=without)
    chosen = Strategy.of(strategy)
    limits = Limits(spp=spp, error=error, seconds=time)
    job = Job(scene=as_scene(scene), strategy=chosen, limits=limits, seed=seed, threads=threads)
    begin = clock.perf_counter()
    if without:
        job = measured(job.scene, chosen, tuple(without), seed, threads).job(job)
    spent = clock.perf_counter() - begin
    with open_cluster(cluster) as opened:
        found = _quoted(Session(replace(job, limits=Limits(), cluster=opened), progress), job.limits, why)
    return replace(found, pilot_seconds=found.pilot_seconds + spent)


def _quoted(session: Session, limits: Limits, why: bool | None) -> Quote:
    """Run the pilot of a session, and find which light makes the noise unless ``why`` is False."""
    job = session.job
    share = 1.0 if why is False else 1.0 - _SHARE_FOR_LIGHT
    pilot = Pilot(session, limits, share, fewest=FEWEST)
    found = pilot.run()
    assert found is not None  # no time limits the pilot's passes
    begin = clock.perf_counter()
    try:
        light = None if why is False or found.interrupted else _light(pilot, why is True, job)
    except KeyboardInterrupt:
        light, found = None, replace(found, interrupted=True)
    found = replace(found, places=places_of(session), light=light)
    return replace(found, pilot_seconds=found.pilot_seconds + clock.perf_counter() - begin)


def seconds_of_pilot(scene: Scene, strategy: Strategy, threads: int = 0, samples: int = FEWEST) -> float:
    """Return the seconds that a pilot (short render that predicts) of a scene takes; 0 if its film is small.

    The seconds are measured by rendering a small film of ``scene`` by ``strategy``. ``threads`` is the number of
    threads; 0 is one for each processor. ``samples`` is the pilot's number of samples per pixel; by default, the fewest
    that a pilot takes.
    """
    pixels = scene.model.sensor.film.crop[2] * scene.model.sensor.film.crop[3]
    if pixels <= _LEAST_TIMED:
        return 0.0
    small = smaller(scene, _MOST_TIMED)
    renderer = make_renderer(small, strategy, 0, threads)
    begin = clock.perf_counter()
    renderer.advance(FEWEST)
    took = clock.perf_counter() - begin
    return (samples / FEWEST) * took * pixels / (small.model.sensor.film.crop[2] * small.model.sensor.film.crop[3])


def _light(pilot: Pilot, always: bool, job: Job) -> NoiseLight | None:
    """Split the light with the work that the pilot left, or, with ``always``, with as much as it took if need be."""
    from equaltime.quoting.noise_light import (  # here, as it imports the tools that measure renders
        LEAST_PATHS,
        noise_light,
    )

    paths = max(pilot.left, LEAST_PATHS, pilot.taken) if always else pilot.left
    return noise_light(job.scene, pilot.strategy, paths, job.seed, job.threads)
