"""Places of the parts of a model in its file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from equaltime.scene.model import Plugin
from equaltime.scene.tree import Place

__all__ = ["NOWHERE", "Places", "told_once"]


ALONE: Final = ("sensor", "integrator")


class Places:
    """The places of shapes by index, and of all parts by identity or equality."""

    def __init__(self, shapes: tuple[Place, ...], parts: Iterable[tuple[Plugin, Place]]) -> None:
        self.shapes = shapes
        self._parts = tuple(parts)
        self._known = {id(part): place for part, place in self._parts}

    def of(self, part: Plugin) -> Place | None:
        """Return the place of `part`, or of the first part equal to it; None if it was made later.

        A scene has only one sensor and one integrator, so their places are found even after a change of size or depth.
        """
        if (place := self._known.get(id(part))) is not None:
            return place
        kind = part.kind if part.kind in ALONE else None
        return next((place for known, place in self._parts if known == part or known.kind == kind), None)


def told_once(place: Place, message: str) -> tuple[Place, str]:
    """Return place and message; if the message repeats the place's file, move its line number into the place."""
    found = re.fullmatch(rf"{re.escape(place.file)}(?::(\d+))?: (.*)", message, re.DOTALL)
    if found is None or place != Place(place.file):
        return place, message
    return Place(place.file, int(found[1]) if found[1] else None), found[2]


NOWHERE: Final = Places((), ())
"""Places of a model that was made in memory."""
