"""The arguments of renders: what each may be, and what has not been loaded yet."""

from __future__ import annotations

import os
from collections.abc import Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Literal, get_args

from equaltime.scene import Scene, load, load_dict
from equaltime.scene.model import MOST_SAMPLES

__all__ = ["MOST_ERROR", "MOST_SECONDS", "MOST_THREADS", "Backend", "as_scene", "check_arguments"]

Backend = Literal["core", "embreex"]
MOST_THREADS = 4096
"""More than any machine has processors; some ten thousand end the process."""
MOST_SECONDS = 1e9
"""Thirty years: what a 64-bit count of nanoseconds holds, with room to spare."""
MOST_ERROR = 1e3
"""A thousand times the image: nobody can mean more."""


def check_arguments(
    spp: int | None = None,
    time: float | None = None,
    error: float | None = None,
    seed: int = 0,
    threads: int = 0,
    backend: str = "core",
) -> None:
    """Raise `ValueError` for an argument of a render that is out of range, or no number."""
    if spp is not None and not (_is_whole(spp) and 1 <= spp <= MOST_SAMPLES):
        raise ValueError(f"spp must be a whole number from 1 to {MOST_SAMPLES}, found {spp!r}")
    if time is not None and not (_is_real(time) and 0.0 < time <= MOST_SECONDS):
        raise ValueError(f"time must be a positive number of seconds up to {MOST_SECONDS:g}, found {time!r}")
    if error is not None and not (_is_real(error) and 0.0 < error <= MOST_ERROR):
        raise ValueError(f"error must be a positive fraction up to {MOST_ERROR:g}, such as 0.02, found {error!r}")
    if not (_is_whole(seed) and 0 <= seed < 2**64):
        raise ValueError(f"seed must be a whole number from 0 to 2^64 - 1, found {seed!r}")
    if not (_is_whole(threads) and 0 <= threads <= MOST_THREADS):
        raise ValueError(f"threads must be a whole number from 0 to {MOST_THREADS}, found {threads!r}")
    if backend not in get_args(Backend):
        raise ValueError(f"backend must be one of {', '.join(get_args(Backend))}, found {backend!r}")


def as_scene(scene: Scene | str | os.PathLike[str] | Mapping[str, Any]) -> Scene:
    """Load what is not a loaded scene already."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return load_dict(dict(scene))
    return load(Path(scene))


def _is_whole(value: object) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
