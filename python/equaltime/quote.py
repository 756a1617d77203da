"""Quotes: what an error will cost in time, or what error a time will buy, from a short pilot.

The pilot, N samples a pixel, gives the error at its end, the exponent by which it falls (`equaltime.law`) and the time
of a sample. Intervals are at 95 %, formed on logarithms: the doubt about the error, about the exponent (which counts
for more the farther the target is from the pilot) and about the speed of the machine.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from equaltime.budget import FIRST_LOOK, Limits
from equaltime.error_estimate import Estimate
from equaltime.errors import RenderError
from equaltime.law import Law, fit
from equaltime.passes import ProgressCallback
from equaltime.scene import Scene
from equaltime.session import Session
from equaltime.strategy import Strategy

__all__ = ["TARGETS", "Pilot", "Quote", "quote"]

TARGETS = (0.20, 0.10, 0.05, 0.02, 0.01)
"""Errors whose price every quote tells."""

_PILOT_SHARE = 0.05
_BYTES_PER_PIXEL = 219


@dataclass(frozen=True)
class Quote:
    """What a render will cost, or bring."""

    seconds: Estimate
    """From the first sample to the final film."""
    spp: Estimate
    """Samples per pixel."""
    error: Estimate
    """Of the image at the end."""
    memory: int
    """Bytes of the scene and its film at the peak."""
    law: Law
    prices: Mapping[float, Estimate]
    """Seconds to each of `TARGETS` that the pilot has not reached."""
    pilot_seconds: float
    """What the quote itself took."""

    def as_dict(self) -> dict[str, Any]:
        """Return the quote as JSON data."""
        return {
            "seconds": self.seconds.as_dict(),
            "spp": self.spp.as_dict(),
            "error": self.error.as_dict(),
            "memory": self.memory,
            "law": self.law.as_dict(),
            "prices": [{"error": target, "seconds": price.as_dict()} for target, price in self.prices.items()],
            "pilot_seconds": self.pilot_seconds,
        }


def quote(
    scene: Scene,
    error: float | None = None,
    time: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: ProgressCallback | None = None,
) -> Quote:
    """Say what an error will cost, or what a time will buy.

    Renders a pilot of 8 samples a pixel, or of a twentieth of the work if that is more.

    Parameters
    ----------
    error, time
        Exactly one: the relative error to reach (0.02 is 2 %), or the seconds to spend.

    Raises
    ------
    RenderError
        If the pilot saw no light, so that nothing can be said.
    ValueError
        If not exactly one of ``error`` and ``time`` is given.
    """
    if (error is None) == (time is None):
        raise ValueError("a quote takes an error or a time, one of them")
    chosen = strategy if isinstance(strategy, Strategy) else Strategy.parse(strategy)
    session = Session(scene, chosen, seed, threads, Limits(spp=FIRST_LOOK), progress)
    pilot = Pilot(session, error, time)
    while True:
        for _ in session.passes:
            pilot.pass_ended()
        found = pilot.quote()
        share = 2 * math.floor(0.5 * _PILOT_SHARE * found.spp.value)
        if share <= session.passes.samples:
            return found
        session.passes.limits = Limits(spp=share)


class Pilot:
    """Watches the first passes of a render, whose own it may be, and makes a quote of them."""

    def __init__(self, session: Session, error: float | None, time: float | None) -> None:
        self._session, self._error, self._time = session, error, time
        self._errors: dict[int, Estimate] = {}
        self._seconds: dict[int, float] = {}

    def pass_ended(self) -> None:
        """Note the error and the time after 2, 4, 8, … samples, and at the end of what was asked for."""
        passes = self._session.passes
        if passes.samples.bit_count() == 1 or passes.samples == passes.limits.spp:
            self._errors[passes.samples], self._seconds[passes.samples] = self._session.error(), passes.rendering

    def quote(self) -> Quote:
        """Return the quote by what was noted; raises `RenderError` if that is nothing."""
        last = self._errors[max(self._errors)]
        if not (last.known and last.value > 0.0 and math.isfinite(last.high)):
            raise RenderError("the pilot saw no light, or too little to say how fast the error falls")
        law = fit(self._errors, self._seconds, self._session.strategy.sampler)
        if self._error is not None:
            spp = law.samples_until(self._error)
            seconds = law.seconds_for(spp)
        else:
            assert self._time is not None
            spp = law.samples_in(self._time)
            seconds = Estimate(self._time, self._time, self._time)
        return Quote(
            seconds=seconds,
            spp=spp,
            error=law.error_at(spp.value),
            memory=self._session.scene_bytes + self._session.passes.pixels * _BYTES_PER_PIXEL,
            law=law,
            prices={target: law.seconds_for(law.samples_until(target)) for target in TARGETS if target < law.error},
            pilot_seconds=self._session.passes.rendering,
        )
