"""Lengths of time as people write them."""

from __future__ import annotations

import re

__all__ = ["seconds_of"]

_SECONDS = {"ms": 0.001, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "day": 86400.0, "days": 86400.0}
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
_PART = rf"({_NUMBER})({'|'.join(sorted(_SECONDS, key=len, reverse=True))})"


def seconds_of(text: str) -> float:
    """Read ``10s``, ``500ms``, ``2.5m``, ``1h30m``, ``2d`` or plain seconds; raises ValueError for anything else."""
    words = text.strip().lower().replace(" ", "")
    if re.fullmatch(_NUMBER, words):
        words += "s"
    if not re.fullmatch(f"({_PART})+", words):
        raise ValueError(f"'{text}' is no duration; write 10s, 500ms, 2.5m or 1h30m")
    return sum(float(number) * _SECONDS[unit] for number, unit in re.findall(_PART, words))
