"""The report as a file: what is in it, that nothing is fetched, and that hostile names stay names."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.report import page as page_module
from equaltime.experiments.report import write_report
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.page import longest_side
from equaltime.experiments.report.pictures import Pictures, load_pictures
from equaltime.experiments.report.tables import check_table, geometric_mean
from equaltime.experiments.report.words import Cell
from equaltime.experiments.run.reference import KnownReference, write
from equaltime.images.metrics import Reference
from equaltime.statistics.intervals import UNKNOWN, Interval

from .fake_summary import CONSTANTS, FEW, SHAPE, TARGETS, doubted, summary

HOSTILE = '<script>alert("1")</script>&\'$x_y$\\../..'
VOID = {"meta", "link", "img", "input", "br", "hr"}


class Page(HTMLParser):
    """A page taken apart: its elements in order, text by element, and whether all that was opened is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if data.strip():
            self.texts.append((self.open[-1], data.strip()))

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]

    @property
    def visible(self) -> str:
        return " ".join(text for tag, text in self.texts if tag not in ("style", "script"))


def written(value: Summary, folder: Path) -> tuple[Page, str]:
    text = write_report(value, folder).read_text("utf-8")
    return Page(text), text


@pytest.fixture
def without_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the figure files: they take most of the time, and only one test looks at them."""
    monkeypatch.setattr(page_module, "write_figures", lambda *_: ())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def page(folder: Path) -> Page:
    return written(summary(folder, scenes=2), folder)[0]


def test_the_verdict_is_the_first_sentence_after_the_title(page: Page) -> None:
    texts = [text for _, text in page.texts]
    title = max(i for i, (tag, _) in enumerate(page.texts) if tag == "h1")
    assert (
        texts[title + 1]
        == "On box0, best is about 64 times faster than naive (58 to 70): 1 % error in 100 s (90 to 110)."
    )


def test_every_part_that_the_page_promises_is_there(page: Page) -> None:
    headings = [text for tag, text in page.texts if tag in ("h1", "h2", "h3", "h4")]
    assert headings.count("Error against time") == headings.count("Where the error is") == 2
    for heading in ("Pictures", "All scenes", "How to read this page", "What next", "How this was made"):
        assert headings.count(heading) == 1
    for heading in ("box0", "box1", "Image", "Variance", "Error", "Standard error", "Time to an error", "Checks"):
        assert headings.count(heading) == 2
    assert "What is compared, what to see, why." in page.visible
    assert "Same picture" in page.visible


def test_the_pictures_come_before_tables_and_curves_and_how_it_was_made_comes_last(page: Page) -> None:
    headings = [text for tag, text in page.texts if tag in ("h2", "h3", "h4")]
    wanted = ["Pictures", "Image", "All scenes", "Error against time", "Checks", "What next", "How this was made"]
    places = [headings.index(heading) for heading in wanted]
    assert places == sorted(places)
    assert headings[-1] == "How this was made"


def test_the_best_strategy_stands_beside_the_reference(page: Page) -> None:
    images = [str(image["alt"]) for image in page.all("img") if "pixels from" not in str(image["alt"])]
    assert images[:4] == ["box0: reference", *(f"box0 rendered by {label}" for label in ("best", "naive", "cut"))]


def test_maps_of_samples_are_left_out_where_all_pixels_have_as_many(page: Page) -> None:
    assert "Samples" not in [text for tag, text in page.texts if tag == "h4"]


def test_provenance_names_machine_build_seeds_strategies_and_digests(page: Page) -> None:
    for text in ("machine", "cpu", "a processor", "a build", "0, 1, 2", "0123456789abcdef", "best,technique=naive"):
        assert text in page.visible


def test_the_page_says_over_how_many_machines_runs_were_spread(tmp_path: Path) -> None:
    found = summary(tmp_path, scenes=1)
    workers = {f"tcp://{n}:9": {"host": f"node{n}", "ran": [["box0", "best", n]]} for n in (1, 2)}
    spread, _ = written(replace(found, provenance={**found.provenance, "runs": 2, "workers": workers}), tmp_path)
    assert "2 of 2 runs were spread over 2 like machines of a cluster: node1 (1), node2 (1)." in spread.visible
    assert "node2: box0, best, 2" in spread.visible
    assert "like machines" not in written(found, tmp_path)[0].visible


def test_nothing_is_fetched_and_links_lead_to_files_beside_the_page(folder: Path, page: Page) -> None:
    linked = set()
    for tag, attributes in page.elements:
        for name in ("src", "href", "srcset", "data", "action", "xlink:href"):
            target = attributes.get(name)
            if target is None or target.startswith(("#", "data:")):
                continue
            assert (tag, name) == ("a", "href"), (tag, name, target)
            assert (folder / target).exists()
            linked.add(target)
    assert "figures/box0-curves.pdf" in linked
    style = " ".join(text for tag, text in page.texts if tag == "style")
    assert "@import" not in style
    assert "url(" not in style


def test_every_picture_says_what_it_shows_and_every_control_has_a_name(page: Page) -> None:
    assert all(image.get("alt") for image in page.all("img"))
    assert all(chart.get("aria-label") or chart.get("aria-hidden") for chart in page.all("svg"))
    labelled = {label["for"] for label in page.all("label")}
    sliders = page.all("input")
    assert len(sliders) == 2
    assert all(slider["type"] == "range" and slider["id"] in labelled for slider in sliders)


def test_no_id_is_there_twice_and_every_address_in_the_page_has_its_target(page: Page) -> None:
    ids = [attributes["id"] for _, attributes in page.elements if attributes.get("id")]
    assert len(ids) == len(set(ids))
    targets = [attributes["href"] for _, attributes in page.elements if (attributes.get("href") or "").startswith("#")]
    assert {target[1:] for target in targets if target} <= set(ids)


def test_every_point_of_a_curve_says_its_numbers(page: Page) -> None:
    titles = [text for tag, text in page.texts if tag == "title"]
    assert sum(title.startswith("best: ") for title in titles) == 2 * 2 * 5  # scenes, widths, checkpoints


def test_a_biased_strategy_is_named_biased_in_legend_and_tables(page: Page) -> None:
    tags = [text for tag, text in page.texts if tag == "em"]
    assert tags.count("biased") >= 2 * 3


def test_figures_are_written_as_pdf_and_png(folder: Path, page: Page) -> None:
    names = {path.name for path in (folder / "figures").iterdir()}
    assert names == {"table.tex"} | {
        f"box{scene}-{what}.{kind}" for scene in (0, 1) for what in ("curves", "crops") for kind in ("pdf", "png")
    }
    assert all((folder / "figures" / name).stat().st_size > 1000 for name in names)
    assert "figures/box0-curves.pdf" in page.visible


def test_a_page_of_small_images_is_small(folder: Path, page: Page) -> None:
    assert (folder / "report.html").stat().st_size < 600_000


@pytest.mark.usefixtures("without_figures")
def test_a_long_remark_is_said_once_and_every_mark_leads_to_it(tmp_path: Path) -> None:
    plain = summary(tmp_path, scenes=2)
    remark = f"6 of 6 renders: {'light that samples have not met ' * 6}"
    scenes = tuple(
        replace(
            scene,
            strategies=tuple(
                replace(one, error_at_budget=one.error_at_budget.noted(remark)) for one in scene.strategies
            ),
        )
        for scene in plain.scenes
    )
    page, _ = written(replace(plain, scenes=scenes), tmp_path)
    assert page.visible.count(remark.strip()) == 1
    marks = [link for link in page.all("a") if link.get("aria-label") == "note a"]
    assert [link["href"] for link in marks] == ["#notes_a"] * 6
    assert any(attributes.get("id") == "notes_a" for attributes in page.all("dt"))


@pytest.mark.usefixtures("without_figures")
def test_the_same_summary_gives_the_same_bytes(tmp_path: Path) -> None:
    first = written(summary(tmp_path), tmp_path)[1]
    assert written(summary(tmp_path), tmp_path)[1] == first


def test_hostile_names_stay_text_and_inside_the_folder(tmp_path: Path) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    plain = summary(folder)
    scene = plain.scenes[0]
    first = replace(scene.strategies[0], label=HOSTILE, name=HOSTILE, renderer=HOSTILE, notes=(HOSTILE,))
    scene = replace(scene, name=HOSTILE, digest=HOSTILE, baseline=HOSTILE, strategies=(first, *scene.strategies[1:]))
    scene = doubted(scene, "best", HOSTILE)
    provenance = {HOSTILE: [HOSTILE, {HOSTILE: HOSTILE}]}
    hostile = Summary(HOSTILE, HOSTILE, (scene, replace(scene, name="two")), TARGETS, provenance, HOSTILE)
    page, text = written(hostile, folder)
    assert len(page.all("script")) == 1
    assert "<script>alert" not in text
    assert page.visible.count(HOSTILE) > 15
    assert {path.name for path in tmp_path.iterdir()} == {"inner"}


@pytest.mark.usefixtures("without_figures")
def test_what_cannot_be_trusted_has_its_reason_in_place_of_numbers(tmp_path: Path) -> None:
    value = summary(tmp_path)
    page, _ = written(replace(value, scenes=(doubted(value.scenes[0], "best"),)), tmp_path)
    texts = [text for _, text in page.texts]
    row = texts.index("best", texts.index("Time to an error"))
    cells = texts[row + 1 : texts.index("Checks")]
    assert cells == ["\N{EN DASH}"] * (len(TARGETS) + 2) + ["\N{EN DASH}: these runs cannot tell."]
    assert any(span.get("title") == FEW for span in page.all("span"))


@pytest.mark.usefixtures("without_figures")
def test_the_checks_say_with_which_strategy_pictures_are_compared(tmp_path: Path) -> None:
    value = summary(tmp_path)
    page, _ = written(value, tmp_path)
    told = "without it the unbiased strategy with the smallest error on the scene"
    assert told in page.visible
    assert "of a bias contains the noise of the reference, whose error may be larger" in page.visible
    page, _ = written(replace(value, scenes=(replace(value.scenes[0], standard=None),)), tmp_path)
    assert told not in page.visible


def test_a_bias_that_is_not_found_has_no_limit_where_it_cannot_be_trusted(tmp_path: Path) -> None:
    (scene,) = summary(tmp_path).scenes
    styles = looks([one.label for one in scene.strategies], scene.baseline)
    first, *others = scene.strategies
    assert first.bias is not None

    def bias(found: StrategyResult) -> Cell:
        return check_table("box", replace(scene, strategies=(found, *others)), styles).rows[0].cells[3][0]

    assert str(bias(first)).startswith("none found (at most ")
    for found in (first.bias, Interval(-0.28, -0.31, -0.23)):
        cell = bias(replace(first, bias=found.doubted("heavy tail: one pixel")))
        assert (str(cell), cell.state, cell.note) == ("none found", "untrusted", "heavy tail: one pixel")
    limit = bias(replace(first, bias=Interval(0.02, -0.01, 0.0362).bounded("high", "the picture differs")))
    assert (str(limit), limit.note) == ("at most 3.62\u202f%", "the picture differs")
    large = bias(replace(first, bias=Interval(0.28, 0.23, 0.31).doubted("heavy tail: one pixel")))
    assert (str(large), large.state) == ("not trusted", "untrusted")


@pytest.mark.usefixtures("without_figures")
def test_the_factors_that_verdicts_tell_stand_in_the_table(tmp_path: Path) -> None:
    """Gains at equal time and at equal samples; one that is not known as a number stands as a limit."""
    value = summary(tmp_path)
    first, *others = value.scenes[0].strategies
    assert first.label == "naive"
    best = replace(others[0], efficiency=Interval(900.0, 500.0, 999.0).bounded("low", "hidden"))
    page, _ = written(replace(value, scenes=(replace(value.scenes[0], strategies=(first, best)),)), tmp_path)
    assert "gain at equal time gain at equal samples" in page.visible
    assert "\N{GREATER-THAN OR EQUAL TO} 500\N{MULTIPLICATION SIGN}" in page.visible
    assert "900" not in page.visible
    assert "2.0\N{MULTIPLICATION SIGN}" in page.visible
    assert "at 32 samples" in page.visible


def test_the_geometric_mean_over_scenes_adds_their_intervals_on_the_logarithm(tmp_path: Path) -> None:
    value = summary(tmp_path, scenes=2)
    slow, fast = (
        replace(one, strategies=tuple(replace(s, ratio={0.1: ratio}) for s in one.strategies))
        for one, ratio in zip(value.scenes, (Interval(4.0, 2.0, 8.0), Interval(16.0, 8.0, 32.0)), strict=True)
    )
    mean = geometric_mean(replace(value, scenes=(slow, fast)), "best", 0.1)
    assert mean is not None
    assert mean.value == pytest.approx(8.0)
    assert mean.high / mean.value == pytest.approx(2.0 ** (0.5**0.5))
    assert geometric_mean(value, "naive", 0.1) is None
    broken = geometric_mean(replace(value, scenes=(value.scenes[0], doubted(value.scenes[1], "best"))), "best", 0.1)
    assert broken is not None
    assert not broken.known
    assert "box1" in broken.note


@pytest.mark.usefixtures("without_figures")
def test_a_report_without_pictures_says_why_and_keeps_its_numbers(tmp_path: Path) -> None:
    value = summary(tmp_path)
    page, _ = written(replace(value, scenes=(replace(value.scenes[0], reference=None),)), tmp_path)
    assert "name no reference" in page.visible
    assert "Time to an error" in page.visible
    assert page.all("img") == []


@pytest.mark.usefixtures("without_figures")
def test_a_missing_or_damaged_image_is_said_and_the_others_are_shown(tmp_path: Path) -> None:
    value = summary(tmp_path)
    (tmp_path / "box0-cut-1.npy").write_bytes(b"no array")
    np.save(tmp_path / "box0-naive-0.npy", np.zeros((3, 3, 3)))
    page, _ = written(value, tmp_path)
    assert "There is no picture of cut" in page.visible
    assert "has shape (3, 3, 3), not (24, 36, 3)" in page.visible
    assert any("rendered by best" in str(image["alt"]) for image in page.all("img"))


def test_a_strategy_with_a_reference_of_its_own_is_held_against_that(tmp_path: Path) -> None:
    value = summary(tmp_path)
    other = tmp_path / "other.npz"
    write(other, KnownReference(Reference(np.full(SHAPE, 0.25), np.zeros(SHAPE)), {}))
    scene = value.scenes[0]
    plain, own = (
        load_pictures(replace(scene, strategies=tuple(replace(s, reference=path) for s in scene.strategies)))
        for path in (None, other)
    )
    assert isinstance(plain, Pictures)
    assert isinstance(own, Pictures)
    assert own.squares["best"].mean() > 10.0 * plain.squares["best"].mean()


@pytest.mark.usefixtures("without_figures")
def test_windows_that_are_not_shown_are_told_beside_the_pictures(tmp_path: Path) -> None:
    value = summary(tmp_path)
    scene = replace(value.scenes[0], crops_left_out="Not shown enlarged: 3x3 at 0, 0.")
    page, _ = written(replace(value, scenes=(scene,)), tmp_path)
    assert "Not shown enlarged: 3x3 at 0, 0." in page.visible


@pytest.mark.usefixtures("without_figures")
def test_crops_are_cut_at_the_border_of_the_image_and_left_out_beyond_it(tmp_path: Path) -> None:
    value = summary(tmp_path)
    scene = replace(value.scenes[0], crops=((30, 20, 12, 12), (36, 0, 5, 5)))
    page, _ = written(replace(value, scenes=(scene,)), tmp_path)
    crops = [str(image["alt"]) for image in page.all("img") if "pixels from" in str(image["alt"])]
    assert len(crops) == 1 + len(CONSTANTS)
    assert all(crop.endswith("pixels from 30, 20, 6 wide and 4 high") for crop in crops)


@pytest.mark.usefixtures("without_figures")
def test_curves_without_a_positive_number_are_left_out_without_fuss(tmp_path: Path) -> None:
    value = summary(tmp_path)
    strategies = tuple(
        replace(one, curve=replace(one.curve, error=(UNKNOWN,) * 4 + (Interval(-0.01, -0.02, 0.01),)))
        for one in value.scenes[0].strategies
    )
    written(replace(value, scenes=(replace(value.scenes[0], strategies=strategies),)), tmp_path)


def test_an_experiment_that_has_not_begun_has_a_page_too(tmp_path: Path) -> None:
    page, _ = written(Summary("Nothing yet", "", (), TARGETS, {}, "Nothing was run."), tmp_path / "new")
    assert "Nothing was run." in page.visible
    assert set(CONSTANTS) & set(page.visible.split()) == set()


def test_the_more_scenes_a_page_has_the_smaller_its_pictures_are(tmp_path: Path) -> None:
    value = summary(tmp_path)
    one, eight, many = (longest_side(replace(value, scenes=value.scenes * count)) for count in (1, 8, 10_000))
    assert (one, many) == (640, 128)
    assert 200 < eight < 300


@pytest.mark.usefixtures("without_figures")
def test_a_first_look_tells_which_word_of_its_command_to_leave_out(tmp_path: Path) -> None:
    quick = replace(summary(tmp_path), provenance={"command": "equaltime cost a.toml -o b --quick"})
    page, _ = written(quick, tmp_path)
    assert "run the command below again after taking --quick out of it." in page.visible
