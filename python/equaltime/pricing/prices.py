"""The price list: time, memory and noise of each effect that a scene uses."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.pricing.output_costs import ALL, measure_outputs
from equaltime.quoting.light_parts import KINDS_OF_PARTS
from equaltime.quoting.noise_parts import NoiseParts, measure_noise_parts
from equaltime.quoting.pairs import Versus, run_in_turn
from equaltime.rendering.job import as_scene, check_arguments
from equaltime.rendering.stated import shorter
from equaltime.scene import Scene
from equaltime.scene.effects.kinds import KINDS, Effect, Reason, derive, kind_of
from equaltime.scene.effects.leaving import can_leave_out
from equaltime.scene.scene import smaller
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy
from equaltime.words import Shown

__all__ = ["LITTLE", "Price", "PriceList", "effects"]

LITTLE = 0.02
"""Largest relative error of the image that a cut of long paths may make, for which `PriceList.cut` states the cost."""

MOST_PIXELS = 128 * 128
"""Largest number of pixels of the film on which the cost of effects (features such as media) is measured, unless a size
is given."""
REPEATS, SAMPLES = 12, 16
QUICK_PIXELS, QUICK_REPEATS, QUICK_SAMPLES = 64 * 64, 6, 8


@dataclass(frozen=True, eq=False)
class Price:
    """Cost of one effect (feature of a scene, such as media) in time, variance and memory.

    Intervals are at 95 %. A field that is not known is None.
    """

    kind: Effect
    """The effect (feature of a scene, such as media): its name, title, and stand-in."""
    reasons: tuple[Reason, ...]
    """Objects of the scene that use the effect, each with its position in the scene file."""
    instead: str | None
    """Stand-in that replaces the effect where it is left out, such as ``vacuum``; None if it cannot be left out of this
    scene."""
    time: Interval | None = None
    """Share of the time of a sample that the effect (feature such as media) takes, as a fraction."""
    variance: Interval | None = None
    """Share of the variance, and so of the squared error, that the effect (feature such as media) makes, as a fraction.
    """
    change: Interval | None = None
    """Relative error of the image if the effect (feature such as media) is left out: 0.02 is 2 %."""
    memory: int | None = None
    """Bytes of memory that the effect (feature such as media) takes in the core."""
    difference: NDArray[np.float64] | None = None
    """(H, W, 3): the image without the effect (feature such as media), minus the full image."""

    def as_dict(self) -> dict[str, Any]:
        """Return the price as JSON data, without the image ``difference``."""
        intervals = {"time": self.time, "variance": self.variance, "change": self.change}
        return {
            "name": self.kind.name,
            "title": self.kind.title,
            "reasons": [{"place": reason.place, "what": reason.what} for reason in self.reasons],
            "instead": self.instead,
            **{name: None if interval is None else interval.as_dict() for name, interval in intervals.items()},
            "memory": self.memory,
        }


@dataclass(frozen=True, eq=False, repr=False)
class PriceList(Shown):
    """Costs of the effects (such as media) that a scene uses, and its variance split by kind of light."""

    prices: tuple[Price, ...]
    """Cost of each effect (feature such as media) that the scene uses, in time, variance and memory."""
    free: tuple[str, ...]
    """Names of the effects (features such as media) that the scene does not use, which cost neither time nor memory."""
    shares: Mapping[str, Mapping[str, Interval]]
    """Shares of the variance by kind of part, then by name. Kinds are ``length`` of the path, ``way`` (technique), last
    ``bsdf``, last ``surface``, and ``light`` source; the shares of each kind sum to 1."""
    truncated: Mapping[int, Interval]
    """Relative error of the image if paths are cut at a depth, by that depth in segments, as fractions."""
    outputs: Mapping[str, Interval]
    """Share of the time that each output beside the image takes, by ``name:kind``, such as ``distance:depth``."""
    size: tuple[int, int]
    """Width and height of the measured film, in pixels."""
    samples: int
    """Samples per pixel in each repeat of the measurement."""
    repeats: int
    strategy: str
    memory: int
    """Bytes of memory that the scene takes in the core."""
    max_depth: int
    """Length of the longest paths that were measured, in Mitsuba's counting; -1 if there is no limit."""
    scene_max_depth: int
    """The ``max_depth`` that the scene's file asks for."""
    cut: Price | None = None
    """Cost of paths longer than the smallest depth whose cut changes the image by at most `LITTLE`, its ``instead``
    ``truncate=N``; None if there is no such depth."""
    doubt: str = ""
    """Reason, in words, why shares of the noise cannot be trusted: few bright paths make it. Empty if they can be
    trusted."""

    def __str__(self) -> str:
        called = ", ".join(price.kind.name for price in self.prices) or "no effect"
        lines = [f"the scene calls for {called}; {len(self.free)} other effects cost nothing"]
        for price in self.prices:
            if price.time is not None and price.change is not None:
                lines.append(
                    f"{price.kind.name}: {price.time:%} of the time; without it the image is {price.change:%} off"
                )
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name as JSON data; ``prices`` are named ``effects``."""
        return {
            "effects": [price.as_dict() for price in self.prices],
            "free": list(self.free),
            "shares": {
                kind: {what: share.as_dict() for what, share in shares.items()} for kind, shares in self.shares.items()
            },
            "truncated": {str(depth): error.as_dict() for depth, error in self.truncated.items()},
            "cut": None if self.cut is None else self.cut.as_dict(),
            "outputs": {name: share.as_dict() for name, share in self.outputs.items()},
            "size": list(self.size),
            "samples": self.samples,
            "repeats": self.repeats,
            "strategy": self.strategy,
            "memory": self.memory,
            "max_depth": self.max_depth,
            "scene_max_depth": self.scene_max_depth,
            **({"doubt": self.doubt} if self.doubt else {}),
        }


def effects(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    quick: bool = False,
    size: tuple[int, int] | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
) -> PriceList:
    """Return the measured cost of each effect (feature such as media or textures) that a scene uses.

    The scene is rendered in turn with each of its variants, which leave one effect out, with the same random numbers.
    Then its noise is divided among kinds of light (`equaltime.quoting.noise_parts`), and its outputs beside the image
    are timed.

    Parameters
    ----------
    scene
        A loaded scene, the path of a scene file, or a dict with Mitsuba's keys.
    quick
        Quick estimate: a small film, few samples, few repeats.
    size
        Width and height of the film to measure; by default the scene's, reduced if that is large.
    strategy
        A `Strategy`, or text for `Strategy.parse`.
    seed
        First seed; each repeat takes the next one.
    threads
        Number of threads; 0 is one for each processor.
    progress
        Called with the finished share of the work, in [0, 1].

    Raises
    ------
    SceneError, StrategyError
        If the scene cannot be built, or the strategy cannot be read.
    NonFiniteSample
        If a sample is NaN or infinite.

    Examples
    --------
    >>> prices = et.effects("scene.toml", quick=True)
    >>> [price.kind.name for price in prices.prices]
    ['long_paths']
    """
    check_arguments(seed=seed, threads=threads)
    chosen, scene = Strategy.of(strategy), as_scene(scene)
    most, repeats, samples = (QUICK_PIXELS, QUICK_REPEATS, QUICK_SAMPLES) if quick else (MOST_PIXELS, REPEATS, SAMPLES)
    small, seed = scene.with_(size=size) if size else smaller(scene, most), min(seed, 2**64 - 1 - repeats)
    reasons = derive(small)
    variants = {name: (name,) for name in reasons if kind_of(name).instead and can_leave_out(small, chosen, name)}
    parts = measure_noise_parts(small, chosen, repeats, samples, seed, threads, _part_of(progress, 0.0, 0.3))
    truncated = parts.truncated()
    depth = _depth_of_cut(truncated) if "long_paths" in variants else None
    cut = {} if depth is None else {"cut": (f"long_paths={depth}",)}
    end = 0.9 if "outputs" in reasons else 1.0
    whole, less = run_in_turn(
        small, chosen, {**variants, **cut}, repeats, samples, seed, threads, _part_of(progress, 0.3, end)
    )
    beside = dict(measure_outputs(small, chosen, repeats, samples, seed, threads, _part_of(progress, end, 1.0)))
    together = {"outputs": beside.pop(ALL, None)}
    prices = [
        _price(kind_of(name), why, parts, time=together.get(name))
        for name, why in reasons.items()
        if name not in variants
    ]
    prices += [_price(KINDS[name], reasons[name], parts, Versus.of(whole, less[name])) for name in variants]
    order = list(reasons)
    return PriceList(
        prices=tuple(sorted(prices, key=lambda price: order.index(price.kind.name))),
        free=tuple(name for name in dict.fromkeys((*small.core.effects(), *KINDS)) if name not in reasons),
        shares={kind: parts.shares(kind) for kind in KINDS_OF_PARTS},
        truncated=truncated,
        cut=None
        if depth is None
        else _cut(depth, reasons["long_paths"], truncated, parts, Versus.of(whole, less["cut"])),
        outputs=beside,
        size=small.model.sensor.film.crop[2:],
        samples=samples,
        repeats=repeats,
        strategy=chosen.name,
        memory=small.core.memory_bytes,
        max_depth=shorter(small.max_depth, chosen.truncate),
        scene_max_depth=small.own_max_depth,
        doubt=parts.doubt,
    )


def _depth_of_cut(truncated: Mapping[int, Interval]) -> int | None:
    """Return the smallest depth whose cut changes the image by at most `LITTLE`; None if no depth is known to."""
    return next((depth for depth, error in truncated.items() if depth > 1 and _is_little(error)), None)


def _is_little(change: Interval) -> bool:
    """Tell whether a relative change of the image is at most `LITTLE`, up to its upper end."""
    return change.trusted and change.high <= LITTLE


def _cut(
    depth: int, reasons: tuple[Reason, ...], truncated: Mapping[int, Interval], parts: NoiseParts, versus: Versus
) -> Price:
    """Return the cost of paths longer than ``depth``."""
    share = parts.share("length", lambda what: int(what.split()[0]) > depth)
    return Price(
        KINDS["long_paths"],
        reasons,
        f"truncate={depth}",
        time=versus.time,
        variance=share or versus.variance,
        change=truncated[depth],
        memory=versus.memory,
        difference=versus.difference,
    )


def _price(
    kind: Effect,
    reasons: tuple[Reason, ...],
    parts: NoiseParts,
    versus: Versus | None = None,
    time: Interval | None = None,
) -> Price:
    share = _share(kind, parts)
    if versus is None:
        return Price(kind, reasons, None, time=time, variance=share)
    return Price(
        kind=kind,
        reasons=reasons,
        instead=kind.instead,
        time=versus.time,
        variance=share or versus.variance,
        change=versus.change,
        memory=versus.memory,
        difference=versus.difference,
    )


def _share(kind: Effect, parts: NoiseParts) -> Interval | None:
    """Return the variance share of light that the core tells apart, for effects that are such a light; else None."""
    if kind.scatterers:
        return parts.share("bsdf", lambda what: what in kind.scatterers)
    if kind.name == "environment":
        return parts.share("light", lambda what: what == "environment")
    if kind.name == "point_lights":
        return parts.share("light", lambda what: what.startswith("light "))
    if kind.name == "long_paths":
        return parts.share("length", lambda what: int(what.split()[0]) > 2)
    return None


def _part_of(progress: Callable[[float], object] | None, first: float, last: float) -> Callable[[float], object] | None:
    return None if progress is None else lambda share: progress(first + share * (last - first))
