"""How the sample count of an image depends on the error that was asked for.

A render that looks at its own error (`equaltime.rendering.budget`) and stops when it is small selects images. Images
that have not met a rare bright path stop, and images that have met one go on. Each sample is unbiased, but the mean
over images that were stopped so is not. Images of small lights that glass focuses or metal reflects come out too dark
on average.

A *fixed* count does not depend on the image: a pilot with separate samples chooses the count, which is rendered
whatever the image shows. Such images are unbiased.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

__all__ = ["Stop", "StopRule", "StoppedBy"]

StopRule = Literal["look", "fixed"]
StoppedBy = Literal["spp", "time", "error", "count", "interrupt", "nonfinite", "faulty", "unfinished", "merge"]
"""Reasons why a render ends (`equaltime.rendering.result.Result.stopped_by`)."""

_ALWAYS = ("rule", "selects", "error")
_OF_FIXED = ("spp", "pilot_seed", "pilot_spp", "pilot_seconds")
"""Fields of `Stop` that records hold beside `_ALWAYS` for the rule ``fixed``."""


@dataclass(frozen=True)
class Stop:
    """Rule by which a render stops at an error."""

    rule: StopRule
    """``look``: the render looks at its own error; ``fixed``: a pilot chose the count."""
    error: float
    """Relative error to reach; if effects were left out, of the noise alone."""
    spp: int | None = None
    """Samples per pixel that the pilot chose; None for ``look``."""
    pilot_seed: int | None = None
    """Seed of the pilot's samples; None for ``look``."""
    pilot_spp: int | None = None
    """Samples per pixel of the pilot, which are not part of the image; None for ``look``."""
    pilot_seconds: float = 0.0

    @property
    def selects(self) -> bool:
        """Whether the count depends on the image, so that images with few rare bright paths are preferred."""
        return self.rule == "look"

    def as_dict(self) -> dict[str, Any]:
        """Return the rule as JSON data, as in the record of a result."""
        names = _ALWAYS if self.selects else (*_ALWAYS, *_OF_FIXED)
        return {name: getattr(self, name) for name in names}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Stop:
        """Read the data of `as_dict`."""
        return cls(**{name: data[name] for name in ("rule", "error", *_OF_FIXED) if name in data})
