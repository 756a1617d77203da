"""The shipped scenes, small, and what the tests here ask of their films."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core

__all__ = ["DEPTH", "FILES", "FOLDER", "SIZE", "Moments", "renderer", "same_bits", "shipped"]

Moments = NDArray[Any]
"""(replicates, height, width) of count, mean and m2."""
SIZE: Final = (24, 16)
DEPTH: Final = 8
FILES: Final = ("cornell-box.toml", "veach-mis.toml", "montelight/simple.toml", "montelight/complex.toml")
FOLDER: Final = Path(__file__).parents[2] / "scenes"


def shipped(file: str, crop: tuple[int, int, int, int] | None = None) -> et.Scene:
    return et.load(FOLDER / file).with_(size=SIZE, crop=crop, max_depth=DEPTH)


def renderer(core: _core.Scene, *, seed: int = 5, threads: int = 2, tile: int = 16, **strategy: Any) -> _core.Renderer:
    """Return a renderer whose paths meet the roulette early."""
    settings = _core.Settings(**{"max_depth": DEPTH, "roulette_depth": 3} | strategy)
    return _core.Renderer(core, settings, seed, threads, tile)


def same_bits(first: Moments, second: Moments) -> bool:
    """Return whether two films are one and the same, signs of zeros included."""
    assert first.dtype == second.dtype
    return (
        first.shape == second.shape and np.ascontiguousarray(first).tobytes() == np.ascontiguousarray(second).tobytes()
    )
