"""Ctrl-C and SIGTERM, held back while what is finished must not be lost."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["held_back"]


@contextmanager
def held_back() -> Iterator[list[int]]:
    """Only list those that come, so that an impatient second Ctrl-C does not cost the result of the first.

    In any thread but the main one, which alone hears them, this does nothing.
    """
    seen: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):
            before[number] = signal.signal(number, lambda number, _: seen.append(number))
    try:
        yield seen
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
