"""What a text that an experiment goes back to says, and which of our numbers stand beside its own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import Field

from equaltime.experiments.model.value import Value

__all__ = ["Quantity", "TheirNumber", "Theirs"]

Quantity = Literal[
    "slope",
    "speed-up",
    "efficiency",
    "fewer samples",
    "time",
    "samples",
    "time of a sample",
    "error",
    "last error",
    "bias",
    "p",
]
"""What is measured of a strategy on a scene; see `equaltime.experiments.analysis.beside` for each."""

Words = Annotated[str, Field(min_length=1)]


class TheirNumber(Value):
    """One thing that they say, and what we measured of it."""

    what: Words
    """In words, such as ``speed-up of light sampling over none``."""
    says: str = ""
    """What they say of it, as they print it; empty if they give no figure."""
    ours: Quantity
    strategy: Words
    """Label of the strategy that it is measured of."""
    scene: str = ""
    """Name of the scene; the first if not given."""
    target: Annotated[float, Field(gt=0.0)] | None = None
    """One of the experiment's targets, for times to an error; if not given the smallest that can be trusted."""


class Theirs(Value):
    """A claim that somebody made in public, in our words, with their figures."""

    source: Words
    """Who made it."""
    claim: Words
    figures: str = ""
    """All their figures in a sentence; empty if there are none."""
    numbers: Annotated[tuple[TheirNumber, ...], Field(strict=False)] = ()

    def of(self, labels: Iterable[str]) -> Theirs:
        """Return the claim with the numbers of these strategies alone."""
        kept = set(labels)
        return self.model_copy(update={"numbers": tuple(n for n in self.numbers if n.strategy in kept)})
