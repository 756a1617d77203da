"""Processes of peers: a worker that answers line by line, ending of processes, and the tail of their output."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from typing import IO, Any

from equaltime.errors import PeerError
from equaltime.experiments.peers.limits import limited, send_to_all
from equaltime.strict_json import json_text

__all__ = ["Worker", "end", "ending", "tail"]

_LINES, _CHARACTERS = 12, 2000


def tail(file: IO[bytes]) -> str:
    """Return the last lines that a process wrote to ``file``, each on a new indented line; empty if there are none."""
    file.seek(0, os.SEEK_END)
    file.seek(max(file.tell() - _CHARACTERS, 0))
    lines = [line.rstrip() for line in file.read().decode(errors="replace").splitlines() if line.strip()]
    return "".join(f"\n  {line}" for line in lines[-_LINES:])


def end(process: subprocess.Popen[Any]) -> None:
    """End a process that leads its own session, with its process group."""
    for kind, patience in ((signal.SIGTERM, 2.0), (signal.SIGKILL, 10.0)):
        send_to_all(process, kind)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(patience)
            return


class Worker:
    """A process that answers each JSON line with a JSON line; its errors become `PeerError`.

    The process has its own session, so that Ctrl-C reaches it only through `close`. It ends when its input ends.
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
        """Send a question and return its answer.

        The time limit is the worker's, but at least ``at_least`` seconds. Raises PeerError if the answer is an error,
        the process ended, or the time limit passed. A process over its time limit is ended.
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
        """End the process."""
        end(self._process)
        for pipe in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()  # type: ignore[union-attr]  # both are pipes
        self._stderr.close()


def ending(code: int) -> str:
    """Return a return code in words: ``signal NAME`` or ``code N``."""
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"code {code}"
