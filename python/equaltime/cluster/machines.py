"""Machines that take whole runs of an experiment, one run at a time: the workers of a scheduler of Dask.

Times of runs are compared. So a worker takes part only if its machine and its build are like this process's. Only one
worker of each machine does: two runs on one machine would disturb each other's clocks. Each task is bound to its
worker. If the worker is lost, the task comes back, and another worker may get it.
"""

from __future__ import annotations

import asyncio
import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from distributed import Client, Future, Worker, wait

from equaltime.cluster.likeness import Likeness, likeness
from equaltime.cluster.scene_text import Files, copy_into, lacks, store
from equaltime.cluster.tasks import Ended, Ground, Machine
from equaltime.errors import EqualtimeError, EqualtimeWarning, RenderError

__all__ = ["ALONE", "LOST", "SCHEDULER_LOST", "Machines", "alone_for", "reason_of", "send_files", "workers_of"]

ALONE = 60.0
"""Seconds without any worker that end a render or an experiment, if nothing but the user starts workers."""
SCHEDULER_LOST = "the connection to the scheduler was lost; start it and its workers again"
"""Error of a scheduler that has ended: its workers end with it."""

LOST = (OSError, asyncio.CancelledError)
"""Errors of a question to a scheduler that is gone: Dask also cancels questions that have no answer yet."""

_PART = 2**22
"""Bytes of a file that are sent at once: a message stays below 8 MB."""
_CHECK_EVERY = 1.0
"""Seconds between two looks at the workers."""
_FETCH = 5.0
"""Seconds of waiting for a finished result until the worker is looked for again."""


@dataclass
class _Task:
    name: Any
    machine: Machine
    ground: Future
    future: Future


class Machines:
    """The machines on which a scheduler's workers run, for tasks whose times are compared.

    A machine takes tasks if it has the hardware and the build of equaltime that this process has. One worker of each
    machine takes them, one task at a time.
    """

    def __init__(self, client: Client, patience: float = ALONE) -> None:
        """Examine the workers of ``client``; raise RenderError if none has a machine and a build like this process.

        ``patience`` is the number of seconds without any worker after which the experiment ends.
        """
        self._client, self._patience, self._here = client, patience, likeness()
        self._known: dict[str, Likeness] = {}
        self._refused: dict[str, str] = {}
        """Why workers take no part, by their addresses."""
        self._grounds: dict[tuple[str, Ground], Future] = {}
        self._running: dict[str, _Task] = {}
        self._returned: list[Ended] = []
        self._looked, self._met = -math.inf, time.monotonic()
        self._addresses: list[str] = []
        self.look()

    @property
    def present(self) -> tuple[Machine, ...]:
        """Machines that take tasks, in the order in which they joined."""
        by_boot: dict[str, Machine] = {}
        for address, known in self._known.items():
            if address in self._addresses and address not in self._refused:
                by_boot.setdefault(known.boot, Machine(address, known.host))
        return tuple(by_boot.values())

    @property
    def free(self) -> tuple[Machine, ...]:
        """Machines without a task."""
        return tuple(machine for machine in self.present if machine.address not in self._running)

    def look(self) -> None:
        """Look for workers that have joined or left, at most once a second.

        Raises RenderError if no worker can take part, or if there has been none for a minute.
        """
        now = time.monotonic()
        if now - self._looked < _CHECK_EVERY:
            return
        self._looked, self._addresses = now, list(workers_of(self._client))
        new = [address for address in self._addresses if address not in self._known.keys() | self._refused.keys()]
        self._meet(new)
        for address in [address for address in self._running if address not in self._addresses]:
            self._lose(address)
        refused = [address for address in self._addresses if address in self._refused]
        if refused and self._known.keys() <= self._refused.keys():
            raise RenderError(f"no worker of the cluster can take runs; {refused[0]}: {self._refused[refused[0]]}")
        if self.present:
            self._met = now
        elif now - self._met > self._patience:
            raise RenderError(f"{alone_for(self._patience)}, then repeat the command")

    def give(self, name: Any, machine: Machine, ground: Ground, function: Callable[..., Any], *arguments: Any) -> None:
        """Let ``machine``, which must be free, call ``function`` as a task.

        The first argument of the call is the object that the machine builds from ``ground``; ``arguments`` are the
        others. ``name`` identifies the task in `ended`.
        """
        address = machine.address
        try:
            built = self._built(address, ground)
            future = self._submit(address, function, built, *arguments)
        except (OSError, TimeoutError, KeyError):  # the worker has just left
            self._returned.append(Ended(name, machine))
            self._looked = -math.inf
            return
        self._running[address] = _Task(name, machine, built, future)

    def ended(self) -> Iterator[Ended]:
        """Wait for up to a second, and yield the tasks that have ended or must be given to another machine.

        Raises
        ------
        EqualtimeError
            If a task raised this error.
        RenderError
            If a task raised an error of another kind, or if the connection to the scheduler was lost.
        """
        if self._running:
            futures = [task.future for task in self._running.values()]
            with suppress(TimeoutError, CancelledError):  # a cancelled one is an error below
                wait(futures, timeout=_CHECK_EVERY, return_when="FIRST_COMPLETED")
        elif not self._returned:
            time.sleep(_CHECK_EVERY)
        for address, task in list(self._running.items()):
            if task.future.done():
                del self._running[address]
                yield self._end(task)
        returned, self._returned = self._returned, []
        yield from returned

    def clear(self) -> None:
        """Cancel all tasks, and let the machines forget the objects that they built for tasks."""
        for task in self._running.values():
            with suppress(Exception):  # a scheduler that is gone has nothing to cancel
                task.future.cancel()
        self._running.clear()
        self._grounds.clear()

    def _meet(self, new: list[str]) -> None:
        """Find out which of the ``new`` workers are like this process."""
        answers = self._client.run(likeness, workers=new, on_error="return") if new else {}
        for address, answer in answers.items():
            if isinstance(answer, OSError):
                continue  # it has left
            if not isinstance(answer, Likeness):
                self._refuse(address, reason_of(answer))
                continue
            self._known[address] = answer
            if why := self._here.differences(answer):
                self._refuse(address, f"times of unlike machines cannot be compared ({why})")
            elif not any(machine.address == address for machine in self.present):
                self._tell(address, f"another worker of {answer.host} does, and runs would disturb each other's times")

    def _refuse(self, address: str, why: str) -> None:
        self._refused[address] = why
        self._tell(address, why)

    def _tell(self, address: str, why: str) -> None:
        warnings.warn(f"the worker {address} takes no part: {why}", EqualtimeWarning, stacklevel=2)

    def _lose(self, address: str) -> None:
        task = self._running.pop(address)
        with suppress(Exception):  # it may be gone already
            task.future.cancel()
        self._forget(address)
        self._returned.append(Ended(task.name, task.machine, lost=True))

    def _forget(self, address: str) -> None:
        self._grounds = {key: future for key, future in self._grounds.items() if key[0] != address}

    def _built(self, address: str, ground: Ground) -> Future:
        """Return the future of a ground on a worker. A worker without the ground gets scene and data, and builds it.

        Dask keeps the object until this process drops the future or ends, however it ends.
        """
        key = (address, ground)
        if key not in self._grounds:
            there = self._client.run(_lacks, ground.scene.files, workers=[address], on_error="ignore")
            if there.get(address):
                send_files(self._client, ground.scene.files, [address])
            sent = self._client.scatter(ground, workers=[address], hash=False)
            self._grounds[key] = self._submit(address, _build, sent)
        return self._grounds[key]

    def _submit(self, address: str, function: Callable[..., Any], *arguments: Any) -> Future:
        return self._client.submit(function, *arguments, workers=[address], allow_other_workers=False, pure=False)

    def _end(self, task: _Task) -> Ended:
        """Return the end of a task; without a result if its worker cannot build the ground, or has left.

        If a worker leaves, Dask cancels its tasks: nobody else has what they need.
        """
        address = task.machine.address
        if task.future.status == "finished" and (fetched := self._fetched(task)) is not None:
            return fetched
        if task.ground.status == "error":
            error = task.ground.exception()
            self._refuse(address, str(error) or type(error).__name__)
        elif task.future.status == "error":
            error = task.future.exception()
            if isinstance(error, EqualtimeError):
                raise error
            raise RenderError(f"the worker {address} failed ({type(error).__name__}: {error})") from error
        elif self._client.status != "running":
            raise RenderError(f"{SCHEDULER_LOST}, then repeat the command")
        self._forget(address)
        self._looked = -math.inf
        return Ended(task.name, task.machine, lost=task.ground.status != "error")

    def _fetched(self, task: _Task) -> Ended | None:
        """Return the end of a finished task with its result; None if the worker left before it had sent it."""
        while True:
            try:
                return Ended(task.name, task.machine, task.future.result(timeout=_FETCH))
            except (TimeoutError, CancelledError, OSError):
                if task.future.status != "finished" or task.machine.address not in workers_of(self._client):
                    return None


def _lacks(files: Files, dask_worker: Worker) -> bool:
    """Tell whether a worker needs copies of ``files``, which it makes in its own folder."""
    copy_into(dask_worker.local_directory)
    return lacks(files)


def _build(ground: Ground) -> Any:
    """Build a ground in this process."""
    return ground.build(ground.scene.load(), ground.data)


def workers_of(client: Client) -> Mapping[str, Any]:
    """Return the facts that the scheduler of ``client`` has of each worker, by the worker's address.

    The result is empty if the scheduler cannot be reached.
    """
    try:
        return client.scheduler_info(n_workers=-1).get("workers", {})  # type: ignore[no-any-return]  # Dask is not typed
    except LOST:
        return {}


def alone_for(seconds: float) -> str:
    """Return the error of a scheduler that has had no worker for ``seconds``."""
    return f"no worker of the cluster has been there for {seconds:g} s; start workers"


def reason_of(error: Exception) -> str:
    """Return, in words, why a worker takes no part that answered with ``error``."""
    if "No module named 'equaltime'" in str(error):  # Dask may have put the error into another one
        return "equaltime is not installed there"
    return f"{type(error).__name__}: {error}"


def send_files(client: Client, files: Files, addresses: list[str]) -> dict[str, Exception]:
    """Copy ``files`` to the workers of ``client`` at ``addresses``; return the errors of those that did not get them.

    A worker that has left is one of them.
    """
    errors: dict[str, Exception] = {}
    for path, size in files:
        with Path(path).open("rb") as file:
            for offset in range(0, max(size, 1), _PART):
                left = [address for address in addresses if address not in errors]
                part = file.read(_PART)
                answers = client.run(store, path, offset, part, workers=left, on_error="return") if left else {}
                errors |= {address: answer for address, answer in answers.items() if answer is not None}
    return errors
