"""Finished results outlast Ctrl-C; signals that must end a process still do."""

from __future__ import annotations

import math
import signal
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime import interrupts
from equaltime.cli.signals import interruptible
from equaltime.images import preview
from equaltime.interrupts import held_back, put_off

SCENE = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"


def test_ctrl_c_is_held_back_and_heard_again_after_it() -> None:
    with held_back() as seen:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
    assert seen == [signal.SIGINT, signal.SIGINT]
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("fails", [False, True])
def test_what_is_put_off_is_heard_once_when_what_was_begun_is_done(fails: bool) -> None:
    done = list[str]()

    def begun() -> None:
        with put_off():
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            done.append("whole")
            if fails:
                raise OSError

    with pytest.raises(KeyboardInterrupt):
        begun()
    assert done == ["whole"]
    with put_off():
        pass


def test_a_checkpoint_is_written_whole_before_ctrl_c_ends_the_render(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, written = preview.write, list[bool]()

    def interrupted(path: Path, *rest: Any, **named: Any) -> None:
        if not written:
            signal.raise_signal(signal.SIGINT)
        write(path, *rest, **named)
        written.append(path.exists())

    monkeypatch.setattr(preview, "write", interrupted)
    scene, begun = et.load(SCENE).with_(size=(16, 16)), tmp_path / "begun.exr"
    result = et.render(scene, time=60.0, checkpoint=begun, checkpoint_every=0.01)
    assert result.stopped_by == "interrupt"
    assert written[0]
    assert {file.name for file in tmp_path.iterdir()} == {"begun.exr", "begun.png"}


def test_a_signal_that_nothing_of_python_hears_keeps_what_it_does() -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with held_back():
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize(
    ("install", "sent"),
    [
        (1, signal.SIGINT),
        (2, signal.SIGTERM),
        (3, signal.SIGTERM),
        (4, signal.SIGTERM),
        (3, signal.SIGINT),
        (4, signal.SIGINT),
    ],
)
def test_a_signal_between_two_installations_leaves_no_handler_behind(
    monkeypatch: pytest.MonkeyPatch, install: int, sent: signal.Signals
) -> None:
    """The first two calls of signal.signal install the handlers of a command, the last two restore those before."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {signal.SIGINT: signal.getsignal(signal.SIGINT), signal.SIGTERM: signal.SIG_IGN}
    really_before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    set_handler, calls = signal.signal, list[int]()

    def set_and_send(number: signal.Signals, handler: Any) -> Any:
        replaced = set_handler(number, handler)
        calls.append(number)
        if len(calls) == install:
            signal.raise_signal(sent)
        return replaced

    try:
        with monkeypatch.context() as patched, suppress(KeyboardInterrupt):
            patched.setattr(interrupts, "_held_at", -math.inf)  # or a test before this one has the signal held back
            patched.setattr(signal, "signal", set_and_send)
            with interruptible():
                pass
        assert {number: signal.getsignal(number) for number in numbers} == before
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        for number, handler in {**before, signal.SIGTERM: really_before}.items():
            set_handler(number, handler)


def test_another_thread_holds_nothing_back_and_needs_not() -> None:
    heard: list[object] = []

    def elsewhere() -> None:
        with held_back() as seen:
            heard.extend([signal.getsignal(signal.SIGINT), seen])

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert heard == [signal.getsignal(signal.SIGINT), []]
