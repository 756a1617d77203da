"""Job: one render in the core, with everything that decides its bits and its end, and the checks of its arguments."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Literal, get_args

from equaltime.rendering.budget import Limits, Stop, StopRule
from equaltime.rendering.saved import SavedRender
from equaltime.rendering.team import Cluster
from equaltime.scene import Scene, load, load_dict
from equaltime.scene.model import MOST_SAMPLES
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy
from equaltime.words import shortened

__all__ = [
    "DEFAULT_SPP",
    "MOST_SECONDS",
    "MOST_THREADS",
    "Backend",
    "Job",
    "Traps",
    "as_scene",
    "check_arguments",
    "check_fraction",
    "is_whole",
]

Backend = Literal["core", "embreex"]
Traps = Literal["ignore", "check", "stop"]
"""Treatment of floating-point faults: ``ignore`` them, report the first sample that raises one (``check``), or end the
process by SIGFPE (``stop``)."""
DEFAULT_SPP = 64
"""Number of samples per pixel where neither the user nor the scene gives a number or another limit."""
MOST_THREADS = 4096
"""Largest number of threads that is accepted: more than any machine has processors. About ten thousand threads would
end the process."""
MOST_SECONDS = 1e9
"""Largest time limit that is accepted, in seconds: thirty years, so that a 64-bit count of nanoseconds cannot
overflow."""
_MOST_PERCENT = 100.0
"""Largest number that may have been meant as per cent where a fraction is expected."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """Everything that one render in the core needs: its scene, strategy, seed and limits, and how it is to be run."""

    scene: Scene
    strategy: Strategy
    limits: Limits = field(default_factory=Limits)
    seed: int = 0
    threads: int = 0
    """Worker threads; 0 is one for each processor."""
    without: tuple[str, ...] = ()
    """Names of the effects that were removed from ``scene`` and ``strategy`` before the render; empty if none was.

    An effect is a feature of the scene that costs time, such as ``media`` or ``long_paths=6``.
    """
    bias: Interval | None = None
    """Relative error of the image (0.02 is 2 %) because the effects in ``without`` are missing; None if none is."""
    traps: Traps = "ignore"
    """Treatment of floating-point faults such as a division by zero.

    ``ignore`` does not look for faults. ``check`` reports the first sample that raises one. ``stop`` ends the process
    by the signal SIGFPE.
    """
    stop: Stop | None = None
    """Rule by which a pilot (short render that predicts) chose the sample count; None without such a pilot."""
    resumed: SavedRender | None = None
    """Saved render that this render resumes; None for a new render."""
    cluster: Cluster | None = None
    """Processes that take the samples of the image; None for this process alone."""


def check_arguments(
    spp: int | None = None,
    time: float | None = None,
    error: float | None = None,
    seed: int = 0,
    threads: int = 0,
    backend: str = "core",
    *,
    within: float | None = None,
    without: Sequence[str] = (),
    checkpoint_every: float = 60.0,
    stop: str = "look",
) -> None:
    """Raise `ValueError` for an argument of `equaltime.render` that is out of range or of another type.

    ``spp`` is samples per pixel; ``time`` and ``checkpoint_every`` are seconds; ``error`` and ``within`` (the bias
    allowed) are fractions. ``seed`` is below 2^64, and ``threads`` 0 or more. ``without`` names features to leave out;
    ``backend`` and ``stop`` are words that `equaltime.render` accepts. ``stop="fixed"`` needs ``error``.
    """
    if spp is not None and not (is_whole(spp) and 1 <= spp <= MOST_SAMPLES):
        raise ValueError(f"spp must be a whole number from 1 to {MOST_SAMPLES}, found {spp!r}")
    for name, seconds in (("time", time), ("checkpoint_every", checkpoint_every)):
        if seconds is not None and not (_is_real(seconds) and 0.0 < seconds <= MOST_SECONDS):
            raise ValueError(f"{name} must be a positive number of seconds up to {MOST_SECONDS:g}, found {seconds!r}")
    for name, fraction in (("error", error), ("within", within)):
        if fraction is not None:
            if not (_is_real(fraction) and 0.0 < fraction < math.inf):
                raise ValueError(f"{name} must be a fraction above 0 and below 1, such as 0.02, found {fraction!r}")
            check_fraction(float(fraction), f"{name}=")
    names = not isinstance(without, str) and isinstance(without, Sequence)
    if not (names and all(isinstance(name, str) for name in without)):
        raise ValueError(f"without must be a sequence of effects' names, such as ('long_paths=6',), found {without!r}")
    if not (is_whole(seed) and 0 <= seed < 2**64):
        raise ValueError(f"seed must be a whole number from 0 to 2^64 - 1, found {seed!r}")
    if not (is_whole(threads) and 0 <= threads <= MOST_THREADS):
        raise ValueError(f"threads must be a whole number from 0 to {MOST_THREADS}, found {threads!r}")
    if stop not in get_args(StopRule):
        raise ValueError(f"stop must be one of {', '.join(get_args(StopRule))}, found {stop!r}")
    if stop == "fixed" and error is None:
        raise ValueError("stop='fixed' takes its number of samples from an error: give error, such as 0.02, too")
    if backend not in get_args(Backend):
        raise ValueError(f"backend must be one of {', '.join(get_args(Backend))}, found {backend!r}")


def check_fraction(error: float, name: str = "") -> float:
    """Return ``error``, a fraction; raise `ValueError` if it is 1 (100 %) or more.

    This catches numbers given in per cent by mistake. ``name`` stands before the number in the message.
    """
    if error < 1.0:
        return error
    hint = f": did you mean {error / 100.0:g}, which is {error:g} %?" if error < _MOST_PERCENT else ""
    raise ValueError(f"{name}{error:g} is {100.0 * error:g} %, and an error to be reached is below 100 %{hint}")


def as_scene(scene: Scene | str | os.PathLike[str] | Mapping[str, Any]) -> Scene:
    """Return a loaded scene unchanged; load any other from its path or its dictionary, and return it."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return load_dict(scene)
    if not isinstance(scene, str | os.PathLike):
        raise TypeError(f"a scene is a Scene, the path of a file or a dictionary; found {shortened(scene, 80)}")
    return load(Path(scene))


def is_whole(value: object) -> bool:
    """Tell whether a value is an integer of Python or NumPy; a bool is not one."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
