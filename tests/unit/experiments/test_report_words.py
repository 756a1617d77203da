"""Numbers as the report prints them, and the looks that strategies get."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from importlib import resources

import jinja2
import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.experiments.model.summary import Summary
from equaltime.experiments.report.footnotes import remarks, shared_remarks
from equaltime.experiments.report.looks import DARK, LIGHT, MARKERS, looks
from equaltime.experiments.report.tables import Table, TableRow
from equaltime.experiments.report.words import (
    Cell,
    error_cell,
    factor_cell,
    measured_cell,
    percent,
    plain_cell,
    provenance_groups,
    seconds,
    seconds_cell,
    slug,
    spread_sentence,
    worker_runs,
)
from equaltime.statistics.curves import time_to_error
from equaltime.statistics.intervals import UNKNOWN, Interval

from .made_up_runs import power_law

THIN, MINUS, TIMES = "\N{NARROW NO-BREAK SPACE}", "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}"


@pytest.mark.parametrize(
    ("interval", "text"),
    [
        (Interval(4.12, 3.91, 4.37), f"4.1{THIN}s (3.9 to 4.4)"),
        (Interval(0.0412, 0.0391, 0.0437), f"41{THIN}ms (39 to 44)"),
        (Interval(5000.0, 4990.0, 5010.0), f"83.33{THIN}min (83.17 to 83.50)"),
        (Interval(2.0, 2.0, 2.0), f"2.00{THIN}s (2.00 to 2.00)"),
        (Interval(46.0, 0.328, 16255.0), f"46{THIN}s (0.33 to 16,255)"),
        (Interval(9.0, 1.24, 49.0), f"9.0{THIN}s (1.2 to 49)"),
        (Interval(0.2, 0.012, 7.0), f"200{THIN}ms (12 to 7,000)"),
        (Interval(3.0, 0.0, 6.0), f"3.0{THIN}s (0.0 to 6.0)"),
    ],
)
def test_a_time_has_the_digits_that_its_interval_allows(interval: Interval, text: str) -> None:
    assert str(seconds_cell(interval)) == text


def test_a_speed_up_has_a_multiplication_sign_and_a_negative_error_a_minus_sign() -> None:
    assert str(factor_cell(Interval(31.0, 27.0, 35.0))) == f"31{TIMES} (27 to 35)"
    assert str(error_cell(Interval(0.001, -0.002, 0.003))) == f"0.10{THIN}% ({MINUS}0.20 to 0.30)"


def test_thousands_have_a_comma_as_in_sentences() -> None:
    assert str(factor_cell(Interval(51193.0, 41000.0, 62000.0))) == f"51,193{TIMES} (41,000 to 62,000)"


def test_an_interval_that_cannot_be_trusted_shows_its_reason_and_no_number() -> None:
    cell = seconds_cell(Interval(12.5, 3.0, 40.0).doubted("only 2 repeats"))
    assert (cell.text, cell.interval, cell.note, cell.state) == ("not trusted", "", "only 2 repeats", "untrusted")


def test_of_a_number_with_one_end_that_holds_that_end_is_printed() -> None:
    heavy = Interval(30.0, 25.0, 36.0).bounded("low", "heavy tail")
    cell = factor_cell(heavy)
    assert (cell.text, cell.interval, cell.state) == (
        "\N{GREATER-THAN OR EQUAL TO} 25\N{MULTIPLICATION SIGN}",
        "",
        "untrusted",
    )
    assert factor_cell(heavy.map(lambda x: 1.0 / x)).text.startswith("\N{LESS-THAN OR EQUAL TO} 0.04")
    assert factor_cell(heavy.doubted("two repeats")).text == "not trusted"


def test_a_measured_error_with_one_end_that_holds_shows_the_measured_value_too() -> None:
    heavy = Interval(2.04, 1.65, 9.0).bounded("low", "heavy tail")
    assert str(measured_cell(heavy)) == f"\N{GREATER-THAN OR EQUAL TO} 165{THIN}% (measured 204{THIN}%)"
    plain = Interval(0.1155, 0.1145, 0.1164)
    assert measured_cell(plain) == error_cell(plain)
    assert measured_cell(heavy.doubted("two repeats")).interval == ""


def test_an_interval_without_ends_is_not_trusted_whatever_it_says() -> None:
    assert factor_cell(Interval(2.0, -math.inf, math.inf)).state == "untrusted"


def test_what_is_not_reached_and_what_is_not_known_are_words() -> None:
    assert seconds_cell(Interval(math.inf, math.inf, math.inf, note="it is biased")).text == "not reached"
    assert factor_cell(Interval(math.inf, math.inf, math.inf)).text == "unknown"
    assert seconds_cell(UNKNOWN).text == "unknown"


def test_short_numbers_have_up_to_three_digits() -> None:
    assert [percent(value) for value in (0.1, 0.05, 0.00316, 7.71)] == [
        f"{text}{THIN}%" for text in ("10", "5", "0.316", "771")
    ]
    assert [seconds(value) for value in (0.05, 1.0, 12.34, 7140.0, 7200.0)] == [
        f"50{THIN}ms",
        f"1{THIN}s",
        f"12.3{THIN}s",
        f"119{THIN}min",
        f"2{THIN}h",
    ]


def test_a_slug_is_a_safe_file_name_and_unique() -> None:
    assert slug("../../etc/<b>Passwd</b>") == "etc-b-passwd-b"
    assert slug("Box", ["box", "box-2"]) == "box-3"
    assert slug("\N{SNOWMAN}") == "scene"
    assert len(slug("x" * 1000)) <= 64


def test_the_baseline_has_the_first_look_wherever_it_stands() -> None:
    found = looks(["best", "mis", "naive"], "naive")
    assert [found[label].index for label in ("naive", "best", "mis")] == [0, 1, 2]


def test_nobody_but_the_baseline_is_grey() -> None:
    found = looks([str(number) for number in range(29)], "0")
    assert [label for label, look in found.items() if look.index == 0] == ["0"]


def test_no_two_of_many_strategies_look_the_same() -> None:
    found = looks([str(number) for number in range(29)], "0")
    assert len({(look.light, look.marker, look.line) for look in found.values()}) == 29
    assert len(set(MARKERS)) == len(LIGHT) == len(DARK)


def linear(colour: str) -> NDArray[np.float64]:
    """Return linear RGB of ``#rrggbb``."""
    encoded = np.array([int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)])
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of WCAG 2.2."""
    low, high = sorted(float(linear(colour) @ (0.2126, 0.7152, 0.0722)) + 0.05 for colour in (one, other))
    return high / low


@pytest.mark.parametrize(("colours", "page"), [(LIGHT, "#ffffff"), (DARK, "#14171c")])
def test_every_colour_stands_out_from_the_page(colours: tuple[str, ...], page: str) -> None:
    assert min(contrast(colour, page) for colour in colours) >= 3.0


SIGHTS = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
"""How linear RGB looks with each colour blindness: Machado, Oliveira & Fernandes 2009, severity 1."""


def lab(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return CIE L*a*b* (D65) of linear sRGB."""
    matrix = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = np.maximum(matrix @ rgb / (0.9505, 1.0, 1.089), 0.0)
    x, y, z = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16.0 / 116.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
def test_colours_are_told_apart_with_every_kind_of_sight(colours: tuple[str, ...], sight: str) -> None:
    seen = [lab(np.asarray(SIGHTS[sight]) @ linear(colour)) for colour in colours]
    assert min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(seen, 2)) >= 10.0


def test_footnotes_are_said_once_and_those_that_differ_in_a_number_together() -> None:
    notes = ("extrapolated 3.6 times", "heavy tail; extrapolated 12 times", "baseline: heavy tail; this: heavy tail")
    cells = [Cell("1", note=note) for note in notes]
    table = Table("slug", "caption", "corner", ("a",), tuple(TableRow("label", None, (), ((cell,),)) for cell in cells))
    assert table.footnotes == ("extrapolated 3.6 to 12 times", "heavy tail", "baseline: heavy tail")
    assert [table.marks(cell) for cell in cells] == [("1",), ("1", "2"), ("2", "3")]


def test_marks_of_several_footnotes_do_not_run_together() -> None:
    files = resources.files("equaltime.experiments.report") / "template"
    loader = jinja2.FunctionLoader(lambda name: (files / name).read_text("utf-8"))
    number = jinja2.Environment(loader=loader, autoescape=True).get_template("parts.html").module.number
    cell = Cell("1", note="one; two")
    table = Table("slug", "", "", ("a",), (TableRow("label", None, (), ((cell,),)),))
    assert re.sub("<.*?>", "", str(number(table, cell))).endswith("1,2")


def test_remarks_that_differ_in_several_numbers_are_one_footnote() -> None:
    notes = ("5 of 6 renders: one in 10,000: 16 samples", "6 of 6 renders: one in 25: 8 samples")
    cells = [Cell("1", note=note) for note in notes]
    table = Table("slug", "caption", "corner", ("a",), tuple(TableRow("label", None, (), ((cell,),)) for cell in cells))
    assert table.footnotes == ("5 to 6 of 6 renders: one in 25 to 10,000: 8 to 16 samples",)


def test_a_long_remark_of_several_tables_has_a_letter_and_leaves_the_numbers_to_others() -> None:
    long = f"{{}} renders: {'light is missing ' * 9}"
    cells = [Cell("1", note=note) for note in (long.format(5), "heavy tail", f"{long.format(9)}; heavy tail")]
    shared = shared_remarks([cells[:1], cells[1:]])
    assert list(shared.values()) == [long.format("5 to 9")]
    assert not shared_remarks([cells]), "one table has room for its own"
    assert not shared_remarks([cells[1:2], cells[2:]]).keys() & {"heavy tail"}, "a short remark stands where it is used"
    rows = tuple(TableRow("label", None, (), ((cell,),)) for cell in cells)
    table = Table("slug", "caption", "corner", ("a",), rows, shared=tuple(shared))
    assert table.footnotes == ("heavy tail",)
    assert [table.marks(cell) for cell in cells] == [("a",), ("1",), ("1", "a")]
    assert [table.address(mark) for mark in ("1", "a")] == ["slug-note-1", "notes_a"]


def test_extrapolation_is_said_in_plain_words() -> None:
    notes = (
        "extrapolated 1.33 times beyond the longest run by slope -1/2",
        "extrapolated 1e+04 times beyond the longest",
    )
    cells = [
        Cell("1", note=note)
        for note in (*notes, "this: extrapolated 3 times before the first measurement by the fitted slope")
    ]
    table = Table("slug", "caption", "corner", ("a",), tuple(TableRow("label", None, (), ((cell,),)) for cell in cells))
    assert list(table.footnotes) == [
        "extrapolated beyond the longest run, 1.33 to 10,000 times as long",
        "extrapolated before the first measurement, which was 3 times later: the curve is carried back with the slope "
        "of its first three doublings of time",
    ]


def test_a_time_before_the_first_measurement_says_how_it_is_made() -> None:
    early = time_to_error(replace(power_law(), independent=True), 0.9)
    (remark,) = remarks(seconds_cell(early))
    assert remark.startswith("extrapolated before the first measurement, which was 1.6")
    assert remark.endswith(" times later: the curve is carried back with slope -1/2")
    assert early.trusted
    assert early.reach > 1.0


def test_numbers_in_the_names_of_scenes_are_left_alone() -> None:
    notes = ("on roughness 0.3 it has no speed-up", "on roughness 0.01 it has no speed-up")
    cells = [Cell("1", note=note) for note in notes]
    table = Table("slug", "caption", "corner", ("a",), tuple(TableRow("label", None, (), ((cell,),)) for cell in cells))
    assert table.footnotes == notes


def test_what_is_no_number_is_printed_nevertheless() -> None:
    assert percent(math.inf) == f"\N{INFINITY}{THIN}%"
    assert percent(math.nan).startswith("unknown")


def test_numbers_with_powers_of_ten_are_compared_whole_and_spelt_out() -> None:
    notes = ("extrapolated 1.37e+03 times", "extrapolated 45 times", "extrapolated 7.14e+05 times", "3e+04 others")
    cells = [Cell("1", note=note) for note in notes]
    table = Table("slug", "caption", "corner", ("a",), tuple(TableRow("label", None, (), ((cell,),)) for cell in cells))
    assert list(table.footnotes) == [
        "extrapolated 45 to 714,000 times",
        "30,000 others",
    ]


def test_the_end_of_a_time_that_holds_has_the_unit_that_suits_it() -> None:
    tail = Interval(86_400.0, 0.05, 1e9).bounded("low", "heavy tail")
    assert seconds_cell(tail).text.replace("\N{NARROW NO-BREAK SPACE}", " ") == "\N{GREATER-THAN OR EQUAL TO} 50 ms"


def test_ends_of_a_ratio_beside_1_are_not_rounded_to_1() -> None:
    """They tell whether there is a difference; a time of 1 s may be rounded."""
    assert str(factor_cell(Interval(1.1, 1.002, 1.5))) == f"1.1{TIMES} (1.002 to 1.5)"
    assert str(factor_cell(Interval(0.9, 0.6, 0.998))) == f"0.90{TIMES} (0.60 to 0.998)"
    assert str(plain_cell(Interval(1.1, 1.002, 1.5))) == "1.1 (1.0 to 1.5)"


def test_a_ratio_to_what_is_never_reached_is_the_end_that_is_known() -> None:
    assert str(factor_cell(Interval(0.0, 0.0, 0.00017, note="baseline"))).startswith("< 0.00017")
    assert factor_cell(Interval(math.inf, 31.0, math.inf)).text == "> 31\N{MULTIPLICATION SIGN}"
    assert factor_cell(Interval(math.inf, 31.0, math.inf, trusted=False)).state != "trusted"
    assert factor_cell(Interval(0.5, 0.0, 0.6)).text.startswith("0.5")


def test_runs_of_a_cluster_are_told_by_machine_and_by_worker() -> None:
    workers = {
        "tcp://a:1": {"host": "node1", "ran": [["box", "best", 0], ["box", "mis", 1]]},
        "tcp://a:2": {"host": "node1", "ran": [["box", "best", 1]]},
        "tcp://b:1": {"host": "node0", "ran": [["box", "mis", 0]]},
    }
    found = Summary("", "", (), (), {"runs": 5, "workers": workers}, "")
    assert spread_sentence(found) == (
        "4 of 5 runs were spread over 2 like machines of a cluster: node0 (1), node1 (3)."
    )
    assert worker_runs(found)["tcp://a:1"] == "node1: box, best, 0; box, mis, 1"
    assert dict(provenance_groups(found))["workers"][1] == ("tcp://a:2", "node1: box, best, 1")
    alone = Summary("", "", (), (), {"runs": 2, "workers": {"tcp://b:1": workers["tcp://b:1"]}}, "")
    assert spread_sentence(alone) == "1 of 2 runs were given to 1 machine of a cluster: node0 (1)."
    assert spread_sentence(Summary("", "", (), (), {"runs": 5}, "")) == ""


def test_an_error_of_nothing_is_exact_and_a_useless_upper_end_is_left_out() -> None:
    assert error_cell(Interval(0.0, 0.0, 0.0)) == Cell("exact")
    far = measured_cell(Interval(40.0, 0.3, 4000.1))
    assert str(far) == f"\N{GREATER-THAN OR EQUAL TO} 30{THIN}% (measured 4,000{THIN}%)"
    assert "beyond 100 times" in far.note
    assert str(error_cell(Interval(0.4, 0.3, 39.9))).startswith(f"40{THIN}% (")
