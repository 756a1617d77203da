"""The image forming in a real browser: it plays at true speed, stops, and is stepped through by keyboard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from equaltime.experiments.report import page as page_module
from equaltime.experiments.report import write_report

from ..unit.experiments.fake_summary import summary
from ..unit.experiments.test_films import TIMES, filmed

Open = Callable[..., Any]
DESK = {"width": 1280, "height": 900}


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("film")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page_module, "write_figures", lambda *_: ())
        return write_report(replace(summary(folder), scenes=(filmed(folder),)), folder)


def frames(page: Any) -> list[int]:
    """Return which picture of each strategy is shown; -1 before the first."""
    return [int(reel.get_attribute("data-frame")) for reel in page.locator(".reel").all()]


def middle(page: Any, reel: int) -> bytes:
    return bytes(page.locator(".stage").nth(reel).screenshot())


def test_it_begins_with_the_first_picture_of_each_and_moves_nothing(visit: Open, report: Path) -> None:
    page = visit(report, viewport=DESK)
    assert frames(page) == [1, 0]
    page.wait_for_timeout(400)
    assert frames(page) == [1, 0]
    assert page.locator("[data-play]").inner_text() == "Play"


def test_it_plays_in_the_time_that_rendering_took_and_stops_at_the_end(visit: Open, report: Path) -> None:
    page = visit(report, viewport=DESK)
    play = page.locator("[data-play]")
    begin = page.evaluate("performance.now()")
    play.click()
    assert play.inner_text() == "Pause"
    page.wait_for_function("document.querySelector('[data-play]').textContent === 'Play'")
    taken = page.evaluate("performance.now()") - begin
    assert 800.0 < taken < 5000.0, "0.9 s are left from the first picture of both"
    assert frames(page) == [3, 2]
    assert page.locator(".film output").inner_text() == "1.20 s"
    play.click()  # again from the beginning
    page.wait_for_function("document.querySelector('.reel').dataset.frame !== '3'")


def test_it_is_paused_and_played_on_by_keyboard(visit: Open, report: Path) -> None:
    page = visit(report, viewport=DESK)
    page.locator(".film select").select_option("0.1")
    play = page.locator("[data-play]")
    play.focus()
    page.keyboard.press("Enter")
    page.wait_for_function("document.querySelector('.film output').textContent > '0.32'")
    page.keyboard.press("Space")
    assert play.inner_text() == "Play"
    before = page.locator(".film output").inner_text()
    page.wait_for_timeout(200)
    assert page.locator(".film output").inner_text() == before


def test_every_picture_can_be_reached_and_is_another_one(visit: Open, report: Path) -> None:
    page = visit(report, viewport=DESK)
    slider = page.locator(".film input")
    slider.focus()
    page.keyboard.press("Home")
    assert frames(page) == [-1, -1]
    assert page.locator("[data-now]").first.inner_text() == "no sample yet"
    seen, pixels = [frames(page)], {middle(page, 0)}
    for _ in range(6):
        page.locator("[data-on]").press("Enter")
        seen.append(frames(page))
        pixels.add(middle(page, 0))
    assert seen == [[-1, -1], [0, -1], [1, -1], [1, 0], [2, 0], [2, 1], [3, 1]]
    assert len(pixels) == 1 + len(TIMES["naive"])
    page.locator("[data-back]").press("Enter")
    assert frames(page) == [2, 1]
    slider.focus()
    page.keyboard.press("End")
    assert frames(page) == [3, 2]
    assert slider.get_attribute("aria-valuetext") == "1.20 s"


def test_who_asked_for_no_motion_steps_and_plays_nothing(visit: Open, report: Path) -> None:
    page = visit(report, viewport=DESK, reduced_motion="reduce")
    assert not page.locator("[data-play]").is_visible()
    page.locator("[data-on]").click()
    assert frames(page) == [2, 0]


def test_without_javascript_the_first_pictures_are_there(visit: Open, report: Path) -> None:
    page = visit(report, viewport=DESK, java_script_enabled=False)
    assert page.locator(".stage img").first.is_visible()
    assert not page.locator(".player").is_visible()


@pytest.mark.parametrize("width", [360, 1280])
def test_the_films_stand_side_by_side_even_on_a_phone(visit: Open, report: Path, width: int) -> None:
    page = visit(report, viewport={"width": width, "height": 740})
    left, right = (stage.bounding_box() for stage in page.locator(".stage").all())
    assert left["y"] == pytest.approx(right["y"], abs=1)
    assert right["x"] > left["x"] + left["width"]
    assert page.evaluate("document.documentElement.scrollWidth") <= width
