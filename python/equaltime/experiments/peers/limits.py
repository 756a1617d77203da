"""Time limits for other renderers: a renderer that hangs is ended with its process group, and the error names it."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer
from typing import Any

from equaltime.errors import PeerError

__all__ = ["DEFAULT_LIMIT", "limited", "send_to_all", "time_limit"]

_TIMES_BUDGET, _SECONDS_MORE = 20.0, 60.0
"""Default limit of a render: a multiple of the budget, plus seconds for loading and compiling.

A run's last render takes at most a few times the budget."""
_WITHOUT_BUDGET = 3600.0
"""Default limit of a render, in seconds, if the experiment gives sample counts, whose time is unknown."""
SETUP_LIMIT = 1800.0
"""Limit for starting a renderer or loading and compiling a scene, in seconds: large scenes take minutes."""
_PATIENCE = 2.0
"""Seconds from SIGTERM to SIGKILL."""


def time_limit(budget: float | None, reference: float = 0.0) -> float:
    """Return the longest time of one render, in seconds.

    The limit is 20 times the budget plus a minute, or one hour without a budget. It is at least the seconds of a
    ``reference`` plus a minute, because a peer may have to render its own reference.
    """
    run = _WITHOUT_BUDGET if budget is None else _TIMES_BUDGET * budget + _SECONDS_MORE
    return max(run, reference + _SECONDS_MORE)


DEFAULT_LIMIT = time_limit(None)
"""Limit of one render, in seconds, for a peer used outside an experiment."""


def send_to_all(process: subprocess.Popen[Any], kind: signal.Signals) -> None:
    """Send a signal to the process group of a process that leads its own session."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, kind)


@contextmanager
def limited(process: subprocess.Popen[Any], seconds: float, who: str) -> Iterator[None]:
    """End a process with its process group and raise `PeerError` if the block takes longer than ``seconds``.

    The process must lead its own session. A block that waits for the process goes on when the process has ended. The
    block must not reap the process: the system could reuse its number, and another process would be ended.
    """
    late, done, one_at_a_time = threading.Event(), threading.Event(), threading.Lock()

    def send(kind: signal.Signals) -> None:
        with one_at_a_time:
            if not done.is_set():
                late.set()
                send_to_all(process, kind)

    def stop() -> None:
        send(signal.SIGTERM)
        if not done.wait(_PATIENCE):
            send(signal.SIGKILL)

    timer = Timer(min(seconds, threading.TIMEOUT_MAX), stop)
    timer.daemon = True
    try:
        timer.start()
        yield
    except Exception:
        if not late.is_set():
            raise
    finally:
        with one_at_a_time:
            done.set()
        timer.cancel()
        if timer.ident is not None:  # it was started
            timer.join()
    if late.is_set():
        send_to_all(process, signal.SIGKILL)  # members of the group that outlived its leader
        raise PeerError(
            f"{who}: no answer within {seconds:.6g} s; ended. If the render only needs longer, set limit = '30min' "
            "beside command (peer.limit)."
        )
