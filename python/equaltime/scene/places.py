"""Where the parts of a model stand in its file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from equaltime.scene.model import Plugin
from equaltime.scene.tree import Place

__all__ = ["NOWHERE", "Places", "told_once"]


ALONE: Final = ("sensor", "integrator")


class Places:
    """The places of shapes by their index, and of all parts by what they are."""

    def __init__(self, shapes: tuple[Place, ...], parts: Iterable[tuple[Plugin, Place]]) -> None:
        self.shapes = shapes
        self._parts = tuple(parts)
        self._known = {id(part): place for part, place in self._parts}

    def of(self, part: Plugin) -> Place | None:
        """Return where `part`, or the first that is equal to it, stands; None if it was made later.

        Of a kind that a scene has once it is the one that there is: its size or depth may have been changed.
        """
        if (place := self._known.get(id(part))) is not None:
            return place
        kind = part.kind if part.kind in ALONE else None
        return next((place for known, place in self._parts if known == part or known.kind == kind), None)


def told_once(place: Place, message: str) -> tuple[Place, str]:
    """Return a place and what is wrong there; a message that names the same file gives it its line instead."""
    found = re.fullmatch(rf"{re.escape(place.file)}(?::(\d+))?: (.*)", message, re.DOTALL)
    if found is None or place != Place(place.file):
        return place, message
    return Place(place.file, int(found[1]) if found[1] else None), found[2]


NOWHERE: Final = Places((), ())
"""For a model that was made by hand."""
