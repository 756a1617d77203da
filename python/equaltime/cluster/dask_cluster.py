"""Cluster of dask.distributed: processes on this machine, or the workers of a scheduler.

Dask gives the units of a worker that ends to other workers, and lets workers join at any time. A worker takes units
once it has the scene and has rendered a small test unit to the bits of this process. It then offers a resource of Dask
that every unit requires; a worker with other bits never offers it. Dask looks for the resource only when a worker joins
or a unit arrives, which is before a new worker offers it. So if all workers end, their units are submitted again.
"""

from __future__ import annotations

import asyncio
import logging
import time
import warnings
from collections.abc import Mapping
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from pathlib import Path
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster, Worker, WorkerPlugin

from equaltime.cluster.machines import LOST, Machines, send_files, workers_of
from equaltime.cluster.scene_text import SceneText, lacks
from equaltime.cluster.team import CONNECT_SECONDS, SceneTeam
from equaltime.cluster.units import bits, probe_unit, render_unit
from equaltime.errors import EqualtimeError, EqualtimeWarning, RenderError
from equaltime.machine import processors
from equaltime.rendering.units import Rendered, Unit, add_samples, release
from equaltime.scene import Scene

__all__ = ["DaskCluster", "DaskTeam"]

_LACKS = "it lacks files of the scene"
_CHECK_EVERY, _ALONE = 1.0, 60.0
"""Seconds between two looks at the workers, and the seconds without any that end a render."""
_IDLE = 3
"""Looks at which no worker does anything, though units wait, before they are submitted again."""
_HUNG = "30s"
"""Time after which a worker on this machine that does not answer is given up."""
_SOON = 0.05
"""Seconds between two looks whether a worker has ended its probe."""


class DaskCluster:
    """Workers of a scheduler of Dask, as a cluster for renders; a context manager, which disconnects at its end."""

    def __init__(
        self,
        client: Client,
        keep: Path | None,
        threads: int = 0,
        own: LocalCluster | None = None,
        shared: bool = False,
    ) -> None:
        """Use the workers of ``client``, each with ``threads`` threads for a unit; 0 is one for each of its processors.

        A unit is a window of the film with some samples. ``keep`` is the folder for finished units until the render is
        saved; None keeps none. ``own`` is the local cluster that was started for this object, which ends it when it is
        closed. ``shared`` is True if the caller made ``client``, which then stays connected.
        """
        self.client, self._keep, self._threads, self._own, self._shared = client, keep, threads, own, shared
        self._teams: dict[str, DaskTeam] = {}

    @classmethod
    def of(cls, where: Any, keep: Path | None) -> DaskCluster:
        """Return the cluster for ``where``: ``local:N``, the address of a scheduler, or a ``distributed.Client``.

        ``keep`` is the folder for finished parts of a render until the render is saved; None keeps none. Raises
        ValueError if ``where`` is of another type, and RenderError if no scheduler answers.
        """
        if isinstance(where, Client):
            return cls(where, keep, shared=True)
        if not isinstance(where, str):
            raise ValueError(f"a cluster is local:N, an address, a Client of Dask or an Executor; found {where!r}")
        kind, _, count = where.partition(":")
        return cls.here(int(count), keep) if kind == "local" else cls.at(where, keep)

    @classmethod
    def at(cls, address: str, keep: Path | None) -> DaskCluster:
        """Connect to the scheduler at ``address``, such as ``tcp://node1:8786``, and return its workers as a cluster.

        ``keep`` is the folder for finished parts of a render until the render is saved; None keeps none. Raises
        RenderError if the scheduler does not answer.
        """
        try:
            return cls(Client(address, timeout=CONNECT_SECONDS), keep)
        except (OSError, ValueError) as error:
            raise RenderError(f"no scheduler of Dask answers at {address}: {error}") from error

    @classmethod
    def here(cls, count: int, keep: Path | None) -> DaskCluster:
        """Start ``count`` worker processes on this machine, which share its processors, and return them as a cluster.

        ``keep`` is the folder for finished parts of a render until the render is saved; None keeps none.
        """
        dask.config.set({"distributed.scheduler.worker-ttl": _HUNG})
        local = LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            memory_limit=0,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        )
        return cls(Client(local), keep, max(1, processors() // count), local)

    def team(self, scene: Scene) -> DaskTeam:
        """Return a team that renders ``scene``: the workers that are present, and workers that join later."""
        self._teams[scene.digest] = team = DaskTeam(scene, self._keep, self.client, self._threads)
        return team

    def machines(self) -> Machines:
        """Return the machines that can take runs whose times are compared with each other.

        Raises RenderError if no worker is like this process.
        """
        return Machines(self.client)

    def close(self) -> None:
        """Free the scenes in the workers, disconnect, and end the workers that this object started."""
        for team in self._teams.values():
            team.close()
        if not self._shared:
            with suppress(OSError, RuntimeError):  # if the scheduler has ended, nothing is left open
                self.client.close()
        if self._own is not None:
            self._own.close()

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class DaskTeam(SceneTeam):
    """Team of a scheduler's workers that have one scene, and render its units (windows of the film, some samples)."""

    def __init__(self, scene: Scene, keep: Path | None, client: Client, threads: int) -> None:
        """Let the workers of ``client`` load ``scene``; raise RenderError if none gives the bits of this process.

        ``keep`` is the folder for finished units until the render is saved; None keeps none. ``threads`` is the number
        of threads that a worker uses for a unit; 0 is one for each of its processors.
        """
        super().__init__(scene, keep)
        self._client, self._name = client, f"equaltime-{scene.digest[:16]}"
        self._workers: dict[str, str] = {}
        """Why each worker was refused, by its address; empty if it was not."""
        self._looked = self._met = time.monotonic()
        self._idle = 0
        unit = probe_unit(scene)
        expected = bits(add_samples(scene, unit))
        release()
        client.register_plugin(_Joining(self._name, self.scene, unit, expected, threads), name=self._name)
        self._executor = client.get_executor(pure=False, resources={self._name: 1})
        self._threads = threads
        self.begin()

    @property
    def size(self) -> int:
        """Number of workers that can render at once, at least 1."""
        return max(1, sum(not why for why in self._workers.values()))

    def begin(self) -> None:
        """Prepare for a pass: find workers that have joined or left.

        Raises RenderError if no worker gives the bits of this process.
        """
        addresses = list(workers_of(self._client))
        new = [address for address in addresses if address not in self._workers]
        found = {**self._workers, **self._joined(new)}
        self._workers = {address: found[address] for address in addresses if address in found}
        for address in new:
            if why := self._workers.get(address):
                warnings.warn(f"the worker {address} takes no part: {why}", EqualtimeWarning, stacklevel=2)
        self._idle = 0
        if self._workers and all(self._workers.values()):
            address, why = next(iter(self._workers.items()))
            raise RenderError(f"no worker of the cluster can take part; {address}: {why}")

    def submit(self, unit: Unit) -> Future[Rendered]:
        """Let a worker render ``unit``, a window of the film with some samples; return a future of the result."""
        future: Future[Rendered] = self._executor.submit(render_unit, self.scene.digest, unit, self._threads)
        return future

    def check(self) -> bool:
        """Tell whether all waiting units must be submitted again, because the workers do nothing although work waits.

        A unit is a window of the film with some samples. The answer is True if all workers have ended and new workers
        have joined. Raises RenderError if there has been no worker for a minute.
        """
        now = time.monotonic()
        if now - self._looked < _CHECK_EVERY:
            return False
        self._looked = now
        there = [address for address, facts in workers_of(self._client).items() if facts["resources"].get(self._name)]
        if not there:
            if self._client.status == "closed":  # it could not connect again
                raise RenderError("the connection to the scheduler was lost")
            self.begin()
            if now - self._met > _ALONE:
                raise RenderError(f"no worker of the cluster has been there for {_ALONE:g} s")
            return False
        self._met = now
        with suppress(*LOST):  # the scheduler is gone, and the units fail by themselves
            self._idle = 0 if any(self._client.processing(there).values()) else self._idle + 1
        again = self._idle == _IDLE
        self._idle %= _IDLE
        return again

    def failure(self, error: Exception) -> RenderError:
        """Return an error for the user, made of ``error``, which Dask raised for a unit.

        It says whether the workers failed or the connection to the scheduler was lost.
        """
        if isinstance(error, KilledWorker):
            return RenderError("one unit ended several workers in turn, perhaps for lack of memory")
        if isinstance(error, CancelledError):
            return RenderError("the connection to the scheduler was lost")
        return RenderError(f"a worker failed ({type(error).__name__}: {error})")

    def close(self) -> None:
        """Free the scene in all workers."""
        with suppress(Exception):  # a scheduler that is gone has nothing to take from
            self._client.unregister_worker_plugin(self._name)

    def _joined(self, addresses: list[str]) -> dict[str, str]:
        """Return for each new worker why it is refused, after it got the files that it lacks."""
        found: dict[str, str] = self._asked(_reason, addresses)
        needy = [address for address, why in found.items() if why == _LACKS]
        if needy:
            send_files(self._client, self.scene.files, needy)
            found |= self._asked(_tried_again, needy)
        return found

    def _asked(self, function: Any, addresses: list[str]) -> dict[str, str]:
        """Ask workers, and return their answers; those that are gone have none."""
        if not addresses:
            return {}
        answers: Mapping[str, Any] = {}
        with suppress(*LOST):
            answers = self._client.run(function, self._name, workers=addresses, on_error="ignore")
        return {address: str(answer) for address, answer in answers.items()}


class _Joining(WorkerPlugin):  # type: ignore[misc]  # Dask is not typed
    """Plugin of a worker, which loads the scene when it joins, and offers its work if it gives the same bits."""

    def __init__(self, name: str, scene: SceneText, unit: Unit, expected: str, threads: int) -> None:
        self.name, self._scene, self._unit, self._expected, self._threads = name, scene, unit, expected, threads
        self.why: str | None = None
        """Why the worker is refused; empty if it is not, None while that is not known."""

    async def setup(self, worker: Worker) -> None:
        """Find out whether the worker gives the same bits; its loop goes on meanwhile."""
        self.why = None
        self.why = await asyncio.to_thread(self._differs)
        await worker.set_resources(**{self.name: 0 if self.why else 1})

    async def teardown(self, worker: Worker) -> None:
        """Offer no more work."""
        await worker.set_resources(**{self.name: 0})

    def _differs(self) -> str:
        """Return why this worker is refused; empty if it is not."""
        if lacks(self._scene.files):
            return _LACKS
        try:
            same = bits(render_unit(self._scene, self._unit, self._threads)) == self._expected
        except (EqualtimeError, ValueError, MemoryError) as error:
            return str(error) or "not enough memory"
        return "" if same else "the same samples have other bits there"


async def _reason(name: str, dask_worker: Worker) -> str:
    while (why := dask_worker.plugins[name].why) is None:
        await asyncio.sleep(_SOON)
    return str(why)


async def _tried_again(name: str, dask_worker: Worker) -> str:
    await dask_worker.plugins[name].setup(dask_worker)
    return await _reason(name, dask_worker)
