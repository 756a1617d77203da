"""Delays Ctrl-C and SIGTERM while a finished result is saved."""

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
    """Return the time of the clock `time.monotonic` at which `held_back` last caught a signal; -inf if it never did.

    A signal is Ctrl-C or SIGTERM.
    """
    return _held_at


@contextmanager
def held_back() -> Iterator[list[int]]:
    """Catch Ctrl-C and SIGTERM inside the block, without calling their handlers.

    The yielded list gets the number of each caught signal. If a result is saved because of a first Ctrl-C, a second
    Ctrl-C does not interrupt the block. A signal is caught only if it has a Python handler, and only in the main
    thread. Other signals act as usual.
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
    """Delay the first Ctrl-C or SIGTERM until the end of the block, and drop later signals."""
    seen: list[int] = []
    try:
        with _listed(lambda number: None) as seen:
            yield
    finally:
        if seen:
            signal.raise_signal(seen[0])


def _is_heard(number: signal.Signals) -> bool:
    return callable(signal.getsignal(number))
