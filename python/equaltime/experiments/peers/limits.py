"""Time limits for other renderers: one that hangs is ended with its process group, and the error names it."""

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
"""A run's last render takes at most a few times its budget; the seconds are for loading and compiling."""
_WITHOUT_BUDGET = 3600.0
"""Seconds for a render of an experiment that gives sample counts: how long they take is not known."""
SETUP_LIMIT = 1800.0
"""Seconds for starting a renderer or loading and compiling a scene: large scenes take minutes, whatever the budget."""
_PATIENCE = 2.0
"""Seconds from SIGTERM to SIGKILL."""


def time_limit(budget: float | None, reference: float = 0.0) -> float:
    """Return the seconds that one render may take.

    It is 20 times the budget and a minute; or, if that is more, the seconds of a ``reference`` and a minute, because
    a peer may have to render its own reference. Without a budget an hour takes the place of the former.
    """
    run = _WITHOUT_BUDGET if budget is None else _TIMES_BUDGET * budget + _SECONDS_MORE
    return max(run, reference + _SECONDS_MORE)


DEFAULT_LIMIT = time_limit(None)
"""Seconds for a peer that is used outside an experiment."""


def send_to_all(process: subprocess.Popen[Any], kind: signal.Signals) -> None:
    """Send a signal to a process that leads a session of its own, with its process group."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, kind)


@contextmanager
def limited(process: subprocess.Popen[Any], seconds: float, who: str) -> Iterator[None]:
    """End a process with its process group if the block takes longer; raise `PeerError` then.

    The process must lead a session of its own. A block that waits for it goes on when the process has ended. The block
    must not reap the process: the system may give its number to another one, which would be ended in its place.
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
        send_to_all(process, signal.SIGKILL)  # what did not end with its leader
        raise PeerError(
            f"{who}: no answer within {seconds:.6g} s; ended. If the render only needs longer, set limit = '30min' "
            "beside command (peer.limit)."
        )
