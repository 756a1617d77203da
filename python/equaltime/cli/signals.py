"""Handlers of Ctrl-C and SIGTERM: both end a command and keep its finished work."""

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
"""Signals within this many seconds of the first count as one: a key may be held down or pressed repeatedly.

A signal that was held back while a command ended counts as a first one, too.
"""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGINT and SIGTERM raise `KeyboardInterrupt` inside the context.

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
        over()
        with ExitStack() as stack:  # a restored handler may raise before the other is restored
            for number, handler in before.items():
                if signal.getsignal(number) is interrupt:
                    stack.callback(signal.signal, number, handler)
