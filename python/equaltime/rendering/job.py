"""Job: one render in the core, with everything that decides its bits and its end."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from equaltime.rendering.budget import Limits, Stop
from equaltime.rendering.checkpoint import SavedRender
from equaltime.scene import Scene
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["Job", "Traps"]

Traps = Literal["ignore", "check", "stop"]
"""Treatment of floating-point faults: ``ignore``, name the sample (``check``), or end by SIGFPE (``stop``)."""


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
    """Names of the effects that were left out of ``scene`` and ``strategy``."""
    bias: Interval | None = None
    """Error due to the effects that were left out; None if there are none."""
    traps: Traps = "ignore"
    stop: Stop | None = None
    """Rule by which a pilot chose the sample count; None without such a pilot."""
    resumed: SavedRender | None = None
    """Saved render that this render resumes; None for a new render."""
