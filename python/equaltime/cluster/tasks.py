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
    """Recipe of an object that each machine builds once, and that the machine's tasks then use."""

    scene: SceneText
    data: Any
    """Second argument of ``build``."""
    build: Callable[[Scene, Any], Any]
    """Function that returns the object, given the loaded scene and ``data``."""


@dataclass(frozen=True)
class Machine:
    """Machine that takes runs of an experiment, one at a time, through one worker (process) of a scheduler."""

    address: str
    """Address of the worker."""
    host: str
    """Name of the machine in the network."""


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
