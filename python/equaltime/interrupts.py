"""Ctrl-C and SIGTERM, held back while what is finished must not be lost."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

__all__ = ["held_back", "put_off"]


@contextmanager
def held_back() -> Iterator[list[int]]:
    """Only list those that come, so that an impatient second Ctrl-C does not cost the result of the first.

    A signal that would end the process does so, since nothing of Python's hears it; in any thread but the main one,
    which alone hears them, nothing is held back.
    """
    seen: list[int] = []
    with ExitStack() as stack:
        if threading.current_thread() is threading.main_thread():
            for number in filter(_is_heard, (signal.SIGINT, signal.SIGTERM)):
                # Before the handler is replaced: the other signal may raise at any moment.
                stack.callback(signal.signal, number, signal.getsignal(number))
                signal.signal(number, lambda number, _: seen.append(number))
        yield seen


@contextmanager
def put_off() -> Iterator[None]:
    """Let the first of those that come be heard only when what is begun is done."""
    seen: list[int] = []
    try:
        with held_back() as seen:
            yield
    finally:
        if seen:
            signal.raise_signal(seen[0])


def _is_heard(number: signal.Signals) -> bool:
    return callable(signal.getsignal(number))
