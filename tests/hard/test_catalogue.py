"""The table of hard cases in README.md: every case has a row, and every test that a row names is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COUNTS = {"G": 19, "S": 28, "T": 14, "E": 14, "C": 7}
IDS = [f"{letter}{number}" for letter, count in COUNTS.items() for number in range(1, count + 1)]
ROW = re.compile(r"^\| ([GSTEC]\d+) \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)
NAMED = re.compile(r"`([\w/]+\.(?:py|cpp))(?:::([^`]+))?`")
ROWS = {match[1]: match.groups()[1:] for match in ROW.finditer((ROOT / "tests/hard/README.md").read_text())}


def is_there(file: str, name: str | None) -> bool:
    """Tell whether a file has a test: a Python function, or a sentence of C++."""
    path = ROOT / file if "/" in file else ROOT / "tests/hard" / file
    if not path.is_file():
        return False
    text = path.read_text()
    return name is None or (f"def {name}(" in text if path.suffix == ".py" else f'TEST("{name}' in text)


def test_every_case_of_the_catalogue_has_a_row() -> None:
    assert len(IDS) == 82
    assert list(ROWS) == IDS


@pytest.mark.parametrize("case", IDS)
def test_every_test_that_a_row_names_is_there(case: str) -> None:
    _, test, twin = ROWS[case]
    assert NAMED.findall(test) or test.startswith("does not apply:"), "a test, or why there is none"
    assert NAMED.findall(twin) or twin == "in it" or test.startswith("does not apply:"), "a twin"
    missing = [
        named for cell in (test, twin) for named in NAMED.findall(cell) if not is_there(named[0], named[1] or None)
    ]
    assert missing == []


def test_a_test_that_is_not_there_is_found_to_be_missing() -> None:
    """The twin."""
    assert not is_there("cpp/tests/test_mis.cpp", "weights of any kind")
    assert not is_there("test_catalogue.py", "test_of_nothing")
    assert not is_there("test_nowhere.py", None)


def test_every_test_here_that_is_named_by_a_case_is_one_of_the_catalogue() -> None:
    names = re.findall(
        r"def test_([GSTEC])0?(\d+)_", "".join(p.read_text() for p in Path(__file__).parent.glob("*.py"))
    )
    assert {letter + number for letter, number in names} <= set(IDS)
