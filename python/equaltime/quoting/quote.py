"""Quotes: the time to reach an error, or the error that a time reaches, predicted from a short pilot render."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from equaltime.quoting.noise_places import places_of
from equaltime.quoting.pilot import Pilot, Quote
from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job, as_scene, check_arguments
from equaltime.rendering.passes import ProgressCallback
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.strategy import Strategy

if TYPE_CHECKING:
    from equaltime.quoting.noise_light import NoiseLight

__all__ = ["quote"]

_SHARE_FOR_LIGHT = 0.1
"""Share of the allowance of pilot and probe that splitting the light takes."""


def quote(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    error: float | None = None,
    time: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: ProgressCallback | None = None,
    why: bool | None = None,
) -> Quote:
    """Predict the time to reach an error, or the error that a time reaches, and find which light makes the noise.

    A pilot (a short render) and a probe (some pixels rendered to the end) take at most max(8 samples per pixel, min(5 %
    of the predicted work, 10 s)). One tenth of that allowance goes to finding which light makes the noise, on a small
    film (`equaltime.quoting.noise_light`).

    Parameters
    ----------
    scene, strategy, seed, threads, progress
        As for `equaltime.render`.
    error, time
        Exactly one: the relative error to reach (0.02 is 2 %), or the seconds to spend.
    why
        Whether to find which light makes the noise. None: if the pilot's allowance has room for it. True: always, with
        as much work as the pilot if need be. False: never.

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    RenderError
        If the pilot saw no light, so that nothing can be predicted, or if the target is beyond reach.
    ValueError
        If not exactly one of ``error`` and ``time`` is given, or an argument is out of range, or of another type.

    Examples
    --------
    >>> quote = et.quote("scene.toml", error=0.2)
    >>> quote.error.value <= 0.2
    True
    """
    if (error is None) == (time is None):
        raise ValueError("a quote takes an error or a time, one of them")
    check_arguments(time=time, error=error, seed=seed, threads=threads)
    chosen = Strategy.of(strategy)
    loaded = as_scene(scene)
    session = Session(Job(scene=loaded, strategy=chosen, seed=seed, threads=threads), progress)
    pilot = Pilot(session, Limits(error=error, seconds=time), 1.0 if why is False else 1.0 - _SHARE_FOR_LIGHT)
    found = pilot.run()
    assert found is not None  # no time limits the pilot's passes
    begin = clock.perf_counter()
    light = None if why is False else _light(loaded, pilot, why is True, seed, threads)
    found = replace(found, places=places_of(session), light=light)
    return replace(found, pilot_seconds=found.pilot_seconds + clock.perf_counter() - begin)


def _light(scene: Scene, pilot: Pilot, always: bool, seed: int, threads: int) -> NoiseLight | None:
    """Split the light with the work that the pilot left, or, with ``always``, with as much as it took if need be."""
    from equaltime.quoting.noise_light import (  # here, as it imports the tools that measure renders
        LEAST_PATHS,
        noise_light,
    )

    paths = max(pilot.left, LEAST_PATHS, pilot.taken) if always else pilot.left
    return noise_light(scene, pilot.strategy, paths, seed, threads)
