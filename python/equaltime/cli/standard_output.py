"""Errors of standard output, with an exception type of their own: a plain OSError does not tell which file failed."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import IO, Any

from equaltime.cli.messages import print_error

__all__ = ["OutputError", "named_output", "tell_os_error"]


class OutputError(OSError):
    """Failure to write to standard output: the disk is full, or the reader has closed the pipe (``| head``)."""

    def __init__(self, reason: OSError) -> None:
        super().__init__(reason.errno, reason.strerror or str(reason), "standard output")
        self.unread = isinstance(reason, BrokenPipeError)
        """Whether the reader has closed the pipe, which is no error."""


class _Named:
    """A text stream whose write errors are `OutputError`."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except OSError as error:
            raise OutputError(error) from error

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as error:
            raise OutputError(error) from error

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def named_output() -> Iterator[None]:
    """Raise `OutputError` if writing to standard output fails in this context.

    If standard output is closed (``>&-``), nothing is printed and no error is raised.
    """
    if sys.stdout is None:
        yield
        return
    with redirect_stdout(_Named(sys.stdout)):
        yield
        print(end="", flush=True)


def tell_os_error(error: OSError) -> int:
    """Print an operating-system error with its file, and return the exit code 1.

    After an `OutputError`, standard output is redirected to the null device. If the reader closed the pipe, no message
    is printed.
    """
    if isinstance(error, OutputError):
        # otherwise Python's flush of stdout at exit would fail again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if not (isinstance(error, OutputError) and error.unread):
        print_error(f"{error.filename}: {error.strerror}" if error.filename else error.strerror or str(error))
    return 1
