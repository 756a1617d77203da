"""What every node of the model shares: frozen, strict, closed to unknown parameters.

A node is a value. Its fields carry Mitsuba 3's parameter names and defaults; all data is as the user wrote it, in the
scene's own units, in double precision.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict

__all__ = ["NOT_YET", "Kind", "Plugin"]

Kind = Literal[
    "bsdf",
    "emitter",
    "field",
    "film",
    "integrator",
    "medium",
    "phase",
    "rfilter",
    "sampler",
    "scene",
    "sensor",
    "shape",
    "texture",
    "volume",
]
"""Mitsuba's families of plugins, by their XML element names."""

NOT_YET = "known to Mitsuba 3 but not supported by equaltime yet"


class Plugin(BaseModel):
    """Base of all nodes: one class per Mitsuba plugin, told apart by ``type``."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    kind: ClassVar[Kind]
    roles: ClassVar[Mapping[Kind, str]] = {}
    """For each kind of object that may be nested here, the field that takes it (Mitsuba matches them by kind)."""
    lists: ClassVar[frozenset[str]] = frozenset()
    """Those of these fields that take several objects, in order."""
    later: ClassVar[frozenset[str]] = frozenset()
    """Parameters that Mitsuba 3 documents for this plugin and that are not supported yet."""
    hints: ClassVar[frozenset[str]] = frozenset()
    """Fields that cannot change the expected image, such as sampling hints and output formats; see `digest`."""

    id: str | None = None
    """Name of this object in its file."""

    def replace(self, **changes: object) -> Self:
        """Return the same with some parameters changed, checked anew; raises pydantic's ValidationError."""
        given: dict[str, Any] = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**(given | changes))
