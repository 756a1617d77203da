"""Base class of all nodes of the scene model. Nodes are immutable and strictly typed, and refuse unknown parameters.

Two nodes are equal if their parameters are equal. The fields of a node have Mitsuba 3's parameter names and defaults.
Numbers are kept in double precision, in the units of the scene file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, ClassVar, Literal, Self, get_args

from pydantic import BaseModel, ConfigDict

__all__ = ["NOT_YET", "NO_MORE", "Kind", "Plugin"]

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
NO_MORE = "one of Mitsuba 0.6, which Mitsuba 3 and equaltime do not have"


class Plugin(BaseModel):
    """Base class of all nodes of the scene model.

    Each subclass is one plugin, such as ``diffuse``, or the common base of several plugins.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    kind: ClassVar[Kind]
    roles: ClassVar[Mapping[Kind, str]] = {}
    """Fields by family of plugins, for nested objects that are assigned by their family and not by a parameter name."""
    lists: ClassVar[frozenset[str]] = frozenset()
    """Fields in `roles` that take several objects, in the order of the file."""
    later: ClassVar[frozenset[str]] = frozenset()
    """Parameters that Mitsuba 3 documents for this plugin and that are not supported yet."""
    old: ClassVar[frozenset[str]] = frozenset()
    """Parameters of Mitsuba 0.6 that changed the image and that Mitsuba 3 does not have."""
    hints: ClassVar[frozenset[str]] = frozenset()
    """Fields that cannot change the expected image, such as sampling hints; the scene's digest (a hash) ignores
    them."""

    newer: ClassVar[frozenset[str]] = frozenset()
    """Fields that the digest leaves out where they are None, because scenes of earlier versions do not have them."""

    id: str | None = None
    """Name of this object in its file."""

    @property
    def title(self) -> str:
        """Mitsuba's name of the plugin, such as ``diffuse``: the value of the field ``type``."""
        return str(type(self).model_fields["type"].default)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters by name, without those that are hints."""
        unused = {"type", "id", *self.hints}
        return {name: getattr(self, name) for name in type(self).model_fields if name not in unused}

    @classmethod
    @cache
    def slots(cls) -> Mapping[str, frozenset[Kind]]:
        """Return the fields that hold nested objects assigned by parameter name, such as textures.

        Keys are names of fields. Values are the families of plugins that the field accepts, such as ``texture``.
        """
        by_kind = set(cls.roles.values())
        kinds = {name: frozenset(_kinds(field.annotation)) for name, field in cls.model_fields.items()}
        return {name: found for name, found in kinds.items() if found and name not in by_kind}

    @classmethod
    @cache
    def holders(cls) -> tuple[str, ...]:
        """Return the names of the fields that can hold other nodes, as a tuple."""
        return tuple(name for name, field in cls.model_fields.items() if any(_kinds(field.annotation)))

    def nodes(self) -> Iterator[Plugin]:
        """Iterate over this node and all nodes nested in it, depth first, each node once.

        A node that several others share is not repeated: the number of its uses can double with each level of nesting.
        """
        seen: set[int] = set()
        waiting: list[Plugin] = [self]
        while waiting:
            node = waiting.pop()
            if id(node) not in seen:
                seen.add(id(node))
                yield node
                waiting += reversed(list(node.nested()))

    def nested(self) -> Iterator[Plugin]:
        """Iterate over the nodes directly inside this node."""
        for name in self.holders():
            value = getattr(self, name)
            for item in value if isinstance(value, tuple) else (value,):
                if isinstance(item, Plugin):
                    yield item

    def replace(self, **changes: object) -> Self:
        """Return a copy of the node with the parameters in `changes` replaced.

        Raises pydantic's ValidationError if the copy is not valid.
        """
        given: dict[str, Any] = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**(given | changes))


def _kinds(annotation: object) -> Iterator[Kind]:
    """Iterate over the kinds of the plugins that `annotation` mentions."""
    if isinstance(annotation, type) and issubclass(annotation, Plugin):
        yield annotation.kind
    for argument in get_args(annotation):
        yield from _kinds(argument)
