"""The verdict of an experiment: one sentence, only with numbers whose intervals can be trusted."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from equaltime.experiments.model.experiment import Question
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.curves import TYPICAL
from equaltime.statistics.intervals import Interval, product_mean, sound, sound_below
from equaltime.words import percent

__all__ = ["bias_verdict", "efficiency_verdict", "pick_standard", "samples_verdict", "verdict"]

_TIMES = "\N{MULTIPLICATION SIGN}"


def pick_standard(labels: Sequence[str], biased: Sequence[bool], errors: Sequence[float]) -> str | None:
    """Return the label of the standard strategy, against which other strategies are tested for bias.

    The standard is ``best`` if it is unbiased, else the unbiased strategy with the smallest of ``errors``. Returns None
    if all strategies are biased.
    """
    unbiased = [(e, label) for label, b, e in zip(labels, biased, errors, strict=True) if not b]
    if any(label == "best" for _, label in unbiased):
        return "best"
    return min(unbiased, key=lambda one: one[0] if math.isfinite(one[0]) else math.inf)[1] if unbiased else None


def verdict(scenes: Sequence[SceneResult], targets: Sequence[float], question: Question = "time") -> str:
    """Return the sentence that answers an experiment's question.

    For the question ``time`` the answer has two numbers: the standard strategy's time to an error, and its speed-up
    over the baseline. Both numbers are for the smallest target error at which their intervals are trusted, on all
    scenes if possible. Numbers that need no extrapolation are preferred, then numbers for which only the baseline is
    extrapolated. Without a trusted speed-up, a speed-up with a trusted lower limit is used.
    """
    if question == "bias":
        return bias_verdict(scenes, LEVEL)
    if question == "samples":
        return samples_verdict(scenes)
    if question == "efficiency":
        return efficiency_verdict(scenes)
    for all_scenes in (True, False):
        for ratio_is_good in (sound, sound_below):
            for reach in _REACHES:
                for target in sorted(targets):
                    found = [one for scene in scenes if (one := _at(scene, target, reach, ratio_is_good)) is not None]
                    if found and (len(found) == len(scenes) or not all_scenes):
                        return _sentence(found, target, len(scenes))
    return _without_ratio(scenes, targets)


_Found = tuple[SceneResult, StrategyResult]
_Test = Callable[[Interval], bool]

_REACHES: tuple[Callable[[Interval, Interval], bool], ...] = (
    lambda time, ratio: time.reach == ratio.reach == 1.0,
    lambda time, ratio: time.reach == 1.0,
    lambda time, ratio: True,
)
"""Tests of how far time and ratio are extrapolated, in order of preference: neither, only the ratio, any."""


def _at(scene: SceneResult, target: float, reach: Callable[[Interval, Interval], bool], good: _Test) -> _Found | None:
    for _, strategy in _standards((scene,)):
        if strategy.label != scene.baseline:
            time, ratio = strategy.time_to.get(target), strategy.ratio.get(target)
            if time is not None and ratio is not None and sound(time) and good(ratio) and reach(time, ratio):
                return scene, strategy
    return None


def _sentence(found: Sequence[_Found], target: float, count: int) -> str:
    times = [strategy.time_to[target] for _, strategy in found]
    ratios = [strategy.ratio[target] for _, strategy in found]
    baseline = _joined(scene.baseline for scene, _ in found)
    time, ratio = product_mean(times), product_mean(ratios)
    where, said = _where([scene.name for scene, _ in found], count), ""
    if (reach := max(i.reach for i in times)) > 1.0:
        said = f"; partly extrapolated, {_farthest(reach, len(found))}"
    elif (reach := max(i.reach for i in ratios)) > 1.0:
        said = f"; {baseline} is extrapolated, {_farthest(reach, len(found))}"
    if any(TYPICAL in interval.note for interval in (*times, *ratios)):
        said += f"; {TYPICAL}, since few events make most of the error"
    if not ratio.trusted:
        said += "; how much more is not known"
    labels = _joined(strategy.label for _, strategy in found)
    return f"{labels}: {percent(target)} in {_seconds(time)}, {_faster(ratio)} than {baseline}{where}{said}"


def _where(names: Sequence[str], count: int) -> str:
    """Format which of an experiment's scenes a sentence is about."""
    if count == 1:
        return ""
    return (
        f" on {names[0]} (1 of {count} scenes)"
        if len(names) == 1
        else f" (geometric means of {len(names)} of {count} scenes)"
    )


def _farthest(reach: float, scenes: int) -> str:
    return f"{'up to ' if scenes > 1 else ''}{reach:.3g}{_TIMES} beyond the runs"


def _faster(ratio: Interval) -> str:
    """Format a ratio of times as "N times faster" or "N times slower"."""
    if not ratio.trusted:
        return (
            f"at least {ratio.low:.3g}{_TIMES} as fast"
            if ratio.low < 1.0
            else f"at least {ratio.low:.3g}{_TIMES} faster"
        )
    return _times(ratio, "faster", "slower")


def _times(ratio: Interval, above: str, below: str) -> str:
    """Format a ratio as "N times" and a word, ``above`` if the ratio is at least 1; else its inverse and ``below``."""
    low, value, high = ratio.low, ratio.value, ratio.high
    if value < 1.0:
        low, value, high = 1.0 / high, 1.0 / value, 1.0 / low
    return f"{value:.3g}{_TIMES} [{low:.3g}, {high:.3g}] {above if ratio.value >= 1.0 else below}"


def _without_ratio(scenes: Sequence[SceneResult], targets: Sequence[float]) -> str:
    """Return a sentence with the first trusted time and the efficiency of typical runs, or why both are missing."""
    alone, typical = _time_alone(scenes, targets), _typical(scenes)
    if alone is None:
        told = "no strategy's time to a wanted error can be told with an interval that is trusted"
        return f"{typical}; {told}{_reasons(scenes)}" if typical else told + _reasons(scenes)
    scene, strategy, text = alone
    if strategy.label == scene.baseline:
        return text if len(scene.strategies) == 1 else f"{text}; it is the baseline"
    if typical:
        return f"{text}; {typical}"
    notes = next((s.notes for s in scene.strategies if s.label == scene.baseline), ())
    reason = f" (there: {notes[0]})" if notes else ""
    return f"{text}; how much faster than {scene.baseline} cannot be told with an interval that is trusted{reason}"


def _time_alone(
    scenes: Sequence[SceneResult], targets: Sequence[float]
) -> tuple[SceneResult, StrategyResult, str] | None:
    """Return the first trusted time with its scene and strategy; times within the runs are preferred."""
    for extrapolated in (False, True):
        for target in sorted(targets):
            for scene, strategy in _standards(scenes):
                time = strategy.time_to[target]
                if sound(time) and (extrapolated or time.reach == 1.0):
                    on = f" on {scene.name}" if len(scenes) > 1 else ""
                    text = f"{strategy.label}: {percent(target)} in {_seconds(time)}{on}"
                    return scene, strategy, text + (f" ({time.note})" if time.note else "")
    return None


def _typical(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the median efficiency of the standard strategy; empty if none is trusted."""
    found = [
        (scene, strategy)
        for scene, strategy in _standards(scenes)
        if strategy.label != scene.baseline and sound(strategy.efficiency)
    ]
    if not found:
        return ""
    ratio = product_mean([strategy.efficiency for _, strategy in found])
    labels, baseline = _joined(s.label for _, s in found), _joined(scene.baseline for scene, _ in found)
    where = _where([scene.name for scene, _ in found], len(scenes))
    gain = f"{ratio.value:.3g}{_TIMES} [{ratio.low:.3g}, {ratio.high:.3g}]"
    what = f"squared error {_TIMES} time, medians"
    return f"typical runs of {labels} are {gain} as efficient as those of {baseline} ({what}){where}"


def _standards(scenes: Sequence[SceneResult]) -> Iterator[_Found]:
    return ((scene, s) for scene in scenes for s in scene.strategies if s.label == scene.standard)


def _reasons(scenes: Sequence[SceneResult]) -> str:
    notes = (n.note for _, strategy in _standards(scenes) for n in strategy.time_to.values() if not n.trusted)
    first = next((note for note in notes if note), "")
    return f": {first}" if first else ""


def _joined(labels: Iterable[str]) -> str:
    return " / ".join(dict.fromkeys(labels))


def _seconds(time: Interval) -> str:
    return f"{time.value:.3g} s [{time.low:.3g}, {time.high:.3g}]"


def bias_verdict(scenes: Sequence[SceneResult], level: float) -> str:
    """Return a sentence that lists the strategies found biased, those not found biased, and those not tested.

    A strategy is biased if its expected image differs from the expected image of the scene's standard strategy.
    ``level`` is the false-alarm rate of all these tests together.
    """
    found, right, open_ = [], [], []
    for scene, strategy in _others(scenes):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        if strategy.equality_p is None:
            open_.append(f"{strategy.label}{on}{_why(strategy)}")
        elif strategy.unequal:
            found.append(f"{strategy.label}{_size(strategy.bias)}{on}")
        else:
            right.append(f"{strategy.label}{on}")
    standard = _joined(scene.standard or "nothing" for scene in scenes)
    parts = [
        f"found biased at a level of {100.0 * level:.2g} %, held against {standard}: {_listed(found)}",
        f"not: {_listed(right)}",
        *([f"not to be told: {_listed(open_)}"] if open_ else []),
    ]
    return "; ".join(parts)


def samples_verdict(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the factor by which each strategy needs fewer samples than the baseline at equal error."""
    baseline = _joined(scene.baseline for scene in scenes)
    said = []
    for scene, strategy in _others(scenes, baseline=True):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        said.append(f"{strategy.label}{on} {_fewer(strategy.fewer_samples)}")
    return f"samples to the same error, against {baseline}: {_listed(said)}"


def efficiency_verdict(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence with each strategy's gain: the baseline's squared error x time, divided by the strategy's.

    With several scenes, each gain is a geometric mean over scenes, with its smallest and largest value. The standard
    strategy comes first.
    """
    baseline = _joined(scene.baseline for scene in scenes)
    found: dict[str, list[tuple[str, Interval]]] = {}
    for scene, strategy in _others(scenes, baseline=True):
        found.setdefault(strategy.label, []).append((scene.name, strategy.efficiency))
    standards = {scene.standard for scene in scenes}
    said = [_gain(label, found[label], len(scenes)) for label in sorted(found, key=lambda one: one not in standards)]
    what = f"squared error {_TIMES} time, of typical runs, against {baseline}"
    return f"{what}{' (geometric means)' if len(scenes) > 1 else ''}: {_listed(said)}"


def _gain(label: str, found: Sequence[tuple[str, Interval]], scenes: int) -> str:
    """Format the mean gain of one strategy; with several scenes also its smallest and largest gain."""
    known = [(name, interval) for name, interval in found if sound(interval)]
    if not known:
        return f"{label} not to be told ({found[0][1].note})"
    text = f"{label} {_less(product_mean([interval for _, interval in known]))}"
    if len(known) > 1:
        least, most = (pick(known, key=lambda one: one[1].value) for pick in (min, max))
        text += f" ({least[0]}: {_less(least[1])}; {most[0]}: {_less(most[1])})"
    return text + (f" on {len(known)} of {scenes} scenes" if len(known) < scenes else "")


def _less(ratio: Interval) -> str:
    return _times(ratio, "less", "more")


def _others(scenes: Sequence[SceneResult], baseline: bool = False) -> Iterator[tuple[SceneResult, StrategyResult]]:
    for scene in scenes:
        for strategy in scene.strategies:
            if strategy.label != (scene.baseline if baseline else scene.standard):
                yield scene, strategy


def _fewer(ratio: Interval) -> str:
    if math.isinf(ratio.value):
        return "needs one, being exact"
    if not ratio.trusted:
        if ratio.bound == "low":
            return f"at least {ratio.low:.3g}{_TIMES} fewer"
        if ratio.bound == "high" and ratio.high < 1.0:
            return f"at least {1.0 / ratio.high:.3g}{_TIMES} more"
        return f"not to be told ({ratio.note})"
    return _times(ratio, "fewer", "more")


def _size(bias: Interval | None) -> str:
    """Format a bias as a relative error in %; empty if its interval is not trusted or includes 0."""
    if bias is None or not bias.trusted or bias.low <= 0.0:
        return ""
    return f" by {percent(bias.value)} [{100.0 * bias.low:.3g}, {100.0 * bias.high:.3g}]"


def _why(strategy: StrategyResult) -> str:
    return f" ({strategy.notes[0]})" if strategy.notes else ""


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(texts) or "none"
