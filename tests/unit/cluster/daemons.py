"""Schedulers and workers of Dask as processes of their own, which a test or a bench may stop and kill."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import equaltime as et
from equaltime.rendering.passes import Progress

__all__ = ["at_progress", "free_port", "same", "scheduler", "worker"]


def free_port() -> int:
    """Return a port of this machine that nothing uses."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@contextmanager
def scheduler(port: int, **variables: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a scheduler that listens to a port; ``variables`` are added to its environment."""
    words = ("dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--no-show")
    with _daemon(words, variables) as process:
        yield process


@contextmanager
def worker(port: int, **variables: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a worker of the scheduler at a port, without a process that would start it again."""
    words = ("dask_worker", f"tcp://127.0.0.1:{port}", "--nthreads", "1", "--no-dashboard", "--no-nanny")
    with _daemon(words, variables) as process:
        yield process


@contextmanager
def _daemon(words: tuple[str, ...], variables: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-m", f"distributed.cli.{words[0]}", *words[1:]]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, env={**os.environ, **variables}, stdout=quiet, stderr=quiet) as process:
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def at_progress(count: int, act: Callable[[], object]) -> Iterator[et.Observer]:
    """Yield an observer that acts once, the ``count``-th time that it hears of the render."""
    heard = 0

    def progress(_: Progress) -> None:
        nonlocal heard
        heard += 1
        if heard == count:
            act()

    yield et.Observer.of(progress=progress)
    assert heard >= count, "the render had ended"


def same(a: et.Result, b: et.Result) -> bool:
    """Tell whether two renders have the same moments, bit by bit."""
    assert a.moments is not None
    assert b.moments is not None
    return a.moments.tobytes() == b.moments.tobytes()
