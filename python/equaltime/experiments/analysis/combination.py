"""Verdict of experiments that compare a combination of techniques, such as MIS, with its parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress

from equaltime.errors import StrategyError
from equaltime.experiments.analysis.sentences import joined, listed
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.curves import TYPICAL
from equaltime.statistics.in_words import about, figure
from equaltime.statistics.intervals import Interval, sound
from equaltime.strategy import Strategy

__all__ = ["combination_verdict"]

_SINGLE = ("uniform", "bsdf", "light")
"""Techniques that combine no others: a strategy with one of them can be a part of the combination."""

_Ratio = Callable[[StrategyResult], Interval]
_Found = tuple[Interval, str, str]
"""Squared error of the combination over a part's, or an upper limit of it; label of the part; name of the scene."""


def combination_verdict(scenes: Sequence[SceneResult]) -> str:
    """Return how much worse the baseline, a combination of techniques, is at worst than the better of its parts.

    The parts are the strategies of a single technique. The first sentence tells the worst scene at equal samples and at
    equal time. The second tells the scene on which each part alone is worst.
    """
    baseline = joined(scene.baseline for scene in scenes)
    parts = list(dict.fromkeys(part.label for scene in scenes for part in _parts(scene)))
    if not parts:
        return f"{baseline} has no parts to compare with: no other strategy has the technique bsdf, light or uniform."
    better = f"the better of {listed(parts)}" if len(parts) > 1 else parts[0]
    at_worst = " at worst" if len(scenes) > 1 else ""
    samples = _worst([_behind(scene, lambda part: part.fewer_samples) for scene in scenes], "at equal samples")
    time = _worst([_behind(scene, lambda part: part.efficiency) for scene in scenes], "at equal time")
    answer = f"Compared with {better}, the squared error of {baseline} is{at_worst} {samples} and {time}."
    if alone := [told for label in parts if (told := _alone(scenes, label))]:
        answer += f" At equal time, {listed(alone)} the squared error of {baseline}."
    return answer + _typical(scenes)


def _typical(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence if a ratio that is told is a median of repeats instead of a ratio of means; else empty."""
    ratios = (ratio for scene in scenes for part in _parts(scene) for ratio in (part.fewer_samples, part.efficiency))
    if not any(_is_told(ratio) and TYPICAL in ratio.note for ratio in ratios):
        return ""
    return " Where a few rare events make most of an error, these are ratios of typical runs."


def _parts(scene: SceneResult) -> list[StrategyResult]:
    return [one for one in scene.strategies if one.label != scene.baseline and _technique(one) in _SINGLE]


def _technique(strategy: StrategyResult) -> str:
    """Return the technique of a strategy of equaltime; empty for another renderer or subject."""
    if strategy.renderer == "core":
        with suppress(StrategyError):  # a user's own subject may have any name
            return Strategy.parse(strategy.name).technique
    return ""


def _behind(scene: SceneResult, ratio: _Ratio) -> _Found | None:
    """Compare the baseline with the better part of a scene; None if it is open which part is better, or how much.

    ``ratio`` returns the baseline's squared error over a part's.
    """
    found = [(ratio(part), part.label, scene.name) for part in _parts(scene)]
    return max(found, key=_most) if found and all(_is_told(one) for one, *_ in found) else None


def _is_told(ratio: Interval) -> bool:
    """Tell whether a ratio is trusted, or known to be below 1: the part is then the worse one."""
    return sound(ratio) or (ratio.bound == "high" and 0.0 < ratio.high < 1.0)


def _most(found: _Found) -> float:
    """Return the ratio, or its upper limit if only that is known."""
    return found[0].value if sound(found[0]) else found[0].high


def _worst(found: Sequence[_Found | None], when: str) -> str:
    """Return the largest ratio in words, with its interval, part and scene, and the number of scenes that tell it."""
    told = [one for one in found if one is not None]
    if not told:
        return f"not known {when}"
    ratio, part, scene = max(told, key=_most)
    place = f"{part} on {scene}" if len(found) > 1 else part
    some = f"; known on {len(told)} of {len(found)} scenes" if len(told) < len(found) else ""
    if not sound(ratio):
        return f"at most {figure(ratio.high)} times as large {when} ({place}{some})"
    return f"{about(ratio)} times as large {when} ({figure(ratio.low)} to {figure(ratio.high)}; {place}{some})"


def _alone(scenes: Sequence[SceneResult], label: str) -> str:
    """Return how much worse a part is than the baseline on its worst scene, at equal time; empty if it is not known."""
    every = [(part.efficiency, label, scene.name) for scene in scenes for part in _parts(scene) if part.label == label]
    told = [one for one in every if _is_told(one[0])]
    if not told:
        return ""
    worst = min(told, key=_most)
    several = len(scenes) > 1
    sign = "at least " if not sound(worst[0]) else "up to " if several else ""
    place = f" (on {worst[2]})" if several else ""
    return f"{label} alone has {sign}{figure(1.0 / _most(worst))} times{place}"
