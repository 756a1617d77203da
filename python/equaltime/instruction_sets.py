"""Levels of x86-64: the levels that this machine has, and the level of the compiled core that is loaded.

A level is a set of instructions that processors share: v2 has SSE4.2, v3 also AVX2 and fused multiplications, v4 also
AVX-512 (the psABI of x86-64 defines them). Processors of other kinds have one level, ``generic``.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Collection
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Final

__all__ = ["EMBREE", "LEVELS", "OTHER", "VARIABLE", "LevelError", "choose", "core_file", "levels_of", "machine_levels"]

VARIABLE: Final = "EQUALTIME_ISA"
"""Environment variable that chooses the level of the core, and limits Embree to the same level."""
LEVELS: Final = {
    "v2": ("ssse3", "sse4_1", "sse4_2", "popcnt"),
    "v3": ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"),
    "v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
}
"""The flags of /proc/cpuinfo that each level adds to the level before."""
OTHER: Final = "generic"
FASTEST: Final = ("v2", "v3", "v4", OTHER)
"""Levels in the order in which the compiled core is preferred, fastest first.

On a Xeon with AVX-512, v3 renders .82 to 1.00 of the paths that v2 does in the same time, and v4 .86 to .96
(tests/bench/build_variants.py): the core works on one path at a time. Embree takes the machine's best in any case.
"""
EMBREE: Final = {"v2": "sse4.2", "v3": "avx2", "v4": "avx512"}
"""Embree's name for the best instruction set of each level, by which Embree is limited to the level."""


class LevelError(ImportError):
    """Raised if the package has no compiled core for this machine, or for the level that ``EQUALTIME_ISA`` asks for."""


def machine_levels(told: Path = Path("/proc/cpuinfo")) -> tuple[str, ...]:
    """Return the levels of x86-64 that this machine has, such as ``("v3", "v2")``, best first.

    ``told`` is the file in which Linux lists the processor's features. Without that file, the result is v2 alone.
    Another kind of processor has the single level ``generic``.
    """
    if platform.machine() not in ("x86_64", "AMD64"):
        return (OTHER,)
    try:
        return levels_of(told.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return ("v2",)


def levels_of(cpuinfo: str) -> tuple[str, ...]:
    """Return the levels of x86-64 that the text of the file /proc/cpuinfo shows, best first."""
    lines = (line.partition(":") for line in cpuinfo.splitlines())
    flags = next(({*words.split()} for name, _, words in lines if name.strip() == "flags"), set[str]())
    found: tuple[str, ...] = ()
    for level, needed in LEVELS.items():
        if not flags.issuperset(needed):
            break
        found = (level, *found)
    return found


def core_file() -> tuple[str, Path]:
    """Return the level of the core to load, and the core's compiled file; raises `LevelError` if no core fits."""
    folder = Path(__file__).parent  # the dot in the name keeps tools that list modules from importing these files
    names = {level: [folder / f"_core.{level}{suffix}" for suffix in EXTENSION_SUFFIXES] for level in (*LEVELS, OTHER)}
    files = {level: found for level, paths in names.items() if (found := next(filter(Path.exists, paths), None))}
    level = choose(files, machine_levels(), os.environ.get(VARIABLE, ""))
    return level, files[level]


def choose(built: Collection[str], machine: Collection[str], asked: str = "") -> str:
    """Return the level of the core to load: the level ``asked`` for, or else the fastest possible level.

    ``built`` holds the levels for which a core was compiled, and ``machine`` the levels that this machine has. Raises
    `LevelError`, whose message gives the reason, if no level fits.
    """
    if not built:
        raise LevelError("equaltime has no compiled core: install it, as its README says")
    have, cores = ", ".join(machine) or "none of them", ", ".join(sorted(built))
    if asked and asked not in (*LEVELS, OTHER):
        raise LevelError(f"{VARIABLE} is '{asked}': expected {', '.join(LEVELS)}")
    if asked and asked not in machine:
        raise LevelError(f"{VARIABLE} asks for {asked}, which this machine does not have (it has {have})")
    if asked and asked not in built:
        raise LevelError(f"{VARIABLE} asks for {asked}, and this build of equaltime has {cores} alone")
    if level := asked or next((level for level in FASTEST if level in machine and level in built), ""):
        return level
    raise LevelError(f"this build of equaltime is for x86-64 {cores}, and this machine has {have}")
