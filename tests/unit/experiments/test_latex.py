"""The table for a paper: every strategy of every scene, in characters that LaTeX reads."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

from equaltime.experiments.report.latex import latex_table, write_latex
from equaltime.statistics.curves import BEYOND
from equaltime.statistics.intervals import UNKNOWN, Interval

from .fake_summary import summary


def heads(lines: list[str]) -> list[str]:
    """Return the headings of the first scene, each in one line."""
    row = lines[5].removesuffix(r" \\")
    return [
        re.sub(r"^\\begin\{tabular\}.*?@\{\}\}|\\end\{tabular\}$", "", cell).replace(r" \\ ", " ")
        for cell in row.split(" & ")
    ]


def test_notes_are_as_wide_as_a_line_and_not_as_wide_as_they_are_long(tmp_path: Path) -> None:
    """Rows of the table itself are short; long sentences stand in a box of the line's width."""
    found = summary(tmp_path)
    (scene,) = found.scenes
    first, *others = scene.strategies
    far = {target: replace(time, note=BEYOND, reach=4.0) for target, time in first.time_to.items()}
    changed = replace(scene, strategies=(replace(first, time_to=far), *others))
    inner, box = latex_table(replace(found, scenes=(changed,))).split("\\parbox{\\linewidth}{\\raggedright\n")
    assert "extrapolated beyond the longest run" in box
    assert "extrapolated beyond the longest run" not in inner
    assert inner.count("{") - inner.count("}") == 1, "the group of the small print stays open"
    assert inner.count(r"\begin{tabular}") - inner.count(r"\end{tabular}") == 1


def test_a_label_that_begins_with_a_bracket_is_no_argument_of_the_row_above(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    named = replace(scene.strategies[0], label="[a]*")
    table = latex_table(replace(found, scenes=(replace(scene, strategies=(named, *scene.strategies[1:])),)))
    assert "\n{}[a]* & " in table


def test_a_strategy_without_a_known_speed_up_has_its_gain_at_equal_time(tmp_path: Path) -> None:
    """The twin has speed-ups, which say more."""
    found = summary(tmp_path)
    assert "gain over naive" not in latex_table(found)
    scene = found.scenes[0]
    none = tuple(replace(one, ratio=dict.fromkeys(one.ratio, UNKNOWN)) for one in scene.strategies)
    table = latex_table(replace(found, scenes=(replace(scene, strategies=none),)))
    (told,) = (line for line in table.splitlines() if line.startswith("gain over naive at equal time"))
    assert told.endswith(r"cut 3.0$\times$ (2.5 to 3.5), best 3.0$\times$ (2.5 to 3.5)\par")


def test_the_table_has_every_strategy_of_every_scene(tmp_path: Path) -> None:
    found = summary(tmp_path, scenes=2)
    lines = latex_table(found).splitlines()
    rows = [line for line in lines if line.endswith(r"\\") and not line.startswith(r"\multicolumn")]
    assert len(rows) == sum(1 + len(scene.strategies) for scene in found.scenes)
    assert {row.count(" & ") for row in rows} == {1 + 2 * len(found.targets)}
    assert [line[:15] for line in lines[2:4]] == [r"\begin{tabular}"] * 2
    assert lines[-1] == r"\end{tabular}}"
    assert sum(line == r"\midrule" for line in lines) == 2 * len(found.scenes) - 1


def test_only_characters_that_latex_reads(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    table = latex_table(replace(found, scenes=(replace(scene, name="100 % a_b & {c} ~ ^ #1 $ \\x"),)))
    assert table.isascii()
    assert r"100 \% a\_b \& \{c\} \textasciitilde{} \textasciicircum{} \#1 \$ \textbackslash{}x" in table


def test_a_number_that_cannot_be_trusted_is_a_dash(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    first = scene.strategies[0]
    doubted = replace(first, error_at_budget=first.error_at_budget.doubted("few repeats"))
    table = latex_table(replace(found, scenes=(replace(scene, strategies=(doubted,)),)))
    assert f"{first.label} & -- &" in table
    far = {target: replace(time.doubted("too far"), reach=99.0) for target, time in first.time_to.items()}
    table = latex_table(
        replace(found, scenes=(replace(scene, strategies=(replace(first, time_to=far), scene.strategies[2])),))
    )
    assert "& -- &" in table
    assert "--$^*$" not in table


def test_what_limits_a_number_stands_beside_it(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    first, *others = scene.strategies
    bound = first.error_at_budget.bounded("low", "heavy tail")
    far = {target: replace(time, note=BEYOND, reach=4.0) for target, time in first.time_to.items()}
    changed = replace(first, error_at_budget=bound, time_to=far, biased=True)
    lines = latex_table(replace(found, scenes=(replace(scene, strategies=(changed, *others)),))).splitlines()
    (row,) = [line for line in lines if line.startswith(first.label)]
    assert row.startswith(rf"{first.label} (biased) & $\ge$")
    assert row.count("$^*$") == sum(time.known and time.trusted for time in far.values())
    (conditions,) = [line for line in lines if line.startswith(r"\multicolumn")]
    assert f"{scene.size[0]}x{scene.size[1]} pixels, {first.repeats} repeats, " in conditions
    assert [line.partition(":")[0] for line in lines if line.endswith(r"\par")] == [
        *("in brackets", "(biased)", r"$\ge$", "$^*$")
    ]


def test_an_error_beyond_the_runs_has_the_star(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    error = replace(scene.strategies[0].error_at_budget, note=BEYOND, reach=1.2)
    first = replace(scene.strategies[0], error_at_budget=error)
    rows = latex_table(replace(found, scenes=(replace(scene, strategies=(first,)),))).splitlines()
    assert rows[7].split(" & ")[1].endswith("$^*$")
    assert any("extrapolated beyond the longest run" in row for row in rows)


def test_notes_explain_only_the_marks_that_the_table_has(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    table = latex_table(replace(found, scenes=(replace(scene, strategies=scene.strategies[:1]),)))
    assert table.endswith(
        "\\bottomrule\n\\end{tabular} \\\\[1ex]\n\\parbox{\\linewidth}{\\raggedright\n"
        "in brackets: 95 \\% intervals, by the spread over repeats and the noise of the reference\\par\n"
        "}\n\\end{tabular}}\n"
    )


def test_all_times_of_a_column_have_the_unit_of_its_heading(tmp_path: Path) -> None:
    rows = latex_table(summary(tmp_path)).splitlines()
    assert heads(rows)[:3] == ["box0", r"error after 2\,s [\%]", r"time to 10\,\% [s]"]
    assert [row.partition(" & ")[0] for row in rows[7:10]] == ["naive", "cut (biased)", "best"]
    assert r" & 1,600 (1,440 to 1,760) & 6,400 (5,760 to 7,040) & " in rows[7], "96 to 117 minutes, in seconds"
    assert r"\%" not in "".join(rows[7:10])


def test_times_of_a_column_that_spans_powers_of_ten_have_units_of_their_own(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    naive, cut, best = scene.strategies
    quick, slow = Interval(3e-3, 2e-3, 4e-3), Interval(7200.0, 7000.0, 7400.0)
    times = [replace(one, time_to={**one.time_to, 0.1: time}) for one, time in ((naive, slow), (best, quick))]
    changed = replace(scene, strategies=(times[0], cut, times[1]))
    rows = latex_table(replace(found, scenes=(changed,))).splitlines()
    assert heads(rows)[2:4] == [r"time to 10\,\%", r"time to 5\,\% [s]"]
    assert r" & 2.00\,h (1.94 to 2.06) & " in rows[7]
    assert r" & 3.0\,ms (2.0 to 4.0) & " in rows[9]


def test_the_last_columns_have_the_speed_ups_over_the_baseline_to_every_target(tmp_path: Path) -> None:
    found = replace(summary(tmp_path), targets=(0.1, 0.05))
    (scene,) = found.scenes
    far = Interval(16.0, 14.0, 18.0, note=BEYOND, reach=2.0)
    cut = replace(scene.strategies[1], ratio={**scene.strategies[1].ratio, 0.05: far})
    strategies = (scene.strategies[0], cut, scene.strategies[2])
    rows = latex_table(replace(found, scenes=(replace(scene, strategies=strategies),))).splitlines()
    assert heads(rows)[-2:] == [r"speed-up over naive to 10\,\%", r"speed-up over naive to 5\,\%"]
    assert rows[8].split(" & ")[-2] == "16.0 (14.4 to 17.6)"
    last = [row.rpartition(" & ")[2] for row in rows[7:10]]
    assert last == [
        r"1 \\",
        r"16 (14 to 18)$^*$ \\",
        r"64 (58 to 70) \\",
    ]
    none = (replace(one, ratio=dict.fromkeys(one.ratio, UNKNOWN)) for one in scene.strategies)
    assert "speed-up over" not in latex_table(replace(found, scenes=(replace(scene, strategies=tuple(none)),)))


def test_a_limit_for_want_of_a_time_has_its_own_sign_and_the_gain_beside_it(tmp_path: Path) -> None:
    """Such a limit is trusted: only a number with a doubtful lower end is "at most"."""
    found = replace(summary(tmp_path), targets=(0.1,))
    (scene,) = found.scenes
    naive, cut, best = scene.strategies
    never = Interval(math.inf, 1e5, math.inf).noted("not reached in 100 times the longest run")
    gain = Interval(0.0159, 0.0142, 0.0176)
    slow = replace(cut, biased=False, time_to={0.1: never}, ratio={0.1: Interval(0.0, 0.0, 0.0855)}, efficiency=gain)
    table = latex_table(replace(found, scenes=(replace(scene, strategies=(naive, slow, best)),)))
    assert r"& not reached & $<$ 0.0855 \\" in table
    assert "\n$<$: less than, since the strategy does not reach the error in 100 times its longest run" in table
    assert r"median over pairs of runs): cut 0.0159$\times$ (0.0142 to 0.0176)\par" in table
    assert "cannot be trusted" not in table
    assert "\nnot reached: in 100 times the longest run; by a biased strategy, in its runs" in table
    faster = replace(best, ratio={0.1: Interval(math.inf, 11.7, math.inf)})
    table = latex_table(replace(found, scenes=(replace(scene, strategies=(naive, faster)),)))
    assert "\n$>$: more than, since the baseline does not reach the error in 100 times its longest run" in table


def test_columns_without_any_number_are_left_out_and_named(tmp_path: Path) -> None:
    found = summary(tmp_path)
    (scene,) = found.scenes
    doubted = [
        replace(
            one,
            time_to={**one.time_to, 0.02: UNKNOWN},
            ratio={**one.ratio, 0.02: UNKNOWN, 0.01: UNKNOWN},
        )
        for one in scene.strategies
    ]
    table = latex_table(replace(found, scenes=(replace(scene, strategies=tuple(doubted)),)))
    assert [head.rpartition(" to ")[2].partition(" ")[0] for head in heads(table.splitlines())[2:]] == [
        *(r"10\,\%", r"5\,\%", r"1\,\%", r"10\,\%", r"5\,\%")
    ]
    assert (
        "\nleft out, since no number is known: time to 2\\,\\%, speed-up to 2\\,\\%, speed-up to 1\\,\\%\\par" in table
    )
    assert "--" not in table


def test_the_table_is_written_into_a_new_folder(tmp_path: Path) -> None:
    found = summary(tmp_path / "runs")
    write_latex(found, tmp_path / "figures" / "table.tex")
    assert (tmp_path / "figures" / "table.tex").read_text() == latex_table(found)
