"""What lint finds: a hazard, where it is, what becomes of it, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Literal

__all__ = ["MOST_PLACES", "Finding", "Severity"]

Severity = Literal["warning", "note"]
"""A warning is about what makes the image wrong or late; a note about what is dealt with, or may be meant."""

MOST_PLACES: Final = 8
"""How many places a finding names; `count` counts all."""


@dataclass(frozen=True)
class Finding:
    """One kind of hazard in one scene."""

    check: str
    """Its id."""
    severity: Severity
    what: str
    """What was found, with figures."""
    where: tuple[str, ...]
    """The first `MOST_PLACES` shapes, BSDFs or lights, with their places in the file."""
    count: int
    """Of triangles, vertices, texels or objects, as `what` says."""
    becomes: str
    """What equaltime does about it."""
    advice: str
    """What the user can do about it."""

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as JSON data."""
        return {**self.__dict__, "where": list(self.where)}


def first_places(places: Iterable[object]) -> tuple[str, ...]:
    """Return the places to name, each once."""
    return tuple(dict.fromkeys(map(str, places)))[:MOST_PLACES]
