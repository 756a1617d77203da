"""How the sample count of an image depends on the error that was asked for.

A render that looks at its own error (`equaltime.rendering.budget`) and stops when it is small selects images: those
that have not met a rare bright path yet stop, and those that have go on. Each sample is unbiased, but the mean over
images that were stopped so is not: images of small lights that are focused by glass or seen in metal come out too dark
on average.

A *fixed* count does not depend on the image: a pilot with samples of its own chooses it, and it is rendered whatever
the image shows. Such images are unbiased.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

__all__ = ["Stop", "StopRule", "StoppedBy"]

StopRule = Literal["look", "fixed"]
StoppedBy = Literal["spp", "time", "error", "count", "interrupt", "nonfinite", "faulty", "unfinished", "merge"]
"""What ends a render (`equaltime.rendering.result.Result.stopped_by`)."""

_ALWAYS = ("rule", "selects", "error")
_OF_FIXED = ("spp", "pilot_seed", "pilot_spp", "pilot_seconds")
"""What records hold of a stop, by the names of `Stop`."""


@dataclass(frozen=True)
class Stop:
    """The rule by which a render that was asked for an error stops."""

    rule: StopRule
    """``look``: the image's own error is looked at; ``fixed``: a pilot chose the count."""
    error: float
    """The relative error to reach; of the noise alone, where something was left out."""
    spp: int | None = None
    """Samples per pixel that the pilot chose; None for ``look``."""
    pilot_seed: int | None = None
    """Seed of the pilot's samples; None for ``look``."""
    pilot_spp: int | None = None
    """Samples per pixel of the pilot, which are none of the image's; None for ``look``."""
    pilot_seconds: float = 0.0

    @property
    def selects(self) -> bool:
        """Whether the count depends on the image, so that images with few rare bright paths are preferred."""
        return self.rule == "look"

    def as_dict(self) -> dict[str, Any]:
        """Return the rule as JSON data, as it stands in the record of a result."""
        names = _ALWAYS if self.selects else (*_ALWAYS, *_OF_FIXED)
        return {name: getattr(self, name) for name in names}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Stop:
        """Read what `as_dict` wrote."""
        return cls(**{name: data[name] for name in ("rule", "error", *_OF_FIXED) if name in data})
