"""The interval: how it prints in a unit, and how it comes back from JSON."""

import json
import math
from dataclasses import replace

import pytest

import equaltime as et
from equaltime.film.error import UNKNOWN_ERROR
from equaltime.statistics.intervals import UNKNOWN, Interval


@pytest.mark.parametrize(
    ("unit", "text"),
    [
        ("", "0.0231 (0.0228 to 0.0234)"),
        ("%", "2.31 % (2.28 to 2.34)"),
        ("s", "23.1 ms (22.8 to 23.4)"),
        ("spp", "0.0231 spp (0.0228 to 0.0234)"),
        ("MB", "0.0000000231 MB (0.0000000228 to 0.0000000234)"),
    ],
)
def test_a_unit_is_a_format(unit: str, text: str) -> None:
    assert format(Interval(0.0231, 0.0228, 0.0234), unit) == text


def test_a_representation_is_short_and_has_all_digits() -> None:
    assert repr(Interval(1 / 3, 0.25, 0.5)) == "Interval(0.3333333333333333, 0.25, 0.5)"
    doubted = Interval(1.0, 0.5, math.inf).doubted("heavy tail")
    assert repr(doubted) == "Interval(1.0, 0.5, inf, trusted=False, note='heavy tail')"
    assert Interval(0.2, 0.1, 0.3)._repr_html_() == "<pre>0.20 (0.10 to 0.30)</pre>"


def test_a_unit_that_does_not_exist_is_refused() -> None:
    with pytest.raises(ValueError, match="'kg' is no unit"):
        format(Interval(1.0, 1.0, 1.0), "kg")


def test_what_is_not_a_number_is_a_word() -> None:
    assert f"{Interval(0.0, 0.0, math.inf):%}" == "0 % (0 to unknown)"
    assert f"{Interval(math.inf, 900.0, math.inf):s}" == "never"
    assert [str(unknown) for unknown in (UNKNOWN, UNKNOWN_ERROR)] == ["unknown", "unknown"]


@pytest.mark.parametrize(
    "said",
    [
        Interval(3.0, 2.5, 3.5),
        Interval(3.0, 2.5, math.inf),
        Interval(math.inf, 900.0, math.inf),
        Interval(3.0, 2.5, 3.5).doubted("heavy tail"),
        Interval(3.0, 2.5, 3.5).bounded("low", "one repeat missed light"),
        Interval(3.0, 2.5, 3.5, note="extrapolated", reach=4.0),
    ],
)
def test_an_interval_comes_back_from_json(said: Interval) -> None:
    assert Interval.from_dict(json.loads(json.dumps(said.as_dict()))) == said


@pytest.mark.parametrize("unknown", [UNKNOWN, UNKNOWN_ERROR])
def test_an_unknown_number_is_null_in_json(unknown: Interval) -> None:
    data = unknown.as_dict()
    assert (data["value"], data["high"]) == (None, None)
    back = Interval.from_dict(json.loads(json.dumps(data)))
    assert not back.known
    assert math.isnan(back.value)
    assert back.trusted == unknown.trusted


def test_the_keys_of_an_ordinary_interval_are_four() -> None:
    assert Interval(3.0, 2.5, 3.5).as_dict() == {"value": 3.0, "low": 2.5, "high": 3.5, "trusted": True}


def test_intervals_of_earlier_files_are_read() -> None:
    old = {"value": 0.02, "low": 0.01, "high": None, "unit": "%"}
    assert Interval.from_dict(old) == Interval(0.02, 0.01, math.inf)
    assert Interval.from_dict(old | {"doubt": "heavy tail"}) == Interval(0.02, 0.01, math.inf).doubted("heavy tail")


def test_noise_and_bias_make_the_error_with_the_doubts_of_both() -> None:
    noise, bias = Interval(0.3, 0.3, 0.6), Interval(0.4, 0.4, 0.8)
    assert noise.with_bias(None) is noise
    assert noise.with_bias(bias) == Interval(0.5, 0.5, 1.0)
    doubted = noise.doubted("of the noise").with_bias(bias.doubted("of the bias"))
    assert doubted.doubt == "of the noise; of the bias"
    assert replace(doubted, trusted=True).doubt == ""


def test_an_estimate_is_an_interval() -> None:
    assert et.Estimate is et.Interval
