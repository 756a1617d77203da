"""The page of all experiments in a real browser: it leads to the reports, fits every screen and fetches nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from equaltime.experiments.report.index import write_index

from ..unit.experiments.test_collection import cards

Open = Callable[..., Any]


@pytest.fixture(scope="module")
def index(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experiments")
    (folder / "x1-a").mkdir()
    (folder / "x1-a" / "report.html").write_text("<title>its report</title>")
    return write_index(
        cards(folder), folder, quick=True, command="equaltime cost scenes/experiments -o " + "long/" * 60
    )


@pytest.mark.parametrize("width", [360, 768, 1280])
def test_the_page_never_scrolls_sideways(visit: Open, index: Path, width: int) -> None:
    page = visit(index, viewport={"width": width, "height": 740})
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.locator(".thumb svg").first.bounding_box()["width"] > 250


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_text_stands_out_in_light_and_dark(visit: Open, index: Path, contrasts: Open, scheme: str) -> None:
    page = visit(index, viewport={"width": 1280, "height": 900}, color_scheme=scheme)
    found = contrasts(page)
    assert len(found) > 30
    assert [(ratio, text) for ratio, text in found if ratio < 4.5] == []


def test_a_report_is_reached_by_keyboard(browser: Any, index: Path) -> None:
    page = browser.new_page()
    page.goto(index.as_uri())
    reached = []
    for _ in range(12):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.getAttribute('href')"))
        if reached[-1] == "x1-a/report.html":
            break
    assert reached[0] == "#content"
    page.keyboard.press("Enter")
    page.wait_for_url("**/report.html")
    assert page.title() == "its report"
    page.close()
