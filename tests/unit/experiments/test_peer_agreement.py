"""The gate that peers pass: once, with a shared false-alarm rate, and what happens to one that means another image."""

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

    def own(*_: Any) -> KnownReference:
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


def test_the_gate_is_passed_once(tmp_path: Path, asked: list[float]) -> None:
    assert enter(ExperimentFolder(tmp_path), 1) == enter(ExperimentFolder(tmp_path), 1)
    assert len(asked) == 1
