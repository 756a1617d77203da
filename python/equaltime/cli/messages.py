"""Messages of the command line: errors, warnings, durations, quotes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import TypeVar

from rich.console import Console

from equaltime.quoting.pilot import Quote
from equaltime.rendering.stated import stated
from equaltime.scene import Scene
from equaltime.words import duration, percent

__all__ = [
    "WAYS",
    "plain_console",
    "print_error",
    "print_lines",
    "print_no_quote",
    "print_quote",
    "print_warning",
    "print_warnings",
    "while_heard",
]

T = TypeVar("T")

WAYS = {"seen": "seen by the camera", "met": "met by a scattered ray", "aimed": "aimed at"}
"""Descriptions of the ways in which a path finds light."""


def plain_console() -> Console:
    """Return a console without markup, because rich would interpret brackets in names."""
    return Console(highlight=False, markup=False)


def print_error(text: str) -> None:
    """Print one line ``error: …`` for each line of the text."""
    for line in text.split("\n"):
        print(f"error: {_visible(line)}", file=sys.stderr)


def print_warnings(scene: Scene) -> None:
    """Print one line ``warning: …`` for each warning of the scene."""
    for warning in scene.warnings:
        print_warning(warning)


def print_warning(text: str) -> None:
    """Print one line ``warning: …``."""
    print(f"warning: {_visible(text)}", file=sys.stderr)


def print_lines(lines: Sequence[str]) -> None:
    """Print lines, and flush each."""
    for line in lines:
        print(_visible(line), flush=True)


def print_quote(quote: Quote) -> None:
    """Print the predicted error, time and samples of a render in one line."""
    spp, seconds, error, number = quote.spp, quote.seconds, quote.error, stated(quote.origin)
    limits = f" [{duration(seconds.low)}, {duration(seconds.high)}]" if seconds.high > seconds.low else ""
    print(
        f"quote: {number.noun} {percent(error.value)} [{percent(error.low)}, {percent(error.high)}]{number.of_paths} "
        f"in {duration(seconds.value)}{limits}, {spp.value:.3g} spp [{spp.low:.3g}, {spp.high:.3g}]"
        f"{f' (in doubt: {error.doubt})' if error.doubt else ''}",
        flush=True,
    )


def print_no_quote(why: str) -> None:
    """Print one line with the reason why there is no quote."""
    print(f"no quote: {why}", flush=True)


def while_heard(say: Callable[[T], object]) -> Callable[[T], None]:
    """Return a callback that is silent after its first OSError: a closed pipe or a full disk must not end a render."""
    heard = True

    def said(what: T) -> None:
        nonlocal heard
        if heard:
            try:
                say(what)
            except OSError:
                heard = False

    return said


def _visible(text: str) -> str:
    """Escape unprintable characters: a text from a file must not control the terminal."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)
