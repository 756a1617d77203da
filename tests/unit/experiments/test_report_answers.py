"""A report's answers beside the verdict: other renderers, hidden curves, links, and cells that say nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.report.index import Card, write_index
from equaltime.experiments.report.links import next_links
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.overlap import hidden_curves
from equaltime.experiments.report.own import other_renderers
from equaltime.experiments.report.tables import Table, TableRow, check_table
from equaltime.experiments.report.telling import commands, is_quick
from equaltime.experiments.report.words import Cell, same_cell, seconds_cell
from equaltime.images.image_files import SOFTWARE
from equaltime.statistics.curves import time_to_error
from equaltime.statistics.intervals import UNKNOWN, Interval

from .fake_summary import summary
from .made_up_runs import power_law

DASH, THIN, TIMES = "\N{EN DASH}", "\N{NARROW NO-BREAK SPACE}", "\N{MULTIPLICATION SIGN}"


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Summary:
    return summary(tmp_path_factory.mktemp("summary"), scenes=2)


def with_renderer(value: Summary, change: dict[str, object] | None = None) -> Summary:
    """Return the results with the strategy "cut" as a command of one's own, and with these changes to it."""

    def own(strategy: StrategyResult) -> StrategyResult:
        if strategy.label != "cut":
            return strategy
        return replace(strategy, label="my_renderer", renderer="command", biased=False, **(change or {}))  # type: ignore[arg-type]

    scenes = tuple(replace(scene, strategies=tuple(map(own, scene.strategies))) for scene in value.scenes)
    return replace(value, scenes=scenes)


def test_a_renderer_of_ones_own_has_its_time_beside_the_baseline_and_the_best(found: Summary) -> None:
    one = with_renderer(replace(found, scenes=found.scenes[:1]))
    assert other_renderers(one) == (
        f"my_renderer: 1{THIN}% in 400{THIN}s (360 to 440), 16.0{TIMES} (14.4 to 17.6) as fast as naive; "
        f"best takes 100{THIN}s (90 to 110).",
    )


def test_on_several_scenes_ratios_alone_are_means_and_times_have_their_scenes(found: Summary) -> None:
    (sentence,) = other_renderers(with_renderer(found))
    box, room = (scene.name for scene in found.scenes)
    assert f" on {box} to " in sentence
    assert f" on {room}, " in sentence
    assert " as fast as naive (geometric mean of 2 scenes); best takes " in sentence


def test_what_the_runs_cannot_tell_of_it_is_said_with_its_error(found: Summary) -> None:
    unknown = {"time_to": dict.fromkeys(found.targets, UNKNOWN)}
    (sentence,) = other_renderers(with_renderer(replace(found, scenes=found.scenes[:1]), unknown))
    told = f"after 2{THIN}s its error is 14.1{THIN}% (12.7 to 15.6)"
    assert sentence == f"my_renderer: these runs cannot tell its time to an error; {told}."


def test_a_renderer_that_the_verdict_names_is_not_named_twice(found: Summary) -> None:
    assert other_renderers(found) == ()
    named = replace(found, verdict="my_renderer is 16 times faster than naive")
    assert other_renderers(with_renderer(named)) == ()
    assert len(other_renderers(with_renderer(replace(named, verdict="not_my_renderer2 is fast")))) == 1


def test_a_curve_beneath_another_is_told(found: Summary) -> None:
    scene = found.scenes[0]
    naive, cut, best = scene.strategies
    assert hidden_curves(scene) == ""
    nearly = tuple(error.map(lambda value: 1.001 * value) for error in best.curve.error)
    changed = replace(cut, curve=replace(best.curve, error=nearly))
    assert hidden_curves(replace(scene, strategies=(naive, changed, best))) == "cut lies exactly beneath best."


def test_curves_that_cross_or_have_one_point_hide_nothing(found: Summary) -> None:
    scene = found.scenes[0]
    naive, cut, best = scene.strategies
    crossing = replace(cut, curve=replace(best.curve, error=best.curve.error[::-1]))
    assert hidden_curves(replace(scene, strategies=(naive, crossing, best))) == ""
    short = replace(best.curve, seconds=best.curve.seconds[:1], error=best.curve.error[:1])
    assert hidden_curves(replace(scene, strategies=(naive, replace(cut, curve=short), best))) == ""
    assert hidden_curves(replace(scene, strategies=())) == ""


def test_links_lead_to_what_is_there_and_to_an_index_of_ours_alone(tmp_path: Path) -> None:
    folder = tmp_path / "x1"
    folder.mkdir()
    assert next_links(folder) == ()
    (folder / "records.csv").write_text("scene\n")
    (folder / "figures").mkdir()
    (tmp_path / "index.html").write_text("<title>somebody's home page</title>")
    assert [link.path for link in next_links(folder)] == ["records.csv", "figures/"]
    (tmp_path / "index.html").write_text(f'<meta name="generator" content="{SOFTWARE}">')
    assert [link.path for link in next_links(folder)] == ["../index.html", "records.csv", "figures/"]


def test_a_first_look_is_known_by_its_command(found: Summary) -> None:
    assert commands(found) == ()
    assert not is_quick(found)
    sessions = {"a": {"command": "equaltime cost a.toml -o b --quick"}, "b": {"command": "equaltime cost a.toml -o b"}}
    known = replace(found, provenance={"command": sessions["a"]["command"], "sessions": sessions})
    assert commands(known) == (sessions["a"]["command"], sessions["b"]["command"])
    assert is_quick(known)


def table(*rows: tuple[Cell, ...]) -> Table:
    cells = tuple(TableRow("row", None, (), tuple((cell,) for cell in row)) for row in rows)
    return Table("slug", "caption", "corner", tuple("abc"[: len(rows[0])]), cells)


def test_columns_that_say_nothing_are_left_out_and_other_cells_are_dashes() -> None:
    unknown = Cell("unknown", note="too few checkpoints", state="unknown")
    doubted = Cell("not trusted", note="heavy tail", state="untrusted")
    told = table((Cell("1"), unknown, unknown), (doubted, unknown, doubted)).telling(quick=True)
    assert told.columns == ("a",)
    assert [str(row.cells[0][0]) for row in told.rows] == ["1", DASH]
    assert told.rows[1].cells[0][0].note == "heavy tail"
    assert told.footnotes == ()
    why = "these runs cannot tell, where rare events make most of an error"
    assert told.unsaid == f"Left out (b, c), and {DASH}: {why}."
    few = replace(doubted, note="too few repeats")
    told = table((Cell("1"), unknown, unknown), (few, unknown, few)).telling(quick=True)
    assert told.unsaid == f"Left out (b, c), and {DASH}: these runs are too short to tell; run without --quick."
    mixed = replace(unknown, note="speed-ups of typical runs and of mean errors have no common mean")
    told = table((Cell("1"), mixed)).telling(quick=False)
    assert told.unsaid == f"Left out (b): these runs cannot tell; {mixed.note}."


@pytest.mark.parametrize("note", ["not reached: biased, not extrapolated", "never reached: its bias is larger"])
def test_a_biased_strategy_that_is_not_extrapolated_is_told(note: str) -> None:
    never = Cell("not reached", note=note, state="unknown")
    told = table((Cell("1"), never)).telling(quick=False)
    assert told.unsaid == (
        "Left out (b): these runs cannot tell; biased strategies may never reach an error, and are not extrapolated."
    )


def test_a_column_beyond_the_reference_s_own_error_says_so() -> None:
    """As for two scenes, in an overview: the smallest and the largest of their references' errors."""
    runs = replace(power_law(), independent=True)
    times = [time_to_error(replace(runs, reference=error), 0.01) for error in (0.0904, 0.0863)]
    told = table(*((Cell("1"), seconds_cell(time)) for time in times)).telling(quick=False)
    assert told.columns == ("a",)
    assert told.unsaid == (
        "Left out (b): these runs cannot tell; the references have errors of 8.63 to 9.04 %, too much for times "
        "beyond the runs to a smaller one (reference.error and reference.seconds of an experiment file ask for a "
        "better one)."
    )


def test_a_table_that_says_everything_is_left_alone() -> None:
    full = table((Cell("1"), Cell("\N{GREATER-THAN OR EQUAL TO} 2", note="heavy tail", state="untrusted")))
    assert full.telling(quick=False) == full


def test_a_remark_on_a_number_stays_below_its_dash() -> None:
    remark = Cell("area 1, at 5 %", state="unknown")
    row = TableRow("row", None, (), ((Cell("unknown", state="unknown"), remark), (Cell("1"),)))
    kept = TableRow("row", None, (), ((Cell("7"), remark), (Cell("1"),)))
    told = Table("slug", "", "", ("a", "b"), (row, kept)).telling(quick=False)
    assert [[cell.text for cell in row.cells[0]] for row in told.rows] == [[DASH, remark.text], ["7", remark.text]]


def test_whether_pictures_are_the_same_is_yes_no_or_a_dash() -> None:
    assert str(same_cell(0.4, unequal=False)) == "yes (p = 0.40)"
    assert str(same_cell(1e-9, unequal=True)) == "no (p < 0.0001)"
    assert str(same_cell(None, unequal=False)) == DASH


def test_the_page_of_all_experiments_names_it_too(found: Summary, tmp_path: Path) -> None:
    one = with_renderer(replace(found, scenes=found.scenes[:1]))
    text = write_index([Card("mine", "A renderer of my own", "done", one)], tmp_path).read_text("utf-8")
    assert other_renderers(one)[0] in text


def test_a_bias_whose_interval_excludes_0_beside_an_equal_picture_is_explained(tmp_path: Path) -> None:
    plain = summary(tmp_path).scenes[0]
    off = {"naive": Interval(-0.004, -0.006, -0.002), "cut": Interval(0.003, 0.002, 0.004), "best": None}
    strategies = tuple(replace(one, bias=off[one.label]) for one in plain.strategies)
    look = looks(list(off), "naive")
    told = check_table("box", replace(plain, strategies=strategies), look)
    assert [row.cells[3][0].note for row in told.rows] == [
        "the interval excludes 0, as 1 of 20 does by chance: the test for an equal picture decides, which finds a "
        "difference by chance in 1 of 1000 experiments, all rows and scenes together",
        "biased by its settings, but too little for the test for an equal picture, which finds a difference by chance "
        "in 1 of 1000 experiments, all rows and scenes together",
        "",
    ]
    assert len([note for note in told.footnotes if "by chance" in note]) == 2
    found = check_table("box", replace(plain, strategies=tuple(replace(one, unequal=True) for one in strategies)), look)
    for table in (check_table("box", plain, look), found):
        assert not any("by chance" in note for note in table.footnotes)
