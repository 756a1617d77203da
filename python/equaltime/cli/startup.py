"""Handler that ends the ``equaltime`` command quietly if Ctrl-C comes during its imports.

Importing this module installs the handler, but only in a process that was started as the command. The package imports
this module before all slow modules. From the call of `ready` until the call of `over`, the command line handles Ctrl-C
itself.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from pathlib import Path
from types import FrameType
from typing import NoReturn

__all__ = ["over", "ready", "runs_the_command"]


def runs_the_command(arguments: list[str]) -> bool:
    """Tell whether a process with these ``arguments`` runs the command: by its script, or by ``-m equaltime``.

    ``arguments`` has the form of ``sys.orig_argv``, with Python's own options.
    """
    before, after = arguments[1:2], arguments[2:3]
    while before and before[0].startswith("-") and before[0] != "-m":  # Python's own options
        arguments = arguments[1:]
        before, after = arguments[1:2], arguments[2:3]
    return after == ["equaltime"] if before == ["-m"] else bool(before) and Path(before[0]).name == "equaltime"


def ready() -> None:
    """Let Ctrl-C raise `KeyboardInterrupt` again, once the imports are done."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def over() -> None:
    """Ignore Ctrl-C after the command has done its work, so that Python does not exit as if killed."""
    if _IS_THE_COMMAND:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    os._exit(130)  # no work was begun, and an exception would appear inside an import


_IS_THE_COMMAND = (
    runs_the_command(sys.orig_argv)
    and threading.current_thread() is threading.main_thread()
    and signal.getsignal(signal.SIGINT) is signal.default_int_handler
)
if _IS_THE_COMMAND:
    signal.signal(signal.SIGINT, _end)
