"""Comparison of published numbers with the numbers that an experiment measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from equaltime.experiments.model.experiment import Quantity, TheirNumber, Theirs
from equaltime.experiments.model.summary import Beside, SceneResult, StrategyResult, Summary
from equaltime.statistics.intervals import UNKNOWN, Interval

__all__ = ["beside"]


def beside(theirs: Theirs, summary: Summary) -> tuple[Beside, ...]:
    """Return the measured number that belongs to each number published in the claim ``theirs``, in order.

    Each result holds the published number and the measured interval. If a number was not measured, its interval is
    unknown and has a note with the reason.
    """
    return tuple(_beside(number, summary) for number in theirs.numbers)


def _beside(number: TheirNumber, summary: Summary) -> Beside:
    scene = next((one for one in summary.scenes if number.scene in ("", one.name)), None)
    found = [] if scene is None else [one for one in scene.strategies if one.label == number.strategy]
    base = [] if scene is None else [one for one in scene.strategies if one.label == scene.baseline]
    line = Beside(number.what, number.says, number.ours, number.strategy, scene.name if scene else number.scene)
    if scene is None or not found or not base:
        return replace(line, value=replace(UNKNOWN, note="it has not run"))
    own = _Own(scene, found[0], base[0])
    if number.ours not in _AT_A_TARGET:
        return replace(line, value=_MEASURED[number.ours](own))
    targets = summary.targets if number.target is None else (number.target,)
    values = {target: _at(number.ours, own, target) for target in targets}
    target = _best(values)
    return replace(line, value=values[target], target=target)


@dataclass(frozen=True)
class _Own:
    """Strategy and baseline on the scene from which a number is computed."""

    scene: SceneResult
    strategy: StrategyResult
    baseline: StrategyResult


def _of_a_sample(strategy: StrategyResult) -> Interval:
    curve = strategy.curve
    return curve.seconds[-1].map(lambda seconds: seconds / curve.spp[-1]) if curve.spp else UNKNOWN


def _equality(own: _Own) -> Interval:
    p = own.strategy.equality_p
    if p is None:
        return replace(UNKNOWN, note=f"it is the standard strategy of {own.scene.name}, or has too few repeats")
    return Interval(p, p, p)


_MEASURED: Mapping[Quantity, Callable[[_Own], Interval]] = {
    "slope": lambda own: own.strategy.curve.slope,
    "error": lambda own: own.strategy.error_at_budget,
    "last error": lambda own: own.strategy.curve.error[-1] if own.strategy.curve.error else UNKNOWN,
    "bias": lambda own: own.strategy.bias or UNKNOWN,
    "p": _equality,
    "fewer samples": lambda own: own.strategy.fewer_samples,
    "efficiency": lambda own: own.strategy.efficiency,
    "time of a sample": lambda own: _over(_of_a_sample(own.strategy), _of_a_sample(own.baseline)),
}
"""Functions that compute each quantity without a target.

Of a strategy: slope of its error, error at equal time and after all samples, bias, p-value against the standard's
expectation. Relative to the baseline: samples to equal error, efficiency of typical runs, time of a sample."""

_AT_A_TARGET = ("speed-up", "time", "samples")


def _at(quantity: Quantity, own: _Own, target: float) -> Interval:
    """Return the time or samples to an error, or the baseline's time over this one's."""
    time = own.strategy.time_to.get(target, UNKNOWN)
    if quantity == "speed-up":
        return own.strategy.ratio.get(target, UNKNOWN)
    return time if quantity == "time" else _over(time, _of_a_sample(own.strategy))


def _over(one: Interval, other: Interval) -> Interval:
    """Divide two independently measured intervals; keep the notes of the numerator."""
    numbers = (one.value, one.low, one.high, other.value, other.low, other.high)
    if not all(0.0 < number < math.inf for number in numbers):
        return replace(UNKNOWN, value=one.value if math.isinf(one.value) else math.nan, note=one.note or other.note)
    below = math.hypot(math.log(one.value / one.low), math.log(other.high / other.value))
    above = math.hypot(math.log(one.high / one.value), math.log(other.value / other.low))
    value = one.value / other.value
    found = replace(one, value=value, low=value * math.exp(-below), high=value * math.exp(above))
    return (found if other.trusted else found.doubted(other.note)).telling()


def _best(values: Mapping[float, Interval]) -> float:
    """Return the smallest target with a trusted number, preferably one within the runs.

    Otherwise return the smallest target whose number has one valid end, else the largest target.
    """
    trusted = [t for t, value in values.items() if value.trusted and value.value > 0.0 and math.isfinite(value.high)]
    within = [target for target in trusted if values[target].reach == 1.0]
    bounded = [target for target, value in values.items() if value.bound and value.known]
    return min(within or trusted or bounded or [max(values)])
