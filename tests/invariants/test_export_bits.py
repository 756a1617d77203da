"""A scene that is written and read again has the same bits in its image, in every spelling."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et

ROOT = Path(__file__).parents[2]
SCENES = {
    path.relative_to(ROOT / "scenes").as_posix(): path
    for pattern in ("*.toml", "*/*.toml", "mitsuba/*/scene.xml")
    for path in sorted((ROOT / "scenes").glob(pattern))
    if "[sensor]" in path.read_text() or path.suffix == ".xml"
}
OTHERS = {  # of two files the later, which is the one for Mitsuba 3
    f"others/{path.parent.name}": path
    for pattern in ("*/scene.xml", "*/scene_m3.xml")
    for path in sorted((ROOT.parent / "shared" / "scenes" / "mitsuba").glob(pattern))
}


def image(scene: et.Scene) -> NDArray[np.float32]:
    return et.render(scene.with_(size=(12, 9)), spp=1, seed=5).image


def load(path: Path) -> et.Scene:
    chosen = path.suffix == ".xml" and '<default name="integrator"' in path.read_text()
    return et.load(path, **({"integrator": "path"} if chosen else {}))


@pytest.mark.parametrize("name", SCENES | OTHERS)
def test_a_written_scene_is_the_same_scene(name: str, tmp_path: Path) -> None:
    scene = load((SCENES | OTHERS)[name])
    scene.write(tmp_path / "again.toml")
    scene.write(tmp_path / "again.xml")
    again = [et.load(tmp_path / "again.toml"), et.load(tmp_path / "again.xml"), et.load_dict(scene.to_dict())]
    assert {found.digest for found in again} == {scene.digest}
    if name in SCENES:
        assert all(np.array_equal(image(found), image(scene)) for found in again)


def test_the_image_of_another_scene_would_be_seen() -> None:
    """The power twin: a lamp that is a millionth brighter gives other bits."""
    scene = load(SCENES["cornell-box.toml"])
    other = scene.to_dict()
    lamp = next(part for part in other.values() if isinstance(part, dict) and "emitter" in part)
    lamp["emitter"]["radiance"]["value"][0] *= 1.000001
    found = et.load_dict(other)
    assert found.digest != scene.digest
    assert not np.array_equal(image(found), image(scene))
