"""What is finished outlasts Ctrl-C; what must end a process still does."""

from __future__ import annotations

import signal
import threading

import pytest

from equaltime.interrupts import held_back


def test_ctrl_c_is_held_back_and_heard_again_after_it() -> None:
    with held_back() as seen:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
    assert seen == [signal.SIGINT, signal.SIGINT]
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_a_signal_that_nothing_of_python_hears_keeps_what_it_does() -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with held_back():
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGTERM, before)


def test_another_thread_holds_nothing_back_and_needs_not() -> None:
    heard: list[object] = []

    def elsewhere() -> None:
        with held_back() as seen:
            heard.extend([signal.getsignal(signal.SIGINT), seen])

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert heard == [signal.getsignal(signal.SIGINT), []]
