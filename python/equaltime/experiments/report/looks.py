"""How each strategy looks: a colour, a marker and a name that stay its own through the whole page.

Colours are told apart with normal sight and with each kind of colour blindness (simulated after Machado 2009), have a
contrast of at least 3 with the page, light or dark, and are never alone: a marker goes with each, and dashes from the
ninth strategy on. The baseline is grey, and alone is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["DARK", "LIGHT", "MARKERS", "Look", "looks"]

LIGHT = ("#5b6168", "#0f4f94", "#b23406", "#0a9a5c", "#d04bb4", "#a87400", "#6f22b4", "#571629")
DARK = ("#a9b1bb", "#3f8fd8", "#ef8a45", "#3fe89a", "#f7a8ea", "#ffe061", "#a77bff", "#e0305f")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
_DASHES = ("-", "--", ":", "-.")


@dataclass(frozen=True)
class Look:
    """The look of one strategy."""

    index: int
    """Which colour and marker: 0 is the baseline's."""
    light: str
    """Colour on white, ``#rrggbb``."""
    marker: str
    """Matplotlib's name of the marker."""
    line: str
    """Matplotlib's name of the line style."""


def looks(labels: Sequence[str], baseline: str) -> dict[str, Look]:
    """Give each label its look; the baseline comes first whatever its place."""
    ordered = dict.fromkeys((baseline, *labels))
    return {label: _look(place) for place, label in enumerate(ordered)}


def _look(place: int) -> Look:
    """Return a look by its place: 0 is the baseline's alone; the others begin again with other dashes."""
    turn, index = divmod(max(place - 1, 0), len(LIGHT) - 1)
    index += place > 0
    return Look(index, LIGHT[index], MARKERS[index], _DASHES[turn % len(_DASHES)])
