"""How the command line says things: errors, warnings, times."""

from __future__ import annotations

import sys

from equaltime.scene import Scene

__all__ = ["duration", "print_error", "print_warnings"]


def duration(seconds: float) -> str:
    """Write a time for people: ``12.3 ms``, ``4.56 s``."""
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{1000 * seconds:.3g} ms"


def print_error(text: str) -> None:
    """Print one line ``error: …`` for every problem."""
    for line in text.splitlines():
        print(f"error: {line}", file=sys.stderr)


def print_warnings(scene: Scene) -> None:
    """Print one line ``warning: …`` for everything odd about the scene's files."""
    for warning in scene.warnings:
        print(f"warning: {warning}", file=sys.stderr)
