"""Cluster of dask.distributed: processes on this machine, or the workers of a scheduler.

Dask gives the units of a worker that ends to other workers, and lets workers join at any time. A worker takes units
once it has the scene and has rendered a small test unit to the bits of this process. It then offers a resource of Dask
that every unit requires; a worker with other bits never offers it. Dask looks for the resource only when a worker joins
or a unit arrives, which is before a new worker offers it. So if all workers end, their units are submitted again.
"""

from __future__ import annotations

import asyncio
import logging
import math
import time
import warnings
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster, Status, Worker, WorkerPlugin
from distributed.deploy.cluster import Cluster
from distributed.utils import silence_logging_cmgr

from equaltime.cluster.machines import (
    ALONE,
    LOST,
    SCHEDULER_LOST,
    Machines,
    alone_for,
    reason_of,
    send_files,
    workers_of,
)
from equaltime.cluster.scene_text import SceneText, copy_into, lacks
from equaltime.cluster.team import CONNECT_SECONDS, SceneTeam
from equaltime.cluster.units import bits, probe_unit, render_unit
from equaltime.errors import EqualtimeError, EqualtimeWarning, RenderError
from equaltime.machine import processors
from equaltime.rendering.units import Rendered, Unit, add_samples, release
from equaltime.scene import Scene

__all__ = ["DaskCluster", "DaskTeam"]

_LACKS = "it lacks files of the scene"
_CHECK_EVERY, _PATIENT = 1.0, 10.0
"""Seconds between two looks at the workers, and the seconds without any after which the user is told."""
_IDLE = 3
"""Looks at which no worker does anything, though units wait, before they are submitted again."""
_HUNG = "30s"
"""Time after which a worker on this machine that does not answer is given up."""
_SOON = 0.05
"""Seconds between two looks whether a worker has ended its probe."""
_ADDED = 10.0
"""Seconds after which a worker without the plugin is refused: it could not read the plugin."""


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
        starts_workers = own is None and getattr(client, "cluster", None) is not None  # such as jobs of a queue
        self._patience = math.inf if starts_workers else ALONE
        self._quiet = ExitStack()
        if not shared:  # Dask logs a traceback for each connection that is lost
            self._quiet.enter_context(silence_logging_cmgr(logging.CRITICAL))

    @classmethod
    def of(cls, where: Any, keep: Path | None) -> DaskCluster:
        """Return the cluster for ``where``: ``local:N``, a scheduler's address, or a client or cluster of Dask.

        ``keep`` is the folder for finished parts of a render until the render is saved; None keeps none. Raises
        ValueError if ``where`` is of another type or a client that cannot be used. Raises RenderError if no scheduler
        answers.
        """
        if isinstance(where, Client):
            if where.asynchronous or where.status != "running":
                state = "asynchronous" if where.asynchronous else where.status
                raise ValueError(f"the Client of Dask is {state}; expected one that is connected and waits for results")
            return cls(where, keep, shared=True)
        if isinstance(where, Cluster):
            return cls(Client(where), keep)
        if not isinstance(where, str):
            raise ValueError(
                f"a cluster is local:N, an address, a Client or a cluster of Dask, or an Executor; found {where!r}"
            )
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
        self._teams[scene.digest] = team = DaskTeam(scene, self._keep, self.client, self._threads, self._patience)
        return team

    def machines(self) -> Machines:
        """Return the machines that can take runs whose times are compared with each other.

        Raises RenderError if no worker is like this process.
        """
        return Machines(self.client, self._patience)

    def close(self) -> None:
        """Free the scenes in the workers, disconnect, and end the workers that this object started."""
        for team in self._teams.values():
            team.close()
        if not self._shared:
            with suppress(OSError, RuntimeError):  # if the scheduler has ended, nothing is left open
                self.client.close()
        if self._own is not None:
            self._own.close()
        self._quiet.close()

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class DaskTeam(SceneTeam):
    """Team of a scheduler's workers that render units (windows of the film with some samples) of one scene."""

    def __init__(self, scene: Scene, keep: Path | None, client: Client, threads: int, patience: float = ALONE) -> None:
        """Let the workers of ``client`` load ``scene``; raise RenderError if none gives the bits of this process.

        ``keep`` is the folder for finished units until the render is saved; None keeps none. ``threads`` is the number
        of threads that a worker uses for a unit; 0 is one for each of its processors. ``patience`` is the number of
        seconds without any worker after which the render ends.
        """
        super().__init__(scene, keep)
        self._client, self._name, self._patience = client, f"equaltime-{scene.digest[:16]}", patience
        self._workers: dict[str, str] = {}
        """Why each worker was refused, by its address; empty if it was not."""
        self._sent: set[str] = set()
        """Addresses of workers that got copies of the scene's files."""
        self._looked = self._met = time.monotonic()
        self._idle, self._told = 0, False
        unit = probe_unit(scene)
        expected = bits(add_samples(scene, unit))
        release()
        with suppress(Exception):  # of a worker that cannot load it, which `_meet` then refuses
            client.register_plugin(_Joining(self._name, self.scene, unit, expected, threads), name=self._name)
        self._executor = client.get_executor(pure=False, resources={self._name: 1})
        self._threads = threads
        self.begin()

    @property
    def size(self) -> int:
        """Number of workers that can render at once, at least 1."""
        return max(1, sum(not why for why in self._workers.values()))

    def begin(self) -> None:
        """Prepare for a pass: find workers that have joined or left, and wait until new ones have loaded the scene.

        Raises RenderError if no worker gives the bits of this process.
        """
        self._meet(_reason)
        self._idle = 0

    def submit(self, unit: Unit) -> Future[Rendered]:
        """Let a worker render ``unit``, a window of the film with some samples; return a future of the result."""
        future: Future[Rendered] = self._executor.submit(render_unit, self.scene.digest, unit, self._threads)
        return future

    def check(self) -> bool:
        """Tell whether all waiting units must be submitted again, because the workers do nothing although work waits.

        A unit is a window of the film with some samples. The answer is True if all workers have ended and new workers
        have joined. Raises RenderError if there has been no worker for too long.
        """
        now = time.monotonic()
        if now - self._looked < _CHECK_EVERY:
            return False
        self._looked = now
        present = workers_of(self._client)
        if present.keys() != self._workers.keys():
            self._meet(_reason_so_far)
        there = [address for address, facts in present.items() if facts["resources"].get(self._name)]
        if not there:
            if self._client.status == "closed":  # it could not connect again
                raise self._lost()
            self._wait(now - self._met)
            return False
        self._met, self._told = now, False
        with suppress(*LOST):  # the scheduler is gone, and the units fail by themselves
            busy = self._client.processing()  # of all workers: to ask for one that has just left is an error
            self._idle = 0 if any(busy.get(address) for address in there) else self._idle + 1
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
            return self._lost()
        return RenderError(f"a worker failed ({type(error).__name__}: {error})")

    def close(self) -> None:
        """Free the scene in all workers."""
        with suppress(Exception):  # a scheduler that is gone has nothing to take from
            self._client.unregister_worker_plugin(self._name)

    def _lost(self) -> RenderError:
        return RenderError(SCHEDULER_LOST + self.way_on)

    def _wait(self, alone: float) -> None:
        """Tell the user of ``alone`` seconds without a worker; raise RenderError if they are too many."""
        if alone > self._patience:
            raise RenderError(alone_for(self._patience) + self.way_on)
        if alone > _PATIENT and not self._told:
            self._told = True
            limit = "" if math.isinf(self._patience) else f" up to {self._patience:g} s"
            warnings.warn(f"the cluster has no worker; the render waits{limit} for one", EqualtimeWarning, stacklevel=2)

    def _meet(self, question: Any) -> None:
        """Find out which new workers take part. A worker that lacks files of the scene gets copies.

        ``question`` is `_reason`, which waits until a worker has loaded the scene, or `_reason_so_far`. Raises
        RenderError if all workers are refused.
        """
        addresses = list(workers_of(self._client))
        new = [address for address in addresses if address not in self._workers]
        found = self._asked(question, new)
        needy = [address for address, why in found.items() if why == _LACKS and address not in self._sent]
        if needy:
            errors = send_files(self._client, self.scene.files, needy)
            self._sent.update(needy)
            self._asked(_try_again, needy)
            found = {address: why for address, why in found.items() if address not in needy}
            found |= self._asked(question, needy)
            found |= {one: f"{_LACKS} ({reason_of(errors[one])})" for one in errors if found.get(one) == _LACKS}
        known = {**self._workers, **found}
        self._workers = {address: known[address] for address in addresses if address in known}
        for address, why in found.items():
            if why:
                warnings.warn(f"the worker {address} takes no part: {why}", EqualtimeWarning, stacklevel=2)
        if self._workers and all(self._workers.values()):
            address, why = next(iter(self._workers.items()))
            raise RenderError(f"no worker of the cluster can take part; {address}: {why}")

    def _asked(self, function: Any, addresses: list[str]) -> dict[str, str]:
        """Ask workers, and return their answers; workers that are gone or do not know it yet have none."""
        if not addresses:
            return {}
        answers: dict[str, Any] = {}
        with suppress(*LOST):
            answers = self._client.run(function, self._name, workers=addresses, on_error="return")
        return {
            address: reason_of(answer) if isinstance(answer, Exception) else answer
            for address, answer in answers.items()
            if answer is not None and not isinstance(answer, OSError)
        }


class _Joining(WorkerPlugin):  # type: ignore[misc]  # Dask is not typed
    """Plugin of a worker, which loads the scene when it joins, and offers its work if it gives the same bits."""

    def __init__(self, name: str, scene: SceneText, unit: Unit, expected: str, threads: int) -> None:
        self.name, self._scene, self._unit, self._expected, self._threads = name, scene, unit, expected, threads
        self.why: str | None = None
        """Why the worker is refused; empty if it is not, None while that is not known."""

    def begin(self, worker: Worker) -> None:
        """Let `setup` run beside the worker's loop."""
        self.why = None
        self._task = asyncio.ensure_future(self.setup(worker))

    async def setup(self, worker: Worker) -> None:
        """Find out whether the worker gives the same bits; its loop goes on meanwhile."""
        self.why = None
        copy_into(worker.local_directory)
        self.why = await asyncio.to_thread(self._differs)
        await worker.set_resources(**{self.name: 0 if self.why else 1})

    async def teardown(self, worker: Worker) -> None:
        """Offer no more work. The scheduler has forgotten a worker that ends."""
        if worker.status == Status.running:
            await worker.set_resources(**{self.name: 0})

    def _differs(self) -> str:
        """Return why this worker is refused; empty if it is not."""
        if lacks(self._scene.files):
            return _LACKS
        try:
            same = bits(render_unit(self._scene, self._unit, self._threads)) == self._expected
        except MemoryError:
            return "not enough memory"
        except Exception as error:  # another build may fail in any way
            return str(error) if isinstance(error, EqualtimeError) else reason_of(error)
        return "" if same else "the same samples have other bits there"


def _reason_so_far(name: str, dask_worker: Worker) -> str | None:
    """Return why a worker is refused, empty if it is not; None while that is not known."""
    joining = dask_worker.plugins.get(name)
    return None if joining is None else joining.why


async def _reason(name: str, dask_worker: Worker) -> str:
    """Return why a worker is refused, empty if it is not, as soon as that is known."""
    last = time.monotonic() + _ADDED
    while (why := _reason_so_far(name, dask_worker)) is None:
        if name not in dask_worker.plugins and time.monotonic() > last:
            return "its equaltime cannot read the work"
        await asyncio.sleep(_SOON)
    return why


async def _try_again(name: str, dask_worker: Worker) -> None:
    """Let a worker find out anew whether it gives the same bits, and do not wait for it."""
    dask_worker.plugins[name].begin(dask_worker)
