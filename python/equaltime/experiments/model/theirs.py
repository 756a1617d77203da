"""Published claims that experiments test, and the quantities to measure beside the published numbers."""

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
"""Measured quantity of a strategy on a scene; `equaltime.experiments.analysis.beside` defines each."""

Words = Annotated[str, Field(min_length=1)]


class TheirNumber(Value):
    """One published number, and the quantity that the experiment measures for comparison."""

    what: Words
    """Description, such as ``speed-up of light sampling over none``."""
    says: str = ""
    """Published value as printed; empty if no figure was published."""
    ours: Quantity
    strategy: Words
    """Label of the measured strategy."""
    scene: str = ""
    """Name of the scene; by default the first."""
    target: Annotated[float, Field(gt=0.0)] | None = None
    """One of the experiment's targets, for times to an error; by default the smallest with a trusted number."""


class Theirs(Value):
    """A published claim, put in equaltime's terms, with the figures that its authors published."""

    source: Words
    """Author or publication of the claim."""
    claim: Words
    figures: str = ""
    """All published figures in one sentence; empty if there are none."""
    numbers: Annotated[tuple[TheirNumber, ...], Field(strict=False)] = ()

    def of(self, labels: Iterable[str]) -> Theirs:
        """Return a copy of the claim with only the published numbers of strategies that have these labels."""
        kept = set(labels)
        return self.model_copy(update={"numbers": tuple(n for n in self.numbers if n.strategy in kept)})
