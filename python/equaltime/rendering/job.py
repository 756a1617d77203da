"""A job: one render in the core, with all that decides its bits and where it ends."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from equaltime.film.error import Estimate
from equaltime.rendering.budget import Limits
from equaltime.rendering.checkpoint import Checkpoint
from equaltime.rendering.stopping import Stop
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["Job", "Traps"]

Traps = Literal["ignore", "check", "stop"]
"""Floating-point faults: ``ignore`` them, name the sample (``check``), or end the process by SIGFPE (``stop``)."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """One render in the core."""

    scene: Scene
    strategy: Strategy
    limits: Limits = field(default_factory=Limits)
    seed: int = 0
    threads: int = 0
    """Worker threads; 0 is one for each processor."""
    without: tuple[str, ...] = ()
    """Names of the effects that were left out of ``scene`` and ``strategy``."""
    bias: Estimate | None = None
    """Error that leaving effects out makes; None if none were."""
    traps: Traps = "ignore"
    stop: Stop | None = None
    """How a pilot chose the sample count; None if none did."""
    resumed: Checkpoint | None = None
    """The saved render that this one goes on from."""
