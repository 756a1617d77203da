"""Floating-point faults: no scene that is shipped raises one outside Embree, and one that is raised is named."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import pytest

import equaltime as et
from equaltime import _core

SCENES: Final = Path(__file__).parents[2] / "scenes"
SIZE: Final = 24
"""Pixels along the longer side."""
STRATEGIES: Final[tuple[dict[str, Any], ...]] = (
    {"lights": "tree"},
    {"technique": "mixture"},
    {"technique": "uniform", "sampler": "independent", "roulette": "albedo"},
)


def shipped() -> Iterator[Path]:
    for path in sorted([*SCENES.rglob("*.toml"), *SCENES.rglob("*.xml")]):
        if "experiments" not in path.parts:
            yield path


def small(path: Path) -> et.Scene:
    scene = et.load(path, **({"integrator": "path"} if path.suffix == ".xml" else {}))
    width, height = (max(1, round(n * SIZE / max(scene.size))) for n in scene.size)
    return scene.with_(size=(width, height), max_depth=min(scene.max_depth, 64) if scene.max_depth > 0 else 64)


@pytest.mark.parametrize("path", list(shipped()), ids=lambda path: str(path.relative_to(SCENES)))
def test_no_shipped_scene_raises_a_fault(path: Path) -> None:
    scene = small(path)
    for strategy in STRATEGIES:
        renderer = _core.Renderer(scene.core, _core.Settings(max_depth=scene.max_depth, **strategy), traps="check")
        assert renderer.advance(4)
        assert renderer.faulty == []


def test_looking_for_faults_changes_no_bit() -> None:
    scene = small(SCENES / "cornell-box.toml")
    looked, plain = (et.render(scene, spp=4, traps=traps).moments for traps in ("check", "ignore"))
    assert looked is not None
    assert plain is not None
    assert looked.tobytes() == plain.tobytes()


def mirror() -> et.Scene:
    """Return a mirror of a roughness that nobody means, whose densities are beyond single precision."""
    return et.load(SCENES / "hard" / "rough-mirror.toml", alpha=1e-12).with_(size=(8, 8))


def test_a_sample_that_overflows_is_named_with_its_fault() -> None:
    """The twin."""
    with pytest.raises(et.FaultySample, match=r"floating-point fault \(overflow\) at pixel \d,\d, sample \d") as caught:
        et.render(mirror(), spp=4, traps="check")
    assert isinstance(caught.value.result, et.Result)
    assert caught.value.result.stopped_by == "faulty"
    assert caught.value.command[:2] == ("equaltime", "replay")
    path = et.replay(mirror(), pixel=caught.value.pixel, sample=caught.value.index)
    assert {vertex["faults"] for vertex in path.vertices} == {"", "overflow"}


def test_it_is_not_looked_for_unless_asked(request: pytest.FixtureRequest) -> None:
    if request.config.getoption("--traps"):
        pytest.skip("--traps asks for all renders")
    assert et.render(mirror(), spp=4).stopped_by == "spp"


def test_a_debugger_is_called_where_it_happens() -> None:
    program = f"""
import equaltime as et
et.render(et.load({str(SCENES / "hard" / "rough-mirror.toml")!r}, alpha=1e-12), spp=4, traps="stop")
"""
    ended = subprocess.run([sys.executable, "-c", program], check=False, timeout=60)
    assert ended.returncode == -signal.SIGFPE
