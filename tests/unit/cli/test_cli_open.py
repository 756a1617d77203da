"""``equaltime open``: which page it opens, and what it says if there is none."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from equaltime.cli import main


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Addresses that were given to the browser."""
    addresses: list[str] = []
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    return addresses


@pytest.mark.parametrize("name", ["report.html", "index.html"])
def test_the_page_of_the_folder_is_opened_and_its_path_printed(
    tmp_path: Path, opened: list[str], capsys: pytest.CaptureFixture[str], name: str
) -> None:
    page = tmp_path / name
    page.write_text("a page")
    assert main(["open", str(tmp_path)]) == 0
    assert main(["open", str(page)]) == 0
    assert opened == [page.as_uri()] * 2
    assert capsys.readouterr().out == f"{page}\n" * 2


def test_a_report_comes_before_an_index(tmp_path: Path, opened: list[str]) -> None:
    for name in ("index.html", "report.html"):
        (tmp_path / name).write_text("a page")
    assert main(["open", str(tmp_path)]) == 0
    assert opened == [(tmp_path / "report.html").as_uri()]


def test_a_folder_without_a_page_is_an_error_that_says_how_to_make_one(
    tmp_path: Path, opened: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["open", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert "has neither report.html nor index.html" in error
    assert f"equaltime cost SCENE -o {tmp_path}" in error
    assert main(["open", str(tmp_path / "missing")]) == 2
    assert "is no folder" in capsys.readouterr().err
    assert opened == []
