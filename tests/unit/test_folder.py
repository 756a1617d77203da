"""The folder of an experiment: tidying leaves alone what others write."""

from __future__ import annotations

import os
from pathlib import Path

from equaltime.cost.folder import Folder


def test_tidying_removes_what_a_killed_experiment_was_writing_and_nothing_else(tmp_path: Path) -> None:
    part = f".equaltime-{os.uname().nodename}-17-7f.part"
    ours = [part, f"figures/{part}", f"references/{part}", f"images/room/{part}"]
    others = [".equaltime-elsewhere-17-7f.part", f"more/{part}", "images/room/a.npy"]
    for name in (*ours, *others):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    Folder(tmp_path).tidy()
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()) == sorted(others)
