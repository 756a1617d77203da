"""A renderer that hangs is ended with all that it started, and the error says who it was and what to do."""

from __future__ import annotations

import os
import select
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cost.experiment import Experiment
from equaltime.cost.peers import limits
from equaltime.cost.peers.command import CommandPeer
from equaltime.cost.peers.process import Worker
from equaltime.cost.subjects import make_subjects
from equaltime.errors import PeerError

SCENE = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
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


@pytest.mark.parametrize("ignores", ["", "trap '' TERM; "])
def test_a_command_that_hangs_is_ended_with_what_it_started(
    tmp_path: Path, living: int, ignores: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "_PATIENCE", 0.2)
    script = tmp_path / "hangs.sh"
    script.write_text(f"exec >pipe; {ignores}(trap '' TERM; {HANGS}) & {HANGS}")
    subject = CommandPeer("mine", f"sh {script} {{spp}} {{seed}} {{out}}", tmp_path, limit=1.0)
    subject.prepare(et.load(SCENE), 1)
    with pytest.raises(PeerError, match=r"mine: no answer within 1 s, so its process was ended.*peer\.limit"):
        list(subject.run(1, [4]))
    assert read_to_end(living) == b"begun\nbegun\n"


def test_a_process_that_does_not_answer_is_ended(tmp_path: Path, living: int) -> None:
    script = f"echo stuck >&2; exec 3>'{tmp_path / 'pipe'}'; read question; echo begun >&3; exec sleep 1000"
    worker = Worker(["sh", "-c", script], "theirs", limit=1.0)
    with pytest.raises(PeerError, match=r"(?s)theirs: no answer within 1 s.*stuck"):
        worker.ask("start")
    assert read_to_end(living) == b"begun\n"
    worker.close()


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
