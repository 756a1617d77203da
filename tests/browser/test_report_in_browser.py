"""The report in a real browser: it opens, fetches nothing, flips by mouse and keyboard, and fits every screen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from equaltime.experiments.report import write_report

from ..unit.experiments.fake_summary import doubted, summary

STRATEGIES = ["best", "naive", "cut"]
LABELS = ["reference", *STRATEGIES]

Open = Callable[..., Any]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of two scenes, one with a very long name and an interval that cannot be trusted."""
    folder = tmp_path_factory.mktemp("report")
    value = summary(folder, scenes=2)
    second = doubted(value.scenes[1], "cut")
    first = replace(value.scenes[0], name="a-scene-whose-name-is-longer-than-any-telephone-is-wide-" * 2)
    return write_report(replace(value, scenes=(first, second)), folder)


@pytest.fixture
def opened(visit: Open, report: Path) -> Open:
    """Open the report in a window of its own."""
    return lambda **settings: visit(report, **settings)


def visible_frames(book: Any) -> list[str]:
    """Return the labels of the pictures that can be seen."""
    return [frame.locator("figcaption b").inner_text() for frame in book.locator(".frame").all() if frame.is_visible()]


def flipping(page: Any) -> Any:
    """Return the first scene's pictures, shown one at a time."""
    book = page.locator("[data-flip]").first
    book.get_by_role("button", name="Flip").click()
    return book


def crop(book: Any) -> bytes:
    """Return the pixels of the first crop that can be seen."""
    return bytes(book.locator(".crops img:visible").first.screenshot())


def test_it_opens_with_its_verdict_curves_and_pictures(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    assert page.title() == "Three strategies: what accuracy costs in time"
    assert page.locator("header .verdict").is_visible()
    book = page.locator("[data-flip]").first
    assert visible_frames(book) == LABELS
    first, second = (book.locator(".whole").nth(number).bounding_box() for number in (0, 1))
    assert first["y"] == pytest.approx(second["y"], abs=1)
    assert first["y"] + first["height"] < 900
    assert not book.locator(".slider").is_visible()
    assert first["y"] < page.locator("table").first.bounding_box()["y"]
    assert page.locator(".chart .wide svg").first.is_visible()
    assert not page.locator(".chart .narrow svg").first.is_visible()
    broken = page.evaluate("[...document.images].filter(image => !(image.complete && image.naturalWidth)).length")
    assert broken == 0


def test_the_slider_flips_by_keyboard(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    book = flipping(page)
    slider = book.locator("input[type=range]")
    slider.focus()
    seen = []
    for key in ["Home", *["ArrowRight"] * (len(LABELS) - 1)]:
        page.keyboard.press(key)
        seen.append((visible_frames(book), slider.get_attribute("aria-valuetext"), crop(book)))
    assert [frames for frames, _, _ in seen] == [[label] for label in LABELS]
    assert [text for _, text, _ in seen] == LABELS
    assert len({pixels for _, _, pixels in seen}) == len(LABELS)
    assert book.locator("[data-says]").inner_text().startswith("cut")


def test_the_slider_flips_by_mouse(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    book = flipping(page)
    slider = book.locator("input[type=range]")
    slider.evaluate("e => e.scrollIntoView({ block: 'start', behavior: 'instant' })")
    box = slider.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.click(box["x"] + box["width"] - 4, middle)
    assert visible_frames(book) == ["cut"]
    last = crop(book)
    page.mouse.down()
    page.mouse.move(box["x"] + 4, middle, steps=5)
    page.mouse.up()
    assert visible_frames(book) == ["reference"]
    assert crop(book) != last


def test_flipping_moves_nothing_but_the_picture(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    book = flipping(page)
    boxes = set()
    for number in range(len(LABELS)):
        book.locator(f"[data-step='{number}']").click()
        boxes.add(tuple(book.locator(".whole:visible").bounding_box().values()))
    for kind in ("error", "standard-error"):
        book.locator(f"[data-kind={kind}]").click()
        boxes.add(tuple(book.locator(".whole:visible").bounding_box().values()))
    assert len(boxes) == 1


def test_buttons_choose_the_picture_the_kind_and_the_way_to_compare(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    book = flipping(page)
    book.get_by_role("button", name="cut").click()
    assert visible_frames(book) == ["cut"]
    book.get_by_role("button", name="Error", exact=True).click()
    assert book.locator(".frame:visible img").get_attribute("alt").startswith("Error map of cut")
    book.get_by_role("button", name="reference").click()
    assert book.locator(".absent:visible").count() == 1
    book.get_by_role("button", name="Side by side").click()
    assert not book.locator(".slider").is_visible()
    assert visible_frames(book) == STRATEGIES
    book.get_by_role("button", name="Image", exact=True).click()
    assert visible_frames(book) == LABELS


def test_each_scene_has_its_own_pictures_behind_its_name(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    first, second = page.locator("[data-flip]").all()
    flipping(page)
    first.get_by_role("button", name="cut").click()
    assert not second.is_visible()
    page.locator("#pictures").get_by_role("button", name="box1").click()
    assert not first.is_visible()
    assert visible_frames(second) == LABELS


def test_a_curve_is_singled_out_from_the_legend(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    chart = page.locator("[data-chart]").first
    button = chart.locator("button[data-curve='2']")
    button.focus()
    page.keyboard.press("Enter")
    assert button.get_attribute("aria-pressed") == "true"
    assert chart.locator(".wide svg .chosen").count() == 2  # the curve and its band
    page.keyboard.press("Enter")
    assert chart.locator("svg .chosen").count() == 0


@pytest.mark.parametrize("width", [360, 768, 1280])
def test_the_page_never_scrolls_sideways(opened: Open, width: int) -> None:
    page = opened(viewport={"width": width, "height": 740})
    for mode in ("flip", "grid"):
        for button in page.locator(f"[data-mode={mode}]").all():
            button.dispatch_event("click")
        for details in page.locator("details").all():
            details.evaluate("element => { element.open = true }")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.locator(".chart .narrow svg").first.is_visible() == (width == 360)


def test_tables_are_what_would_scroll_the_page_if_they_did_not_scroll_themselves(opened: Open) -> None:
    page = opened(viewport={"width": 360, "height": 740})
    page.add_style_tag(content=".scroll { overflow: visible !important; }")
    assert page.evaluate("document.documentElement.scrollWidth") > 360


def test_a_table_that_is_too_wide_says_so_until_its_end(opened: Open) -> None:
    page = opened(viewport={"width": 390, "height": 740})
    box = page.locator(".scroll.wider").first
    assert "more to the right" in box.evaluate("e => getComputedStyle(e, '::before').content")
    handle = box.element_handle()
    handle.evaluate("e => { e.scrollLeft = e.scrollWidth }")
    page.wait_for_function("e => !e.classList.contains('wider')", arg=handle)


def test_no_table_is_cut_on_a_desk(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    cut = "[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth + 1).length"
    assert page.evaluate(cut) == 0


def test_a_table_can_be_scrolled_by_keyboard_on_a_phone(opened: Open) -> None:
    page = opened(viewport={"width": 360, "height": 740})
    box = page.locator(".scroll").first
    box.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("e => e.scrollLeft > 0", arg=box.element_handle())


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_text_stands_out_in_light_and_dark(opened: Open, contrasts: Open, scheme: str) -> None:
    page = opened(viewport={"width": 1280, "height": 900}, color_scheme=scheme)
    found = contrasts(page)
    assert len(found) > 150
    assert [(ratio, text) for ratio, text in found if ratio < 4.5] == []
    page.add_style_tag(content=":root { --muted: #808080 !important; }")  # power: grey on grey is seen
    assert any(ratio < 4.5 for ratio, _ in contrasts(page))


def test_dark_mode_is_dark_and_recolours_the_curves(opened: Open) -> None:
    colours = {}
    for scheme in ("light", "dark"):
        page = opened(viewport={"width": 1280, "height": 900}, color_scheme=scheme)
        body = page.evaluate("getComputedStyle(document.body).backgroundColor")
        curve = page.locator(".wide svg [data-curve='2'] path").last.evaluate("e => getComputedStyle(e).stroke")
        colours[scheme] = (body, curve)
    assert colours["light"][0] == "rgb(255, 255, 255)"
    assert colours["dark"][0] == "rgb(20, 23, 28)"
    assert colours["light"][1] != colours["dark"][1]


def test_focus_is_visible_and_the_first_stop_skips_to_the_results(opened: Open) -> None:
    page = opened(viewport={"width": 1280, "height": 900})
    page.keyboard.press("Tab")
    style = page.evaluate(
        "(({outlineStyle, outlineWidth}) => [outlineStyle, outlineWidth])(getComputedStyle(document.activeElement))"
    )
    assert style == ["solid", "3px"]
    assert page.evaluate("document.activeElement.getAttribute('href')") == "#content"
    assert page.locator(".skip").bounding_box()["x"] >= 0


def test_nothing_moves_for_who_asked_for_no_motion(opened: Open) -> None:
    page = opened(reduced_motion="reduce")
    durations = page.evaluate("[...document.querySelectorAll('*')].map(e => getComputedStyle(e).transitionDuration)")
    assert set(durations) - {""} == {"0s"}


def test_without_javascript_every_picture_and_table_is_there(opened: Open) -> None:
    page = opened(java_script_enabled=False)
    book = page.locator("[data-flip]").first
    assert visible_frames(book) == [*LABELS, *STRATEGIES * 3]
    assert not book.locator("input").is_visible()


def test_on_paper_every_picture_table_and_number_is_there(opened: Open) -> None:
    page = opened(viewport={"width": 760, "height": 1000}, color_scheme="dark")
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert visible_frames(page.locator("[data-flip]").first) == [*LABELS, *STRATEGIES * 3]
    assert all(panel.is_visible() for panel in page.locator("[data-panel]").all())
    assert all(table.is_visible() for table in page.locator("table").all())
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.evaluate("document.documentElement.scrollWidth") <= 760
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.locator("details[open]").count() == 0
