"""How the command line writes numbers."""

import math

import pytest

from equaltime.cli.messages import once_each, print_error, while_heard
from equaltime.words import duration, seconds_of


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0 ms"),
        (0.01234, "12.3 ms"),
        (0.9996, "1 s"),
        (4.56, "4.56 s"),
        (299.0, "299 s"),
        (2040.0, "34 min"),
        (18001.0, "5 h"),
        (1e6, "11.6 days"),
        (math.inf, "inf days"),
    ],
)
def test_a_time_is_written_in_the_unit_that_people_would_use(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize("seconds", [0.0123, 4.56, 2040.0, 18000.0, 950400.0, 1e9])
def test_a_time_that_is_written_can_be_read_again(seconds: float) -> None:
    assert seconds_of(duration(seconds)) == pytest.approx(seconds, rel=5e-3)  # three digits are written


def test_what_nobody_hears_any_more_is_said_once_and_harms_nobody() -> None:
    tried: list[str] = []

    def say(words: str) -> None:
        tried.append(words)
        raise BrokenPipeError

    said = while_heard(say)
    said("one")
    said("two")
    assert tried == ["one"]


def test_a_problem_with_a_line_separator_of_unicode_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    print_error("a\u2028b\x85c\x0cd\nsecond")
    assert capsys.readouterr().err == "error: a\\u2028b\\x85c\\x0cd\nerror: second\n"


def test_warnings_that_differ_by_place_or_file_name_alone_are_told_once() -> None:
    lost = [f"a.mtl:{line}: the image 'lost{line}.png' is left out: no such file" for line in (3, 5, 8)]
    other = [
        "a.mtl:4: 'Ks' is not used: gloss comes from Pr and Pm alone",
        "a.mtl:6: 'Ni' is not used: surfaces are diffuse",
    ]
    told = once_each([lost[0], other[0], *lost[1:], other[1]])
    assert told == [f"{lost[0]} (and 2 more like it: lint -v)", *other]
