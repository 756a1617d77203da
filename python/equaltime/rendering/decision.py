"""Decisions that a strategy leaves to the render: whether paths are split, and whether sample counts follow the noise.

Both follow from counts, not from a clock: whether to split from a pilot of the scene and the strategy alone, the counts
from the first samples of the image. They are values in the record of a render, and one that is taken up keeps them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from equaltime.strategy import Strategy

__all__ = ["Counts", "Decision"]

Counts = Literal["even", "error"]
"""Sample counts that are alike, or that follow the error of the neighbours."""


@dataclass(frozen=True)
class Decision:
    """What a render decided. A field is None where the strategy left nothing to decide, or nothing is decided yet."""

    roulette: Literal["throughput", "efficiency"] | None = None
    """The roulette of an automatic one: ``efficiency`` splits paths."""
    splitting: float | None = None
    """Variance times rays with splitting over that without, by the pilot; None if there was none."""
    counts: Counts | None = None

    def applied(self, strategy: Strategy) -> Strategy:
        """Return the strategy with what was decided; its counts only if they are even: others follow from a pilot."""
        decided: dict[str, str] = {}
        if self.roulette is not None and strategy.roulette == "automatic":
            decided["roulette"] = self.roulette
        if self.counts == "even" and strategy.adaptive == "error":
            decided["adaptive"] = "none"
        return strategy.model_copy(update=decided)

    def __str__(self) -> str:
        """Say in a sentence what was decided and why; nothing if nothing was."""
        return "; ".join(filter(None, (self._roulette(), self._counts())))

    def _roulette(self) -> str:
        if self.roulette is None:
            return ""
        if self.splitting is None:
            return "paths are not split: small pictures, and the techniques uniform and mixture, get no pilot"
        does = "are split where they are scattered first" if self.roulette == "efficiency" else "are not split"
        return f"paths {does}: by a pilot, splitting multiplies the variance times the rays by {self.splitting:.2f}"

    def _counts(self) -> str:
        said = {"even": "all pixels have the same number of samples", "error": "noisy parts have more samples"}
        return "" if self.counts is None else said[self.counts]

    def as_dict(self) -> dict[str, Any]:
        """Return what was decided as JSON data, as it stands in the record of a result."""
        return {"roulette": self.roulette, "splitting": self.splitting, "counts": self.counts}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any] | None) -> Decision:
        """Read what `as_dict` wrote; None is a record that tells of none."""
        return cls() if data is None else cls(*(data.get(name) for name in ("roulette", "splitting", "counts")))
