"""Ctrl-C and SIGTERM: both end a command with what is finished."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType

from equaltime.cli.startup import over
from equaltime.interrupts import last_held_back

__all__ = ["interruptible"]

_ONE_PRESS = 1.0
"""Seconds in which further signals count as the first one: a key is held down, or pressed again and again.

A signal that was held back while a command ended counts as a first one, too.
"""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let both raise `KeyboardInterrupt`, once for all that come within a second; none while a command ends."""
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
        over()
        with ExitStack() as stack:  # a handler that is back may raise before the other is
            for number, handler in before.items():
                if signal.getsignal(number) is interrupt:
                    stack.callback(signal.signal, number, handler)
