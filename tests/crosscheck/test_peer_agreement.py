"""Before a renderer is compared in time it must mean the same image; one that does not gets a reference of its own.

The renderer here is the one that is shown to those who write their own, and a copy with a wrong density.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import equaltime as et
from equaltime.experiments.peers import agreement
from equaltime.experiments.peers.agreement import check, own_reference
from equaltime.experiments.peers.command import CommandPeer
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.rendering.core_subject import Point, RendererKind
from equaltime.scene import Scene
from equaltime.scene.export.plain import mitsuba_dict
from equaltime.statistics.agreement import LEVEL

FOLDER = Path(__file__).parents[2] / "scenes" / "experiments"
COMMAND = "{python} own_renderer.py {json} {spp} {seed} {out}.pfm"
PDF, WRONG_PDF = "* (2 * np.pi)", "* (1.98 * np.pi)"


def module(text: str, folder: Path) -> ModuleType:
    path = folder / "own_renderer.py"
    path.write_text(text)
    spec = importlib.util.spec_from_file_location("own_renderer", path)
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


@dataclass
class InProcess:
    """The example as a function instead of a command: 64 processes take their time."""

    example: ModuleType
    label: str = "own_renderer"
    name: str = "own_renderer"
    renderer: RendererKind = "command"
    biased: bool = False

    def prepare(self, scene: Scene, threads: int) -> float:
        self.scene = mitsuba_dict(scene.model, scene.assets)
        return 0.0

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Point]:
        for spp in ladder:
            image = self.example.render(self.scene, spp, seed)
            yield Point(spp, 0.01, 0.01, image.astype(np.float32))


def text() -> str:
    return (FOLDER / "own_renderer.py").read_text()


def ball() -> Scene:
    return et.load(FOLDER / "ball.toml")


def test_the_example_fits_on_a_page() -> None:
    files = (FOLDER / "own_renderer.py", FOLDER / "own-renderer.toml")
    assert all(len(file.read_text().splitlines()) < 60 for file in files)
    assert COMMAND in files[1].read_text()


def test_the_example_runs_as_a_command_from_a_copy(tmp_path: Path) -> None:
    (tmp_path / "own_renderer.py").write_text(text())
    peer = CommandPeer("own", COMMAND, tmp_path)
    peer.prepare(ball(), 1)
    few, many = peer.run(1, (2, 8))
    assert few.image.shape == (48, 64, 3)
    assert few.wall_s > 0.0
    assert many.wall_s > 0.0
    np.testing.assert_allclose(many.image[0, 0], (0.8, 0.9, 1.0), rtol=1e-6)  # the sky


def test_the_example_tells_which_scenes_it_renders(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="one diffuse sphere in a constant sky, and no other scene"):
        module(text(), tmp_path).render({"sensor": {"type": "", "film": {}, "to_world": []}}, 1, 1)


def test_the_example_agrees(tmp_path: Path) -> None:
    shares: list[float] = []
    gate = check(InProcess(module(text(), tmp_path)), ball(), threads=1, progress=shares.append)
    assert gate.agrees, gate.note
    assert gate.note == ""
    assert gate.size == (48, 36)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_our_side_is_rendered_once_for_all_peers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = InProcess(module(text(), tmp_path))
    first = check(example, ball(), threads=1)
    monkeypatch.setattr(agreement, "Session", None)
    shares: list[float] = []
    second = check(example, ball(), threads=1, progress=shares.append, ours=first.ours)
    assert second.agreement.looks == first.agreement.looks
    assert shares[-1] == 1.0


def test_a_density_one_percent_off_is_found_and_noted(tmp_path: Path) -> None:
    """The power twin."""
    assert text().count(PDF) == 1
    gate = check(InProcess(module(text().replace(PDF, WRONG_PDF), tmp_path)), ball(), threads=1)
    assert not gate.agrees
    assert gate.agreement.p < LEVEL
    assert "a reference of its own" in gate.note
    assert "48x36" in gate.note


def test_a_reference_of_its_own_is_what_the_peer_converges_to(tmp_path: Path) -> None:
    wrong = InProcess(module(text().replace(PDF, WRONG_PDF), tmp_path))
    known = own_reference(wrong, ball(), error=0.02, seconds=20.0, threads=1)
    assert known.error <= 0.02
    reference = known.reference
    assert reference.halves is not None
    np.testing.assert_allclose(0.5 * (reference.halves[0] + reference.halves[1]), reference.mean)
    inside = (slice(18, 30), slice(28, 34))  # of the ball, whose radiance is known: that of the wrong density
    expected = 0.99 * np.array([0.7, 0.5, 0.2]) * (0.8, 0.9, 1.0)
    off, variance = (reference.mean - expected)[inside][..., 0], reference.variance[inside][..., 0]
    assert abs(off.sum()) < 4.0 * np.sqrt(variance.sum())
    assert 0.5 < np.square(off).sum() / variance.sum() < 2.0


@pytest.mark.skipif(find_spec("mitsuba") is None, reason="needs mitsuba")
def test_mitsuba_agrees_on_the_ball() -> None:
    peer = MitsubaPeer("mitsuba", "scalar_rgb", sampler="multijitter")
    try:
        gate = check(peer, ball(), threads=1)
    finally:
        peer.close()
    assert gate.agrees, gate.note


def test_a_command_that_knows_no_size_is_compared_at_that_of_the_scene() -> None:
    assert CommandPeer("own", COMMAND).resizable
    assert CommandPeer("own", "render {width} {height} {spp} {seed} {out}").resizable
    assert not CommandPeer("own", "render {scene} {spp} {seed} {out}").resizable
