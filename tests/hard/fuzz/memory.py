"""How much memory a piece of work took at its highest, by what Linux tells of this process."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .subjects import MEMORY, limit_of

__all__ = ["TooMuchMemory", "Watch"]

_STATUS = Path("/proc/self/status")
_RESET = Path("/proc/self/clear_refs")
_FIELDS = re.compile(r"^Vm(HWM|RSS):\s+(\d+) kB$", re.MULTILINE)


class TooMuchMemory(BaseException):
    """More than an input may take; nothing catches it on its way."""


class Watch:
    """Holds inputs to their limit, or to another."""

    def __init__(self, most: int = MEMORY) -> None:
        """Allow so many bytes, beside 20 for each of an input."""
        self._more = most - MEMORY

    @contextmanager
    def within(self, size: int) -> Iterator[None]:
        """Raise `TooMuchMemory` if what is done with an input of so many bytes takes more than its limit."""
        _RESET.write_text("5")  # the peak begins anew
        before = _numbers()["RSS"]
        yield
        taken = _numbers()["HWM"] - before
        if taken > limit_of(size) + self._more:
            raise TooMuchMemory(f"{taken >> 20} MiB for {size} bytes")


def _numbers() -> dict[str, int]:
    return {name: int(kib) << 10 for name, kib in _FIELDS.findall(_STATUS.read_text())}
