"""Quotes: what an error will cost in time, or what error a time will buy, from a short pilot.

A pilot of all pixels gives the error at its end, the exponent by which it falls (`equaltime.law`) and the time of a
sample. Of low-discrepancy samples the exponent beyond differs by 0.06 (a standard deviation) from that within, whatever
the pilot saw: over a factor of twenty that leaves 0.3 to the logarithm of the samples, and half of such quotes would be
within 20 %. So more than half of the pilot's samples go to a probe: a few hundred pixels that are rendered as far as
the whole will have to be (`equaltime.probe`), with looks at the error where the render itself would look. Pilot and
probe together are at most a twentieth of the work, or 8 samples a pixel. Intervals are at 95 %: what the pixels that
were not drawn leave in doubt, what chance makes of the samples to come, and the speed of the machine. Heavy tails leave
more, and the quote says so where the pilot has met them.
"""

from __future__ import annotations

import math
import os
import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from equaltime.arguments import as_scene, check_arguments
from equaltime.budget import FIRST_LOOK, Limits
from equaltime.error_estimate import Estimate, Unit, load_quantiles
from equaltime.errors import RenderError
from equaltime.law import Law, Probed, fit
from equaltime.noise_places import Places
from equaltime.progress import ProgressCallback
from equaltime.scene import Scene
from equaltime.session import Session
from equaltime.strategy import Strategy

if TYPE_CHECKING:
    from equaltime.noise_light import NoiseLight

__all__ = ["TARGETS", "Pilot", "Quote", "quote"]

TARGETS = (0.20, 0.10, 0.05, 0.02, 0.01)
"""Errors whose price every quote tells."""

_PILOT_SHARE = 0.05
_FIRST = 4
"""Samples a pixel, at least, of a pilot whose samples are not to adapt."""
_SHARE_OF_ALL_PIXELS = 0.4
"""Of a pilot; the rest is for the probe (`equaltime.probe`), if there is one."""
_PROBE_SHARE = 0.9
"""Of what is left for a probe: more may be needed than was foretold."""
_LEAST_DRAWS, _MOST_DRAWS = 16, 4096
_SHARE_FOR_LIGHT = 0.1
"""Of the pilot, to take the light apart."""
_BYTES_PER_PIXEL = 219


@dataclass(frozen=True)
class Quote:
    """What a render will cost, or bring."""

    seconds: Estimate
    """From the first sample to the final film."""
    spp: Estimate
    """Samples per pixel."""
    error: Estimate
    """Of the image at the end; in doubt if the pilot's error was (`equaltime.tails`)."""
    memory: int
    """Bytes of the scene and its film at the peak."""
    law: Law
    prices: Mapping[float, Estimate]
    """Seconds to each of `TARGETS` that the pilot has not reached."""
    pilot_seconds: float
    """What the pilot took to render, and telling what limits it."""
    places: Places | None = None
    """Where on the picture the error is; None where a render quotes itself."""
    light: NoiseLight | None = None
    """Which light makes the noise; None if that was not asked for, or there was no room for it in the pilot."""

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
            **({} if self.places is None else {"places": self.places.as_dict()}),
            **({} if self.light is None else {"light": self.light.as_dict()}),
        }


def quote(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    error: float | None = None,
    time: float | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: ProgressCallback | None = None,
    why: bool | None = None,
) -> Quote:
    """Say what an error will cost, or what a time will buy, and what limits it.

    Renders a pilot and a probe of 8 samples a pixel, or of a twentieth of the work if that is more. Of the latter a
    tenth is kept to tell which light makes the noise, on a small film (`equaltime.noise_light`).

    Parameters
    ----------
    scene, strategy, seed, threads, progress
        As `equaltime.render` takes them.
    error, time
        Exactly one: the relative error to reach (0.02 is 2 %), or the seconds to spend.
    why
        Tell which light makes the noise: if there is room for it in the pilot, or always, with as much work as the
        pilot if need be (True), or never (False).

    Raises
    ------
    SceneError, StrategyError
        If the scene or the strategy cannot be read.
    RenderError
        If the pilot saw no light, so that nothing can be said.
    ValueError
        If not exactly one of ``error`` and ``time`` is given, or an argument is out of range, or of another type.
    """
    if (error is None) == (time is None):
        raise ValueError("a quote takes an error or a time, one of them")
    check_arguments(time=time, error=error, seed=seed, threads=threads)
    chosen = strategy if isinstance(strategy, Strategy) else Strategy.parse(strategy)
    loaded = as_scene(scene)
    session = Session(loaded, chosen, seed, threads, Limits(spp=FIRST_LOOK), progress)
    pilot = Pilot(session, Limits(error=error, seconds=time), 1.0 if why is False else 1.0 - _SHARE_FOR_LIGHT)
    while True:
        for _ in session.passes:
            if (found := pilot.pass_ended()) is not None:
                begin = clock.perf_counter()
                light = None if why is False else _light(loaded, pilot, why is True, seed, threads)
                found = replace(found, places=session.places(), light=light)
                return replace(found, pilot_seconds=found.pilot_seconds + clock.perf_counter() - begin)
        if session.passes.stopped_by == "interrupt":
            raise KeyboardInterrupt
        session.result("unfinished")  # raises if a sample went wrong
        session.passes.limits = Limits(spp=pilot.due)


def _light(scene: Scene, pilot: Pilot, always: bool, seed: int, threads: int) -> NoiseLight | None:
    """Take the light apart by the work that the pilot left, or if need be by as much as it took."""
    from equaltime.noise_light import LEAST_PATHS, noise_light  # here, since it measures by what measures renders

    paths = max(pilot.left, LEAST_PATHS, pilot.taken) if always else pilot.left
    return noise_light(scene, pilot.strategy, paths, seed, threads)


class Pilot:
    """Watches the first passes of a render, whose own it may be, and makes a quote of them.

    Parameters
    ----------
    limits
        What is asked for, one at least: where the nearest ends the render is quoted.
    share
        Of the twentieth of the work, to be taken, with the probe.
    probes
        Whether to take a probe: its samples are none of the render's.
    """

    def __init__(self, session: Session, limits: Limits, share: float = 1.0, probes: bool = True) -> None:
        self._session, self._limits, self._share, self._probes = session, limits, share, probes
        self._errors: dict[int, Estimate] = {}
        self._seconds: dict[int, float] = {}
        self.due = _FIRST if probes and session.strategy.adaptive == "none" else FIRST_LOOK
        """Samples a pixel at which there may be a quote."""
        self._work = self._probed = self._seconds_probed = 0.0
        load_quantiles()

    @property
    def strategy(self) -> Strategy:
        """Whose pilot it is."""
        return self._session.strategy

    @property
    def taken(self) -> float:
        """Samples of the image that the pilot has, with the probe's."""
        return self._session.passes.samples * self._session.passes.pixels + self._probed

    @property
    def left(self) -> float:
        """Samples of the image that are left of what a pilot may take."""
        most = max(FIRST_LOOK, _PILOT_SHARE * self._work)
        return max(0.0, most * self._session.passes.pixels - self.taken)

    def pass_ended(self) -> Quote | None:
        """Return the quote, if that was the pass after which enough is known.

        The error is noted after 2, 4, 8, … samples, half way between, and where a quote may be due; raises
        `RenderError` if one is due and the pilot saw no light.
        """
        passes = self._session.passes
        samples, due = passes.samples, passes.samples >= self.due
        self._seconds[samples] = passes.rendering
        if due or _is_noted(samples):
            self._errors[samples] = self._session.error()
        if not due:
            return None
        if samples < FIRST_LOOK and not self._errors[samples].high < math.inf:
            self.due = FIRST_LOOK
            return None
        law = self._law()
        self._work = self._end(law)[0].value
        of_all_pixels = _SHARE_OF_ALL_PIXELS if self._probes else 1.0
        enough = self._share * of_all_pixels * _PILOT_SHARE * self._work
        self.due = min(2 * math.floor(0.5 * enough), 2 * samples)  # as far as what so few samples foretell may be wrong
        return self._quote(self._probe(law)) if self.due <= samples else None

    def _law(self) -> Law:
        last = self._errors[max(self._errors)]
        if last.known and last.high == 0.0 and self._session.image().any():
            raise RenderError("the pilot saw no noise: as few samples as it took are exact")
        if not (last.known and last.value > 0.0 and math.isfinite(last.high)):
            raise RenderError("the pilot saw no light, or too little to say how fast the error falls")
        return fit(self._errors, self._seconds, self._session.strategy.sampler)

    def _probe(self, pilot: Law) -> Law:
        """Return the law that goes through what some pixels show where the render will end."""
        law, probed, sampler = pilot, list[Probed](), self._session.strategy.sampler
        begin, spare = clock.perf_counter(), self._share * self.left
        draws = min(_MOST_DRAWS, math.floor(_PROBE_SHARE * spare / self._work))
        if draws < _LEAST_DRAWS or not self._probes:
            return law
        probe = self._session.probe(round(self._work), draws)
        most = probe.most_samples(spare)
        while (samples := min(self._next(law), most)) > law.samples and (found := probe.advance(samples)) is not None:
            probed.append(found)
            law = pilot.through(probed, sampler)
        self._probed, self._seconds_probed = probe.taken, clock.perf_counter() - begin
        return law

    def _next(self, law: Law) -> int:
        """Return to how many samples a pixel the probe goes next, which is where the render would look; or no more."""
        limits, ends = self._limits, list[float]()
        if limits.error is not None:
            ends.append(next((n for n in law.looks_until(limits.error) if n > law.samples), 0))
        if limits.seconds is not None:
            ends.append(law.samples_in(limits.seconds).value)
        if limits.spp is not None:
            ends.append(limits.spp)
        return 2 * round(0.5 * min(ends))

    def _quote(self, law: Law) -> Quote:
        spp, seconds = self._end(law)
        first = self._errors[max(self._errors)]
        return Quote(
            seconds=seconds,
            spp=spp,
            error=replace(law.error_at(spp.value), doubt=first.doubt),
            memory=self._session.scene_bytes + self._session.passes.pixels * _BYTES_PER_PIXEL,
            law=law,
            prices={target: law.seconds_for(law.samples_until(target)) for target in TARGETS if target < first.value},
            pilot_seconds=self._session.passes.rendering + self._seconds_probed,
        )

    def _end(self, law: Law) -> tuple[Estimate, Estimate]:
        """Return the samples a pixel and the seconds at which the nearest of the limits ends the render."""
        limits, ends = self._limits, list[tuple[Estimate, Estimate]]()
        if limits.error is not None:
            spp = law.samples_until(limits.error)
            ends.append((spp, law.seconds_for(spp)))
        if limits.seconds is not None:
            ends.append((law.samples_in(limits.seconds), _exactly(limits.seconds, "s")))
        if limits.spp is not None:
            ends.append((_exactly(limits.spp, "spp"), law.seconds_for(_exactly(limits.spp, "spp"))))
        return min(ends, key=lambda end: end[0].value)


def _exactly(number: float, unit: Unit) -> Estimate:
    return Estimate(number, number, number, unit=unit)


def _is_noted(samples: int) -> bool:
    return samples.bit_count() == 1 or (samples % 3 == 0 and (samples // 3).bit_count() == 1)
