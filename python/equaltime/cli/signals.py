"""Handlers of Ctrl-C and SIGTERM, from the imports of a command to its end.

Importing this module installs a handler that ends the process quietly if Ctrl-C comes during the other imports. It does
so only in a process that was started as the command, and before all slow modules are imported. After the call of
`ready`, both signals end the command and keep its finished work (`interruptible`).
"""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn

from equaltime.interrupts import last_held_back

__all__ = ["interruptible", "ready", "runs_the_command"]

_ONE_PRESS = 1.0
"""Signals within this many seconds of the first count as one: a key may be held down or pressed repeatedly.

A signal that was held back while a command ended counts as a first one, too.
"""


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
    """Let Ctrl-C raise `KeyboardInterrupt` again, once the imports of a command are done.

    Until then Ctrl-C ends the process without a traceback.
    """
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    os._exit(130)  # no work was begun, and an exception would appear inside an import


_IS_THE_COMMAND = (
    runs_the_command(sys.orig_argv)
    and threading.current_thread() is threading.main_thread()
    and signal.getsignal(signal.SIGINT) is signal.default_int_handler
)
if _IS_THE_COMMAND:
    signal.signal(signal.SIGINT, _end)


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGINT and SIGTERM raise `KeyboardInterrupt` inside the context, so that a command can save its work.

    Further signals within a second are ignored, and so are signals that arrive while the context ends.
    """
    raised = -_ONE_PRESS

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal raised
        now = time.monotonic()
        if now - max(raised, last_held_back()) >= _ONE_PRESS:
            raised = now
            raise KeyboardInterrupt

    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        for number in before:  # inside the try: the first handler may raise before the second is installed
            signal.signal(number, interrupt)
        yield
    finally:
        raised = math.inf  # `interrupt` raises nothing from here on, so that both handlers are restored
        _over()
        with ExitStack() as stack:  # a restored handler may raise before the other is restored
            for number, handler in before.items():
                if signal.getsignal(number) is interrupt:
                    stack.callback(signal.signal, number, handler)


def _over() -> None:
    """Ignore Ctrl-C after the command has done its work, so that Python does not exit as if killed."""
    if _IS_THE_COMMAND:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
