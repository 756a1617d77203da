"""The table that ``equaltime cost`` prints in a terminal: nothing by half, nothing without its reason."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from equaltime.cli.cost_table import every_row, legend, print_summary
from equaltime.cli.messages import MOST_LINES
from equaltime.experiments.model.summary import StrategyResult, Summary
from equaltime.experiments.report.latex import latex_table
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.tables import check_table, point_table
from equaltime.experiments.report.words import facts, percent
from equaltime.statistics.curves import BEFORE, BELOW, BETTER, BEYOND, RISES, TOO_NOISY
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.statistics.runs import TYPICAL

from ..experiments.fake_summary import summary

LEFT_OUT = f"times to {percent(0.1)}, {percent(0.05)}"
"""Times that the table has no column for, in words."""
STAR = "* extrapolated beyond the longest run"
HUGE = Interval(500.0, 400.0, 600.0, note=f"extrapolated 9 times {BEYOND}", reach=9.0)


def changed(found: Summary, label: str, change: Callable[[StrategyResult], StrategyResult]) -> Summary:
    strategies = (change(one) if one.label == label else one for one in found.scenes[0].strategies)
    return replace(found, scenes=(replace(found.scenes[0], strategies=tuple(strategies)),))


def printed(
    found: Summary, folder: Path, capsys: pytest.CaptureFixture[str], verbose: bool = False, quick: bool = False
) -> list[str]:
    print_summary(found, folder, verbose, quick)
    return capsys.readouterr().out.splitlines()


def test_a_time_that_was_not_measured_is_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    far = changed(summary(tmp_path), "naive", lambda one: replace(one, time_to={**one.time_to, 0.02: HUGE}))
    never = Interval(math.inf, 1.0, math.inf)
    far = changed(far, "best", lambda one: replace(one, time_to={**one.time_to, 0.01: never}))
    verdict, head, naive, cut, best, below = printed(far, tmp_path, capsys)[:6]
    assert verdict == far.verdict
    assert "time to 1 %" not in head  # one of them does not reach it
    assert naive.rstrip().endswith("*")
    assert "*" not in cut + best
    assert below == STAR


def test_the_verdict_is_the_first_and_the_last_line_and_its_notes_are_below_the_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = replace(summary(tmp_path), verdict_notes=("One.", "Two.", "Three."))
    lines = printed(found, tmp_path, capsys)
    assert lines[0] == lines[-1] == found.verdict
    assert lines[5:7] == ["One.", "Two."]
    assert "Three." not in lines
    assert any(line.endswith("1 more note") or "1 more note " in line for line in lines)
    assert "Three." in printed(found, tmp_path, capsys, verbose=True)
    assert "Three." in legend(found, every_row(found))


def test_the_note_on_what_to_do_is_always_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = replace(summary(tmp_path), verdict_notes=("One.", "Two.", "Three.", "What to do: longer runs."))
    lines = printed(found, tmp_path, capsys)
    assert lines[5:8] == ["One.", "Two.", "What to do: longer runs."]
    assert "Three." not in lines


def test_both_of_two_targets_are_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """To the second a single strategy has a time. The twin has a third target, so that the table must choose."""
    rare = UNKNOWN.doubted("no repeats")
    some = changed(summary(tmp_path), "naive", lambda one: replace(one, time_to={**one.time_to, 0.02: rare}))
    for targets, shown in (((0.05, 0.02), True), ((0.1, 0.05, 0.02), False)):
        head = printed(replace(some, targets=targets, headline_target=0.05), tmp_path, capsys)[1]
        assert "time to 5\u202f%" in head
        assert ("time to 2\u202f%" in head) == shown


def test_an_error_beyond_the_runs_is_marked_and_not_called_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    error = replace(summary(tmp_path).scenes[0].strategies[0].error_at_budget, note=BEYOND, reach=1.2)
    lines = printed(
        changed(summary(tmp_path), "naive", lambda one: replace(one, error_at_budget=error)), tmp_path, capsys
    )
    assert "*" in lines[2]
    assert "*" not in lines[3]
    assert STAR in lines
    bound = error.bounded("low", "heavy tail")
    lines = printed(
        changed(summary(tmp_path), "naive", lambda one: replace(one, error_at_budget=bound)), tmp_path, capsys
    )
    assert "(extrapolated 56.6" in lines[2]
    assert "measured" not in lines[2]


def test_the_table_has_the_error_of_the_verdict_and_a_line_says_why_it_is_this_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Most strategies have trusted times to all errors; the table would show the smallest two."""
    found = replace(summary(tmp_path), headline_target=0.1)
    lines = printed(found, tmp_path, capsys)
    assert [" ".join(part.split()) for part in lines[1].split("time to ")[1:]] == ["10 %", "1 %"]
    why = (
        "Why 10 %: it is the smallest target whose times can be trusted; times within the runs come before "
        "extrapolated ones."
    )
    assert lines[5] == why
    assert why in legend(found, every_row(found))
    far = changed(found, "best", lambda one: replace(one, time_to={**one.time_to, 0.1: replace(HUGE, note="")}))
    beyond = (
        "Why 10 %: no target is reached within the runs. It is the nearest to them of those that are known on most "
        "scenes; targets below three times the reference's error come last."
    )
    assert far.headline_rule == beyond
    slow = changed(found, "best", lambda one: replace(one, ratio={**one.ratio, 0.1: replace(HUGE, note="")}))
    assert slow.headline_rule == beyond, "the time of the baseline is extrapolated"
    several = replace(found, scenes=(found.scenes[0], far.scenes[0]))
    assert several.headline_rule == beyond, "the answer is on both scenes"
    unknown = changed(found, "best", lambda one: replace(one, time_to={}))
    some = replace(found, scenes=(found.scenes[0], far.scenes[0], unknown.scenes[0]))
    assert some.headline_rule == why, "the answer is on the first scene"
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "66")
    assert "time to 10" in printed(found, tmp_path, capsys)[1], "the only one on a narrow terminal"
    assert not any("Why" in line for line in printed(summary(tmp_path), tmp_path, capsys))


def test_a_time_that_is_not_reached_is_explained(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The error of an unbiased strategy falls on: it reaches every error at some time."""
    never = Interval(math.inf, 60.0, math.inf).noted("not reached in 100 times the longest run")
    found = changed(summary(tmp_path), "naive", lambda one: replace(one, time_to=dict.fromkeys(one.time_to, never)))
    told = "not reached in 100 times the longest run; by a biased strategy, in its runs"
    assert told in printed(found, tmp_path, capsys)
    assert told not in printed(summary(tmp_path), tmp_path, capsys)


def test_times_of_typical_runs_are_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def typical(one: StrategyResult) -> StrategyResult:
        return replace(one, time_to={target: time.noted(TYPICAL) for target, time in one.time_to.items()})

    found = changed(summary(tmp_path), "naive", typical)
    lines = printed(found, tmp_path, capsys)
    assert lines[2].count("\N{DAGGER}") == 2
    assert "\N{DAGGER}" not in lines[3]
    assert any(line.startswith("\N{DAGGER} of typical runs: a median over repeats") for line in lines)
    table = latex_table(found)
    assert table.count(r"$^\dagger$") == 5, "four times and the note"
    assert table.isascii()


def test_a_lower_limit_and_the_error_beside_it_are_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = summary(tmp_path)
    bound = plain.scenes[0].strategies[0].error_at_budget.bounded("low", "heavy tail")
    found = changed(plain, "naive", lambda one: replace(one, error_at_budget=bound))
    told = "\N{GREATER-THAN OR EQUAL TO} at least, since the upper end of the interval cannot be trusted"
    assert f"{told}; in brackets: the error that was measured" in printed(found, tmp_path, capsys)
    assert not any(told in line for line in printed(plain, tmp_path, capsys))


@pytest.mark.parametrize(
    ("note", "sign", "meaning"),
    [
        (BEYOND, "*", "extrapolated beyond the longest run"),
        (BEFORE, "\N{DOUBLE DAGGER}", "extrapolated to a time before the first measurement"),
        (RISES, "\N{SECTION SIGN}", "read off where measured errors rise with time"),
    ],
)
def test_each_reason_for_a_mark_has_a_sign_of_its_own_which_is_explained(
    note: str, sign: str, meaning: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def limited(one: StrategyResult) -> StrategyResult:
        return replace(one, time_to={target: time.noted(note) for target, time in one.time_to.items()})

    lines = printed(changed(summary(tmp_path), "naive", limited), tmp_path, capsys)
    signs = "*\N{DAGGER}\N{DOUBLE DAGGER}\N{SECTION SIGN}"
    assert [letter for letter in lines[2] if letter in signs] == [sign, sign]
    assert not set(lines[3]) & set(signs)
    (told,) = [line for line in lines if line[0] in signs]
    assert told.startswith(f"{sign} {meaning}")


def test_every_speed_up_over_the_baseline_is_told_with_all_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = replace(summary(tmp_path, scenes=2), headline_target=0.1)
    told = [line for line in legend(found, every_row(found)) if "speed-up" in line]
    assert [line.partition(":")[0] for line in told] == ["box0", "box1"]
    assert told[0].replace("\N{NARROW NO-BREAK SPACE}", " ").replace("\N{MULTIPLICATION SIGN}", "x") == (
        "box0: speed-up over naive to 10 %: cut 16.0x (14.4 to 17.6), best 64x (58 to 70)"
    )
    assert told[1] in printed(found, tmp_path, capsys, verbose=True)
    assert not any("speed-up over" in line for line in printed(found, tmp_path, capsys))


def test_a_row_of_another_picture_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = changed(summary(tmp_path), "best", lambda one: replace(one, agreement_p=1e-9))
    naive, cut, best = printed(wrong, tmp_path, capsys)[2:5]
    assert "(" not in naive[:20]
    assert cut.startswith("cut (biased) ")
    assert best.startswith("best (another picture) ")


def test_paths_that_are_not_those_of_the_scene_are_said_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = summary(tmp_path)
    for asked, times in ((None, 0), (8, 0), (-1, 1)):
        scene = replace(found.scenes[0], scene_max_depth=asked)
        text = printed(replace(found, scenes=(scene,)), tmp_path, capsys)
        said = "errors and times are of paths up to depth 8; the scene asks for paths of any length"
        assert text.count(said) == times
        assert facts(scene).count(", max_depth 8 (the scene asks for paths of any length); ") == times


def test_what_a_biased_strategy_says_of_itself_is_called_noise(tmp_path: Path) -> None:
    (scene,) = summary(tmp_path).scenes
    styles = looks([one.label for one in scene.strategies], scene.baseline)
    for table, column in ((check_table("box", scene, styles), 2), (point_table("box", scene, styles), 3)):
        own = [(row.label, cell.text, cell.note) for row in table.rows for cell in row.cells[column]]
        assert {label for label, text, _ in own if text.startswith("noise ")} == {"cut"}
        assert {label for label, _, note in own if note == "the strategy's bias is not in it"} == {"cut"}


def test_why_an_error_has_no_interval_is_said_below(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nothing = UNKNOWN.doubted("the error is below what the reference can show")
    found = changed(summary(tmp_path), "best", lambda one: replace(one, error_at_budget=nothing))
    below = printed(found, tmp_path, capsys, verbose=True)[6:]
    assert below[0] == "best: the error is below what the reference can show"
    lines = printed(found, tmp_path, capsys)
    assert lines[5] == below[0]
    assert lines[6] == f"equaltime info {tmp_path} -v shows {LEFT_OUT} and why 1 error is unknown"


def test_why_times_are_unknown_is_said_below_all_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lost = UNKNOWN.doubted("the error varies too much")
    found = summary(tmp_path)
    first, second, *_ = found.targets
    found = changed(found, "best", lambda one: replace(one, time_to={**one.time_to, first: lost, second: lost}))
    line = f"best, time to {percent(first)} and {percent(second)}: the error varies too much"
    assert line in printed(found, tmp_path, capsys, verbose=True)
    assert line not in printed(found, tmp_path, capsys)


def test_a_row_names_its_scene_also_if_no_other_has_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    empty = replace(scene, name="dark", strategies=())
    lines = printed(replace(found, scenes=(scene, empty)), tmp_path, capsys)
    assert any(line.startswith("scene ") for line in lines)
    assert any(line.startswith(f"{scene.name} ") for line in lines)


def test_errors_that_the_reference_hides_have_one_line_with_the_remedy_also_beside_many_rows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hidden = UNKNOWN.doubted(BELOW)
    one = changed(summary(tmp_path), "best", lambda best: replace(best, error_at_budget=hidden))
    assert printed(one, tmp_path, capsys).count(f"best: {BELOW}") == 1
    assert printed(one, tmp_path, capsys, verbose=True).count(f"best: {BELOW}") == 1
    several = replace(one, scenes=tuple(replace(one.scenes[0], name=name) for name in ("a", "b", "c", "d")))
    (scene, *others) = several.scenes
    cut = replace(scene, strategies=(*scene.strategies[:1], replace(scene.strategies[1], error_at_budget=hidden)))
    lines = printed(replace(several, scenes=(cut, *others)), tmp_path, capsys)
    assert lines.count(f"cut on a and best on 3 scenes: {BELOW}") == 1
    assert "reference.error and reference.seconds" in BELOW
    assert len(lines) <= MOST_LINES


def test_an_error_that_is_unknown_is_not_called_untrusted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = changed(summary(tmp_path), "best", lambda one: replace(one, error_at_budget=UNKNOWN.doubted("not near")))
    doubted = changed(
        found, "naive", lambda one: replace(one, error_at_budget=one.error_at_budget.doubted("heavy tail"))
    )
    (scene,) = doubted.scenes
    without = replace(doubted, scenes=(replace(scene, left_out=(("own", "no module"),)),))
    said = "why 1 strategy was left out, why 1 error is unknown and why 1 error cannot be trusted"
    assert any(line.endswith(said) for line in printed(without, tmp_path, capsys))


@pytest.mark.parametrize(("columns", "times"), [("", 2), ("80", 2), ("56", 1), ("36", 0)])
def test_a_narrow_terminal_shows_fewer_times_and_none_by_half(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, columns: str, times: int
) -> None:
    if columns:
        monkeypatch.setenv("FORCE_COLOR", "1")
        monkeypatch.setenv("COLUMNS", columns)
    head, row = printed(summary(tmp_path), tmp_path, capsys)[1:3]
    assert (head.count("time to"), row.count("("), row.count(")")) == (times, 1 + times, 1 + times)


def test_a_table_of_all_has_every_time_or_names_those_without_room(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = summary(tmp_path)
    every = printed(found, tmp_path, capsys, verbose=True)
    assert every[1].count("time to") == len(found.targets) == 4
    monkeypatch.setenv("COLUMNS", "80")
    assert not any("Too wide" in line for line in legend(found, every_row(found))), "a pipe has no width"
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert f"Too wide for this terminal: {LEFT_OUT}; report.html has them" in legend(found, every_row(found))


def test_runs_that_end_early_are_told_beside_the_comparison(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    early = changed(summary(tmp_path), "best", lambda one: replace(one, run_seconds=(1.9, 1.1, 1.0)))
    told = (
        "note: runs did not end at the equal time of 2 s (median, range): best after 1.1 s (1 to 1.9). All runs take "
        "the samples of the first one. Errors at the equal time are read off the curve; beyond its end they are "
        "extrapolated"
    )
    assert told in printed(early, tmp_path, capsys)
    assert not any("did not end" in line for line in printed(summary(tmp_path), tmp_path, capsys))


def test_first_images_later_than_the_budget_are_told_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    late = changed(summary(tmp_path), "naive", lambda one: replace(one, late=3.0))
    assert printed(late, tmp_path, capsys)[5] == "note: the first image took longer than the budget of 2 s: naive (3 s)"
    both = changed(late, "best", lambda one: replace(one, late=2.5))
    lines = printed(both, tmp_path, capsys)
    assert lines.count("note: first images took longer than the budget of 2 s: naive (3 s), best (2.5 s)") == 1


def test_up_to_eight_strategies_are_all_shown_also_without_a_number(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nothing = UNKNOWN.doubted("no repeats")
    silent = changed(
        summary(tmp_path),
        "cut",
        lambda one: replace(one, error_at_budget=nothing, time_to=dict.fromkeys(one.time_to, nothing)),
    )
    lines = printed(silent, tmp_path, capsys)
    assert [text.split()[0] for text in lines[2:5]] == ["naive", "cut", "best"]
    assert lines[5:7] == [
        "cut: no repeats",
        f"equaltime info {tmp_path} -v shows {LEFT_OUT}, why 1 error is unknown and why 2 times are unknown",
    ]


def test_the_legend_has_the_marks_of_its_table_and_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    plain = changed(summary(tmp_path), "cut", lambda one: replace(one, biased=False))
    assert legend(plain, every_row(plain))[1:] == [
        "in brackets: 95 % intervals, by the spread over repeats and the noise of the reference"
    ]
    far = changed(summary(tmp_path), "naive", lambda one: replace(one, time_to={**one.time_to, 0.02: HUGE}))
    half = changed(
        far, "best", lambda one: replace(one, error_at_budget=one.error_at_budget.bounded("low", "light is missing"))
    )
    assert legend(half, every_row(half))[2:] == [
        "(biased) the strategy may converge to another picture",
        "\N{GREATER-THAN OR EQUAL TO} at least, since the upper end of the interval cannot be trusted",
        STAR,
        "best: light is missing",
    ]


def test_the_legend_and_the_latex_table_have_the_same_marks_with_the_same_meanings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bounds that are extrapolated or of typical runs, and words in place of numbers."""
    monkeypatch.setenv("COLUMNS", "200")
    far = Interval(9.0, 4.0, 20.0, reach=3.0).noted(TYPICAL).noted(BEYOND).bounded("low", "heavy tail")
    none = UNKNOWN.doubted("too few").noted(TYPICAL)
    times = {0.02: far, 0.01: none}
    found = changed(summary(tmp_path), "naive", lambda one: replace(one, time_to={**one.time_to, **times}))
    half = changed(found, "best", lambda one: replace(one, error_at_budget=one.error_at_budget.bounded("low", "light")))
    table = every_row(half)
    (column,) = [one for one in table.columns if str(one.header).startswith("time to 2")]
    assert str(next(iter(column.cells))).endswith("s\N{NARROW NO-BREAK SPACE}*\N{NARROW NO-BREAK SPACE}\N{DAGGER}")
    told = [text.replace("%", r"\%").replace("\N{GREATER-THAN OR EQUAL TO}", r"$\ge$") for text in legend(half, table)]
    told = [text.replace("* ", "$^*$ ", 1).replace("\N{DAGGER} ", r"$^\dagger$ ", 1) for text in told]
    *same, dash = [line.removesuffix(r"\par") for line in latex_table(half).splitlines() if line.endswith(r"\par")]
    assert dash.startswith("--: unknown, not trusted, or ")
    assert {re.sub(r"^(\S+[$)]):", r"\1", note) for note in same} <= set(told)
    assert len(same) == 5


def test_names_with_brackets_are_shown_as_they_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    named = changed(summary(tmp_path), "best", lambda one: replace(one, label="best[bold] of[/x] all"))
    assert printed(named, tmp_path, capsys)[4].startswith("best[bold] of[/x] all ")


def test_targets_without_any_time_are_named_with_the_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    note = f"the reference has an error of 0.2 %{TOO_NOISY} ({BETTER})"
    found = summary(tmp_path)
    for label in ("naive", "cut", "best"):
        found = changed(
            found,
            label,
            lambda one: replace(one, time_to={**one.time_to, **dict.fromkeys((0.02, 0.01), UNKNOWN.doubted(note))}),
        )
    told = (
        "No times to 2 % and 1 %: the reference has an error of 0.2 %, too much for times beyond the runs to a smaller "
    )
    print_summary(found, tmp_path, quick=True)
    assert (
        f"{told}one (without --quick it is better)"
        in capsys.readouterr().out.replace("\N{NARROW NO-BREAK SPACE}", " ").splitlines()
    )
    print_summary(found, tmp_path)
    assert f"{told}one ({BETTER})" in capsys.readouterr().out.replace("\N{NARROW NO-BREAK SPACE}", " ").splitlines()
    worse = replace(found.scenes[0], name="room", reference_error=0.0264)
    print_summary(replace(found, scenes=(worse, *found.scenes)), tmp_path)
    told = "No times to 2 % and 1 %: the references have errors of 0.2 % (box0) to 2.64 % (room), too much for times"
    assert told in capsys.readouterr().out.replace("\N{NARROW NO-BREAK SPACE}", " ")


def test_the_reason_why_no_strategy_has_a_time_is_not_one_of_a_biased_strategy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = summary(tmp_path)
    for label, note in (("naive", "the bias is its own"), ("cut", "the bias is its own"), ("best", "few checkpoints")):
        biased = label != "best"
        found = changed(
            found,
            label,
            lambda one, note=note, biased=biased: replace(
                one, biased=biased, time_to={**one.time_to, 0.01: UNKNOWN.doubted(note)}
            ),
        )
    assert "No times to 1\N{NARROW NO-BREAK SPACE}%: few checkpoints" in printed(found, tmp_path, capsys)


def test_the_reason_of_some_strategies_names_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = summary(tmp_path)
    for label, note in (("naive", "not reached"), ("cut", "not reached"), ("best", "few checkpoints")):
        found = changed(
            found,
            label,
            lambda one, note=note: replace(one, biased=False, time_to={**one.time_to, 0.01: UNKNOWN.doubted(note)}),
        )
    told = "No times to 1\N{NARROW NO-BREAK SPACE}%. naive and cut: not reached"
    assert told in printed(found, tmp_path, capsys)


def test_unknown_times_of_the_table_point_to_their_reasons(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    none = UNKNOWN.doubted("the error varies too much between repeats to tell how it goes on")
    found = changed(summary(tmp_path), "naive", lambda one: replace(one, time_to=dict.fromkeys(one.time_to, none)))
    lines = printed(found, tmp_path, capsys)
    assert any(line.startswith("naive ") and line.count("unknown") == 2 for line in lines)
    assert any(line.startswith("equaltime info ") and "why 2 times are unknown" in line for line in lines)


def test_an_error_that_the_reference_hides_has_its_upper_limit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hidden = Interval(math.nan, 0.0, 0.00347).bounded("high", BELOW)
    lines = printed(
        changed(summary(tmp_path), "best", lambda one: replace(one, error_at_budget=hidden)), tmp_path, capsys
    )
    (row,) = [line for line in lines if line.startswith("best ")]
    assert "\N{LESS-THAN OR EQUAL TO} 0.347 %" in row.replace("\N{NARROW NO-BREAK SPACE}", " ")
    assert any(line.startswith("\N{LESS-THAN OR EQUAL TO} at most, ") for line in lines)
    assert not any("unknown" in line for line in lines)


@pytest.mark.parametrize("scenes", [1, 4])
def test_the_verdict_is_the_first_and_the_last_of_at_most_12_lines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], scenes: int
) -> None:
    found = summary(tmp_path, scenes)
    lines = printed(found, tmp_path, capsys, quick=True)
    assert lines[0] == lines[-1] == found.verdict
    assert lines[-2] == (
        f"Curves and pictures: open {tmp_path / 'report.html'}; without --quick the numbers are more exact"
    )
    assert len(lines) <= MOST_LINES
    assert len(printed(found, tmp_path, capsys, verbose=True)) == 4 + 4 * scenes


def test_standards_and_baselines_are_shown_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = printed(summary(tmp_path, 3), tmp_path, capsys)
    assert lines[1].split()[:2] == ["scene", "strategy"]
    rows = [tuple(line.split()[:2]) for line in lines[2:-3]]
    assert rows == [(f"box{number}", label) for number in range(3) for label in ("naive", "best")]
    assert lines[-3] == f"equaltime info {tmp_path} -v shows 3 more rows and {LEFT_OUT}"
