"""Styles of a report: the colours of a page, and colour, marker and line style of each strategy.

The colours can be told apart with normal sight and with each type of colour blindness (simulated after Machado 2009).
The contrast of a colour with the page, light or dark, is at least 3. Each colour comes with a marker, and from the
ninth strategy on with dashes. Only the baseline is grey.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["DARK", "GRID", "INK", "LIGHT", "MARKERS", "MUTED", "Style", "looks"]

INK, MUTED, GRID = "#1b1f24", "#5c6470", "#d8dce2"
"""Colours of text, of lines and ticks, and of grids."""

LIGHT = ("#5b6168", "#0f4f94", "#b23406", "#0a9a5c", "#d04bb4", "#a87400", "#6f22b4", "#571629")
DARK = ("#a9b1bb", "#3f8fd8", "#ef8a45", "#3fe89a", "#f7a8ea", "#ffe061", "#a77bff", "#e0305f")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
_DASHES = ("-", "--", ":", "-.")


@dataclass(frozen=True)
class Style:
    """Colour, marker and line style of one strategy on a page."""

    index: int
    """Number of the strategy's colour and marker; 0 is the baseline's."""
    light: str
    """Colour on a white page, ``#rrggbb``."""
    marker: str
    """Matplotlib's name of the marker."""
    line: str
    """Matplotlib's name of the line style."""


def looks(labels: Sequence[str], baseline: str) -> dict[str, Style]:
    """Return the style (colour, marker and line style) of each strategy by its label; the baseline's is grey."""
    ordered = dict.fromkeys((baseline, *labels))
    return {label: _look(place) for place, label in enumerate(ordered)}


def _look(place: int) -> Style:
    """Return the look at a place; 0 is reserved for the baseline, and the other colours repeat with other dashes."""
    turn, index = divmod(max(place - 1, 0), len(LIGHT) - 1)
    index += place > 0
    return Style(index, LIGHT[index], MARKERS[index], _DASHES[turn % len(_DASHES)])
