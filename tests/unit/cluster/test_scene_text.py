"""Scenes as text: the same scene in another process, from the same files or from copies."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cluster import scene_text
from equaltime.cluster.scene_text import SceneText, copy_into, lacks, scene_of, store
from equaltime.errors import RenderError, SceneError

TERRAIN = Path(__file__).parents[3] / "scenes" / "terrain"
OBJ = """v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3
"""


@pytest.fixture(autouse=True)
def another_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget scenes and copies, as another process does not have them."""
    monkeypatch.setattr(scene_text, "_SCENES", {})
    monkeypatch.setattr(scene_text, "_COPIES", [])
    monkeypatch.setattr(scene_text, "_PARENTS", [])


def with_mesh(folder: Path) -> et.Scene:
    (folder / "a b.obj").write_text(OBJ)
    return et.load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective"},
            "mesh": {"type": "obj", "filename": str(folder / "a b.obj")},
            "sky": {"type": "constant"},
        }
    )


@pytest.mark.parametrize("name", ["cornell-box", "veach-mis", "terrain", "windmill"])
def test_a_scene_from_its_text_is_the_same_scene(name: str) -> None:
    scene = et.load(name).with_(size=(20, 10), max_depth=3, transparent=True)
    text = SceneText.of(scene)
    assert text.load().digest == scene.digest
    assert scene_of(scene.digest) is text.load()


def test_a_process_without_the_files_reads_copies(tmp_path: Path) -> None:
    scene = with_mesh(tmp_path)
    text = SceneText.of(scene)
    content = (tmp_path / "a b.obj").read_bytes()
    (tmp_path / "a b.obj").unlink()
    assert lacks(text.files)
    for offset in range(0, len(content), 10):
        store(str(tmp_path / "a b.obj"), offset, content[offset : offset + 10])
    assert not lacks(text.files)
    assert text.load().digest == scene.digest


def test_copies_are_in_the_folder_that_was_given(tmp_path: Path) -> None:
    copy_into(str(tmp_path))
    store("/some where/a.obj", 0, OBJ.encode())
    (found,) = tmp_path.glob("equaltime-*/some where/a.obj")
    assert found.read_text() == OBJ


def test_a_file_that_changed_before_the_text_was_made_is_an_error_of_the_scene(tmp_path: Path) -> None:
    scene = with_mesh(tmp_path)
    (tmp_path / "a b.obj").write_text(OBJ + "\n")
    with pytest.raises(SceneError, match="the file has changed since the scene was loaded"):
        SceneText.of(scene)


def test_files_with_other_contents_are_refused(tmp_path: Path) -> None:
    text = SceneText.of(with_mesh(tmp_path))
    (tmp_path / "a b.obj").write_text(OBJ.replace("v 1 0 0", "v 2 0 0"))
    with pytest.raises(RenderError, match="other contents"):
        text.load()


def test_a_file_of_another_size_counts_as_missing(tmp_path: Path) -> None:
    text = SceneText.of(with_mesh(tmp_path))
    (tmp_path / "a b.obj").write_text(OBJ + "\n")
    assert lacks(text.files)


def test_a_scene_that_was_not_loaded_is_refused() -> None:
    with pytest.raises(RenderError, match="does not have the scene"):
        scene_of("0" * 64)


def test_the_scene_file_itself_need_not_be_there(tmp_path: Path) -> None:
    for file in TERRAIN.iterdir():
        shutil.copy(file, tmp_path)
    text = SceneText.of(et.load(tmp_path / "terrain.toml").with_(size=(8, 8)))
    (tmp_path / "terrain.toml").unlink()
    assert not lacks(text.files)
    text.load()
