"""All scenes at a glance: which times have a dot, and which error to reach shows the most."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report import page
from equaltime.experiments.report.charts import (
    clearest,
    curve_titles,
    draw_curves,
    draw_dots,
    has_dots,
    tick,
    with_one_point,
    without_curve,
)
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.page import without_marks
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.statistics.runs import TYPICAL

from .fake_summary import CONSTANTS, TARGETS, doubted, summary
from .test_report import Page

LOOKS = looks(list(CONSTANTS), "naive")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Summary:
    return summary(tmp_path_factory.mktemp("summary"), scenes=2)


def untrusted(scene: SceneResult, labels: tuple[str, ...] = tuple(CONSTANTS)) -> SceneResult:
    for label in labels:
        scene = doubted(scene, label)
    return scene


def test_a_time_that_cannot_be_trusted_has_no_dot(found: Summary) -> None:
    nothing = replace(found, scenes=tuple(map(untrusted, found.scenes)))
    assert has_dots(found, 0.02)
    assert not has_dots(nothing, 0.02)
    assert clearest(nothing) is None


def test_the_error_with_the_most_dots_is_shown_and_of_several_the_smallest(found: Summary) -> None:
    assert clearest(found) == min(TARGETS)
    scene = found.scenes[0]
    naive = scene.strategies[0]
    times = {target: time if target > 0.015 else time.doubted("why") for target, time in naive.time_to.items()}
    changed = replace(scene, strategies=(replace(naive, time_to=times), *scene.strategies[1:]))
    assert clearest(replace(found, scenes=(changed,))) == 0.02


def test_the_legend_of_curves_marks_a_strategy_with_another_picture(found: Summary) -> None:
    scene = found.scenes[0]
    naive, *others = scene.strategies
    changed = replace(scene, strategies=(replace(naive, agreement_p=1e-6), *others))
    legend = draw_curves(changed, TARGETS, LOOKS, (6.0, 4.0), legend=True).axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["naive (another picture)", "cut (biased)", "best"]


def test_a_strategy_without_a_curve_has_no_entry_in_the_legend_and_the_page_says_why(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    first, second = found.scenes
    naive, *others = first.strategies
    why = "its picture disagrees with the reference by 35 % (30 to 41): no error is given"
    unknown = replace(naive.curve, error=tuple(UNKNOWN.noted(why) for _ in naive.curve.error))
    changed = replace(first, strategies=(replace(naive, curve=unknown, agreement_p=1e-6), *others))
    legend = draw_curves(changed, TARGETS, LOOKS, (6.0, 4.0), legend=True).axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["cut (biased)", "best"]
    text = page.write_report(replace(found, scenes=(changed, second)), tmp_path).read_text("utf-8")
    assert text.count(f"naive has no curve: {why}.") == 1
    assert "Error against time on box0, both logarithmic, one curve each for cut, best;" in text


def test_a_strategy_that_is_exact_has_no_curve_for_that_reason(found: Summary) -> None:
    first, *others = found.scenes[0].strategies
    exact = replace(first.curve, error=tuple(Interval(0.0, 0.0, 0.0) for _ in first.curve.error))
    scene = replace(found.scenes[0], strategies=(replace(first, curve=exact), *others))
    assert without_curve(scene) == "naive has no curve: it is exact from its first image on."
    hidden = replace(first.curve, error=tuple(UNKNOWN for _ in first.curve.error))
    scene = replace(found.scenes[0], strategies=(replace(first, curve=hidden), *others))
    assert without_curve(scene) == "naive has no curve: none of its errors is known."


def test_curves_of_runs_too_short_for_a_clock_are_drawn_against_samples(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    first, second = found.scenes
    short = replace(first, budget_s=0.05)
    axes = draw_curves(short, TARGETS, LOOKS, (6.0, 4.0), legend=True).axes[0]
    assert axes.get_xlabel() == "samples per pixel"
    assert list(axes.get_lines()[0].get_xdata()) == [float(spp) for spp in first.strategies[0].curve.spp]
    low, high = axes.get_xlim()
    assert low < 2.0 < 32.0 < high < 64.0, "without the equal time"
    text = page.write_report(replace(found, scenes=(short, second)), tmp_path).read_text("utf-8")
    assert text.count("<h3>Error against samples per pixel</h3>") == text.count("<h3>Error against time</h3>") == 1
    assert text.count("The dashed line is the equal time") == 1
    assert "the\n      times are too short for a clock" in text


def test_a_chart_says_that_curves_are_root_mean_squares_and_some_times_medians(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    first, second = found.scenes
    naive, *others = first.strategies
    times = {target: time.noted(TYPICAL) for target, time in naive.time_to.items()}
    typical = replace(first, strategies=(replace(naive, time_to=times), *others))
    plain, marked = (draw_curves(scene, TARGETS, LOOKS, (6.0, 4.0), legend=True) for scene in (first, typical))
    assert plain.axes[0].get_ylabel() == marked.axes[0].get_ylabel() == "error (root mean square of the runs)"
    assert plain.get_supxlabel() == ""
    assert marked.get_supxlabel().startswith(
        "Curves are root mean squares of all runs. Times with \N{DAGGER} in tables"
    )
    text = page.write_report(replace(found, scenes=(typical, second)), tmp_path).read_text("utf-8")
    assert text.count("are medians: they are not where a curve crosses the error.") == 1


def test_the_equal_time_is_named_above_the_axes_beside_no_legend(found: Summary) -> None:
    axes = draw_curves(found.scenes[0], TARGETS, LOOKS, (6.0, 4.0), legend=True).axes[0]
    (label,) = (text for text in axes.texts if text.get_text().startswith("equal time"))
    figure = axes.get_figure()
    figure.draw_without_rendering()
    above, legend = label.get_window_extent(), axes.get_legend().get_window_extent()
    assert above.y0 >= axes.get_window_extent().y1
    assert not above.overlaps(legend)
    assert not axes.get_window_extent().overlaps(legend), "it would lie on curves or on the equal time"
    assert legend.x1 <= figure.bbox.x1


def test_an_error_that_the_table_does_not_trust_is_a_pale_point(found: Summary) -> None:
    scene = found.scenes[0]
    naive, *others = scene.strategies
    first, second, *last = naive.curve.error
    errors = (first.doubted("few repeats"), second.bounded("low", "heavy tail"), *last)
    curve = replace(naive.curve, error=errors)
    changed = replace(scene, strategies=(replace(naive, curve=curve), *others))
    axes = draw_curves(changed, TARGETS, LOOKS, (6.0, 4.0), legend=True).axes[0]
    sure, pale = (next(line for line in axes.lines if line.get_gid() == gid) for gid in ("curve-0", "curve-0-pale"))
    assert [math.isnan(error) for error in sure.get_ydata()] == [True, True, False, False, False]
    assert (pale.get_markevery(), sure.get_alpha()) == ([0, 1], None)
    assert 0.5 < pale.get_alpha() < 0.7, "told apart, but readable where a short run has no other points"
    assert axes.get_legend().get_texts()[-1].get_text() == "pale: not trusted"
    titles = curve_titles(0, changed.strategies[0])
    assert [len(titles[gid]) for gid in ("curve-0", "curve-0-pale")] == [3, 2]
    assert titles["curve-0-pale"][0].startswith("naive: not trusted after ")


def test_every_scene_has_a_row_and_what_lies_beyond_the_runs_is_hollow(found: Summary) -> None:
    scene = found.scenes[1]
    best = scene.strategies[2]
    beyond = replace(
        best, time_to={target: replace(time.noted("extrapolated"), reach=2.0) for target, time in best.time_to.items()}
    )
    changed = replace(found, scenes=(found.scenes[0], replace(scene, strategies=(*scene.strategies[:2], beyond))))
    axes = draw_dots(changed, 0.02, LOOKS, 6.0).axes[0]
    assert [text.get_text() for text in axes.get_yticklabels()] == ["box0", "box1"]
    hollow = [line for line in axes.lines if line.get_markerfacecolor() == "white" and len(line.get_ydata())]
    assert [list(line.get_ydata()) for line in hollow] == [[1]]
    filled = [line for line in axes.lines if line.get_marker() == "o"]
    assert sum(len(line.get_ydata()) for line in filled) == 2


def test_a_lower_end_above_the_time_of_another_strategy_is_an_arrow(found: Summary) -> None:
    changed = with_lower_end(found, 0.9)
    axes = draw_dots(changed, 0.02, LOOKS, 6.0).axes[0]
    arrows = [line for line in axes.lines if line.get_marker() == ">" and len(line.get_ydata())]
    low = 0.9 * found.scenes[0].strategies[0].time_to[0.02].value
    assert [(list(line.get_xdata()), list(line.get_ydata())) for line in arrows] == [([low], [0])]
    assert page.overview_views(changed, LOOKS)[0].table.columns == ("naive", "cut", "best")


def test_a_lower_end_below_every_known_time_says_nothing_and_is_not_drawn(found: Summary) -> None:
    changed = with_lower_end(found, 1e-6)
    arrows = [line for line in draw_dots(changed, 0.02, LOOKS, 6.0).axes[0].lines if line.get_marker() == ">"]
    assert not any(len(line.get_ydata()) for line in arrows)
    view = page.overview_views(changed, LOOKS)[0]
    assert view.unmarked == "No mark, since the time is not reached or not known: naive on every scene."
    assert set(view.looks) == {"cut", "best"}
    assert view.table.columns == ("cut", "best")
    assert view.table.unsaid == "Left out (naive): these runs cannot tell, where rare events make most of an error."


def with_lower_end(found: Summary, part: float) -> Summary:
    """Return the first scene alone; of the baseline's times only a lower end is known, ``part`` of the time."""
    scene = found.scenes[0]
    naive, *others = scene.strategies
    low = {
        target: replace(time, low=part * time.value).bounded("low", "a heavy tail")
        for target, time in naive.time_to.items()
    }
    return replace(found, scenes=(replace(scene, strategies=(replace(naive, time_to=low), *others)),))


def test_strategies_without_a_mark_are_named_with_the_scenes(found: Summary) -> None:
    first, second = found.scenes
    changed = replace(found, scenes=(untrusted(first, ("best", "cut")), untrusted(second, ("best",))))
    assert without_marks(found, 0.02) == ""
    sentence = "No mark, since the time is not reached or not known: cut on box0; best on every scene."
    assert without_marks(changed, 0.02) == sentence
    lows = [line for line in draw_dots(changed, 0.02, LOOKS, 6.0).axes[0].lines if line.get_marker() == ">"]
    assert not any(len(line.get_ydata()) for line in lows)


def test_pale_points_have_an_entry_in_the_legend_of_the_page(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    first, second = found.scenes
    naive, *others = first.strategies
    doubtful = replace(naive.curve, error=tuple(error.doubted("few repeats") for error in naive.curve.error))
    changed = replace(first, strategies=(replace(naive, curve=doubtful), *others))
    text = page.write_report(replace(found, scenes=(changed, second)), tmp_path).read_text("utf-8")
    assert text.count("pale: not trusted") == 1
    pale = [svg for svg in text.split("<svg")[1:] if 'id="box0-wide-curve-0-pale"' in svg]
    assert len(pale) == 1
    assert sum(title.startswith("naive: not trusted") for title in pale[0].split("<title>")[1:]) == 5


def test_the_page_has_a_chart_for_each_error_that_is_reached(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    shown = Page(page.write_report(found, tmp_path).read_text("utf-8"))
    charts = [str(svg["aria-label"]) for svg in shown.all("svg") if "Time to an error" in str(svg.get("aria-label"))]
    assert len(charts) == 2 * len(TARGETS)
    assert all("box0, box1" in chart for chart in charts)


@pytest.mark.parametrize("high", [1.1, 1.3, 1.7, 2.4, 3.5, 6.0, 30.0, 300.0, 4e3, 1e7, 1e12])
@pytest.mark.parametrize("low", [0.0013, 0.32, 1.0, 47.0])
@pytest.mark.parametrize("most", [4.0, 8.0])
def test_an_axis_has_three_labelled_ticks_or_more_and_not_too_many(low: float, high: float, most: float) -> None:
    axes = Figure().add_subplot()
    axes.set(xscale="log", xlim=(low, low * high))
    tick(axes.xaxis, lambda value: f"{value:.3g}", most)
    places = [place for place in axes.xaxis.get_major_locator()() if low <= place <= low * high]
    words = [axes.xaxis.get_major_formatter()(place) for place in places]
    assert 3 <= len(words) <= max(most, 6.0)
    assert len(set(words)) == len(words)


def test_a_curve_of_one_point_is_called_so_in_the_legend_and_below_the_chart(
    found: Summary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    first, second = found.scenes
    naive, *others = first.strategies
    curve = naive.curve
    one = replace(curve, spp=curve.spp[:1], seconds=curve.seconds[:1], error=curve.error[:1])
    changed = replace(first, strategies=(replace(naive, curve=one), *others))
    legend = draw_curves(changed, TARGETS, LOOKS, (6.0, 4.0), legend=True).axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["naive, one point", "cut (biased)", "best"]
    text = page.write_report(replace(found, scenes=(changed, second)), tmp_path).read_text("utf-8")
    assert text.count("naive has one point: no slope can be told, and no line drawn.") == 1
    assert with_one_point(second) == ""
