"""Processes of other renderers: time limits, ending of processes, and a worker that answers JSON lines."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Timer
from typing import IO, Any

from equaltime.errors import PeerError
from equaltime.strict_json import json_text

__all__ = ["DEFAULT_LIMIT", "Worker", "end", "ending", "limited", "send_to_all", "tail", "time_limit"]

_TIMES_BUDGET, _SECONDS_MORE = 20.0, 60.0
"""Default limit of a render: a multiple of the budget, plus seconds for loading and compiling.

A run's last render takes at most a few times the budget."""

_WITHOUT_BUDGET = 3600.0
"""Default limit of a render, in seconds, if the experiment gives sample counts, whose time is unknown."""

SETUP_LIMIT = 1800.0
"""Longest time for starting a renderer, or for loading and compiling a scene, in seconds: large scenes take minutes."""

_PATIENCE = 2.0
"""Seconds from SIGTERM to SIGKILL."""


def time_limit(budget: float | None, reference: float = 0.0) -> float:
    """Return the longest time that one render of a peer (another renderer) may take, in seconds.

    The limit is 20 times the budget plus 60 seconds, or one hour without a budget. The limit is never less than
    ``reference`` plus 60 seconds, because a peer may have to render its own reference.
    """
    run = _WITHOUT_BUDGET if budget is None else _TIMES_BUDGET * budget + _SECONDS_MORE
    return max(run, reference + _SECONDS_MORE)


DEFAULT_LIMIT = time_limit(None)
"""Longest time of one render, in seconds, by another renderer that is used outside an experiment."""


def send_to_all(process: subprocess.Popen[Any], kind: signal.Signals) -> None:
    """Send the signal ``kind`` to a process and its children; the process must lead its own session."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, kind)


@contextmanager
def limited(process: subprocess.Popen[Any], seconds: float, who: str) -> Iterator[None]:
    """Limit the time of a process during the context: after ``seconds``, end its process group and raise `PeerError`.

    The process must lead its own session. Code in the context may wait for the process, but must not reap it. Otherwise
    the system could reuse the process id, and another process would be ended. ``who`` names the renderer in the error.
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


_LINES, _CHARACTERS = 12, 2000


def tail(file: IO[bytes]) -> str:
    """Return the last lines of a process's output ``file``, for an error message; empty without output.

    Each line begins with a newline and an indent.
    """
    file.seek(0, os.SEEK_END)
    file.seek(max(file.tell() - _CHARACTERS, 0))
    lines = [line.rstrip() for line in file.read().decode(errors="replace").splitlines() if line.strip()]
    return "".join(f"\n  {line}" for line in lines[-_LINES:])


def end(process: subprocess.Popen[Any]) -> None:
    """End a process and its children by SIGTERM, and after 2 s by SIGKILL; the process must lead its own session."""
    for kind, patience in ((signal.SIGTERM, 2.0), (signal.SIGKILL, 10.0)):
        send_to_all(process, kind)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(patience)
            return


class Worker:
    """Another process that renders on request: it answers each JSON line with a JSON line.

    Errors of the process become `PeerError`. The process has its own session, so that Ctrl-C does not reach the
    process. The process ends when `close` is called or its standard input ends.
    """

    def __init__(self, command: Sequence[str], who: str, limit: float) -> None:
        self._who, self._limit = who, limit
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the process runs
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            text=True,
            start_new_session=True,
        )

    @property
    def running(self) -> bool:
        """Whether the process is still running."""
        return self._process.poll() is None

    def ask(self, do: str, at_least: float = 0.0, **question: Any) -> dict[str, Any]:
        """Send a request to the process, and return the answer.

        ``do`` names the request, and ``question`` has its parameters. The time limit is the worker's, but at least
        ``at_least`` seconds. Raises PeerError if the answer is an error, the process ended, or the time limit passed. A
        process over its time limit is ended.
        """
        try:
            with limited(self._process, max(self._limit, at_least), self._who):
                line = self._exchange(json_text({"do": do, **question}))
        except PeerError as error:
            raise PeerError(f"{error}{tail(self._stderr)}") from error
        if not line:
            code = self._process.wait()
            raise PeerError(f"{self._who}: its process ended with {ending(code)}{tail(self._stderr)}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise PeerError(f"{self._who}: {answer['error']}")
        return answer

    def _exchange(self, question: str) -> str:
        """Write a line and return the answer; empty if the process has ended."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(question + "\n")
            self._process.stdin.flush()
            return self._process.stdout.readline()
        except BrokenPipeError:
            return ""

    def close(self) -> None:
        """End the process and its children."""
        end(self._process)
        for pipe in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()  # type: ignore[union-attr]  # both are pipes
        self._stderr.close()


def ending(code: int) -> str:
    """Return a process's exit code in words: ``signal NAME`` if a signal ended the process, else ``code N``."""
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"code {code}"
