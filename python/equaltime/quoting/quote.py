"""Quotes: the time that an error will take, or the error that a time will buy, from a short pilot."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from equaltime.quoting.noise_places import places_of
from equaltime.quoting.pilot import Pilot, Quote
from equaltime.rendering.arguments import as_scene, check_arguments
from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job
from equaltime.rendering.progress import ProgressCallback
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.strategy import Strategy

if TYPE_CHECKING:
    from equaltime.quoting.noise_light import NoiseLight

__all__ = ["quote"]

_SHARE_FOR_LIGHT = 0.1
"""Of the pilot, to take the light apart."""


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
    """Say what an error will cost, or what a time will buy, and what limits it.

    Renders a pilot and a probe of 8 samples a pixel, or if that is more of a twentieth of the work, but of no more than
    ten seconds. Of the latter a tenth is kept to tell which light makes the noise, on a small film
    (`equaltime.quoting.noise_light`).

    Parameters
    ----------
    scene, strategy, seed, threads, progress
        As `equaltime.render` takes them.
    error, time
        Exactly one: the relative error to reach (0.02 is 2 %), or the seconds to spend.
    why
        Tell which light makes the noise: if there is room for it in the pilot, or always, with as much work as the
        pilot if need be (True), or never (False).

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    RenderError
        If the pilot saw no light, so that nothing can be said, or what is asked for is beyond reach.
    ValueError
        If not exactly one of ``error`` and ``time`` is given, or an argument is out of range, or of another type.
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
    """Take the light apart by the work that the pilot left, or if need be by as much as it took."""
    from equaltime.quoting.noise_light import (  # here, since it measures by what measures renders
        LEAST_PATHS,
        noise_light,
    )

    paths = max(pilot.left, LEAST_PATHS, pilot.taken) if always else pilot.left
    return noise_light(scene, pilot.strategy, paths, seed, threads)
