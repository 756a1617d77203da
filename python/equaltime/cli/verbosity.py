"""The option ``-v`` of commands that print a short answer, and the number of lines of one."""

from __future__ import annotations

from typing import Annotated, Final

import typer

__all__ = ["MOST_LINES", "Verbose"]

MOST_LINES: Final = 12
"""Largest number of lines of an output without ``-v``: two with the answer, and ten more."""

Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Print all numbers, with what limits them.")]
