"""A time limit for other renderers: one that hangs is ended and told, so that it cannot stop an experiment for ever."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from equaltime.errors import PeerError

__all__ = ["DEFAULT_LIMIT", "limited", "send_to_all", "time_limit"]

_TIMES_BUDGET, _SECONDS_MORE = 20.0, 60.0
"""A run's last render takes at most a few times its budget; the seconds are for loading and compiling."""
_WITHOUT_BUDGET = 3600.0
"""Seconds for a render of an experiment that gives sample counts: how long they take is not known."""
_PATIENCE = 2.0
"""Seconds from SIGTERM to SIGKILL."""


def time_limit(budget: float | None) -> float:
    """Return the seconds that one render may take: 20 times the budget and a minute; an hour if there is no budget."""
    return _WITHOUT_BUDGET if budget is None else _TIMES_BUDGET * budget + _SECONDS_MORE


DEFAULT_LIMIT = time_limit(None)
"""Seconds for a peer that is used outside an experiment."""


def send_to_all(process: subprocess.Popen[Any], kind: signal.Signals) -> None:
    """Send a signal to a process that leads a session of its own, and to all that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, kind)


@contextmanager
def limited(process: subprocess.Popen[Any], seconds: float, who: str) -> Iterator[None]:
    """End a process, with all that it started, if the block takes longer; raise `PeerError` then.

    The process must lead a session of its own. A block that waits for it goes on when the process has ended.
    """
    late, done = threading.Event(), threading.Event()

    def stop() -> None:
        late.set()
        send_to_all(process, signal.SIGTERM)
        if not done.wait(_PATIENCE):
            send_to_all(process, signal.SIGKILL)

    timer = threading.Timer(min(seconds, threading.TIMEOUT_MAX), stop)
    timer.daemon = True
    timer.start()
    try:
        yield
    except Exception:
        if not late.is_set():
            raise
    finally:
        done.set()
        timer.cancel()
        timer.join()
    if late.is_set():
        send_to_all(process, signal.SIGKILL)  # what did not end with its leader
        raise PeerError(
            f"{who}: no answer within {seconds:.6g} s, so its process was ended; if it only needs longer, set "
            "peer.limit in the experiment, such as limit = '30min'"
        )
