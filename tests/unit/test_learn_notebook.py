"""The notebook to learn from: it is stored without outputs, its cells run in order, and each is short."""

from __future__ import annotations

import ast
import json
import time
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
CELLS = json.loads((ROOT / "scenes" / "learn" / "learn.ipynb").read_text())["cells"]
CODE = ["".join(cell["source"]) for cell in CELLS if cell["cell_type"] == "code"]
SMALL = {"SIZE = 80": "SIZE = 12", "REFERENCE = 512": "REFERENCE = 16", "time=1.0": "time=0.1"}
"""What makes the notebook quick."""
LONGEST = 180.0
"""Seconds that all cells may take on two quiet processors."""


def run(cells: list[str]) -> None:
    """Run cells in one namespace, as a notebook does, drawing into memory only."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    namespace: dict[str, Any] = {}
    try:
        for number, cell in enumerate(cells):
            exec(compile(cell, f"cell {number}", "exec"), namespace)
    finally:
        pyplot.close("all")


def test_its_cells_run(capsys: pytest.CaptureFixture[str]) -> None:
    cells = CODE
    for long, short in SMALL.items():
        assert any(long in cell for cell in cells)
        cells = [cell.replace(long, short) for cell in cells]
    run(cells)
    assert "3 x²     mean 1.000, variance 0.000" in capsys.readouterr().out


@pytest.mark.slow
def test_it_takes_three_minutes_at_most() -> None:
    begin = time.process_time()  # what others do on the processors does not count
    run(CODE)
    assert time.process_time() - begin < 2 * LONGEST


@pytest.mark.parametrize("number", range(1, len(CODE)))
def test_a_cell_needs_the_first_one_only_or_the_one_before(number: int) -> None:
    """A student may run any section by itself."""
    made = [names(cell, ast.Store) for cell in CODE]
    of_section = made[0] | made[number] | (made[number - 1] if shares_section(number) else set())
    elsewhere = set().union(*made) - of_section
    assert names(CODE[number], ast.Load) & elsewhere == set()


def names(cell: str, context: type[ast.expr_context]) -> set[str]:
    """Return the names that a cell reads or makes."""
    tree = ast.parse(cell)
    made = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    named = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, context)}
    return named | (made if context is ast.Store else set())


def shares_section(number: int) -> bool:
    """Tell whether no text stands between a cell of code and the one before it."""
    places = [place for place, cell in enumerate(CELLS) if cell["cell_type"] == "code"]
    return places[number] == places[number - 1] + 1


def test_it_is_stored_without_outputs_and_its_cells_are_short() -> None:
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in CELLS)
    assert max(len(cell.splitlines()) for cell in CODE[1:]) <= 12
    assert (ROOT / "scenes" / "learn" / "learn.ipynb").stat().st_size < 50_000
