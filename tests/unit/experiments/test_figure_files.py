"""A figure that cannot be written leaves the one before as it was, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from equaltime.experiments.report import figures, rays
from equaltime.experiments.report.looks import looks

from .fake_summary import scene_result


class Unfinished:
    def savefig(self, file: Path, **_: Any) -> None:
        file.write_bytes(b"half")
        raise OSError("no room")


def test_a_pdf_has_no_fonts_of_type_3_which_journals_refuse(tmp_path: Path) -> None:
    scene = scene_result(tmp_path)
    look = looks([strategy.label for strategy in scene.strategies], scene.baseline)
    (pdf, _) = figures.write_figures(tmp_path / "figures", "box", scene, (0.1,), look, None, ())
    content = (tmp_path / pdf).read_bytes()
    assert b"/Type3" not in content
    assert b"/TrueType" in content or b"/CIDFontType2" in content


@pytest.mark.parametrize("name", ["directions", "box-curves"])
def test_a_figure_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    scene, folder = scene_result(tmp_path), tmp_path / "figures"
    folder.mkdir()
    (folder / f"{name}.pdf").write_bytes(b"the one before")
    monkeypatch.setattr(rays, "draw_rays", lambda *_: Unfinished())
    monkeypatch.setattr(figures, "draw_curves", lambda *_, **__: Unfinished())
    write = {
        "directions": lambda: rays.write_rays(folder, {}),
        "box-curves": lambda: figures.write_figures(folder, "box", scene, (), {}, None, ()),
    }
    with pytest.raises(OSError, match="no room"):
        write[name]()
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == {f"{name}.pdf": b"the one before"}
