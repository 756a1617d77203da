"""Facts of a process and its machine that affect times, and the comparison of two processes by these facts."""

from __future__ import annotations

import math
import socket
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from equaltime.machine import machine_facts
from equaltime.rendering.core import build_facts

__all__ = ["Likeness", "likeness"]

_BOOT = Path("/proc/sys/kernel/random/boot_id")
_SAME_MEMORY = 0.02
"""Relative difference of memory sizes up to which machines are alike: firmware reserves different amounts."""
_SHOWN = 40
"""Characters of a value that are shown; a SHA-256 is longer."""


@dataclass(frozen=True)
class Likeness:
    """Facts of a process that another process must share for times to be compared."""

    host: str
    """Name of the machine in its network."""
    boot: str
    """Name of the running system: equal for two processes on one machine, also in two containers."""
    facts: Mapping[str, Any] = field(hash=False)
    """Facts of the machine and of equaltime's build, by name."""

    def differences(self, other: Likeness) -> str:
        """Return, in words, the facts in which ``other`` differs; empty if times of both processes may be compared."""
        return "; ".join(self._differences(other))

    def _differences(self, other: Likeness) -> Iterator[str]:
        for name in {**self.facts, **other.facts}:
            mine, its = self.facts.get(name), other.facts.get(name)
            if name == "memory_bytes" and mine and its and math.isclose(mine, its, rel_tol=_SAME_MEMORY):
                continue
            if mine != its:
                yield f"{name} is {str(its)[:_SHOWN]} there, and {str(mine)[:_SHOWN]} here"


def likeness() -> Likeness:
    """Return the facts of this process and its machine that affect times."""
    host = socket.gethostname()
    try:
        boot = _BOOT.read_text().strip()
    except OSError:
        boot = host
    return Likeness(host, boot, {**machine_facts(), **build_facts()})
