"""JSON is what every reader takes: no command prints NaN or Infinity, whatever there is to tell."""

from __future__ import annotations

import ast
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equaltime.bench import Report
from equaltime.cli import COMMANDS, main
from equaltime.cost import single_run
from equaltime.strict_json import json_text

CORNELL = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
PACKAGE = Path(__file__).parents[2] / "python" / "equaltime"
DARK = """
[integrator]
type = "path"
max_depth = 2
[sensor]
type = "perspective"
[sensor.film]
type = "hdrfilm"
width = 8
height = 8
[lamp]
type = "point"
position = [0, 0, 5]
intensity = 0
"""
COMMANDS_WITH_JSON = {
    "render": ["SCENE", "-o", "a.exr", "--spp", "2", "--error", "50%"],
    "quote": ["LIT", "--size", "8x8", "--error", "50%", "--why"],
    "cost": ["SCENE", "-o", "out", "--quick", "--strategies", "best", "--repeats", "1", "--budget", "10ms"],
    "effects": ["LIT", "--size", "8x8", "--max-depth", "2", "--quick"],
    "compare": ["ONE.exr", "TWO.exr"],
    "merge": ["ONE.exr", "TWO.exr", "-o", "both.exr"],
    "info": ["ONE.exr"],
    "lint": ["SCENE"],
    "replay": ["SCENE", "--pixel", "1,1", "--sample", "0"],
    "bench": ["SCENE", "--repeats", "1", "--spp", "1"],
    "selftest": ["--only", "C1"],
}


def refuse(number: str) -> None:
    raise AssertionError(f"{number} is no JSON")


def strictly(text: str) -> Any:
    return json.loads(text, parse_constant=refuse)


def test_a_number_that_is_not_finite_is_null() -> None:
    data = {"a": [math.nan, math.inf, (-math.inf, 1.5)], "b": {"c": np.float64("nan"), 0.5: True}, "d": None, "e": "é"}
    assert strictly(json_text(data)) == {
        **{"a": [None, None, [None, 1.5]], "b": {"c": None, "0.5": True}},
        **{"d": None, "e": "é"},
    }
    assert json_text({"b": Path("p"), "a": "é"}, sort_keys=True, ensure_ascii=False, default=str, indent=1) == (
        '{\n "a": "é",\n "b": "p"\n}'
    )


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> dict[str, str]:
    """A scene that is black everywhere, and two renders of it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(single_run, "flip", lambda image, truth: 0.5)
    (tmp_path / "dark.toml").write_text(DARK)
    for seed, name in enumerate(("one.exr", "two.exr")):
        assert main(["render", "dark.toml", "-o", name, "--spp", "4", "--seed", str(seed), "-q"]) == 0
    capsys.readouterr()
    return {"SCENE": "dark.toml", "LIT": str(CORNELL), "ONE.exr": "one.exr", "TWO.exr": "two.exr"}


@pytest.mark.parametrize("command", COMMANDS_WITH_JSON)
def test_every_command_prints_json_that_every_reader_takes(
    files: dict[str, str], command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [files.get(word, word) for word in COMMANDS_WITH_JSON[command]]
    assert main([command, *words, "--json"]) == (1 if command == "lint" else 0), capsys.readouterr().err
    assert strictly(capsys.readouterr().out)


def test_numbers_that_are_not_finite_are_printed_as_null(
    files: dict[str, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Report, "as_dict", lambda self: {"rate": math.inf, "ratios": [math.nan]})
    assert main(["bench", files["SCENE"], "--repeats", "1", "--spp", "1", "--json"]) == 0
    assert strictly(capsys.readouterr().out) == {"rate": None, "ratios": [None]}


def test_every_command_that_prints_json_is_tried() -> None:
    modules = {file.stem for file in (PACKAGE / "cli").glob("*.py") if '"--json"' in file.read_text()}
    assert modules == set(COMMANDS_WITH_JSON) <= {command.__name__ for command in COMMANDS}


def test_nothing_writes_json_that_may_hold_other_numbers() -> None:
    loose = [
        f"{file.relative_to(PACKAGE)}:{call.lineno}"
        for file in PACKAGE.rglob("*.py")
        for call in calls_of_dumps(ast.parse(file.read_text()))
        if not any(keyword.arg == "allow_nan" for keyword in call.keywords)
    ]
    assert loose == []


def calls_of_dumps(tree: ast.AST) -> Iterator[ast.Call]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("json.dumps", "json.dump"):
            yield node
