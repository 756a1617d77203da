"""The account of a file: a line for each kind, with its count and its first place."""

from __future__ import annotations

from equaltime.scene.report import MOST_KINDS, Account


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
