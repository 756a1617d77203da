"""Tasks of machines that take whole runs: where they run, on what, and how they end (`equaltime.cluster.machines`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from equaltime.cluster.scene_text import SceneText
from equaltime.scene import Scene

__all__ = ["Ended", "Ground", "Machine"]


@dataclass(frozen=True, eq=False)
class Ground:
    """Object that each machine builds once, from a scene and other data, and that its tasks then use."""

    scene: SceneText
    data: Any
    build: Callable[[Scene, Any], Any]


@dataclass(frozen=True)
class Machine:
    """Worker that takes runs, one at a time."""

    address: str
    """Address of the worker."""
    host: str
    """Name of its machine in the network."""


@dataclass(frozen=True)
class Ended:
    """Task that has ended, or must be given to another machine."""

    name: Any
    """Name that the task was given."""
    machine: Machine
    result: Any = None
    """Result of the task; None if there is none."""
    lost: bool = False
    """Whether the machine was lost while the task ran there."""
