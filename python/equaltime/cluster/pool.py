"""Cluster of the processes of an executor: Python's process pool, MPI's, or any other of `concurrent.futures`."""

from __future__ import annotations

from concurrent.futures import Executor, Future
from pathlib import Path

from equaltime.cluster.team import SceneTeam
from equaltime.cluster.units import render_unit
from equaltime.errors import RenderError
from equaltime.machine import processors
from equaltime.rendering.units import Rendered, Unit
from equaltime.scene import Scene

__all__ = ["Pool"]


class Pool:
    """Processes of an executor of `concurrent.futures`, as a cluster for renders."""

    def __init__(self, executor: Executor, threads: int = 1, keep: Path | None = None) -> None:
        """Let ``executor`` render units (windows of the film with some samples), each with ``threads`` threads.

        ``keep`` is the folder for finished units until the render is saved; None keeps none.
        """
        self._executor, self._threads, self._keep = executor, threads, keep

    def team(self, scene: Scene) -> PoolTeam:
        """Return a team that renders ``scene``, which is sent as text with each unit of the work."""
        return PoolTeam(scene, self._keep, self._executor, self._threads)


class PoolTeam(SceneTeam):
    """Team of an executor's processes that render units (windows of the film with some samples) of one scene."""

    def __init__(self, scene: Scene, keep: Path | None, executor: Executor, threads: int) -> None:
        """Make a team for ``scene``; ``keep``, ``executor`` and ``threads`` are as for `Pool`."""
        super().__init__(scene, keep)
        self._executor, self._threads = executor, threads

    @property
    def size(self) -> int:
        """Number of the executor's processes, or of this machine's processors if the executor does not tell it."""
        return int(getattr(self._executor, "_max_workers", None) or processors())

    def begin(self) -> None:
        """Do nothing before a pass: an executor does not tell which processes it has."""

    def submit(self, unit: Unit) -> Future[Rendered]:
        """Let the executor render ``unit``, a window of the film with some samples; return a future of the result."""
        return self._executor.submit(render_unit, self.scene, unit, self._threads)

    def check(self) -> bool:
        """Return False: no work need be submitted again, since the executor's futures fail if its processes end."""
        return False

    def failure(self, error: Exception) -> RenderError:
        """Return an error for the user, made of ``error``, which the executor raised for a unit."""
        said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        return RenderError(f"a process of the executor failed ({said})")
