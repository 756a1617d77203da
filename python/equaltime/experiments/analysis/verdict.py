"""The verdict of an experiment: a plain sentence that answers its question, then what limits the answer.

The verdict takes only numbers whose intervals can be trusted. `analysis.questions` and `analysis.combination` have the
questions other than time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from equaltime.experiments.analysis.combination import combination_verdict
from equaltime.experiments.analysis.pictures import other_pictures
from equaltime.experiments.analysis.questions import bias_verdict, efficiency_verdict, samples_verdict
from equaltime.experiments.analysis.sentences import across, compared, joined, less_time, where
from equaltime.experiments.analysis.winners import best_per_scene, fastest, quotient
from equaltime.experiments.model.experiment import Question
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.curves import TYPICAL
from equaltime.statistics.in_words import about, figure, in_time, span
from equaltime.statistics.intervals import Interval, product_mean, sound, sound_below
from equaltime.words import percent

__all__ = ["headline_target", "pick_standard", "verdict"]


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
    """Return the answer to an experiment's question in a line of one to five sentences, the answer first.

    The last sentence names strategies and renderers that converge to another picture although they do not declare
    themselves biased, and how far off these pictures are.

    For the question ``time`` the answer has two numbers: the speed-up of the standard strategy (usually ``best``) over
    the baseline, and its time to an error. Both numbers are for the smallest target error at which their intervals are
    trusted, on all scenes if possible. Numbers that need no extrapolation are preferred, then numbers for which only
    the baseline is extrapolated. Without a trusted speed-up, a speed-up with a trusted lower limit is used.
    """
    if question == "bias":
        return bias_verdict(scenes, LEVEL)
    if question == "samples":
        return samples_verdict(scenes) + other_pictures(scenes)
    if question == "combination":
        return combination_verdict(scenes) + other_pictures(scenes)
    if question == "efficiency":
        return efficiency_verdict(scenes) + best_per_scene(scenes) + other_pictures(scenes)
    return _answer_in_time(scenes, targets)[0] + other_pictures(scenes)


def headline_target(scenes: Sequence[SceneResult], targets: Sequence[float], question: Question) -> float | None:
    """Return the error whose time the verdict gives; None if it gives none or answers another question than time."""
    return _answer_in_time(scenes, targets)[1] if question == "time" else None


def _answer_in_time(scenes: Sequence[SceneResult], targets: Sequence[float]) -> tuple[str, float | None]:
    """Return the answer to the question ``time``, and the error whose time it gives (None if it gives none)."""
    for all_scenes in (True, False):
        for ratio_is_good in (sound, sound_below):
            for reach in _REACHES:
                for target in sorted(targets):
                    found = [one for scene in scenes if (one := _at(scene, target, reach, ratio_is_good)) is not None]
                    if found and (len(found) == len(scenes) or not all_scenes):
                        answer = _speed_up(found, target, len(scenes)) + fastest(scenes, target)
                        return answer + _own_renderers(scenes, target), target
    alone = _time_alone(scenes, targets)
    if alone is None:
        return _without_ratio(scenes, alone), None
    return _without_ratio(scenes, alone) + fastest(scenes, alone[2]), alone[2]


_Found = tuple[SceneResult, StrategyResult]
_Test = Callable[[Interval], bool]

_REACHES: tuple[Callable[[Interval, Interval], bool], ...] = (
    lambda time, ratio: time.reach == ratio.reach == 1.0,
    lambda time, ratio: time.reach == 1.0,
    lambda time, ratio: True,
)
"""Tests of how far time and ratio are extrapolated, in order of preference: neither, only the ratio, any."""
_MOST_OWN = 3
"""Largest number of renderers other than equaltime that the verdict names; tables show more of them better."""


def _at(scene: SceneResult, target: float, reach: Callable[[Interval, Interval], bool], good: _Test) -> _Found | None:
    for _, strategy in _standards((scene,)):
        if strategy.label != scene.baseline:
            time, ratio = strategy.time_to.get(target), strategy.ratio.get(target)
            if time is not None and ratio is not None and sound(time) and good(ratio) and reach(time, ratio):
                return scene, strategy
    return None


def _speed_up(found: Sequence[_Found], target: float, count: int) -> str:
    """Return the sentence on speed-up and time to ``target``, on the scenes ``found`` of ``count`` scenes."""
    times = [strategy.time_to[target] for _, strategy in found]
    ratios = [strategy.ratio[target] for _, strategy in found]
    label, baseline = joined(strategy.label for _, strategy in found), joined(scene.baseline for scene, _ in found)
    faster = compared(label, product_mean(ratios), baseline)
    answer = f"{where([scene.name for scene, _ in found], count)}, {faster}: "
    each = [(scene.name, strategy.time_to[target]) for scene, strategy in found]
    answer += f"{percent(target)} error in {across(each, in_time)}."
    several = len(found) > 1
    farthest = max(times, key=lambda time: time.reach)
    answer += _extrapolated(farthest, several)
    if (reach := max(ratio.reach for ratio in ratios)) > farthest.reach:
        answer += f" The time of {baseline} is extrapolated: it is {_longer(reach, several)} its longest run."
    return answer + _rare((*times, *ratios))


def _own_renderers(scenes: Sequence[SceneResult], target: float) -> str:
    """Return a sentence on each renderer other than equaltime, beside standard and baseline on the only scene."""
    if len(scenes) != 1:
        return ""
    (scene,) = scenes
    own = [one for one in scene.strategies if one.renderer != "core" and one.label != scene.baseline]
    beside = [one for one in scene.strategies if one.label in (scene.baseline, scene.standard)]
    said = ""
    for strategy in own if len(own) <= _MOST_OWN else ():
        ratios = {other.label: _times_as_long(scene, strategy, other, target) for other in beside}
        told = [f"{about(ratio)} times as long as {label} {span(ratio)}" for label, ratio in ratios.items() if ratio]
        if told:
            said += f" {strategy.label} needs {' and '.join(told)} for {percent(target)}."
    return said


def _times_as_long(
    scene: SceneResult, strategy: StrategyResult, other: StrategyResult, target: float
) -> Interval | None:
    """Return a strategy's time to ``target`` over another's; None if it is not known.

    Beside the baseline it is the inverse of the speed-up that tables show, which compares paired repeats.
    """
    ratio = strategy.ratio.get(target)
    if other.label == scene.baseline and ratio is not None and sound(ratio):
        return ratio.map(lambda speed_up: 1.0 / speed_up)
    return quotient(strategy.time_to[target], other.time_to[target])


def _without_ratio(scenes: Sequence[SceneResult], alone: tuple[SceneResult, StrategyResult, float] | None) -> str:
    """Return a line with the efficiency of typical runs and a trusted time, or why both are missing.

    ``alone`` is the result of `_time_alone`: the first trusted time.
    """
    typical = _typical(scenes)
    if alone is None:
        reason = _reason(scenes)
        if typical:
            return f"{typical} Times to a given error cannot be trusted{reason}."
        return f"No time to a given error can be trusted{reason}."
    scene, strategy, target = alone
    time = strategy.time_to[target]
    reached = f"{strategy.label} reaches {percent(target)} error in {in_time(time)}."
    caveats = _extrapolated(time) + _rare((time,))
    if typical:
        place = f"On {scene.name}, " if len(scenes) > 1 else "There, "
        return f"{typical} {place}{reached}{_extrapolated(time)}"
    if strategy.label == scene.baseline:
        alone_there = len(scene.strategies) == 1
        return f"On {scene.name}, {reached}{caveats}{'' if alone_there else ' It is the baseline of the comparison.'}"
    notes = next((s.notes for s in scene.strategies if s.label == scene.baseline), ()) or (strategy.ratio[target].note,)
    reason = f": {notes[0]}" if notes[0] else ""
    return f"On {scene.name}, {reached}{caveats} How much faster it is than {scene.baseline} cannot be told{reason}."


def _longer(reach: float, several: bool) -> str:
    """Return how a time compares with a run, for one that is ``reach`` times as long; ``several`` times have a most."""
    return "a little longer than" if reach < 1.05 else f"{'up to ' if several else ''}{figure(reach)} times"


def _extrapolated(time: Interval, several: bool = False) -> str:
    """Return a sentence on how far a time is beyond the longest run; empty if a run was long enough.

    ``several`` tells that the time is the farthest of several scenes.
    """
    if time.reach <= 1.0:
        return ""
    return (
        f" Extrapolated: {'times are' if several else 'this time is'} {_longer(time.reach, several)} the longest run."
    )


def _rare(intervals: Iterable[Interval]) -> str:
    """Return a sentence if intervals describe medians of repeats instead of means; else an empty text."""
    typical = any(TYPICAL in interval.note for interval in intervals)
    return " This holds for typical runs: a few rare events make most of the error." if typical else ""


def _time_alone(
    scenes: Sequence[SceneResult], targets: Sequence[float]
) -> tuple[SceneResult, StrategyResult, float] | None:
    """Return a scene, its standard strategy, and the first target with a trusted time; times within the runs first."""
    for extrapolated in (False, True):
        for target in sorted(targets):
            for scene, strategy in _standards(scenes):
                time = strategy.time_to[target]
                if sound(time) and (extrapolated or time.reach == 1.0):
                    return scene, strategy, target
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
    labels, baseline = joined(s.label for _, s in found), joined(scene.baseline for scene, _ in found)
    place = where([scene.name for scene, _ in found], len(scenes))
    gain = product_mean([strategy.efficiency for _, strategy in found])
    return (
        f"{place}, for the same error, a typical run of {labels} needs {less_time(gain, f'one of {baseline}')}, if "
        "errors go on to fall as 1/sqrt(time)."
    )


def _standards(scenes: Sequence[SceneResult]) -> Iterator[_Found]:
    return ((scene, s) for scene in scenes for s in scene.strategies if s.label == scene.standard)


def _reason(scenes: Sequence[SceneResult]) -> str:
    notes = (n.note for _, strategy in _standards(scenes) for n in strategy.time_to.values() if not n.trusted)
    first = next((note for note in notes if note), "")
    return f": {first}" if first else ""
