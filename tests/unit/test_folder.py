"""The folder of an experiment: tidying leaves alone what others write."""

from __future__ import annotations

from pathlib import Path

from equaltime.cost.folder import Folder


def test_tidying_removes_what_a_killed_experiment_was_writing_and_nothing_else(tmp_path: Path) -> None:
    ours = [
        ".equaltime-17.part",
        "figures/.equaltime-17-7f.part",
        "references/.equaltime-17.part",
        "images/room/.equaltime-17.part",
    ]
    others = [".equaltime-17-7f.part", "more/.equaltime-17.part", "images/room/a.npy"]
    for name in (*ours, *others):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    Folder(tmp_path).tidy()
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()) == sorted(others)
