"""The account of a file: a line for each kind, with its count and its first place."""

from __future__ import annotations

import pytest

from equaltime.errors import SceneError
from equaltime.scene.report import MOST_KINDS, Account, Report
from equaltime.scene.tree import Place


def test_each_kind_is_told_once_with_its_first_place_and_its_count() -> None:
    account = Account()
    for line, kind in enumerate(["'Ks' is not used", "'Ns' is not used", "'Ks' is not used"], 1):
        account.tell(kind, f"a.mtl:{line}")
    assert list(account) == ["a.mtl:1: 'Ks' is not used (first of 2)", "a.mtl:2: 'Ns' is not used"]


def test_an_account_of_nothing_is_silent() -> None:
    assert list(Account()) == []


def test_a_file_that_is_broken_all_over_takes_few_lines() -> None:
    account = Account()
    for line in range(10 * MOST_KINDS):
        account.tell(f"'{line % (2 * MOST_KINDS)}' is unknown", line)
    told = list(account)
    assert len(told) == MOST_KINDS + 1
    assert told[0] == "0: '0' is unknown (first of 5)"
    assert told[-1] == f"and {5 * MOST_KINDS} more statements of other kinds are not used"


def test_what_is_wrong_within_a_value_is_told_once() -> None:
    report = Report()
    place = Place("a.toml", 42, "left.bsdf")
    report.add(place.key("reflectance").key("filename"), "no such file: wood.png")
    report.add(place, "no such file: wood.png")
    report.add(place, "something else")
    report.add(Place("a.toml", 43, "left.bsdf2"), "no such file: wood.png")
    with pytest.raises(SceneError) as told:
        report.raise_if_any()
    assert [problem.place for problem in told.value.problems] == [
        "a.toml:42: left.bsdf.reflectance.filename",
        "a.toml:42: left.bsdf",
        "a.toml:43: left.bsdf2",
    ]
