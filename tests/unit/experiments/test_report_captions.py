"""Captions of pictures: which error is that of the run shown, and which that of all runs."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from equaltime.experiments.model.summary import StrategyResult
from equaltime.experiments.report.captions import mean_of_runs, short_caption, this_run
from equaltime.experiments.report.figures import draw_comparison
from equaltime.experiments.report.pictures import Pictures, load_pictures
from equaltime.experiments.report.words import EXTRAPOLATED
from equaltime.statistics.curves import BEYOND
from equaltime.statistics.intervals import Interval

from .fake_summary import CONSTANTS, REPEATS, scene_result, strategy

THIN = "\N{NARROW NO-BREAK SPACE}"
BELOW = "below what the reference can show"


@pytest.fixture
def best(tmp_path: Path) -> StrategyResult:
    return strategy("best", tmp_path, "box")


def ended(best: StrategyResult, error: Interval) -> StrategyResult:
    return replace(best, curve=replace(best.curve, error=(*best.curve.error[:-1], error)))


def test_a_caption_tells_the_error_of_this_run_from_that_of_all_runs(best: StrategyResult) -> None:
    end = 100.0 * CONSTANTS["best"] / math.sqrt(2.0)
    assert this_run(best) == f"this run: {1.05 * end:.2f}{THIN}% after 1.9{THIN}s, 32 spp"
    assert mean_of_runs(best) == f"the mean of {REPEATS} runs: {end:.1f}{THIN}% after 2{THIN}s"
    assert short_caption(best, 2.0).splitlines() == [
        f"this run: {1.05 * end:.2f}{THIN}% in 1.9{THIN}s",
        f"mean of {REPEATS}: {end:.1f}{THIN}% in 2{THIN}s",
    ]


def test_a_short_caption_has_the_tables_error_at_equal_time(best: StrategyResult) -> None:
    """Runs may end at another time than the equal time of the table."""
    other = replace(best, error_at_budget=Interval(0.123, 0.11, 0.14, note=BEYOND, reach=1.2))
    assert short_caption(other, 7.0).splitlines()[1] == f"mean of {REPEATS}: 12.3{THIN}%{THIN}* in 7{THIN}s"


def test_an_error_without_valid_interval_is_shown_as_the_curve_draws_it(best: StrategyResult) -> None:
    for doubted in (Interval(2.04, 1.65, 9.0).bounded("low", "a tail"), Interval(2.04, 1.0, 9.0).doubted("few")):
        assert mean_of_runs(ended(best, doubted)).startswith(f"the mean of {REPEATS} runs: 204{THIN}% after ")


def test_an_error_below_the_noise_of_the_reference_is_no_number(best: StrategyResult) -> None:
    assert this_run(replace(best, image_error=-0.01)).startswith(f"this run: {BELOW} after ")
    below = Interval(-0.01, -0.02, 0.01).doubted("noise")
    drowned = replace(ended(best, below), image_error=-0.01, error_at_budget=below)
    assert BELOW in mean_of_runs(drowned)
    assert short_caption(drowned, 2.0) == ""


def test_an_image_without_any_error_is_exact(best: StrategyResult) -> None:
    assert this_run(replace(best, image_error=0.0)).startswith("this run: exact after ")


def test_a_figure_for_papers_has_both_errors_above_the_crops(tmp_path: Path) -> None:
    scene = scene_result(tmp_path)
    pictures = load_pictures(scene)
    assert isinstance(pictures, Pictures)
    figure = draw_comparison(scene, pictures, scene.crops)
    assert "Each picture is one run at its end" in figure.get_supxlabel()
    assert "the equal time, 2" in figure.get_supxlabel()
    titles = [axes.get_title() for axes in figure.axes]
    wanted = [f"{one.label}\n{short_caption(one, scene.budget_s)}" for one in scene.strategies]
    assert [title for title in titles if title] == [scene.name, "reference", *wanted]


def test_a_figure_for_papers_explains_the_marks_of_its_errors_and_no_other(tmp_path: Path) -> None:
    scene = scene_result(tmp_path)
    pictures = load_pictures(scene)
    assert isinstance(pictures, Pictures)
    star = f"{EXTRAPOLATED.strip()} extrapolated beyond the longest run"
    assert star not in draw_comparison(scene, pictures, scene.crops).get_supxlabel()
    first, *others = scene.strategies
    beyond = replace(first, error_at_budget=replace(first.error_at_budget, note=BEYOND, reach=1.2))
    far = replace(scene, strategies=(beyond, *others))
    assert star in draw_comparison(far, pictures, far.crops).get_supxlabel()


def test_what_is_not_known_is_left_out(best: StrategyResult) -> None:
    assert this_run(replace(best, image_seconds=None)) == ""
    assert this_run(replace(best, image_error=None)).startswith("this run: error unknown after ")
    assert mean_of_runs(replace(best, repeats=1)) == ""
    assert mean_of_runs(ended(best, Interval(math.nan, math.nan, math.nan))) == ""
    assert short_caption(replace(best, repeats=1, image_error=None), 2.0) == ""
