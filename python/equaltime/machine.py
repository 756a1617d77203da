"""Number of processors and size of memory that this process may use: all of the machine, or a container's limit."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Any

__all__ = [
    "allowed_processors",
    "machine",
    "machine_facts",
    "memory_bytes",
    "processors",
    "resident_bytes",
    "worker_threads",
]

_GROUPS = Path("/sys/fs/cgroup")
_OWN = Path("/proc/self/cgroup")


def worker_threads(wanted: int) -> int:
    """Return the number of worker threads to start: ``wanted``, or one for each usable processor if ``wanted`` is 0."""
    return wanted or processors()


def processors(groups: Path = _GROUPS) -> int:
    """Return the number of processors that this process may use, at least 1.

    A container may limit the processor time. The limit is rounded up: 1.5 processors count as 2. ``groups`` is the
    folder of the system's cgroups, Linux's limits for containers.
    """
    present = len(allowed_processors()) or os.cpu_count() or 1
    return min([present, *(max(1, math.ceil(share)) for share in _shares(groups))])


def allowed_processors() -> set[int]:
    """Return the numbers of the processors that this process may run on; empty if the system does not tell them."""
    return os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()


def memory_bytes(groups: Path = _GROUPS) -> int:
    """Return the size of memory that this process may use, in bytes: the machine's, or a container's smaller limit.

    A limit of 0 bytes is ignored, because no process could run with it. ``groups`` is the folder of the system's
    cgroups, Linux's limits for containers.
    """
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    names = ("memory.max", "memory.limit_in_bytes")
    limits = (_numbers(folder / name) for folder in _folders("memory", groups) for name in names)
    return min([present, *(limit[0] for limit in limits if limit and limit[0] > 0)])


def resident_bytes() -> int:
    """Return the size of memory that this process uses now, in bytes; 0 if the system does not tell it."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


def _shares(groups: Path) -> Iterator[float]:
    """Yield the processor time per time that each cgroup around this process may have at most."""
    for folder in _folders("cpu", groups):
        limit = _numbers(folder / "cpu.max") or [
            *_numbers(folder / "cpu.cfs_quota_us"),
            *_numbers(folder / "cpu.cfs_period_us"),
        ]
        if len(limit) == 2 and min(limit) > 0:
            yield limit[0] / limit[1]


def _folders(controller: str, groups: Path) -> Iterator[Path]:
    """Yield the folders of the cgroups around this process, in versions 1 and 2, whether they are there or not."""
    inner = [""]
    try:
        for line in _OWN.read_text().splitlines():
            _, names, path = line.split(":", 2)
            if not names or controller in names.split(","):
                inner.append(path.lstrip("/"))
    except (OSError, ValueError):
        pass
    for path in inner:
        for step in (Path(path), *Path(path).parents):
            yield groups / step
            yield groups / controller / step


def _numbers(file: Path) -> list[int]:
    """Return the numbers in a file of a cgroup; none if there is no such file, or no limit (``max``)."""
    try:
        return [int(word) for word in file.read_text().split()]
    except (OSError, ValueError):
        return []


def machine() -> dict[str, Any]:
    """Return a description of this machine, as JSON data.

    ``cpu`` names the processor. ``processors`` and ``memory_bytes`` are the amounts that this process may use.
    ``system`` names the operating system. ``load_average`` is the mean number of busy processes in the last minute.
    """
    return {
        "cpu": _processor(),
        "processors": processors(),
        "memory_bytes": memory_bytes(),
        "system": platform.platform(),
        "load_average": os.getloadavg()[0],
    }


def machine_facts() -> dict[str, Any]:
    """Return the facts about the machine that affect times, without the momentary load."""
    facts = machine()
    facts.pop("load_average")
    return facts


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())
