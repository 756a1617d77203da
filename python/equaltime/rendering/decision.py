"""Decisions that a strategy leaves to the render: whether paths are split, and whether pixels get uneven counts.

Both follow from counts, not from a clock. The decision on splitting follows from a pilot render of the scene with the
strategy. The decision on sample counts follows from the first samples of the image. Both are stored with a render, and
a resumed render keeps them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from equaltime.strategy import Strategy

__all__ = ["Counts", "Decision"]

Counts = Literal["even", "error"]
"""Sample counts that are equal (``even``), or that follow the error of neighbouring pixels (``error``)."""


@dataclass(frozen=True)
class Decision:
    """Decisions that a strategy left to the render, and a resumed render keeps: splitting of paths, and sample counts.

    A field is None if the strategy did not leave that decision to the render, or if it is not made yet.
    """

    roulette: Literal["throughput", "efficiency"] | None = None
    """Russian roulette that replaces the strategy's ``automatic``: ``throughput``, or ``efficiency``, which also splits
    paths."""
    splitting: float | None = None
    """Variance times rays with path splitting, divided by this product without splitting: below 1, splitting pays. None
    if no pilot (short render) measured the ratio."""
    counts: Counts | None = None
    """Sample counts of pixels: ``even``, or ``error`` if they follow the error of neighbouring pixels."""

    def applied(self, strategy: Strategy) -> Strategy:
        """Return the strategy with decided values in place of automatic ones: it renders without deciding again.

        The decided roulette replaces ``automatic``. Equal sample counts replace ``adaptive=error`` by ``none``. Uneven
        counts change nothing: the render finds them again from its first samples.
        """
        decided: dict[str, str] = {}
        if self.roulette is not None and strategy.roulette == "automatic":
            decided["roulette"] = self.roulette
        if self.counts == "even" and strategy.adaptive == "error":
            decided["adaptive"] = "none"
        return strategy.model_copy(update=decided)

    @property
    def words(self) -> str:
        """Words of a strategy that stand for the decisions, such as ``roulette=efficiency,adaptive=none``.

        The text is empty if nothing was decided.
        """
        roulette = [] if self.roulette is None else [f"roulette={self.roulette}"]
        counts = [] if self.counts is None else [f"adaptive={'none' if self.counts == 'even' else self.counts}"]
        return ",".join((*roulette, *counts))

    def __str__(self) -> str:
        """Say in a sentence what was decided and why; empty if nothing was decided."""
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

    @classmethod
    def from_dict(cls, data: Mapping[str, Any] | None) -> Decision:
        """Return the decisions from their fields as JSON data, as a record holds them; None stands for no decisions."""
        return cls() if data is None else cls(*(data.get(name) for name in ("roulette", "splitting", "counts")))
