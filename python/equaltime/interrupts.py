"""Holds back Ctrl-C and SIGTERM while a finished result is saved."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

__all__ = ["held_back", "last_held_back", "put_off"]


_held_at = -math.inf


def last_held_back() -> float:
    """Return when `held_back` last listed a signal, by `time.monotonic`; minus infinity if it never did."""
    return _held_at


@contextmanager
def held_back() -> Iterator[list[int]]:
    """List signals instead of hearing them, so that a second Ctrl-C does not cost the result of the first.

    A signal that would end the process does so, since nothing of Python's hears it; in any thread but the main one,
    which alone hears them, nothing is held back.
    """

    def note(_: int) -> None:
        global _held_at
        _held_at = time.monotonic()

    with _listed(note) as seen:
        yield seen


@contextmanager
def _listed(told: Callable[[int], object]) -> Iterator[list[int]]:
    """List signals in place of hearing them, and call ``told`` with each."""
    seen: list[int] = []

    def hear(number: int, _: object) -> None:
        seen.append(number)
        told(number)

    with ExitStack() as stack:
        if threading.current_thread() is threading.main_thread():
            for number in filter(_is_heard, (signal.SIGINT, signal.SIGTERM)):
                # Before the handler is replaced: the other signal may raise at any moment.
                stack.callback(signal.signal, number, signal.getsignal(number))
                signal.signal(number, hear)
        yield seen


@contextmanager
def put_off() -> Iterator[None]:
    """Put off the first signal that comes until the block is done; later ones are dropped."""
    seen: list[int] = []
    try:
        with _listed(lambda number: None) as seen:
            yield
    finally:
        if seen:
            signal.raise_signal(seen[0])


def _is_heard(number: signal.Signals) -> bool:
    return callable(signal.getsignal(number))
