"""A renderer that hangs is ended with all that it started, and the error says who it was and what to do."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import threading
from pathlib import Path

import pytest

import equaltime as et
from equaltime.errors import PeerError
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.peers import process as limits
from equaltime.experiments.peers.command import CommandPeer
from equaltime.experiments.peers.process import Worker
from equaltime.experiments.run.subjects import make_subjects

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
COMMAND = "render {spp} {seed} {out}"
HANGS = "echo begun; exec sleep 1000"


@pytest.fixture
def living(tmp_path: Path) -> int:
    """A pipe that ends when all processes have ended that write to ``pipe``."""
    os.mkfifo(tmp_path / "pipe")
    return os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)


def read_to_end(pipe: int) -> bytes:
    words = b""
    while select.select([pipe], [], [], 30.0)[0]:
        if not (more := os.read(pipe, 100)):
            os.close(pipe)
            return words
        words += more
    raise AssertionError(f"a process still runs that said {words!r}")


@pytest.fixture
def begun(living: int, monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Words that processes are to write to the pipe before a time limit begins; what was read is taken off."""
    awaited = list[bytes]()

    class AfterBegun(threading.Timer):
        def run(self) -> None:
            while awaited and select.select([living], [], [], 30.0)[0]:
                if os.read(living, len(awaited[0])) == awaited[0]:
                    awaited.pop(0)
            super().run()

    monkeypatch.setattr(limits, "Timer", AfterBegun)
    return awaited


@pytest.mark.parametrize("ignores", ["", "trap '' TERM; "])
def test_a_command_that_hangs_is_ended_with_what_it_started(
    tmp_path: Path, living: int, begun: list[bytes], ignores: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun += [b"begun\n", b"begun\n"]
    monkeypatch.setattr(limits, "_PATIENCE", 0.2)
    script = tmp_path / "hangs.sh"
    script.write_text(f"exec >pipe; {ignores}(trap '' TERM; {HANGS}) & {HANGS}")
    subject = CommandPeer("mine", f"sh {script} {{spp}} {{seed}} {{out}}", tmp_path, limit=0.01)
    subject.prepare(et.load(SCENE), 1)
    with pytest.raises(PeerError, match=r"mine: no answer within 0\.01 s; ended\. .*\(peer\.limit\)\."):
        list(subject.run(1, [4]))
    assert not begun
    assert read_to_end(living) == b""


def test_a_process_that_does_not_answer_is_ended(tmp_path: Path, living: int, begun: list[bytes]) -> None:
    begun.append(b"begun\n")
    script = f"echo stuck >&2; exec 3>'{tmp_path / 'pipe'}'; read question; echo begun >&3; exec sleep 1000"
    worker = Worker(["sh", "-c", script], "theirs", limit=0.01)
    with pytest.raises(PeerError, match=r"(?s)theirs: no answer within 0\.01 s.*stuck"):
        worker.ask("start")
    assert not begun
    assert read_to_end(living) == b""
    worker.close()


def sleeping() -> subprocess.Popen[bytes]:
    return subprocess.Popen(["sleep", "1000"], start_new_session=True)


def test_a_refused_signal_does_not_keep_the_next_from_being_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "_PATIENCE", 0.0)
    process, kill, sent = sleeping(), os.killpg, list[int]()

    def refuse_first(group: int, kind: int) -> None:
        sent.append(kind)
        if len(sent) == 1:
            raise PermissionError
        kill(group, kind)

    monkeypatch.setattr(os, "killpg", refuse_first)
    with pytest.raises(PeerError), limits.limited(process, 0.01, "mine"):
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    assert sent[:2] == [signal.SIGTERM, signal.SIGKILL]
    process.wait()


def test_a_command_is_not_reaped_while_its_time_limit_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cancel, known = threading.Timer.cancel, list[bool]()

    def cancel_and_look(timer: threading.Timer) -> None:
        known.append(Path(f"/proc/{(tmp_path / 'pid').read_text().strip()}").exists())
        cancel(timer)

    monkeypatch.setattr(threading.Timer, "cancel", cancel_and_look)
    script = tmp_path / "fails.sh"
    script.write_text("echo $$ >pid; exit 3")
    subject = CommandPeer("mine", f"sh {script} {{spp}} {{seed}} {{out}}", tmp_path)
    subject.prepare(et.load(SCENE), 1)
    with pytest.raises(PeerError, match="code 3"):
        list(subject.run(1, [4]))
    assert known == [True]


def test_an_interruption_while_the_timer_starts_leaves_no_timer(monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupted(threading.Timer):
        def start(self) -> None:
            super().start()
            raise KeyboardInterrupt

    monkeypatch.setattr(limits, "Timer", Interrupted)
    process, before = sleeping(), threading.active_count()
    with pytest.raises(KeyboardInterrupt), limits.limited(process, 1000.0, "mine"):
        pass
    assert threading.active_count() == before
    process.kill()
    process.wait()


def test_starting_has_a_longer_limit_than_rendering() -> None:
    worker = Worker(["sh", "-c", "read question; sleep 0.5; echo '{\"seconds\": 1}'"], "theirs", limit=0.1)
    assert worker.ask("start", at_least=60.0) == {"seconds": 1}
    worker.close()


def test_an_answer_in_time_is_an_answer() -> None:
    worker = Worker(["sh", "-c", "read question; echo '{\"seconds\": 1}'"], "theirs", limit=60.0)
    assert worker.ask("start") == {"seconds": 1}
    worker.close()


@pytest.mark.parametrize(
    ("words", "limit"),
    [
        ({"budget": "10s"}, 260.0),
        ({"budget": "10s", "reference": {"seconds": 7200}}, 7260.0),
        ({"spp": [4]}, 3600.0),
        ({"spp": [4], "reference": {"seconds": 7200}}, 7260.0),
        ({"budget": "10s", "strategies": [{"label": "mine", "peer": {"command": COMMAND, "limit": "5min"}}]}, 300.0),
    ],
)
def test_the_limit_follows_from_budget_and_reference(words: dict[str, object], limit: float) -> None:
    peers = {"strategies": [{"label": "mine", "peer": {"command": COMMAND}}, {"label": "theirs", "peer": "mitsuba"}]}
    experiment = Experiment.model_validate({"scenes": [{"path": SCENE}], **peers, **words})
    assert {getattr(subject, "limit", None) for subject in make_subjects(experiment)} == {limit}
