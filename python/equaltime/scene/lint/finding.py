"""Findings of lint: a hazard, its places, the renderer's treatment of it, and advice."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Literal

__all__ = ["MOST_PLACES", "Finding", "Severity"]

Severity = Literal["warning", "note"]
"""Warning: the image may be wrong or late. Note: the hazard is dealt with, or may be intended."""

MOST_PLACES: Final = 8
"""Largest number of places that a finding names; `count` counts all."""


@dataclass(frozen=True)
class Finding:
    """One kind of hazard in one scene."""

    check: str
    """Id of the check."""
    severity: Severity
    what: str
    """The hazard that was found, with figures."""
    where: tuple[str, ...]
    """The first `MOST_PLACES` shapes, BSDFs or lights, with their places in the file."""
    count: int
    """Number of triangles, vertices, texels or objects, as `what` says."""
    becomes: str
    """The renderer's treatment of the hazard."""
    advice: str
    """Advice to the user."""

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as JSON data."""
        return {**self.__dict__, "where": list(self.where)}


def first_places(places: Iterable[object]) -> tuple[str, ...]:
    """Return the first `MOST_PLACES` different places."""
    return tuple(dict.fromkeys(map(str, places)))[:MOST_PLACES]
