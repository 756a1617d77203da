"""Integrators: what is computed. How it is sampled is the strategy's business."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, PositiveInt

from equaltime.scene.model.base import NOT_YET, Kind, Plugin

__all__ = ["Direct", "Integrator", "Path"]


def _shown(hide: bool) -> bool:
    if hide:
        raise ValueError(f"hide_emitters is {NOT_YET}")
    return hide


def _sees_something(depth: int) -> int:
    if depth == 0:
        raise ValueError("must be -1 or at least 1, the depth that sees emitted light: 0 would see nothing")
    return depth


class IntegratorPlugin(Plugin):
    """Base of the integrators."""

    kind: ClassVar[Kind] = "integrator"

    hide_emitters: Annotated[bool, AfterValidator(_shown)] = False


class Path(IntegratorPlugin):
    """Global illumination by paths of up to ``max_depth`` segments."""

    hints: ClassVar[frozenset[str]] = frozenset({"rr_depth"})

    type: Literal["path"] = "path"
    max_depth: Annotated[int, Field(ge=-1, lt=2**31), AfterValidator(_sees_something)] = -1
    """1: emitted light only, 2: direct light too, ...; -1: no limit."""
    rr_depth: PositiveInt = 5
    """From where on Russian roulette may end a path; a default that the strategy may override."""


class Direct(IntegratorPlugin):
    """Emitted and direct light only: a path integrator of depth 2."""

    later: ClassVar[frozenset[str]] = frozenset({"shading_samples", "emitter_samples", "bsdf_samples"})

    type: Literal["direct"] = "direct"

    @property
    def max_depth(self) -> int:
        """Paths of two segments see emitted and direct light."""
        return 2


Integrator = Annotated[Path | Direct, Field(discriminator="type")]
"""Any integrator."""
