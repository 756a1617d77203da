"""Levels of x86-64: what machines have, and the one that the core takes."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from equaltime import _core
from equaltime.instruction_sets import EMBREE, LevelError, choose, levels_of, machine_levels

V2 = "sse4_1 ssse3 sse4_2 popcnt"
V3 = f"{V2} avx avx2 bmi1 bmi2 f16c fma abm movbe"
V4 = f"{V3} avx512f avx512bw avx512cd avx512dq avx512vl"


@pytest.mark.parametrize(
    ("flags", "levels"),
    [
        ("fpu sse2", ()),
        (V2, ("v2",)),
        (V3, ("v3", "v2")),
        (V4, ("v4", "v3", "v2")),
        (V3.replace("bmi2 ", ""), ("v2",)),
        (V4.replace("fma ", ""), ("v2",)),
    ],
)
def test_a_level_has_all_its_flags_and_those_below(flags: str, levels: tuple[str, ...]) -> None:
    text = f"processor\t: 0\nvmx flags\t: {V4}\nflags\t\t: {flags}\nprocessor\t: 1\nflags\t\t: {V4}\n"
    assert levels_of(text) == levels


@pytest.mark.skipif(platform.machine() != "x86_64", reason="levels of x86-64")
def test_a_system_that_does_not_tell_its_flags_has_the_least_level(tmp_path: Path) -> None:
    assert machine_levels(tmp_path / "cpuinfo") == ("v2",)


def test_the_fastest_level_that_was_built_is_taken() -> None:
    assert choose(("v2", "v3", "v4"), ("v3", "v2")) == "v2"
    assert choose(("v3", "v4"), ("v4", "v3", "v2")) == "v3"
    assert choose(("v2",), ("v4", "v3", "v2")) == "v2"
    assert choose(("v2", "v4"), ("v4", "v3", "v2"), "v2") == "v2"


@pytest.mark.parametrize(
    ("built", "machine", "asked", "message"),
    [
        (("v2",), ("v2",), "v5", "EQUALTIME_ISA is 'v5': expected v2, v3, v4"),
        (("v2", "v3"), ("v2",), "v3", "asks for v3, which this machine does not have \\(it has v2\\)"),
        (("v2",), ("v3", "v2"), "v3", "asks for v3, and this build of equaltime has v2 alone"),
        (("v3", "v4"), ("v2",), "", "for x86-64 v3, v4, and this machine has v2"),
        ((), ("v2",), "", "no compiled core: install it"),
    ],
)
def test_a_level_that_is_not_there_is_told(
    built: tuple[str, ...], machine: tuple[str, ...], asked: str, message: str
) -> None:
    with pytest.raises(LevelError, match=message):
        choose(built, machine, asked)


def run(code: str, level: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "EQUALTIME_ISA": level}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment)


def test_the_variable_holds_embree_and_is_in_the_record() -> None:
    built = _core.build_info()["target"].removeprefix("x86-64-")
    code = "from equaltime import _core; b = _core.build_info(); print(b['target'], b['embree_isa'])"
    assert run(code, built).stdout.split() == [f"x86-64-{built}", EMBREE[built]]
    assert run(code, "").stdout.split()[1] == EMBREE[machine_levels()[0]]


def test_a_command_that_asks_for_another_level_ends_with_one_line() -> None:
    done = run(
        "import sys; from equaltime.cli import main; sys.exit(main(['render', 'cornell-box', '-o', 'a.png']))", "v9"
    )
    assert done.returncode == 2
    assert done.stderr.strip() == "error: EQUALTIME_ISA is 'v9': expected v2, v3, v4"


def test_embree_is_not_held_to_what_is_not_there() -> None:
    with pytest.raises(ValueError, match="Embree knows no instruction set 'mmx'"):
        _core.hold_embree("mmx")
