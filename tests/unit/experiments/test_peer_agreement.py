"""The gate that peers pass: once, with a shared false-alarm rate, and what happens to one that means another image."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import equaltime as et
from equaltime.experiments.model.experiment import ReferenceWish
from equaltime.experiments.peers import agreement as peer_agreement
from equaltime.experiments.run import reference as references
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.reference import KnownReference
from equaltime.images.metrics import Reference
from equaltime.rendering.core_subject import Point, RendererKind
from equaltime.statistics import agreement

SCENE = et.load(Path(__file__).parents[3] / "scenes" / "cornell-box.toml").with_(size=(8, 8), max_depth=2)
OURS = agreement.BlockMeans(np.ones((2, 2, 3)), np.ones((2, 2, 3)), 63.0)


class Verdict(NamedTuple):
    """What the test of agreement says."""

    p: float


class Peer:
    """A peer that is never run here."""

    label = "theirs"
    name = "theirs"
    renderer: RendererKind = "command"
    biased = False

    def prepare(self, scene: et.Scene, threads: int) -> float:
        return 0.0

    def run(self, *_: Any) -> Iterator[Point]:
        raise AssertionError


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Answer with a p-value of 1e-5, and tell the levels that were asked for."""
    levels: list[float] = []

    def check(_: Peer, scene: et.Scene, threads: int, level: float, progress: Any, ours: Any) -> peer_agreement.Gate:
        levels.append(level)
        verdict: Any = Verdict(1e-5)
        return peer_agreement.Gate(verdict, OURS, level, (8, 8), 64)

    def own(*_: Any, progress: Any) -> KnownReference:
        progress(0.5)
        return KnownReference(Reference(np.full((8, 8, 3), 7.0), np.zeros((8, 8, 3))), {"own": True})

    monkeypatch.setattr(peer_agreement, "check", check)
    monkeypatch.setattr(peer_agreement, "own_reference", own)
    return levels


def enter(folder: ExperimentFolder, count: int) -> dict[str, Any]:
    peer_agreement.pass_gates([Peer()], "box", SCENE, ReferenceWish(), folder, 1, count)
    noted: dict[str, Any] = folder.read_provenance()["agreements"]["box"]["theirs"]
    return noted


def test_a_peer_that_agrees_is_held_against_the_common_reference(tmp_path: Path, asked: list[float]) -> None:
    folder = ExperimentFolder(tmp_path)
    noted = enter(folder, 1000)
    assert noted["agrees"]
    assert noted["note"] == ""
    assert noted["p"] == 1e-5
    assert not folder.reference("box", "theirs").exists()
    assert 1000 * asked[0] == pytest.approx(agreement.LEVEL, rel=0.01)


def test_one_that_does_not_agree_gets_a_reference_of_its_own(tmp_path: Path, asked: list[float]) -> None:
    folder = ExperimentFolder(tmp_path)
    noted = enter(folder, 1)
    assert not noted["agrees"]
    assert "a reference of its own" in noted["note"]
    assert references.read(folder.reference("box", "theirs")).reference.mean[0, 0, 0] == 7.0


class Clock(Peer):
    """A peer whose render of any scene takes 20 ms."""

    def __init__(self, label: str) -> None:
        self.label = label
        self.sizes: list[tuple[int, int]] = []

    def prepare(self, scene: et.Scene, threads: int) -> float:
        self.sizes.append(scene.size)
        return 0.0

    def run(self, *_: Any) -> Iterator[Point]:
        time.sleep(0.02)
        yield Point(16, 0.02, 0.02, np.ones((8, 8, 3), np.float32))


def test_the_times_of_peers_are_measured_at_the_size_of_the_test(tmp_path: Path, asked: list[float]) -> None:
    folder, peers = ExperimentFolder(tmp_path), [Clock("theirs"), Clock("other")]
    large = SCENE.with_(size=(480, 240))
    times = peer_agreement.measured_times(peers, "box", large, folder, 1)
    assert peers[0].sizes == [(48, 24)]
    assert 0.04 <= times.small_renders < times.tests / 64
    peer_agreement.pass_gates(peers, "box", SCENE, ReferenceWish(), folder, 1, 2)
    passed = peer_agreement.measured_times(peers, "box", SCENE, folder, 1)
    assert passed.tests == 0.0
    assert passed.small_renders >= 0.04


def test_tests_and_references_of_peers_are_told(tmp_path: Path, asked: list[float]) -> None:
    told: list[tuple[str, float]] = []
    peer_agreement.pass_gates(
        *([Peer()], "box", SCENE, ReferenceWish(), ExperimentFolder(tmp_path), 1, 1),
        report_reference=lambda peer, share: told.append((peer.label, share)),
    )
    assert told == [("theirs", 0.5)]
    del asked


def test_the_gate_is_passed_once(tmp_path: Path, asked: list[float]) -> None:
    assert enter(ExperimentFolder(tmp_path), 1) == enter(ExperimentFolder(tmp_path), 1)
    assert len(asked) == 1
