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

from equaltime.bench import Benchmark
from equaltime.cli import COMMANDS, main
from equaltime.experiments.run import single_run
from equaltime.strict_json import json_text, to_json

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


def test_data_are_plain() -> None:
    value = {0.02: (float("nan"), 1, True, None, "x", Path("a"), np.int64(3), np.float32(0.5))}
    assert to_json(value) == {"0.02": [None, 1, True, None, "x", "a", 3, 0.5]}


def test_a_number_that_is_not_finite_is_null() -> None:
    data = {"a": [math.nan, math.inf, (-math.inf, 1.5)], "b": {"c": np.float64("nan"), 0.5: True}, "d": None, "e": "é"}
    assert strictly(json_text(data)) == {
        **{"a": [None, None, [None, 1.5]], "b": {"c": None, "0.5": True}},
        **{"d": None, "e": "é"},
    }
    assert json_text({"b": Path("p"), "a": "é"}, sort_keys=True, ensure_ascii=False, default=str, indent=1) == (
        '{\n "a": "é",\n "b": "p"\n}'
    )


def test_what_default_returns_has_no_such_number_either() -> None:
    assert json_text([{1}], default=lambda value: {"set": [math.nan, *value]}) == '[{"set": [null, 1]}]'


def test_a_key_that_is_not_finite_is_refused() -> None:
    for key in (math.nan, -math.inf):
        with pytest.raises(ValueError, match="not JSON compliant"):
            json_text({key: 1})


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
    monkeypatch.setattr(Benchmark, "as_dict", lambda self: {"rate": math.inf, "ratios": [math.nan]}, raising=False)
    assert main(["bench", files["SCENE"], "--repeats", "1", "--spp", "1", "--json"]) == 0
    assert strictly(capsys.readouterr().out) == {"rate": None, "ratios": [None]}


def test_every_command_that_prints_json_is_tried() -> None:
    modules = {file.stem for file in (PACKAGE / "cli").glob("*.py") if "as_json:" in file.read_text()}
    assert modules == set(COMMANDS_WITH_JSON) <= {command.__name__ for command in COMMANDS}


def test_nothing_writes_json_that_may_hold_other_numbers() -> None:
    loose = [
        f"{file.relative_to(PACKAGE)}:{call.lineno}"
        for file in PACKAGE.rglob("*.py")
        for call in loose_calls(ast.parse(file.read_text()))
    ]
    assert loose == []


@pytest.mark.parametrize(
    ("code", "loose"),
    [
        ("import json\njson.dumps(x)", 1),
        ("import json\njson.dump(x, file, allow_nan=True)", 1),
        ("import json\njson.dumps(x, allow_nan=strict)", 1),
        ("import json\njson.dumps(x, **options)", 1),
        ("import json as j\nj.dumps(x)", 1),
        ("from json import dumps\ndumps(x)", 1),
        ("from json import dump as write\nwrite(x, file)", 1),
        ("from json import dumps\ndumps(x, allow_nan=False)", 0),
        ("import json\njson.dumps(x, allow_nan=False)\njson.loads(x)", 0),
        ("dumps(x)", 0),
    ],
)
def test_every_way_to_write_loose_json_is_seen(code: str, loose: int) -> None:
    assert len([*loose_calls(ast.parse(code))]) == loose


def loose_calls(tree: ast.AST) -> Iterator[ast.Call]:
    """Yield the calls of `json.dumps` and `json.dump`, by whatever name, without the constant ``allow_nan=False``."""
    writers = set[str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules = [name.asname or name.name for name in node.names if name.name == "json"]
            writers |= {f"{module}.{name}" for module in modules for name in ("dumps", "dump")}
        elif isinstance(node, ast.ImportFrom) and node.module == "json":
            writers |= {name.asname or name.name for name in node.names if name.name in ("dumps", "dump")}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in writers and not any(map(_is_strict, node.keywords)):
            yield node


def _is_strict(keyword: ast.keyword) -> bool:
    return keyword.arg == "allow_nan" and isinstance(keyword.value, ast.Constant) and keyword.value.value is False
