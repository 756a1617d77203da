"""The table of hard cases in README.md: every case has a row, and every test that a row names is there."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COUNTS = {"G": 23, "S": 30, "T": 14, "E": 14, "C": 7}
IDS = [f"{letter}{number}" for letter, count in COUNTS.items() for number in range(1, count + 1)]
ROW = re.compile(r"^\| ([GSTEC]\d+) \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)
NAMED = re.compile(r"`([\w/]+\.(?:py|cpp))(?:::([^`]+))?`")
ROWS = {match[1]: match.groups()[1:] for match in ROW.finditer((ROOT / "tests/hard/README.md").read_text())}


Named = tuple[str, str]
"""File and name of a test; of C++ the beginning of its sentence."""


@cache
def sources(file: str) -> dict[str, str]:
    """Return the tests of a file by name, each with what decorates it; of C++ by sentence."""
    path = ROOT / file if "/" in file else ROOT / "tests/hard" / file
    text = path.read_text() if path.is_file() else ""
    if path.suffix == ".cpp":
        return {part.split('"')[0]: part for part in text.split('\nTEST("')[1:]}
    lines = text.splitlines()
    functions = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    first = {node.name: min(part.lineno for part in (node, *node.decorator_list)) - 1 for node in functions}
    return {node.name: "\n".join(lines[first[node.name] : node.end_lineno]) for node in functions}


def source(one: Named) -> str:
    """Return the text of a test; nothing if it is not there."""
    file, name = one
    exact = file.endswith(".py")
    return next(
        (text for key, text in sources(file).items() if name and (key == name if exact else key.startswith(name))), ""
    )


_SEES = re.compile(r"twin|reject|undone|would|wrong|is_seen|are_seen|does change|does_change|without it|is_found")
"""What a twin says of itself."""


def named(cell: str) -> list[Named]:
    return NAMED.findall(cell)


def applies(case: str) -> bool:
    return not ROWS[case][1].startswith("does not apply:")


def test_every_case_of_the_catalogue_has_a_row() -> None:
    assert len(IDS) == 88
    assert list(ROWS) == IDS


@pytest.mark.parametrize("case", IDS)
def test_every_test_that_a_row_names_is_there(case: str) -> None:
    _, test, twin = ROWS[case]
    assert named(test) or not applies(case), "a test, or why there is none"
    assert named(twin) or twin == "in it" or not applies(case), "a twin"
    assert [one for cell in (test, twin) for one in named(cell) if not source(one)] == []


@pytest.mark.parametrize("case", [case for case in IDS if applies(case)])
def test_every_case_is_tested_every_day_and_has_a_twin_that_sees_something(case: str) -> None:
    _, test, twin = ROWS[case]
    texts = [source(one) for one in named(test)]
    assert not all("pytest.mark.slow" in text for text in texts)
    assert not any("xfail" in text or "mark.skip(" in text for text in texts)
    twins = named(twin)
    assert not set(twins) & set(named(test)), "it would be in it"
    if twins:
        assert all(_SEES.search(source(one)) for one in twins)
    else:
        assert any("twin" in text for text in texts)


def test_a_test_that_is_not_there_is_found_to_be_missing() -> None:
    """The twin."""
    assert not source(("cpp/tests/sampling/test_mis.cpp", "weights of any kind"))
    assert not source(("test_catalogue.py", "test_of_nothing"))
    assert not source(("test_nowhere.py", "test_of_nothing"))
    assert "twin" in source(("test_catalogue.py", "test_a_test_that_is_not_there_is_found_to_be_missing"))
    assert "twin" not in source(("test_catalogue.py", "test_every_case_of_the_catalogue_has_a_row"))
    assert "slow" in source(("test_geometry.py", "test_G11_of_ten_million_rays_none_escapes"))
    assert "slow" not in source(("test_geometry.py", "test_G11_no_ray_escapes_between_two_triangles"))
    assert "squares" in source(("cpp/tests/sampling/test_mis.cpp", "the same test rejects"))


def test_every_test_here_that_is_named_by_a_case_is_one_of_the_catalogue() -> None:
    names = re.findall(
        r"def test_([GSTEC])0?(\d+)_", "".join(p.read_text() for p in Path(__file__).parent.glob("*.py"))
    )
    assert {letter + number for letter, number in names} <= set(IDS)
