"""The verdict of an experiment in one sentence, made of numbers that can be trusted or of none."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from equaltime.cost.statistics import Interval
from equaltime.cost.summary import SceneResult, StrategyResult

__all__ = ["pick_standard", "product_mean", "verdict"]

_TIMES = "\N{MULTIPLICATION SIGN}"


def pick_standard(labels: Sequence[str], biased: Sequence[bool], errors: Sequence[float]) -> str | None:
    """Return the label of what others are held against: ``best``, else the unbiased strategy that errs least."""
    unbiased = [(e, label) for label, b, e in zip(labels, biased, errors, strict=True) if not b]
    if any(label == "best" for _, label in unbiased):
        return "best"
    return min(unbiased, key=lambda one: one[0] if math.isfinite(one[0]) else math.inf)[1] if unbiased else None


def product_mean(intervals: Sequence[Interval]) -> Interval:
    """Return the geometric mean of positive numbers that were measured apart, with the interval that their own give."""
    logs = [[math.log(x) for x in (i.value, i.low, i.high)] for i in intervals]
    mean = sum(value for value, _, _ in logs) / len(logs)
    below = math.sqrt(sum((value - low) ** 2 for value, low, _ in logs)) / len(logs)
    above = math.sqrt(sum((high - value) ** 2 for value, _, high in logs)) / len(logs)
    trusted = all(interval.trusted for interval in intervals)
    return Interval(math.exp(mean), math.exp(mean - below), math.exp(mean + above), trusted)


def verdict(scenes: Sequence[SceneResult], targets: Sequence[float]) -> str:
    """Say how fast the standard strategy is, and how much faster than the baseline.

    At the smallest error to which both can be given with intervals that are trusted, on all scenes if possible; numbers
    that lie beyond the runs only if there are no others.
    """
    for extrapolated in (False, True):
        for target in sorted(targets):
            found = [one for scene in scenes if (one := _at(scene, target, extrapolated)) is not None]
            if found and len(found) == len(scenes):
                return _sentence(found, target, len(scenes), extrapolated)
    for target in sorted(targets):
        found = [one for scene in scenes if (one := _at(scene, target, True)) is not None]
        if found:
            return _sentence(found, target, len(scenes), True)
    return _without_ratio(scenes, targets)


_Found = tuple[SceneResult, StrategyResult]


def _at(scene: SceneResult, target: float, extrapolated: bool) -> _Found | None:
    for strategy in scene.strategies:
        if strategy.label == scene.standard and strategy.label != scene.baseline:
            numbers = strategy.time_to.get(target), strategy.ratio.get(target)
            good = all(n is not None and _sound(n) and (extrapolated or not n.note) for n in numbers)
            return (scene, strategy) if good else None
    return None


def _sound(interval: Interval) -> bool:
    return interval.trusted and all(0.0 < x < math.inf for x in (interval.value, interval.low, interval.high))


def _sentence(found: Sequence[_Found], target: float, count: int, extrapolated: bool) -> str:
    times = [strategy.time_to[target] for _, strategy in found]
    ratios = [strategy.ratio[target] for _, strategy in found]
    labels = _joined(strategy.label for _, strategy in found)
    time, ratio = product_mean(times), product_mean(ratios)
    low, value, high = (x if ratio.value >= 1.0 else 1.0 / x for x in (ratio.low, ratio.value, ratio.high))
    low, high = min(low, high), max(low, high)
    word = "faster" if ratio.value >= 1.0 else "slower"
    where = ""
    if count > 1:
        where = f" (geometric means of {len(found)} of {count} scenes)"
    said = "; partly extrapolated" if extrapolated and any(i.note for i in (*times, *ratios)) else ""
    return (
        f"{labels}: {100 * target:.3g} % in {_seconds(time)}, {value:.3g}{_TIMES} [{low:.3g}, {high:.3g}] {word} than "
        f"{_joined(scene.baseline for scene, _ in found)}{where}{said}"
    )


def _without_ratio(scenes: Sequence[SceneResult], targets: Sequence[float]) -> str:
    """Say the time alone, for the first scene that has one, within the runs if possible; or that there is none."""
    for extrapolated in (False, True):
        for target in sorted(targets):
            for scene in scenes:
                for strategy in scene.strategies:
                    time = strategy.time_to[target]
                    if strategy.label == scene.standard and _sound(time) and (extrapolated or not time.note):
                        on = f" on {scene.name}" if len(scenes) > 1 else ""
                        begin = f"{strategy.label}: {100 * target:.3g} % in {_seconds(time)}{on}"
                        return begin + (f" ({time.note})" if time.note else "") + _why_alone(scene, strategy)
    return f"no strategy's time to a wanted error can be told with an interval that is trusted{_reasons(scenes)}"


def _why_alone(scene: SceneResult, strategy: StrategyResult) -> str:
    if strategy.label == scene.baseline:
        return "" if len(scene.strategies) == 1 else "; it is the baseline"
    notes = next((s.notes for s in scene.strategies if s.label == scene.baseline), ())
    reason = f" (there: {notes[0]})" if notes else ""
    return f"; how much faster than {scene.baseline} cannot be told with an interval that is trusted{reason}"


def _reasons(scenes: Sequence[SceneResult]) -> str:
    notes = (n.note for s in scenes for strategy in s.strategies for n in strategy.time_to.values() if not n.trusted)
    first = next((note for note in notes if note), "")
    return f": {first}" if first else ""


def _joined(labels: Iterable[str]) -> str:
    return " / ".join(_each_once(labels))


def _each_once(labels: Iterable[str]) -> Iterator[str]:
    return iter(dict.fromkeys(labels))


def _seconds(time: Interval) -> str:
    return f"{time.value:.3g} s [{time.low:.3g}, {time.high:.3g}]"
