"""Numbers in outputs: two digits, and one unit for a value and its interval."""

from __future__ import annotations

import math
import re

import pytest

from equaltime.experiments.report.words import seconds_cell
from equaltime.statistics.in_words import about, in_percent, in_time, rounded, span
from equaltime.statistics.intervals import UNKNOWN, Interval


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0.0, "0"),
        (0.0351, "0.035"),
        (1.96, "2.0"),
        (9.96, "10"),
        (118.0, "120"),
        (12345.0, "12,000"),
        (float("inf"), "inf"),
    ],
)
def test_a_number_has_two_digits_and_no_exponent(number: float, text: str) -> None:
    assert rounded(number) == text


def test_an_interval_has_one_unit() -> None:
    assert f"{Interval(350.0, 237.0, 708.0):s}" == "5.8 min (4.0 to 12)"
    assert f"{Interval(18000.0, 9600.0, 31800.0):s}" == "5.0 h (2.7 to 8.8)"
    assert str(seconds_cell(Interval(18000.0, 9600.0, 31800.0))).startswith("5.0\N{NARROW NO-BREAK SPACE}h ")
    assert f"{Interval(64440.0, 5664.0, 3.6e6):s}" == "18 h (1.6 to 1,000)"
    assert f"{Interval(30.0, 30.0, 30.0):s}" == "30 s"
    assert f"{Interval(0.0171, 0.0149, 0.0196):%}" == "1.7 % (1.5 to 2.0)"
    assert f"{Interval(0.0171, 0.0149, math.inf):%}" == "1.7 % (1.5 to unknown)"
    assert f"{UNKNOWN:%}" == "unknown"


def test_an_interval_has_as_many_digits_as_tell_its_number_from_its_ends() -> None:
    assert f"{Interval(0.0844, 0.0751, 0.0969):%}" == "8.4 % (7.5 to 9.7)"
    assert f"{Interval(0.034567, 0.034512, 0.0357):%}" == "3.46 % (3.45 to 3.57)"
    assert f"{Interval(0.5, 0.5, 0.62)}" == "0.50 (0.50 to 0.62)", "the number is its lower end"


def test_a_number_of_few_digits_stays_within_its_interval() -> None:
    assert about(Interval(1.26, 1.2, 1.31)) == "1.3"
    assert about(Interval(1.26, 1.2, 1.27)) == "1.26"
    assert about(Interval(1.0442, 1.0438, 1.0446)) == "1.0442"


def test_an_end_of_a_ratio_stays_on_its_side_of_one() -> None:
    assert span(Interval(1.2, 1.03, 1.8)) == "(1.03 to 1.8)"
    assert span(Interval(1.2, 0.996, 1.8)) == "(0.996 to 1.8)"
    assert span(Interval(1.2, 1.0, 1.8)) == "(1 to 1.8)"


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((12.34, 8.12, 20.1), "12 s (8 to 20)"),
        ((12.34, 12.31, 12.37), "12.34 s (12.31 to 12.37)"),
        ((46.0, 0.33, 254.4), "46 s (0.33 to 254)"),
        ((2.0, 2.0, 2.0), "2 s (2 to 2)"),
        ((9.2, 7.1, 11.3), "9.2 s (7.1 to 11.3)"),
    ],
)
def test_a_sentence_has_the_digits_of_the_table(numbers: tuple[float, float, float], text: str) -> None:
    """Only the zeros at the end are left out."""
    found = Interval(*numbers)
    assert in_time(found) == text
    cell = str(seconds_cell(found)).replace("\N{NARROW NO-BREAK SPACE}", " ")
    plain = re.sub(r"(\.\d*?)0+(?=\D|$)", lambda match: match[1].rstrip("."), cell)
    assert plain == text
    assert in_percent(found.map(lambda seconds: 0.01 * seconds)) == text.replace(" s ", " % ")
