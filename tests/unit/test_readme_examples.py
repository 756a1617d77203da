"""The examples of scenes/README.md: one of every plugin; each is a scene, can be written again, and read by Mitsuba."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import OpenImageIO
import pytest

import equaltime as et
from equaltime.scene.model import PLUGINS

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "scenes" / "README.md").read_text()
BLOCKS = re.findall(r"^```toml\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
CAMERA = '[sensor]\ntype = "perspective"\n'
PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
property float r
property float g
property float b
element face 1
property list uchar int vertex_indices
end_header
0 0 0 1 0 0
1 0 0 0 1 0
0 1 0 0 0 1
3 0 1 2
"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def serialized() -> bytes:
    """Return a triangle in Mitsuba's own format."""
    vertices, faces = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4"), np.array([0, 1, 2], "<u4")
    content = struct.pack("<I", 0x1000) + b"mesh\0" + struct.pack("<QQ", 3, 1) + vertices.tobytes() + faces.tobytes()
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(content) + struct.pack("<QI", 0, 1)


def glb() -> bytes:
    """Return a glTF file with one triangle."""
    binary = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    text = (
        b'{"asset":{"version":"2.0"},"buffers":[{"byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],'
        b'"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],'
        b'"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]}'
    )
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the files that the examples name."""
    path = tmp_path_factory.mktemp("examples")
    (path / "mesh.ply").write_text(PLY)
    (path / "mesh-later.ply").write_text(PLY.replace("1 0 0 0 1 0", "1 0 2 0 1 0"))
    (path / "mesh.obj").write_text(OBJ)
    (path / "mesh.serialized").write_bytes(serialized())
    (path / "model.glb").write_bytes(glb())
    for name in ("wood.png", "height.png", "normals.png", "sky.exr"):
        image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(8, 4, 3, "uint8" if name.endswith("png") else "float"))
        OpenImageIO.ImageBufAlgo.fill(image, (0.5, 0.5, 0.9))
        image.write(str(path / name))
    return path


def scene(block: str, folder: Path) -> et.Scene:
    file = folder / "example.toml"
    file.write_text(("" if "[sensor]" in block else CAMERA) + block)
    return et.load(file)


def test_there_is_an_example_of_every_plugin() -> None:
    shown = set(re.findall(r'type = "(\w+)"', "".join(BLOCKS)))
    assert PLUGINS.keys() - shown == set()


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_an_example_is_a_scene_and_can_be_written_again(number: int, folder: Path, tmp_path: Path) -> None:
    loaded = scene(BLOCKS[number], folder)
    loaded.write(tmp_path / "again.toml")
    assert et.load(tmp_path / "again.toml").digest == loaded.digest
    loaded.write(tmp_path / "again.xml")
    again = et.load(tmp_path / "again.xml")
    assert again.digest == loaded.digest or "model.glb" in BLOCKS[number]  # what was in it has files of its own


OURS = re.compile(r"^(blades|priority) =|\"spherical\"|:bounces", re.MULTILINE)
"""Words that Mitsuba does not know."""


@pytest.mark.parametrize("number", [number for number, block in enumerate(BLOCKS) if not OURS.search(block)])
def test_mitsuba_reads_an_example_that_is_written_as_xml(number: int, folder: Path, tmp_path: Path) -> None:
    mi = pytest.importorskip("mitsuba")
    if "animation" in BLOCKS[number]:
        pytest.skip("motion is an extension")
    chosen = mi.variant()
    mi.set_variant("scalar_rgb")
    try:
        scene(BLOCKS[number], folder).write(tmp_path / "again.xml")
        assert mi.load_file(str(tmp_path / "again.xml")) is not None
    finally:
        if chosen:
            mi.set_variant(chosen)


def test_the_scene_as_a_dict_is_the_scene_of_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With all kinds of steps; a transform may be a 4x4 array or one of Mitsuba, as the page says."""
    (block,) = re.findall(r"^```python\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    names: dict[str, Any] = {}
    exec(block, names)
    assert float(capsys.readouterr().out.split()[0]) > 0.0
    (whole,) = [text for text in BLOCKS if "[copper]" in text and "[integrator]" in text]
    (path := tmp_path / "scene.toml").write_text(whole)
    assert names["scene"].digest == et.load(path).digest
    ball = {"type": "sphere", "to_world": [{"translate": [0, 1, 0]}]}
    array = np.eye(4)
    array[1, 3] = 1.0
    for transform in (array, SimpleNamespace(matrix=array)):
        moved = {"type": "scene", "sensor": {"type": "perspective"}, "ball": {**ball, "to_world": transform}}
        assert et.load_dict(moved).digest == et.load_dict({**moved, "ball": ball}).digest


def test_the_experiment_in_python_is_the_one_that_the_page_says(monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "scenes" / "experiments" / "README.md").read_text()
    (block,) = re.findall(r"^```python\n(import equaltime.*?)^```", page, re.DOTALL | re.MULTILINE)
    begun: list[et.Experiment] = []

    def begin(source: et.Experiment, folder: str) -> SimpleNamespace:
        begun.append(source)
        timed = SimpleNamespace(time_to={0.05: et.Interval(1.5, 1.0, 2.0)})
        return SimpleNamespace(verdict="", verdict_notes=(), scenes=[SimpleNamespace(strategies=[timed, timed])])

    monkeypatch.setattr(et, "cost", begin)
    monkeypatch.chdir(ROOT)
    exec(block, {})
    (experiment,) = begun
    assert experiment.targets == (0.05, 0.02)
    assert [entry.label for entry in experiment.strategies] == ["mis", "best", "mine"]
    assert (experiment.scenes[0].name, experiment.budget, experiment.reference.error) == ("box", 3.0, 0.005)
