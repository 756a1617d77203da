"""The page on the data that commands print names every column and every key."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from equaltime.cli import main
from equaltime.experiments.run.record import COLUMNS

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "python" / "equaltime" / "cli" / "README.md"
CORNELL = str(ROOT / "scenes" / "cornell-box.toml")
RENDER = ["render", CORNELL, "--size", "16x16", "-o", "{}/x.exr", "--json"]
COST = ["cost", CORNELL, "--size", "16x16", "--quick", "--budget", "0.02s"]
INTERVAL = {"value", "low", "high", "trusted", "never", "doubt", "note", "bound", "reach"}


def named(title: str) -> list[str]:
    """Return the columns or keys that a section of the page names, in order."""
    section = re.split(r"^## ", PAGE.read_text(), flags=re.MULTILINE)
    text = next(part for part in section if part.startswith(title))
    first = (row.split("|")[1] for row in text.splitlines() if row.startswith("| `"))
    return [key for cell in first for key in re.findall(r"`([^`]+)`", cell)]


def keys(value: Any, prefix: str = "") -> Iterator[str]:
    """Yield the paths of all values that are no objects; an interval is one value."""
    if isinstance(value, dict) and value and not ("value" in value and value.keys() <= INTERVAL):
        for key, entry in value.items():
            yield from keys(entry, f"{prefix}.{key.replace('.', ' ')}" if prefix else key)
    elif isinstance(value, list) and any(isinstance(entry, dict | list) for entry in value):
        for entry in value:
            yield from keys(entry, f"{prefix}[]")
    else:
        yield prefix


def is_named(key: str, patterns: list[str]) -> bool:
    """Tell whether a key is one of the patterns, or above one, as an empty list is and what is null."""
    for pattern in patterns:
        parts = re.split(r"(?=\.|\[\])", pattern)
        for count in range(1, len(parts) + 1):
            words = re.escape("".join(parts[:count])).replace(r"\*\*", ".+").replace(r"\*", r"[^.]+")
            if re.fullmatch(words, key):
                return True
    return False


def test_every_column_of_the_records_is_named_in_order() -> None:
    assert [*dict.fromkeys(named("records.csv"))] == list(COLUMNS)


def saved(folder: Path, name: str, *options: str) -> str:
    path = str(folder / name)
    assert main(["render", CORNELL, "--size", "16x16", "-o", path, "-q", *options]) == 0
    return path


@pytest.mark.parametrize(
    ("section", "command"),
    [
        ("render", [*RENDER, "--error", "60%"]),
        ("render", [*RENDER, "--error", "60%", "--stop", "fixed"]),
        ("render", [*RENDER, "--spp", "4", "--without", "long_paths=3"]),
        (
            "render",
            ["render", CORNELL, "--size", "16x16", "--error", "60%", "--stop", "fixed", "-o", "{}/x.exr", "--json"],
        ),
        (
            "render",
            ["render", CORNELL, "--size", "9x9", "--spp", "4", "--without", "long_paths=3", "-o", "{}/x.exr", "--json"],
        ),
        ("render", ["info", "{}/a.exr", "--json"]),
        ("quote", ["quote", CORNELL, "--size", "16x16", "--error", "5%", "--why", "--json"]),
        ("cost", [*COST, "-o", "{}/cost", "--json"]),
        ("cost", ["info", "{}/cost", "--json"]),
        ("info of an experiment file", ["info", str(ROOT / "scenes" / "experiments" / "x3-light.toml"), "--json"]),
        ("compare", ["compare", "{}/a.exr", "{}/b.exr", "{}/c.exr", "--json"]),
        ("effects", ["effects", CORNELL, "--size", "16x16", "--quick", "--json"]),
        ("bench", ["bench", CORNELL, "--repeats", "2", "--spp", "1", "--threads", "1", "--json"]),
        ("info of a scene", ["info", CORNELL, "--json"]),
        ("info of a scene", ["lint", str(ROOT / "scenes" / "hard" / "lamp-in-wall.toml"), "--json"]),
        ("selftest", ["selftest", "--json"]),
        ("replay", ["replay", CORNELL, "--pixel", "3,4", "--sample", "0", "--json"]),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_every_key_of_a_command_is_named(
    section: str, command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for seed, name in enumerate("abc"):
        if any(f"{name}.exr" in word for word in command):
            saved(tmp_path, f"{name}.exr", "--seed", str(seed), "--spp", "8")
    if command[0] == "info" and any(word.endswith("/cost") for word in command):
        assert main([*COST, "-o", str(tmp_path / "cost")]) == 0
    capsys.readouterr()
    main([word.format(tmp_path) for word in command])
    found, patterns = {*keys(json.loads(capsys.readouterr().out))}, named(section)
    assert [key for key in sorted(found) if not is_named(key, patterns)] == []


def test_a_key_that_the_page_does_not_name_is_seen() -> None:
    assert not is_named("error_of_something", named("render"))
